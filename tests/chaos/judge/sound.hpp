// The sound of alarms, at the true buzzer: a new alarm is heard, also in the pause of an earlier one.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <span>

#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "firmware/sim/world.hpp"
#include "tests/chaos/judge/ears.hpp"

namespace hoist::chaos {

class Sound {
 public:
  Sound(const sim::World& world, const Ears& ears) : world_(world), ears_(ears) {}

  void before_step(std::span<const contract::Command> commands);
  /// After a step of the core: an alarm that was told of and could not be heard in its time.
  [[nodiscard]] std::optional<contract::Fault> after_step(contract::FaultBits in_force, contract::FaultBits raised);
  void restart();

 private:
  const sim::World& world_;
  const Ears& ears_;
  std::array<double, contract::kFaultPlaces> left_s_{};  // for each alarm, until it must have been heard; 0: nothing is due
  bool paused_ = false;                                  // perhaps: a console asked for it
  bool pause_asked_ = false;                             // in this step
};

}  // namespace hoist::chaos
