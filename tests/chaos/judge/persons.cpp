#include "tests/chaos/judge/persons.hpp"

#include <algorithm>
#include <array>

namespace hoist::chaos {

using contract::Command;
using contract::CommandKind;
using contract::FaultBits;
using contract::Mode;
using HoistFault = contract::Fault;

void Persons::before_step(std::span<const Command> commands, std::uint32_t holder, std::uint32_t epoch) {
  commands_.assign(commands.begin(), commands.end());
  // A button held under an earlier number of the lease counts no longer.
  if (epoch != epoch_) button_held_ = false;
  holder_ = holder;
  epoch_ = epoch;
  button_held_before_ = button_held_;
  button_before_s_ = button_s_;
}

std::string_view Persons::started(const contract::TickRecord& record, Mode to, double now_s) {
  constexpr double kHolds_s = 0.24;  // an older word of the button is none
  started_epoch_ = record.lease_epoch;
  const bool asked = std::any_of(commands_.begin(), commands_.end(), [&](const Command& c) {
    const bool start = (c.kind == CommandKind::request_mode && c.a == static_cast<std::uint32_t>(to)) ||
                       (c.kind == CommandKind::begin_guided && to == Mode::guided);
    const bool before = c.client == holder_ && c.lease_epoch == epoch_;
    return start && c.client != 0 && (before || (c.client == record.lease_holder && c.lease_epoch == record.lease_epoch));
  });
  if (!asked) return "I3: a start that its driver did not ask for";
  if (to == Mode::guided && button_held_before_ && now_s - button_before_s_ < kHolds_s)
    return "I7: an exercise begins under a button that was held before";
  return {};
}

std::string_view Persons::led(const contract::TickRecord& record) const {
  return record.lease_epoch == started_epoch_ ? std::string_view{} : "I3: led by a driver who did not start";
}

std::string_view Persons::back_in_service() const {
  std::uint32_t role = 0;
  for (const Command& c : commands_)
    if (c.kind == CommandKind::acknowledge && c.client == holder_ && c.b <= static_cast<std::uint32_t>(contract::Role::engineer))
      role = std::max(role, c.b);
  if (role == static_cast<std::uint32_t>(contract::Role::engineer)) return {};
  // Plugs and cables a therapist may put right; what persons and the floor cause is no defect.
  constexpr std::array kSilence{HoistFault::bus_down,       HoistFault::drive_left_lost, HoistFault::drive_right_lost, HoistFault::io_lost,
                                HoistFault::tilt_left_lost, HoistFault::tilt_right_lost, HoistFault::tilt_base_lost};
  constexpr std::array kNoDefect{HoistFault::control_fault, HoistFault::stop_pressed, HoistFault::bumper_pressed, HoistFault::fall_detected,
                                 HoistFault::base_tilted};
  FaultBits silence = 0, defects = 0;
  for (const contract::FaultInfo& fault : contract::kFaults)
    if (fault.reaction >= contract::Reaction::protective_stop) defects |= contract::fault_bit(fault);
  for (const HoistFault fault : kSilence) silence |= contract::fault_bit(fault);
  for (const HoistFault fault : kNoDefect) defects &= ~contract::fault_bit(fault);
  if ((in_force_ & silence) != 0 && (in_force_ & defects & ~silence) == 0) return {};
  return "I5: put back to work without an engineer";
}

}  // namespace hoist::chaos
