#include "control/run/stop_file.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "control/contract/faults.hpp"
#include "control/run/stored_values.hpp"

namespace hoist::run {
namespace {
using nlohmann::json;

json fault_names(std::uint64_t bits) {
  json names = json::array();
  for (const contract::FaultInfo& fault : contract::kFaults)
    if ((bits >> fault.bit & 1U) != 0) names.push_back(fault.name);
  return names;
}

/// False when the values are not what save_stop_file writes.
bool read_values(const json& values, bool same_boot, std::int64_t now_ns, core::StopHistory& history) {
  if (!values.contains("stops") || !values["stops"].is_array() || values["stops"].size() > history.stops.size()) return false;
  for (const json& item : values["stops"]) {
    if (!item.is_object() || !item.contains("fault") || !item["fault"].is_string() || !item.contains("time_ns") ||
        !item["time_ns"].is_number_integer())
      return false;
    const contract::FaultInfo* fault = contract::find_fault(item["fault"].get<std::string>());
    if (fault == nullptr) continue;  // of another version, which knew other faults
    const auto time_ns = item["time_ns"].get<std::int64_t>();
    history.stops[history.count++] = {same_boot ? std::min(time_ns, now_ns) : now_ns, fault->bit};
  }
  if (!values.contains("out_of_service") || !values["out_of_service"].is_array()) return false;
  for (const json& name : values["out_of_service"]) {
    if (!name.is_string()) return false;
    const contract::FaultInfo* fault = contract::find_fault(name.get<std::string>());
    if (fault != nullptr) history.out_of_service |= contract::fault_bit(*fault);
  }
  return true;
}

}  // namespace

LoadedStops load_stop_file(const std::string& path, const std::string& boot_id, std::uint64_t now_ns) {
  LoadedStops loaded;
  const auto refuse = [&loaded](std::string problem) {
    loaded.history = {};
    loaded.history.out_of_service = contract::fault_bit(contract::Fault::control_fault);
    loaded.problem = std::move(problem);
    return loaded;
  };
  const StoredValues stored = load_values(path, "stop file");
  if (!stored.problem.empty()) return refuse(stored.problem);
  if (stored.missing) return loaded;
  const json& values = stored.values;
  const bool same_boot = !boot_id.empty() && values.contains("boot_id") && values["boot_id"] == boot_id;
  if (!read_values(values, same_boot, static_cast<std::int64_t>(now_ns), loaded.history)) return refuse(path + " is not a stop file");
  return loaded;
}

Saved save_stop_file(const std::string& path, const std::string& boot_id, const core::StopHistory& history) {
  json stops = json::array();
  for (std::size_t i = 0; i < std::min<std::size_t>(history.count, history.stops.size()); ++i) {
    const core::StopHistory::Stop& stop = history.stops[i];
    stops.push_back({{"fault", contract::fault_info(static_cast<contract::Fault>(stop.fault)).name}, {"time_ns", stop.time_ns}});
  }
  const json values = {{"boot_id", boot_id}, {"stops", std::move(stops)}, {"out_of_service", fault_names(history.out_of_service)}};
  return save_values(path, values);
}

std::string boot_id() {
  std::string id;
  if (const char* told = std::getenv("HOIST_BOOT_ID")) {
    id = told;
  } else {
    std::ifstream file("/proc/sys/kernel/random/boot_id");
    std::getline(file, id);
  }
  std::erase(id, '-');  // the kernel writes it with dashes, the service manager without
  return id;
}

StopStore::StopStore(std::string path) : path_(std::move(path)), boot_id_(boot_id()) {}

LoadedStops StopStore::load(std::uint64_t now_ns) const { return path_.empty() ? LoadedStops{} : load_stop_file(path_, boot_id_, now_ns); }

contract::StoreProblem StopStore::look(const core::StopHistory* changed) {
  if (path_.empty()) return contract::StoreProblem::none;
  if (changed != nullptr) newest_ = *changed;
  if (changed != nullptr || waiting_) saved_ = save_stop_file(path_, boot_id_, newest_);
  waiting_ = !saved_.problem.empty();
  return store_problem(saved_);
}

}  // namespace hoist::run
