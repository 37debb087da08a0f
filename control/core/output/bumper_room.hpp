// H13, after the stop: a bumper that still touches was acknowledged, and the therapist drives the hoist off it. Only away from it, slowly.
#pragma once
#include <cstdint>

namespace hoist::core {

/// How fast the hoist may leave what it touches (SOURCES 2.2, H13).
inline constexpr double kOffABumper_m_s = 0.1;

/// Where there is room to go, for the bumpers that are pressed: bit 0 front, 1 rear, 2 left, 3 right. Nothing turns while anything touches:
/// a turn sweeps every corner of the hoist sideways. Along a wall at the side it may go either way.
struct BumperRoom {
  double forward_m_s = 0, backward_m_s = 0;

  explicit constexpr BumperRoom(std::uint8_t bumpers) noexcept
      : forward_m_s((bumpers & 1U) != 0 ? 0.0 : kOffABumper_m_s), backward_m_s((bumpers & 2U) != 0 ? 0.0 : kOffABumper_m_s) {}
};

}  // namespace hoist::core
