// The seam by which tests prove that every limit of every monitor is watched by a test (tests/safety/mutants.cpp): each monitor is switched
// off and each limit made twice as lax, one at a time, and some test must fail. In the product all of this is the value itself.
//
// Every number that decides whether or when a fault is raised goes through one of the two, at the place of its use:
//
//   beyond(angle_rad, threshold<kFault, "angle">(kAngle_rad))
//   apart_ticks_ >= hold<kFault, "apart">(kApartTicks)
//   filter_.value < threshold<kFault, "voltage", Laxer::lower>(params.battery_low_v)
//
// The name tells limits of one fault apart; the same name twice is the same limit, used twice. A counter that stops counting at its limit
// must stop at the value that came through here.
#pragma once
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "control/contract/faults.hpp"

#ifdef HOIST_MUTATION
#include <array>
#endif

namespace hoist::core {

/// Which way a limit must move for its monitor to trip later or never: most are upper limits. Lower ones: a battery's voltage, a window in
/// which two events count together, a share of samples.
enum class Laxer : std::uint8_t { higher, lower };

/// A limit's name as a template argument.
template <std::size_t kSize>
struct LimitName {
  char text[kSize]{};  // NOLINT(cppcoreguidelines-avoid-c-arrays,modernize-avoid-c-arrays): a template argument must be bare
  // NOLINTNEXTLINE(google-explicit-constructor,cppcoreguidelines-avoid-c-arrays,modernize-avoid-c-arrays): made from the quoted name itself
  consteval LimitName(const char (&name)[kSize]) {
    for (std::size_t i = 0; i < kSize; ++i) text[i] = name[i];
  }
};

#ifndef HOIST_MUTATION

/// A limit of a monitor in its own unit: speed, angle, voltage, share.
template <contract::Fault, LimitName, Laxer = Laxer::higher, typename T>
[[nodiscard]] constexpr T threshold(T value) noexcept {
  return value;
}

/// Whether this fault's monitor watches: always.
[[nodiscard]] constexpr bool watches(contract::Fault) noexcept { return true; }

#else

namespace mutation {

struct Limit {
  contract::Fault fault = contract::Fault::tilt_left_lost;
  const char* name = "";
};
inline constexpr std::size_t kMostLimits = 256;
/// Every limit that the program uses: filled before main().
inline std::array<Limit, kMostLimits> limits;
inline std::size_t limit_count = 0;

/// The mutant in force: at most one of the two. Faults whose monitor is off, and the place in `limits` of the limit that is lax.
inline contract::FaultBits off_bits = 0;
inline std::size_t lax = kMostLimits;

inline std::size_t enroll(contract::Fault fault, const char* name) noexcept {
  if (limit_count < kMostLimits) limits[limit_count] = {fault, name};
  return limit_count++;
}
template <contract::Fault kFault, LimitName kName>
inline const std::size_t kPlace = enroll(kFault, kName.text);

}  // namespace mutation

template <contract::Fault kFault, LimitName kName, Laxer kLaxer = Laxer::higher, typename T>
[[nodiscard]] T threshold(T value) noexcept {
  if (mutation::lax != mutation::kPlace<kFault, kName>) return value;
  return static_cast<T>(kLaxer == Laxer::higher ? value * 2 : value / 2);
}

[[nodiscard]] inline bool watches(contract::Fault fault) noexcept { return (mutation::off_bits & contract::fault_bit(fault)) == 0; }

#endif

/// How long a condition must hold before it trips, in steps or seconds.
template <contract::Fault kFault, LimitName kName, Laxer kLaxer = Laxer::higher, typename T>
[[nodiscard]] constexpr T hold(T duration) noexcept {
  return threshold<kFault, kName, kLaxer>(duration);
}

}  // namespace hoist::core
