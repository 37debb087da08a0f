// The tables as they are: live values, faults and refusals, modes, exercises.
#include <array>
#include <nlohmann/json.hpp>

#include "control/contract/exercises.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/signals.hpp"
#include "db/store/tasks.hpp"
#include "server/api/handlers.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
json words(std::string_view en, std::string_view de) { return {{"en", en}, {"de", de}}; }
}  // namespace

void list_signals(const CallPtr& call) {
  constexpr std::array<std::string_view, 6> kTypes{"u64", "u32", "i32", "f32", "u16", "u8"};
  json items = json::array();
  for (const contract::SignalInfo& s : contract::kSignals)
    items.push_back({{"id", s.id},
                     {"name", s.name},
                     {"unit", s.unit},
                     {"type", kTypes[static_cast<std::size_t>(s.type)]},
                     {"lsb", s.lsb},
                     {"offset", s.offset},
                     {"title", words(s.title_en, s.title_de)},
                     {"doc", s.doc}});
  call->respond(json{{"record_bytes", sizeof(contract::TickRecord)}, {"items", std::move(items)}});
}

void list_faults(const CallPtr& call) {
  constexpr std::array<std::string_view, 3> kPriorities{"low", "medium", "high"};
  constexpr std::array<std::string_view, 5> kReactions{"warn", "soft_stop", "protective_stop", "out_of_service", "power_off"};
  json items = json::array();
  for (const contract::FaultInfo& f : contract::kFaults)
    items.push_back({{"bit", f.bit},
                     {"name", f.name},
                     {"priority", kPriorities[static_cast<std::size_t>(f.priority)]},
                     {"reaction", kReactions[static_cast<std::size_t>(f.reaction)]},
                     {"hazard", f.hazard()},
                     {"text", words(f.text_en, f.text_de)},
                     {"action", words(f.action_en, f.action_de)}});
  json refusals = json::array();
  for (const contract::RefusalInfo& r : contract::kRefusals)
    refusals.push_back({{"bit", r.bit}, {"name", r.name}, {"text", words(r.text_en, r.text_de)}});
  call->respond(json{{"items", std::move(items)}, {"refusals", std::move(refusals)}});
}

void list_exercises(const CallPtr& call) {
  json items = json::array();
  for (const contract::ExerciseInfo& row : contract::kExercises) {
    json sizes = json::array();
    for (const contract::ExerciseSize& size : contract::kExerciseSizes)
      if (size.shape == row.shape)
        sizes.push_back({{"name", size.name},
                         {"title", words(size.title_en, size.title_de)},
                         {"doc", size.doc},
                         {"required", size.required},
                         {"usual_m", size.usual_m},
                         {"least_m", contract::kExerciseLeast_m},
                         {"most_m", contract::kExerciseMost_m},
                         {"driven_least_m", size.driven_least_m},
                         {"driven_most_m", size.driven_most_m},
                         {"share", size.share}});
    items.push_back({{"shape", row.name},
                     {"title", words(row.title_en, row.title_de)},
                     {"turned", row.turned},
                     {"closed", row.closed},
                     {"sizes", std::move(sizes)}});
  }
  call->respond(json{{"items", std::move(items)}});
}

void list_tasks(const CallPtr& call) {
  json items = json::array();
  for (const db::TaskInfo& task : db::tasks()) items.push_back(json::parse(task.text));
  call->respond(json{{"items", std::move(items)}});
}

void list_modes(const CallPtr& call) {
  json items = json::array();
  for (const contract::ModeInfo& m : contract::kModes)
    items.push_back({{"value", m.value}, {"name", m.name}, {"moving", m.moving}, {"title", words(m.title_en, m.title_de)}});
  call->respond(json{{"items", std::move(items)}});
}

}  // namespace hoist::server::api
