// The one angle function that the nodes need, without the C library: the same bits on a Cortex-M0 and on this computer (with
// -ffp-contract=off), and a fifth of the code of newlib's.
#pragma once

namespace hoist::firmware {

/// Angle of the vector (x, y), -pi to pi, within 5e-7 rad; 0 for the zero vector. Finite components only, below 1e38; they may have any
/// unit. One division, four multiplications of the polynomial.
constexpr float arctan2(float y, float x) {
  constexpr float kPi = 3.14159265358979F, kHalfPi = 1.57079632679490F, kQuarterPi = 0.785398163397448F;
  constexpr float kTanEighth = 0.414213562373095F;  // tan(pi / 8)
  const float ax = x < 0 ? -x : x;
  const float ay = y < 0 ? -y : y;
  const bool steep = ay > ax;
  const float low = steep ? ax : ay, high = steep ? ay : ax;
  if (high == 0.0F) return 0.0F;
  // Down to +-tan(pi / 8) before the division: atan(q) = pi / 4 + atan((q - 1) / (q + 1)).
  const bool upper = low > kTanEighth * high;
  const float q = upper ? (low - high) / (low + high) : low / high;
  const float z = q * q;
  // Minimax polynomial of atan on that range, as in Cephes (S. Moshier, atanf).
  const float part = (((8.05374449538e-2F * z - 1.38776856032e-1F) * z + 1.99777106478e-1F) * z - 3.33329491539e-1F) * z * q + q;
  float angle = upper ? kQuarterPi + part : part;
  if (steep) angle = kHalfPi - angle;
  if (x < 0) angle = kPi - angle;
  return y < 0 ? -angle : angle;
}

}  // namespace hoist::firmware
