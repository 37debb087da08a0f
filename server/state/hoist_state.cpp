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

void HoistState::choose(const db::TaskChoice& task) {
  walk_.choose(task);
  tell_walk();
}

void HoistState::motion_begins(nlohmann::json told, const std::optional<db::TaskRecord>& task) {
  walk_.begin(std::move(told), task);
  tell_walk();
}

void HoistState::choose_patient(std::optional<ChosenPatient> patient) {
  const auto id_of = [](const std::optional<ChosenPatient>& one) { return one ? std::optional(one->id) : std::nullopt; };
  const bool another = id_of(patient) != id_of(patient_);
  patient_ = std::move(patient);
  patient_rests_ns_.reset();
  if (another) {
    walk_.change_patient();
    tell_walk();
  }
  if (patient_)
    recorder_.set_subject(patient_->code, patient_->file);
  else
    recorder_.set_subject(std::nullopt);
  if (on_patient_) on_patient_();
}

// A new core has none of the proposals and the walk of the old one. A core that was only silent for a while keeps its
// own.
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
  bool told = false, reached = false;
  for (const contract::TickRecord& record : records) {
    const Walk::Change change = walk_.take(record);
    told = told || change.marked || change.task.told;
    reached = reached || change.task.reached;
    if (record.mode < contract::kModes.size() && contract::kModes[record.mode].moving) patient_rests_ns_.reset();
  }
  if (told) tell_walk();
  if (reached && on_task_end_) on_task_end_();
}

void HoistState::poll(std::uint64_t now_ns) {
  if (!patient_) return;
  if (patient_->file != recorder_.file()) return choose_patient(std::nullopt);
  if (!patient_rests_ns_) patient_rests_ns_ = now_ns;
  if (static_cast<double>(now_ns - *patient_rests_ns_) * 1e-9 >= kPatientIdle_s) choose_patient(std::nullopt);
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
