// The stops by strength, and the deceleration of each.
#pragma once
#include <cstdint>

#include "control/contract/params.hpp"

namespace hoist::core {

/// Which stop is in force. Later rows are stronger; a stop in force is only ever replaced by a stronger one.
enum class Braking : std::uint8_t { none, soft, remote, protective, bumper };

/// R1, SOURCES 2.1: the gentle ramp at which normal walking also slows.
inline constexpr double kSoftDeceleration_m_s2 = 0.5;
/// Driving stops a little harder than walking: the therapist has let go or the link is gone (H17: R1 at 0.8).
inline constexpr double kRemoteDeceleration_m_s2 = 0.8;

// A later row brakes at least as hard, for all values that an engineer may set.
static_assert(contract::kParams[contract::param_index(contract::ParamName::protective_deceleration_m_s2)].min >= kRemoteDeceleration_m_s2 &&
              contract::kParams[contract::param_index(contract::ParamName::bumper_deceleration_m_s2)].min >= kRemoteDeceleration_m_s2);

[[nodiscard]] inline double deceleration_m_s2(Braking braking, const contract::Params& params) noexcept {
  switch (braking) {
    case Braking::soft:
      return kSoftDeceleration_m_s2;
    case Braking::remote:
      return kRemoteDeceleration_m_s2;
    case Braking::protective:
      return params.protective_deceleration_m_s2;
    case Braking::bumper:
      return params.bumper_deceleration_m_s2;
    case Braking::none:
      break;
  }
  return params.acceleration_m_s2_max;
}

}  // namespace hoist::core
