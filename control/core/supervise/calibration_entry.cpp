#include "control/core/supervise/calibration_entry.hpp"

#include "control/core/modes/calibration_run.hpp"
#include "control/core/supervise/supervisor.hpp"

namespace hoist::core {

using contract::Mode;
using contract::Refusal;
using contract::refusal_bit;

std::uint32_t enter_calibration(CoreState& state, const contract::CalibrationStepInfo& info) noexcept {
  if (const std::uint32_t bits = calibration_refusals(state, info); bits != 0) return bits;
  if (state.mode == Mode::calibrate) {
    end_calibration(state);
  } else {
    if (find_transition(state.mode, Mode::calibrate, Asker::driver) == nullptr) return refusal_bit(Refusal::not_standby);
    change_mode(state, Mode::calibrate);
  }
  state.in_mode.epoch = state.lease.epoch;
  begin_calibration(state, info.step);
  return 0;
}

void leave_calibration(CoreState& state, bool used) noexcept {
  state.in_mode.calibration.used = used;
  if (!used) state.in_mode.calibration.reason = contract::CalibrationReason::cancelled;
  change_mode(state, Mode::standby);
}

}  // namespace hoist::core
