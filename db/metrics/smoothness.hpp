// How smooth a speed is, without unit: SPARC and LDLJ (Balasubramanian 2012, 2015). Nearer to zero (SPARC) or less negative (LDLJ) is smoother.
#pragma once
#include <optional>
#include <span>

namespace hoist::db {

/// The longest movement: the spectrum of a longer one would take more memory than a hoist has to spare.
inline constexpr double kSmoothMost_s = 600.0;

/// Spectral arc length of the speed, sampled at 100 Hz: up to 10 Hz, and no further than the spectrum has a twentieth of its largest value;
/// padded with zeros to 16 times the next power of two. None for fewer than 2 samples or without speed.
[[nodiscard]] std::optional<double> sparc(std::span<const double> speed_m_s);

/// -ln(T^3 / v_peak^2 · integral of v''^2), of the speed's means over 0.1 s: what is faster is noise of the encoders. None for less than a
/// second, without speed, and for a speed that never bends.
[[nodiscard]] std::optional<double> ldlj(std::span<const double> speed_m_s);

}  // namespace hoist::db
