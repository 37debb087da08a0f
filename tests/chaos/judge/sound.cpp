#include "tests/chaos/judge/sound.hpp"

namespace hoist::chaos {
namespace {

// Until the buzzer is on: at once out of silence, with 120 ms of the input node's word; else in the next burst of an alarm that sounds already.
constexpr double kAtOnce_s = 0.3;
constexpr double next_burst_s(contract::Priority priority) {
  return priority == contract::Priority::high ? 4.5 : priority == contract::Priority::medium ? 8.5 : 17.0;
}

}  // namespace

void Sound::before_step(std::span<const contract::Command> commands) {
  pause_asked_ = false;
  for (const contract::Command& c : commands) pause_asked_ = pause_asked_ || (c.kind == contract::CommandKind::pause_alarm && c.a == 1);
}

std::optional<contract::Fault> Sound::after_step(contract::FaultBits in_force, contract::FaultBits raised) {
  const bool heard = (world_.outputs() & contract::canopen::kBuzzer) != 0;
  // Without power, or without its commands, the node plays what it was told before, or nothing.
  const bool plays = ears_.bus_up() && ears_.age(contract::Node::io) <= 1;
  std::optional<contract::Fault> missed;
  for (const contract::FaultInfo& fault : contract::kFaults) {
    double& left_s = left_s_[fault.bit];
    const bool now = (in_force >> fault.bit & 1U) != 0, fresh = (raised >> fault.bit & 1U) != 0;
    if (heard || !now || !plays || pause_asked_) {
      left_s = 0;
    } else if (fresh) {
      left_s = paused_ ? kAtOnce_s : next_burst_s(fault.priority);
    } else if (left_s > 0 && (left_s -= kStep_s) <= 0) {
      left_s = 0;
      missed = static_cast<contract::Fault>(fault.bit);
    }
  }
  // The pause ends with the first new alarm, and when nothing is in force.
  paused_ = (paused_ && raised == 0 && in_force != 0) || pause_asked_;
  return missed;
}

void Sound::restart() {
  left_s_ = {};
  paused_ = pause_asked_ = false;
}

}  // namespace hoist::chaos
