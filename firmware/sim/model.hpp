// What passes between the parts of the simulated world. Frames: x forward, y left, z up; harness quantities are relative to the platform.
#pragma once

#include <cstddef>
#include <cstdint>

namespace hoist::sim {

inline constexpr double kGravity_m_s2 = 9.80665;
inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kDegree_rad = kPi / 180.0;

enum class Side : std::uint8_t { left, right };
/// Where the three tilt sensors sit; the order of the bus's tilt nodes.
enum class Place : std::uint8_t { left_strut, right_strut, chassis };
inline constexpr std::size_t kPlaceCount = 3;

/// Where the platform truly is and how it moves. psi is not wrapped.
struct PlatformMotion {
  double x_m{};
  double y_m{};
  double psi_rad{};
  double speed_m_s{};
  double yaw_rate_rad_s{};
  double acceleration_m_s2{};
  double yaw_acceleration_rad_s2{};
};

/// Where the support bar is, relative to the platform: forward, left and turned to the left, with the rates of each.
struct HarnessMotion {
  double dx_m{};
  double dy_m{};
  double yaw_rad{};
  double dx_rate_m_s{};
  double dy_rate_m_s{};
  double yaw_rate_rad_s{};
};

/// What the struts' springs push on the platform (the patient feels the opposite).
struct HarnessForce {
  double forward_n{};
  double left_n{};
  double turn_n_m{};
};

/// Six axes as a sensor board gives them: specific force (at rest +g on z) and rates with the sign of the angles.
struct ImuReading {
  double ax_m_s2{};
  double ay_m_s2{};
  double az_m_s2{};
  double alpha_rate_rad_s{};
  double beta_rate_rad_s{};
  double yaw_rate_rad_s{};
};

}  // namespace hoist::sim
