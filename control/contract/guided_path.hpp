// An exercise that the hoist drives by itself while the therapist holds (GUIDED): what may be asked for, and what is wrong with a wish that
// may not. One definition for the core, which decides, and for the server, which tells the fields by name.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "control/contract/commands.hpp"
#include "control/contract/params.hpp"
#include "control/contract/reference_path.hpp"

namespace hoist::contract {

enum class GuidedShape : std::uint8_t { straight = 1, square = 2, circle = 3, eight = 4 };

/// Only forward: whoever is led backward does not see where to.
struct GuidedPath {
  GuidedShape shape = GuidedShape::straight;
  bool clockwise = false;  // square, circle: turns to the right; eight: begins with the left loop
  double size_m = 2.0;     // straight: length; square: side; circle: radius; eight: distance of a loop's centre from the crossing
  double radius_m = 0;     // square: of its corners, 0 = sharp, turned on the spot; eight: of its loops; otherwise 0
  double speed_m_s = 0.2;
  std::uint32_t laps = 1;
};

/// The same way over the floor; how fast it is driven may differ.
[[nodiscard]] inline bool same_figure(const GuidedPath& a, const GuidedPath& b) {
  return a.shape == b.shape && a.clockwise == b.clockwise && a.size_m == b.size_m && a.radius_m == b.radius_m && a.laps == b.laps;
}

/// Curves are driven so slowly that they need no more than this share of the turning limit; the rest corrects.
inline constexpr double kGuidedYawShare_norm = 0.8;
/// And no more than this share of the outer wheel, which leaves a straight its top speed.
inline constexpr double kGuidedWheelShare_norm = 0.93;
/// Slower than this a patient does not walk but stands.
inline constexpr double kGuidedSpeedLeast_m_s = 0.05;
inline constexpr std::uint32_t kGuidedLapsMost = 50;
/// Sizes that a hall and a hoist have in common; tighter curves than the smallest radius turn about the patient's own feet.
inline constexpr double kGuidedSizeLeast_m = 0.5, kGuidedSizeMost_m = 100.0, kGuidedRadiusLeast_m = 0.3, kGuidedRadiusMost_m = 20.0;

/// What the exercise is held against, from the parameters in force.
struct GuidedLimits {
  double speed_m_s = 0, yaw_rate_rad_s = 0, length_m = 0;
};
[[nodiscard]] inline GuidedLimits guided_limits(const Params& p) {
  // The therapist's own turning limit holds here too: the same hand leads.
  const double yaw_rate_rad_s = p.remote_yaw_rate_rad_s_max < p.yaw_rate_rad_s_max ? p.remote_yaw_rate_rad_s_max : p.yaw_rate_rad_s_max;
  return {p.speed_m_s_max * p.speed_cap_norm, yaw_rate_rad_s, p.guided_length_m_max};
}

/// The figure, in its own frame. Not valid() for sizes that make none.
[[nodiscard]] inline ReferencePath figure_of(const GuidedPath& path) {
  const auto figure = [&path] {
    switch (path.shape) {
      case GuidedShape::square:
        return path.radius_m > 0 ? ReferencePath::round_square(path.size_m, path.radius_m) : ReferencePath::square(path.size_m);
      case GuidedShape::circle:
        return ReferencePath::circle(path.size_m);
      case GuidedShape::eight:
        return ReferencePath::eight(path.size_m, path.radius_m);
      case GuidedShape::straight:
        break;
    }
    return ReferencePath::straight(path.size_m);
  };
  return path.clockwise ? figure().mirrored() : figure();
}

/// The fields of an exercise, as refusals name them (item of a command_refused event).
enum class GuidedField : std::uint8_t { none, shape, size, radius, speed, laps, length, curve };
[[nodiscard]] constexpr std::string_view guided_field_name(GuidedField field) {
  constexpr std::array<std::string_view, 8> kNames{"", "shape", "size_m", "radius_m", "speed_m_s", "laps", "length_m", "curve"};
  return kNames[static_cast<std::size_t>(field)];
}

struct GuidedProblem {
  GuidedField field = GuidedField::none;
  bool finite = true;
  double value = 0, min = 0, max = 0;
};
struct GuidedProblems {
  std::array<GuidedProblem, 6> rows{};
  std::size_t count = 0;

