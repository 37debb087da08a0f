// Invariants I1 to I14 of SOURCES 2.4, checked from outside: by what crosses the core's border and by the true state of the simulated machine.
// The judge shares no table with the core; tests/tidy keeps the core's headers out of this folder.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/faults.hpp"
#include "control/contract/signals.hpp"
#include "tests/chaos/judge/alarms.hpp"
#include "tests/chaos/judge/board.hpp"
#include "tests/chaos/judge/deadlines.hpp"
#include "tests/chaos/judge/ears.hpp"
#include "tests/chaos/judge/motion.hpp"
#include "tests/chaos/judge/persons.hpp"
#include "tests/chaos/judge/seen.hpp"
#include "tests/chaos/judge/settings.hpp"
#include "tests/chaos/judge/sound.hpp"
#include "tests/chaos/judge/truth.hpp"
#include "tests/chaos/judge/verdict.hpp"

namespace hoist::chaos {

class Watch {
 public:
  struct Options {
    bool tell = false;         // keep the log of the session
    bool frames_lost = false;  // some frames are always lost: an unasked stop is counted, and no violation
  };
  /// `first`: the parameters that the core starts with.
  Watch(const sim::World& world, const Board& board, Options options, const contract::Params& first, SessionReport& report);

  void before_step(const Given& given);
  void sent(const contract::CanFrame& frame) { ears_.sent(frame), settings_.sent(frame); }
  /// After a step of the world. Without a core nothing was told in it.
  void after_step(const Told* told);
  /// After every millisecond of the world.
  void see_millisecond() { alarms_.see_millisecond(); }
  /// An end of motion in the next seconds is intended.
  void stop_is_wanted() { asked_stop_s_ = world_.time_s(); }
  void core_restarted(const contract::Params& params, std::uint64_t version, std::size_t events);
  void must_stop(std::string_view cause, double budget_s, double braking_m_s2);
  void tell(const std::string& what);
  void broken(std::string_view what, double value = 0.0, std::string_view name = {});

 private:
  void driver_gone();
  void hand_holds(bool holds);
  void must_rest(std::string_view cause, double budget_s, double braking_m_s2);
  [[nodiscard]] double reached_m_s(double budget_s) const;
  struct MustStop {
    std::string_view cause;
    double by_s;
  };

  void watch_truth(bool core_ran);
  void watch_platform(bool core_ran);
  void watch_rest();
  void watch_motion(const Told& told);
  void watch_record(const Told& told);
  void watch_limits(const contract::TickRecord& record);
  void watch_driver(const contract::TickRecord& record);
  void watch_parameters(const Told& told);
  void watch_events(const Told& told);
  void watch_mode_change(const Told& told, contract::Mode from, contract::Mode to);
  void count_end(const contract::TickRecord& record, contract::Mode from);
  void watch_start(const Told& told, contract::Mode to);
  [[nodiscard]] bool unlearning() const;

  const sim::World& world_;
  const Board& board_;
  Options options_;
  SessionReport& report_;
  Ears ears_;
  Deadlines deadlines_;
  Persons persons_;
  Settings settings_;
  Sound sound_;
  Alarms alarms_;
  TruthSampler sampler_;
  Motion motion_{ears_};
  std::vector<std::string> told_;
  std::vector<MustStop> must_stop_;
  std::vector<contract::Command> commands_;  // of this step
  contract::Params params_;                  // in force after the step before
  std::uint64_t parameter_version_{};
  int rested_ticks_ = 0;                   // of a protective stop at rest
  std::vector<contract::Command> staged_;  // rows of the set that is being gathered, by any client
  double asked_stop_s_{-100.0}, acknowledged_s_{-100.0}, driven_s_{-100.0};
  double moving_end_s_{}, core_silent_s_{}, reached_at_silence_m_s_{};
  double disturbed_s_{-100.0};  // when something that may affect a motion was last broken
  double last_speed_m_s_{};
  std::uint64_t drive_sequence_{};
  std::uint64_t server_life_{};
  std::uint64_t next_sequence_{};  // of the commands that came in order
  std::uint32_t drive_epoch_{}, lease_epoch_{}, lease_holder_{};
  contract::Mode mode_{contract::Mode::init};
  std::size_t events_seen_{};
  contract::FaultBits raised_{};
  contract::FaultBits raised_now_{};  // in this step
  std::uint64_t last_tick_{};
  bool freed_{false};  // control was given back in this step, or the server began anew
  bool hand_holds_{false};
  bool ran_{false}, followed_{false}, core_runs_{true}, begun_disturbed_{false};
};

}  // namespace hoist::chaos
