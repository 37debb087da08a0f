#include "server/state/hoist_state.hpp"

#include <nlohmann/json.hpp>
#include <utility>

namespace hoist::server {

namespace {
// Until a client chooses: what the simulated patient walks, else the paper's figure.
Exercise first_choice(const std::optional<std::string>& scenario) {
  return exercise_of_scenario(scenario ? std::string_view{*scenario} : "figure-eight");
}
}  // namespace

HoistState::HoistState(const Settings& settings, const CoreDesk& core, Recorder& recorder)
    : core_(core), recorder_(recorder), walk_(first_choice(settings.scenario)) {}

void HoistState::choose(const Exercise& exercise) {
  walk_.choose(exercise);
  tell_walk();
}

void HoistState::motion_begins(nlohmann::json told) {
  walk_.begin(std::move(told));
  tell_walk();
}

// What another core proposed and walked is nothing of this one's. A core that was only silent for a while keeps its own.
void HoistState::meet_core() {
  const std::uint64_t life = core_.link().life();
  if (life == core_life_) return;
  proposed_.clear();
  core_life_ = life;
  walk_.forget();
  tell_walk();
}

void HoistState::on_core(bool) { meet_core(); }

void HoistState::on_ticks(std::span<const contract::TickRecord> records, std::uint64_t) {
  meet_core();
  bool marked = false;
  for (const contract::TickRecord& record : records) marked = walk_.take(record) || marked;
  if (marked) tell_walk();
}

void HoistState::on_parameters(const contract::ParamsInForce& parameters) { recorder_.set_parameters(parameters); }

void HoistState::on_event(const contract::Event& event) {
  using contract::EventKind;
  if (event.kind == EventKind::emergency) {
    if (emergencies_.size() == kEmergenciesKept) emergencies_.pop_front();
    emergencies_.push_back(event);
  } else if (event.kind == EventKind::calibration_result) {
    if (proposed_.size() < contract::kParamCount) proposed_.push_back(event);
  } else if (event.kind == EventKind::calibration_sample || event.kind == EventKind::calibration_ended) {
    proposed_.clear();
  }
}

}  // namespace hoist::server
