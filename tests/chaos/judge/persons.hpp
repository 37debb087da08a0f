// Who may do what: by the commands that reached the core, and what it then did.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"

namespace hoist::chaos {

class Persons {
 public:
  /// A step begins: its commands, and who had the control before it.
  void before_step(std::span<const contract::Command> commands, std::uint32_t holder, std::uint32_t epoch);
  /// A driving command that may act: the button is held since then, or released.
  void button(bool held, double since_s) { button_held_ = held, button_s_ = since_s; }
  /// After a crash nothing is known of before.
  void restart() { *this = Persons{}; }

  // What was broken; empty for nothing.
  /// I3: a motion begins by the wish of who has the control; I7: an exercise by a button that was released before.
  [[nodiscard]] std::string_view started(const contract::TickRecord& record, contract::Mode to, double now_s);
  /// I3: only who began a motion leads it.
  [[nodiscard]] std::string_view led(const contract::TickRecord& record) const;
  /// I5: out of service ends by an engineer, or by a therapist after silent nodes.
  [[nodiscard]] std::string_view back_in_service() const;
  /// A step is over.
  void after_step(const contract::TickRecord& record) { in_force_ = record.fault_bits; }

 private:
  std::vector<contract::Command> commands_;
  std::uint32_t holder_ = 0, epoch_ = 0, started_epoch_ = 0;
  contract::FaultBits in_force_ = 0;  // after the step before
  double button_s_ = 0, button_before_s_ = 0;
  bool button_held_ = false, button_held_before_ = false;
};

}  // namespace hoist::chaos
