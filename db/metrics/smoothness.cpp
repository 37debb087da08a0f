#include "db/metrics/smoothness.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#include "db/metrics/walk.hpp"

namespace hoist::db {

namespace {

// Discrete Fourier transform in place; the length is a power of two.
void transform(std::vector<std::complex<double>>& x) {
  const std::size_t count = x.size();
  for (std::size_t i = 1, j = 0; i < count; ++i) {
    std::size_t bit = count >> 1U;
    for (; (j & bit) != 0; bit >>= 1U) j ^= bit;
    j ^= bit;
    if (i < j) std::swap(x[i], x[j]);
  }
  for (std::size_t length = 2; length <= count; length *= 2) {
    const double step_rad = -2.0 * std::numbers::pi / static_cast<double>(length);
    for (std::size_t k = 0; k < length / 2; ++k) {
      const std::complex<double> turn = std::polar(1.0, step_rad * static_cast<double>(k));
      for (std::size_t i = k; i < count; i += length) {
        const std::complex<double> odd = x[i + length / 2] * turn;
        x[i + length / 2] = x[i] - odd;
        x[i] += odd;
      }
    }
  }
}

}  // namespace

std::optional<double> sparc(std::span<const double> speed_m_s) {
  constexpr double kMost_hz = 10.0, kLeastNorm = 0.05;
  constexpr std::size_t kPadding = 16;
  if (speed_m_s.size() < 2) return std::nullopt;
  std::vector<std::complex<double>> spectrum(std::bit_ceil(speed_m_s.size()) * kPadding);
  std::copy(speed_m_s.begin(), speed_m_s.end(), spectrum.begin());
  transform(spectrum);
  const double bin_hz = 1.0 / (kSample_s * static_cast<double>(spectrum.size()));
  std::vector<double> size;
  double largest = 0;
  for (std::size_t i = 0; i < spectrum.size(); ++i) {
    const double here = std::abs(spectrum[i]);
    largest = std::max(largest, here);
    if (static_cast<double>(i) * bin_hz <= kMost_hz) size.push_back(here);
  }
  if (!(largest > 0)) return std::nullopt;
  const auto counts = [&](double value) { return value >= kLeastNorm * largest; };
  const auto first = std::find_if(size.begin(), size.end(), counts);
  const auto last = std::find_if(size.rbegin(), size.rend(), counts).base();
  if (last - first < 2) return std::nullopt;
  const double step = 1.0 / static_cast<double>(last - first - 1);
  double length = 0;
  for (auto at = first + 1; at != last; ++at) length += std::hypot(step, (*at - *(at - 1)) / largest);
  return -length;
}

std::optional<double> ldlj(std::span<const double> speed_m_s) {
  constexpr std::size_t kPiece = 10;
  constexpr double kPiece_s = kSample_s * kPiece;
  std::vector<double> v;
  for (std::size_t i = 0; i + kPiece <= speed_m_s.size(); i += kPiece) {
    double sum = 0;
    for (std::size_t k = 0; k < kPiece; ++k) sum += speed_m_s[i + k];
    v.push_back(sum / kPiece);
  }
  if (v.size() < 10) return std::nullopt;
  double peak = 0, jerk2 = 0;
  for (std::size_t i = 0; i < v.size(); ++i) peak = std::max(peak, std::fabs(v[i]));
  for (std::size_t i = 1; i + 1 < v.size(); ++i) jerk2 += std::pow((v[i + 1] - 2 * v[i] + v[i - 1]) / (kPiece_s * kPiece_s), 2) * kPiece_s;
  const double whole_s = static_cast<double>(v.size()) * kPiece_s;
  const double dimensionless = std::pow(whole_s, 3) / (peak * peak) * jerk2;
  return peak > 0 && dimensionless > 0 ? std::optional{-std::log(dimensionless)} : std::nullopt;
}

}  // namespace hoist::db
