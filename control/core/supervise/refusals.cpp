#include "control/core/supervise/refusals.hpp"

#include "control/core/modes/calibration_run.hpp"
#include "control/core/standstill.hpp"
#include "control/core/supervise/fault_sets.hpp"

namespace hoist::core {

using contract::Fault;
using contract::fault_bit;
using contract::Mode;
using contract::Refusal;
using contract::refusal_bit;

std::uint32_t where_it_stands(const CoreState& state) noexcept {
  switch (state.mode) {
    case Mode::init:
      return refusal_bit(Refusal::nodes_missing);
    case Mode::protective_stop:
      return refusal_bit(Refusal::fault_active);
    case Mode::fault:
      return refusal_bit(Refusal::fault_mode);
    case Mode::emergency_stop:
      return refusal_bit(Refusal::emergency_stop_open);
    case Mode::standby:
    case Mode::user:
    case Mode::remote:
    case Mode::calibrate:
    case Mode::guided:
      break;
  }
  return 0;
}

std::uint32_t guard_refusals(const CoreState& state, Guard guard) noexcept {
  std::uint32_t bits = 0;
  switch (guard) {
    case Guard::none:
    case Guard::finished:
    case Guard::ramp_first:
      return 0;
    case Guard::at_rest:
      return at_rest(state) ? 0U : refusal_bit(Refusal::moving);
    case Guard::stood:
    case Guard::checked:
      return !state.still.reached(kStillTicks) ? refusal_bit(Refusal::moving) : 0U;
    case Guard::ready:
      return start_refusals(state, Mode::user);
    case Guard::ready_off_a_bumper:
      return start_refusals(state, Mode::remote);
    case Guard::ready_with_a_path:
      return start_refusals(state, Mode::guided);
    case Guard::cause_gone:
      // A drive's own fault ends with the acknowledgement, and a pressed bumper can be cleared by driving only (H13). A
      // hoist on its way out of service cannot leave by this row.
      if ((state.conditions & kProtective & ~kDriveFaults & ~kBumper) != 0) bits |= refusal_bit(Refusal::cause_not_cleared);
      if ((state.latched & kBreakdown) != 0) bits |= refusal_bit(Refusal::fault_mode);
      if (!state.still.reached(kStillTicks)) bits |= refusal_bit(Refusal::moving);
      return bits;
    case Guard::only_silence:
      if ((state.conditions & kProtective & ~kSilence & ~kDriveFaults & ~kBumper) != 0 || !state.in_mode.silent.reached(kGoneTicks))
        bits |= refusal_bit(Refusal::cause_not_cleared);
      if ((state.latched & kBreakdown) != 0) bits |= refusal_bit(Refusal::fault_mode);
      if (!state.still.reached(kStillTicks)) bits |= refusal_bit(Refusal::moving);
      return bits;
    case Guard::chain_closed:
      if ((state.conditions & kPowerOff) != 0) bits |= refusal_bit(Refusal::emergency_stop_open);
      if (!at_rest(state)) bits |= refusal_bit(Refusal::moving);
      return bits;
  }
  return refusal_bit(Refusal::unknown_item);
}

std::uint32_t start_refusals(const CoreState& state) noexcept {
  const Estimate& sensed = state.sensed;
  std::uint32_t bits = 0;
  const auto add = [&bits](bool when, Refusal refusal) {
    if (when) bits |= refusal_bit(refusal);
  };
  add(state.mode != Mode::standby, Refusal::not_standby);
  add(state.mode == Mode::fault || (state.latched & kBreakdown) != 0, Refusal::fault_mode);
  add(state.mode == Mode::emergency_stop || (state.conditions & kPowerOff) != 0, Refusal::emergency_stop_open);
  add(!state.master.all_running() || sensed.tilts_stale() || sensed.base.rates_fresh().stale() || sensed.drives_lost() ||
          sensed.io.fresh().lost() || !sensed.io.battery_known(),
      Refusal::nodes_missing);
  add(state.master.any_other_version(), Refusal::node_version);
  add((state.latched & ~kWarnings) != 0, Refusal::fault_active);
  add(!state.intent.neutral(), Refusal::not_neutral);
  add(!at_rest(state), Refusal::moving);
  add((state.latched & fault_bit(Fault::battery_empty)) != 0, Refusal::battery_empty_start);
  add(!sensed.left_strut.has(tilt_status::kConverged) || !sensed.right_strut.has(tilt_status::kConverged) ||
          !sensed.base.has(tilt_status::kConverged),
      Refusal::sensors_settling);
  add(state.lease.holder == 0, Refusal::no_lease);
  // A stick out of the middle counts while a hand may still be on it.
  add(!state.remote.neutral() && state.remote.age_s(state.time_ns) <= state.params.remote_stop_age_s, Refusal::stick_not_neutral);
  add(sensed.io.bumpers() != 0, Refusal::bumper_start);
  add(!calibration_valid(state), Refusal::not_calibrated);
  add(!parts_checked(state), Refusal::parts_unchecked);
  return bits;
}

std::uint32_t guided_refusals(const CoreState& state) noexcept {
  std::uint32_t bits = state.guided.loaded() ? 0U : refusal_bit(Refusal::no_exercise);
  // Hold-to-run must be pressed for this exercise, not held from before.
  if (state.remote.held() && state.remote.age_s(state.time_ns) <= state.params.remote_stop_age_s)
    bits |= refusal_bit(Refusal::release_first);
  return bits;
}

std::uint32_t start_refusals(const CoreState& state, Mode to) noexcept {
  std::uint32_t bits = start_refusals(state);
  // In REMOTE the hoist may leave what it touches; limiter and gate allow nothing else.
  if (to == Mode::remote && (state.sensed.io.bumpers() & ~state.acknowledgement.bumpers()) == 0)
    bits &= ~refusal_bit(Refusal::bumper_start);
  if (to == Mode::guided) bits |= guided_refusals(state);
  return bits;
}

}  // namespace hoist::core
