#include "control/core/supervise/fault_latch.hpp"

#include <bit>
#include <tuple>

#include "control/core/events.hpp"
#include "control/core/supervise/fault_sets.hpp"

namespace hoist::core {

using contract::Event;
using contract::EventKind;
using contract::Fault;
using contract::fault_bit;
using contract::FaultBits;

namespace {

void tell_faults(CoreState& state, FaultBits bits, EventKind kind) noexcept {
  for (; bits != 0; bits &= bits - 1) {
    Event event;
    event.kind = kind;
    event.code = static_cast<std::uint32_t>(std::countr_zero(bits));
    // Names the device, for faults that any device may have.
    if (kind == EventKind::fault_raised && event.code == static_cast<std::uint32_t>(Fault::node_duplicate))
      event.item = state.health.duplicate_id();
    if (kind == EventKind::fault_raised && event.code == static_cast<std::uint32_t>(Fault::node_babbling))
      event.item = state.health.babbling_id();
    if (kind == EventKind::fault_raised && (contract::faults_with_details() >> event.code & 1U) != 0)
      event.item = state.fault_codes[event.code];
    emit(state, event);
  }
}

/// Detail code of a fault that holds now (HOIST_DETAIL); 0 = none.
std::uint16_t code_now(const CoreState& state, Fault fault) noexcept {
  const bool left = fault == Fault::drive_left_fault;
  if (left || fault == Fault::drive_right_fault) {
    const DriveSensor& drive = left ? state.sensed.left_drive : state.sensed.right_drive;
    if (!drive_in_fault(drive)) return 0;
    // The emergency message comes at once, 603Fh up to 50 ms later. The register tells whether that error is still there.
    const NodeHealth& node = state.health.node(left ? contract::Node::drive_left : contract::Node::drive_right);
    return node.error_register != 0 ? node.emcy_code : drive.error_code();
  }
  if (fault == Fault::tilt_implausible) return std::get<TiltImplausible>(state.monitors).code();
  if (fault == Fault::overspeed) return std::get<Overspeed>(state.monitors).code();
  return 0;
}

/// A code is taken when its fault begins: what a drive reports during its reset, or a strut that swings back, is not
/// the cause.
void keep_codes(CoreState& state, FaultBits raised) noexcept {
  for (FaultBits bits = contract::faults_with_details(); bits != 0; bits &= bits - 1) {
    const auto bit = static_cast<std::size_t>(std::countr_zero(bits));
    const bool held = (state.latched >> bit & 1U) != 0, begins = (raised >> bit & 1U) != 0;
    if (!held) state.fault_codes[bit] = 0;
    // A drive's code may arrive later than its fault.
    if (held && (begins || (state.fault_codes[bit] == 0 && state.in_mode.ticks <= kJudgeTicks &&
                            (fault_bit(static_cast<Fault>(bit)) & kDriveFaults) != 0)))
      state.fault_codes[bit] = code_now(state, static_cast<Fault>(bit));
  }
}

}  // namespace

bool drive_in_fault(const DriveSensor& drive) noexcept {
  using State = contract::canopen::drive::State;
  return !drive.fresh().lost() && (drive.state() == State::fault || drive.state() == State::fault_reaction);
}

FaultBits from_outside(const CoreState& state) noexcept {
  FaultBits bits = 0;
  for (const contract::DetailInfo& detail : contract::kDetails)
    if (detail.origin == contract::Origin::outside && state.fault_codes[static_cast<std::size_t>(detail.fault)] == detail.code)
      bits |= fault_bit(detail.fault);
  return bits;
}

FaultBits take_conditions(CoreState& state, FaultBits conditions, FaultBits kept) noexcept {
  state.conditions = conditions;
  const FaultBits before = state.latched;
  state.latched = conditions | (before & kept);
  const FaultBits raised = state.latched & ~before;
  keep_codes(state, raised);
  tell_faults(state, before & ~state.latched, EventKind::fault_cleared);
  tell_faults(state, raised, EventKind::fault_raised);
  return raised;
}

void latch(CoreState& state, Fault fault) noexcept {
  const FaultBits bit = fault_bit(fault);
  if ((state.latched & bit) != 0) return;
  state.latched |= bit;
  keep_codes(state, bit);
  tell_faults(state, bit, EventKind::fault_raised);
}

void restore_latched(CoreState& state, FaultBits bits) noexcept {
  state.latched = bits;
  tell_faults(state, bits, EventKind::fault_raised);
}

void clear_latched(CoreState& state, FaultBits bits) noexcept {
  tell_faults(state, state.latched & bits, EventKind::fault_cleared);
  state.latched &= ~bits;
  keep_codes(state, 0);
}

}  // namespace hoist::core
