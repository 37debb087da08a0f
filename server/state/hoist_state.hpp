// What the server knows of the hoist besides the newest step, the same for every protocol: what is walked, the latest emergency messages, what
// a calibration proposes, who asks for the lease. It hears the core before any protocol does.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "db/store/device_settings.hpp"
#include "server/link/core_desk.hpp"
#include "server/record/recorder.hpp"
#include "server/settings.hpp"
#include "server/state/lease_asks.hpp"
#include "server/state/walk.hpp"

namespace hoist::server {

// Emergency messages of nodes that are kept for later questions; all of a session are in its recording.
inline constexpr std::size_t kEmergenciesKept = 64;

// Whom the next motion is recorded for.
struct ChosenPatient {
  std::int64_t id = 0;
  std::string code;
  std::uint64_t file = 0;  // Recorder::file() before the patient was looked up
};
// Without motion for this long the choice ends: the next patient's walk must not get the last one's code.
inline constexpr double kPatientIdle_s = 1800;

class HoistState final : public CoreListener {
 public:
  // Parameters in force go on to the recorder.
  HoistState(const Settings& settings, const CoreDesk& core, Recorder& recorder);

  // Called whenever walk() is another in more than its last point.
  void set_on_walk(std::function<void()> on_walk) { on_walk_ = std::move(on_walk); }

  // Called when the end of the chosen task is reached while patient or therapist lead: the motion is to be ended.
  void set_on_task_end(std::function<void()> on_task_end) { on_task_end_ = std::move(on_task_end); }

  // Called whenever patient() is another.
  void set_on_patient(std::function<void()> on_patient) { on_patient_ = std::move(on_patient); }

  // After each poll of the core, with the steady time: a chosen patient rests also while no core runs, and the choice ends when a backup replaces
  // the recordings.
  void poll(std::uint64_t now_ns);
  void on_core(bool connected) override;
  void on_ticks(std::span<const contract::TickRecord> records, std::uint64_t lost) override;
  void on_parameters(const contract::ParamsInForce& parameters) override;
  void on_lease(std::uint32_t, std::uint32_t) override { asks_.clear(); }
  void on_event(const contract::Event& event) override;

  [[nodiscard]] LeaseAsks& asks() { return asks_; }
  [[nodiscard]] const LeaseAsks& asks() const { return asks_; }
  [[nodiscard]] const Walk& walk() const { return walk_; }
  void choose(const Exercise& exercise);
  void choose(const db::TaskChoice& task);
  void motion_begins(nlohmann::json told, const std::optional<db::TaskRecord>& task);
  // Nothing: no patient is chosen.
  [[nodiscard]] const std::optional<ChosenPatient>& patient() const { return patient_; }
  // Another one than before, or none: also the walk and the task begin anew.
  void choose_patient(std::optional<ChosenPatient> patient);
  // A recording was begun by hand: the next start begins at its start mark.
  void start_anew() { walk_.start_anew(); }
  // Name and language of this hoist, as they were read or changed last; empty before.
  [[nodiscard]] const db::DeviceSettings& device() const { return device_; }
  void set_device(db::DeviceSettings device) { device_ = std::move(device); }
  // The latest emergency messages since the server started, oldest first.
  [[nodiscard]] const std::deque<contract::Event>& emergencies() const { return emergencies_; }
  // What the calibration step under way would change: the core's events, one for each parameter.
  [[nodiscard]] const std::vector<contract::Event>& proposed() const { return proposed_; }

 private:
  void meet_core();
  void tell_walk() const {
    if (on_walk_) on_walk_();
  }

  const CoreDesk& core_;
  Recorder& recorder_;
  std::function<void()> on_walk_;
  std::function<void()> on_patient_;
  std::function<void()> on_task_end_;
  std::optional<ChosenPatient> patient_;
  db::DeviceSettings device_;
  std::optional<std::uint64_t>
      patient_rests_ns_;  // the steady time since the choice or the last step in motion; nothing: since the next poll
  Walk walk_;
  LeaseAsks asks_;
  std::deque<contract::Event> emergencies_;
  std::vector<contract::Event> proposed_;
  std::uint64_t core_life_ = 0;  // of the core that all of this is of
};

}  // namespace hoist::server
