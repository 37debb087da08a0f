// The parameters while the hoist runs (hazard H27): what is in force, a sealed copy that tells damage, the gains on their way to new values,
// and values on trial, which revert unless they are confirmed.
#pragma once
#include <cstddef>
#include <cstdint>

#include "control/contract/params.hpp"
#include "control/core/command/staging.hpp"

namespace hoist::core {

struct CoreState;

/// Gains follow their new value by at most this share of themselves in a second (H27), or of a twentieth of their range when near zero.
inline constexpr double kSlew_per_s = 0.2, kSlewFloor = 0.05;

/// Rows that may change while moving and are shaped by the limiter anyway; a lower cap must not wait.
[[nodiscard]] constexpr bool is_gain(std::size_t index) noexcept {
  using contract::ParamName;
  if (contract::kParams[index].edit != contract::EditRule::live) return false;
  for (const ParamName cap : {ParamName::speed_cap_norm, ParamName::remote_speed_m_s_max, ParamName::remote_yaw_rate_rad_s_max})
    if (index == contract::param_index(cap)) return false;
  return true;
}

/// Who asked, for the events.
struct Asked {
  std::uint32_t request_id = 0, client = 0;
};

/// Puts a checked set into force: all rows at once, one new version, one event each. `trial_s` > 0: for so long, unless confirmed.
void put_into_force(CoreState& state, const Staging& set, const Asked& asked, double trial_s) noexcept;
/// What is on trial stays. False when nothing is.
[[nodiscard]] bool confirm_trial(CoreState& state, const Asked& asked) noexcept;
/// What is on trial goes back at once. False when nothing is.
[[nodiscard]] bool revert_trial(CoreState& state, const Asked& asked) noexcept;

/// A value as the next start is to find it: without what is only on trial.
[[nodiscard]] double kept_param(const CoreState& state, std::size_t index) noexcept;

/// Takes a whole set as it is, and seals it: at the start, and after damage.
void install_params(CoreState& state, const contract::Params& params) noexcept;
/// Once per step, before anything uses them: damage in memory is found and mended from the copy that is whole, trials run out, gains move.
/// Where the drives are enabled gains do not jump.
void serve_params(CoreState& state, double dt_s) noexcept;

}  // namespace hoist::core