  void add(GuidedField field, double value, double min, double max) {
    if (count < rows.size()) rows[count++] = {field, std::isfinite(value), value, min, max};
  }
  /// Written so that a NaN fails.
  bool require(GuidedField field, double value, double min, double max) {
    const bool good = value >= min && value <= max;
    if (!good) add(field, value, min, max);
    return good;
  }
};

/// Everything that is wrong with it, each field with the range it may have.
[[nodiscard]] inline GuidedProblems check_guided(const GuidedPath& path, const GuidedLimits& limits) {
  GuidedProblems problems;
  const auto number = static_cast<double>(path.shape);
  if (!problems.require(GuidedField::shape, number, 1, 4)) return problems;
  bool sized = false;
  switch (path.shape) {
    case GuidedShape::straight:
      sized = problems.require(GuidedField::size, path.size_m, kGuidedSizeLeast_m, kGuidedSizeMost_m) &&
              problems.require(GuidedField::radius, path.radius_m, 0, 0);
      break;
    case GuidedShape::circle:
      sized = problems.require(GuidedField::size, path.size_m, kGuidedRadiusLeast_m, kGuidedRadiusMost_m) &&
              problems.require(GuidedField::radius, path.radius_m, 0, 0);
      break;
    case GuidedShape::square:
      sized = problems.require(GuidedField::size, path.size_m, kGuidedSizeLeast_m, kGuidedSizeMost_m) &&
              (path.radius_m == 0 || problems.require(GuidedField::radius, path.radius_m, kGuidedRadiusLeast_m, path.size_m / 2));
      break;
    case GuidedShape::eight:
      sized = problems.require(GuidedField::size, path.size_m, kGuidedRadiusLeast_m, kGuidedRadiusMost_m) &&
              problems.require(GuidedField::radius, path.radius_m, kGuidedRadiusLeast_m, path.size_m);
      break;
  }
  problems.require(GuidedField::speed, path.speed_m_s, kGuidedSpeedLeast_m_s, limits.speed_m_s);
  const std::uint32_t laps_most = path.shape == GuidedShape::straight ? 1 : kGuidedLapsMost;
  const bool counted = problems.require(GuidedField::laps, path.laps, 1, laps_most);
  if (!sized) return problems;
  const ReferencePath figure = figure_of(path);
  if (counted) problems.require(GuidedField::length, figure.length_m() * path.laps, 0, limits.length_m);
  // Curvature times the slowest speed must stay within the turning limit's share; faster ones are slowed in the curve.
  const double radius_m = path.shape == GuidedShape::circle ? path.size_m : path.radius_m;
  const double least_m = kGuidedSpeedLeast_m_s / (kGuidedYawShare_norm * limits.yaw_rate_rad_s);
  if (radius_m > 0) problems.require(GuidedField::curve, radius_m, least_m, kGuidedRadiusMost_m);
  return problems;
}

/// As a command carries it: a = shape, with bit 8 for clockwise; b = laps; v0 = size, v1 = radius, v2 = speed.
inline constexpr std::uint32_t kGuidedClockwise = 0x100;
[[nodiscard]] inline GuidedPath guided_of(const Command& command) {
  GuidedPath path;
  // Beyond the byte of a shape nothing is known: a number that is no shape says so in the check.
  const std::uint32_t shape = command.a & ~kGuidedClockwise;
  path.shape = static_cast<GuidedShape>(shape > 0xFF ? 0 : shape);
  path.clockwise = (command.a & kGuidedClockwise) != 0;
  path.size_m = command.v0;
  path.radius_m = command.v1;
  path.speed_m_s = command.v2;
  path.laps = command.b;
  return path;
}
inline void put_guided(Command& command, const GuidedPath& path) {
  command.kind = CommandKind::begin_guided;
  command.a = static_cast<std::uint32_t>(path.shape) | (path.clockwise ? kGuidedClockwise : 0U);
  command.b = path.laps;
  command.v0 = path.size_m;
  command.v1 = path.radius_m;
  command.v2 = path.speed_m_s;
}

/// How an exercise ended (code of a guided_ended event; the live value guided_end).
enum class GuidedEnd : std::uint8_t { none, finished, asked, commands_lost, off_path, driver_gone, stopped };
[[nodiscard]] constexpr std::string_view guided_end_name(std::uint32_t code) {
  constexpr std::array<std::string_view, 7> kNames{"none", "finished", "asked", "commands_lost", "off_path", "driver_gone", "stopped"};
  return code < kNames.size() ? kNames[code] : kNames[0];
}

}  // namespace hoist::contract
