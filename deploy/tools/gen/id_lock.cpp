// The lock of ids: it only grows.
#include <map>
#include <sstream>
#include <string>
#include <utility>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/exercises.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "deploy/tools/gen/generate.hpp"

namespace hoist::gen {

IdLock updated_id_lock(std::string_view text) {
  using namespace hoist::contract;
  std::map<std::pair<std::string, unsigned>, std::string> given;
  std::istringstream lines{std::string(text)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string kind, name;
    unsigned id = 0;
    if (words >> kind >> id >> name) given[{kind, id}] = name;
  }
  IdLock lock;
  const auto take = [&](const std::string& kind, unsigned id, std::string_view name) {
    const auto [at, is_new] = given.try_emplace({kind, id}, name);
    if (!is_new && at->second != name) {
      lock.conflicts.push_back(kind + " " + std::to_string(id) + " was given to '" + at->second + "' and is now '" + std::string(name) +
                               "'");
    }
  };
  for (const auto& row : kParams) take("param", row.id, row.name);
  for (const auto& row : kSignals) take("signal", row.id, row.name);
  for (const auto& row : kFaults) take("fault", row.bit, row.name);
  for (const auto& row : kRefusals) take("refusal", row.bit, row.name);
  for (const auto& row : kSpeedCauses) take("speed_cause", row.value, row.name);
  for (const auto& row : kModes) take("mode", row.value, row.name);
  for (const auto& row : kExercises) take("exercise", static_cast<unsigned>(row.shape), row.name);
  for (const auto& row : kNodes) take("node", row.id, row.name);
  lock.text = "# Every id that was ever given away; deploy/dev gen adds new ones. Lines are never removed and ids never reused.\n";
  for (const auto& [key, name] : given) lock.text += key.first + " " + std::to_string(key.second) + " " + name + "\n";
  return lock;
}

}  // namespace hoist::gen
