// Invariants I1 to I14 of SOURCES 2.4, checked from outside by the core's records and frames and by the true state of the simulated
// machine.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/faults.hpp"
#include "control/contract/signals.hpp"
#include "tests/chaos/session_types.hpp"
#include "tests/support/closed_loop.hpp"

namespace hoist::chaos {

/// Active and past faults of the plan.
struct Planned {
  Fault fault;
  bool on = false, done = false;
};
class Board {
 public:
  explicit Board(const std::vector<Fault>& faults) {
    for (const Fault& fault : faults) rows.push_back({fault});
  }
  [[nodiscard]] bool now(Kind kind) const;
  [[nodiscard]] bool ever(Kind kind) const;
  [[nodiscard]] bool ever(Kind kind, contract::NodeKind node) const;
  [[nodiscard]] bool any_yet() const;
  /// A fault that may affect patient-led walking.
  [[nodiscard]] bool any_inside_yet() const;
  /// No other fault is active or has ended within `quiet_s`.
  [[nodiscard]] bool alone(const Planned& row, double now_s, double quiet_s) const;
  std::vector<Planned> rows;
};

class Watch {
 public:
  Watch(tests::ClosedLoop& loop, const Board& board, const SessionOptions& options, SessionReport& report);

  void before_step(const core::TickInputs& inputs);
  void after_step(bool core_ran);
  void fault_begins(const Planned& row);
  /// An end of motion in the next seconds is intended.
  void stop_is_wanted() { asked_stop_s_ = loop_.time_s(); }
  void core_restarted();
  void must_stop(const char* cause, double budget_s, double braking_m_s2);
  void tell(const std::string& what);
  void broken(std::string_view what, double value = 0.0, std::string_view name = {});
  [[nodiscard]] double fastest_wheel() const;
  /// The patient is down, or was made to fall: physics beyond the hoist's power.
  [[nodiscard]] bool fallen() const;

 private:
  struct MustStop {
    const char* cause;
    double since_s, by_s;
  };
  struct MustRaise {
    contract::FaultBits any_of;
    const char* what;
    double by_s, over_s;
  };

  void watch_truth(bool core_ran);
  void watch_record();
  void watch_limits(const contract::TickRecord& record, contract::Mode mode);
  void watch_driver(const contract::TickRecord& record);
  void watch_parameters(contract::Mode mode);
  void watch_events();
  void watch_mode_change(contract::Mode from, contract::Mode to);
  void watch_deadlines(const contract::TickRecord& record);
  [[nodiscard]] bool odd() const;

  tests::ClosedLoop& loop_;
  const Board& board_;
  const SessionOptions& options_;
  SessionReport& report_;
  std::vector<std::string> told_;
  std::vector<MustStop> must_stop_;
  std::vector<MustRaise> must_raise_;
  std::vector<contract::Command> commands_;  // of this step
  contract::Params params_;                  // in force after the step before
  std::uint64_t parameter_version_{};
  int rested_ticks_ = 0;                   // of a protective stop at rest
  std::vector<contract::Command> staged_;  // rows of the set that is being gathered, by any client
  double asked_stop_s_{-100.0}, acknowledged_s_{-100.0}, driven_s_{-100.0};
  double moving_end_s_{}, core_silent_s_{}, wheels_at_silence_m_s_{};
  double last_speed_m_s_{};
  std::uint64_t drive_sequence_{};
  std::uint64_t server_life_{};
  std::uint64_t next_sequence_{};  // of the commands that came in order
  double twisted_s_{-100.0};       // when the pelvis was last turned by force
  double shorted_s_{-100.0};       // when a bridge was last shorted
  double leaned_s_{-100.0};        // when the harness last leaned far
  double fell_s_{-100.0};          // when the patient was last down
  std::uint32_t drive_epoch_{}, lease_epoch_{}, lease_holder_{};
  contract::Mode last_mode_{contract::Mode::init};
  std::size_t events_seen_{};
  contract::FaultBits raised_{};
  contract::FaultBits raised_now_{};  // in this step
  std::uint64_t last_tick_{};
  bool ran_{false}, followed_{false};
};

}  // namespace hoist::chaos
