// What the patient asks for, read from the struts: equations (1)-(3), page 2 of Bosnjak & Skrjanc, and their normalisation.
//
// Frames: x forward, y left, z up. alpha > 0 leans forward, beta > 0 leans right, a positive yaw turns left. All strut angles are
// RELATIVE to the chassis (strut minus chassis, each axis): a push of the chassis tilts all three sensors alike and cancels in the
// difference, while in a single strut's angle it would look like a wish of the patient.
#pragma once

#include <cmath>

namespace hoist::law {

/// The four strut angles relative to the chassis, rad.
template <typename Real>
struct StrutAngles {
  Real alpha_left_rad{};
  Real alpha_right_rad{};
  Real beta_left_rad{};
  Real beta_right_rad{};
};

/// d: height of the harness above the ball joints. d_s: distance of the two struts. Assumed until a machine is measured (D31).
template <typename Real>
struct PelvisGeometry {
  Real strut_length_m{Real(0.80)};
  Real strut_spacing_m{Real(0.60)};
  bool operator==(const PelvisGeometry&) const = default;
};

/// Displacement of the harness. dy is a measure of gait quality only and never drives the machine.
template <typename Real>
struct Pelvis {
  Real dx_m{};
  Real dy_m{};
  Real dpsi_rad{};
};

/// Equations (1)-(3) with the tangent. The factor 2 under d_s in (3) is kept as printed; geometric_yaw_rad is the true pelvis angle.
template <typename Real>
[[nodiscard]] inline Pelvis<Real> pelvis_exact(const StrutAngles<Real>& struts, const PelvisGeometry<Real>& geometry) {
  const Real tan_alpha_left = std::tan(struts.alpha_left_rad);
  const Real tan_alpha_right = std::tan(struts.alpha_right_rad);
  const Real tan_beta_left = std::tan(struts.beta_left_rad);
  const Real tan_beta_right = std::tan(struts.beta_right_rad);
  const Real d_m = geometry.strut_length_m;
  return {
      d_m * (tan_alpha_left + tan_alpha_right) / Real(2),                                          // (1)
      -d_m * (tan_beta_left + tan_beta_right) / Real(2),                                           // (2)
      std::atan(d_m * (tan_alpha_right - tan_alpha_left) / (Real(2) * geometry.strut_spacing_m)),  // (3)
  };
}

/// The small-angle forms printed after (3); "/2d_s" is read as "/(2 d_s)", the only reading that is an angle (D3).
template <typename Real>
[[nodiscard]] inline Pelvis<Real> pelvis_small_angle(const StrutAngles<Real>& struts, const PelvisGeometry<Real>& geometry) {
  const Real d_m = geometry.strut_length_m;
  return {
      d_m * (struts.alpha_left_rad + struts.alpha_right_rad) / Real(2),
      -d_m * (struts.beta_left_rad + struts.beta_right_rad) / Real(2),
      d_m * (struts.alpha_right_rad - struts.alpha_left_rad) / (Real(2) * geometry.strut_spacing_m),
  };
}

/// The yaw the pelvis really has, for screens and exports: (3) without the factor 2 (D2). Never feeds control.
template <typename Real>
[[nodiscard]] inline Real geometric_yaw_rad(const StrutAngles<Real>& struts, const PelvisGeometry<Real>& geometry) {
  const Real along_m = geometry.strut_length_m * (std::tan(struts.alpha_right_rad) - std::tan(struts.alpha_left_rad));
  return std::atan(along_m / geometry.strut_spacing_m);
}

/// The displacement that counts as a full wish, u = 1.
template <typename Real>
struct PelvisRange {
  Real dx_max_m{};
  Real dpsi_max_rad{};
  bool operator==(const PelvisRange&) const = default;
};

/// The range reached with both struts at `limit_rad` (15 deg is the mechanical stop): the value of (1), and of (3) with one strut
/// forward and the other back, so that the printed factor 2 cancels in the normalised wish (D5).
template <typename Real>
[[nodiscard]] inline PelvisRange<Real> full_range(const PelvisGeometry<Real>& geometry, Real limit_rad) {
  const Real dx_max_m = geometry.strut_length_m * std::tan(limit_rad);
  return {dx_max_m, std::atan(dx_max_m / geometry.strut_spacing_m)};
}

/// The posture of the strapped-in patient standing at ease, taken as zero (D5).
template <typename Real>
struct PelvisNeutral {
  Real dx0_m{};
  Real dpsi0_rad{};
  bool operator==(const PelvisNeutral&) const = default;
};

/// The normalised wish, each part in [-1, 1].
template <typename Real>
struct Intent {
  Real u_norm{};
  Real u_psi_norm{};
  /// False when something was not a number or the range is unusable; both wishes are then zero, and the caller must stop.
  bool valid{false};
};

/// u = clamp((dx - dx0) / dx_max, -1, 1), likewise the yaw (D5). Anything not finite, or a range that is not positive, gives zero
/// wishes and valid = false.
template <typename Real>
[[nodiscard]] inline Intent<Real> normalise(const Pelvis<Real>& pelvis, const PelvisRange<Real>& range,
                                            const PelvisNeutral<Real>& neutral) {
  const Real u = (pelvis.dx_m - neutral.dx0_m) / range.dx_max_m;
  const Real u_psi = (pelvis.dpsi_rad - neutral.dpsi0_rad) / range.dpsi_max_rad;
  // Written so that a NaN fails the comparison.
  const bool range_ok = range.dx_max_m > Real(0) && range.dpsi_max_rad > Real(0);
  if (!range_ok || !std::isfinite(u) || !std::isfinite(u_psi)) {
    return {};
  }
  const auto clamp_unit = [](Real x) { return x > Real(1) ? Real(1) : (x < Real(-1) ? Real(-1) : x); };
  return {clamp_unit(u), clamp_unit(u_psi), true};
}

}  // namespace hoist::law
