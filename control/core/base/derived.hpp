// Numbers that follow from the parameters alone, worked out once per change instead of once per step.
#pragma once
#include <numbers>

#include "control/contract/params.hpp"
#include "control/core/law/odometry.hpp"
#include "control/core/law/pelvis.hpp"

namespace hoist::core {

using contract::kGearRatio_norm;

/// The fastest a wheel of this machine can turn, far above its motor at full voltage (40 V / 0.115 V s/rad / 30 * 0.1 m = 1.2 m/s): a
/// position that moves faster than this has jumped (a drive that restarted, a broken frame).
inline constexpr double kWheelSpeedBelievable_m_s = 3.0;

/// Zero: what a sensor sends while its strut stands upright (calibration); subtracted from every angle.
struct TiltZero {
  double alpha_rad = 0, beta_rad = 0;
  bool operator==(const TiltZero&) const = default;
};

struct Derived {
  law::PelvisGeometry<double> geometry;
  law::PelvisRange<double> range;
  law::PelvisNeutral<double> neutral;
  TiltZero left_zero, right_zero, base_zero;
  law::OdometryConfig<double> odometry;
  double left_motor_per_m = 0;  // rad at the motor for each metre of ground
  double right_motor_per_m = 0;
  double left_counts_per_s_max = 0;
  double right_counts_per_s_max = 0;
  double base_yaw_bias_rad_s = 0;

  bool operator==(const Derived&) const = default;
  /// Whether both turn equal sensor readings into equal lean and turn.
  [[nodiscard]] bool reads_posture_as(const Derived& other) const {
    return geometry == other.geometry && range == other.range && neutral == other.neutral && left_zero == other.left_zero &&
           right_zero == other.right_zero && base_zero == other.base_zero;
  }
};

[[nodiscard]] inline Derived derive(const contract::Params& p) noexcept {
  Derived d;
  d.geometry = {p.strut_length_m, p.strut_spacing_m};
  // Lean and turn may have different ranges: each is the value that (1) or (3) reaches with the struts at its own angle (D5).
  d.range = {law::full_range(d.geometry, p.lean_range_rad).dx_max_m, law::full_range(d.geometry, p.turn_range_rad).dpsi_max_rad};
  d.neutral = {p.neutral_lean_m, p.neutral_turn_rad};
  d.left_zero = {p.left_alpha_zero_rad, p.left_beta_zero_rad};
  d.right_zero = {p.right_alpha_zero_rad, p.right_beta_zero_rad};
  d.base_zero = {p.base_alpha_zero_rad, p.base_beta_zero_rad};
  d.base_yaw_bias_rad_s = p.base_yaw_bias_rad_s;
  const double per_count_m = 2.0 * std::numbers::pi * p.wheel_radius_m / p.encoder_counts_per_turn;
  d.odometry = {per_count_m * p.wheel_left_scale_norm, per_count_m * p.wheel_right_scale_norm, p.track_width_m,
                law::OdometryMethod::kEuler};
  d.left_motor_per_m = kGearRatio_norm / (p.wheel_radius_m * p.wheel_left_scale_norm);
  d.right_motor_per_m = kGearRatio_norm / (p.wheel_radius_m * p.wheel_right_scale_norm);
  d.left_counts_per_s_max = kWheelSpeedBelievable_m_s / d.odometry.left_m_per_count;
  d.right_counts_per_s_max = kWheelSpeedBelievable_m_s / d.odometry.right_m_per_count;
  return d;
}

}  // namespace hoist::core
