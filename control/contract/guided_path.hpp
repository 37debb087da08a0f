// An exercise that the hoist drives by itself while the therapist holds (GUIDED): what may be asked for, and what is wrong with a wish that
// may not. One definition for the core, which decides, and for the server, which tells the fields by name.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "control/contract/commands.hpp"
#include "control/contract/exercises.hpp"
#include "control/contract/params.hpp"

namespace hoist::contract {

using GuidedShape = ExerciseShape;

/// Only forward: a patient who is led backward does not see where to. Only of a drivable shape. Turned clockwise, an eight begins with the left loop.
struct GuidedPath : SizedExercise {
  double speed_m_s = 0.2;
  std::uint32_t laps = 1;
};

/// Whether both have the same line on the floor; their speeds may differ.
[[nodiscard]] inline bool same_figure(const GuidedPath& a, const GuidedPath& b) {
  return a.shape == b.shape && a.clockwise == b.clockwise && a.size_m == b.size_m && a.radius_m == b.radius_m && a.laps == b.laps;
}

/// Curves are driven so slowly that they need no more than this share of the turning limit; the rest corrects.
inline constexpr double kGuidedYawShare_norm = 0.8;
/// Curves also take at most this share of the outer wheel's top speed.
inline constexpr double kGuidedWheelShare_norm = 0.93;
/// Slower than this a patient does not walk but stands.
inline constexpr double kGuidedSpeedLeast_m_s = 0.05;
inline constexpr std::uint32_t kGuidedLapsMost = 50;

/// The limits that an exercise is checked against, from the parameters in force.
struct GuidedLimits {
  double speed_m_s = 0, yaw_rate_rad_s = 0, length_m = 0;
};
[[nodiscard]] inline GuidedLimits guided_limits(const Params& p) {
  // The turning limit of driving applies: hold-to-run is in the therapist's hand here, too.
  const double yaw_rate_rad_s = p.remote_yaw_rate_rad_s_max < p.yaw_rate_rad_s_max ? p.remote_yaw_rate_rad_s_max : p.yaw_rate_rad_s_max;
  return {p.speed_m_s_max * p.speed_cap_norm, yaw_rate_rad_s, p.guided_length_m_max};
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
  const ExerciseInfo* info = find_exercise(path.shape);
  if (info == nullptr || !drivable(info->shape)) {
    constexpr auto kMost = std::ranges::count_if(kExercises, [](const ExerciseInfo& row) { return drivable(row.shape); });
    problems.add(GuidedField::shape, static_cast<double>(path.shape), 1, static_cast<double>(kMost));
    return problems;
  }
  bool sized = true;
  for (const ExerciseRole role : {ExerciseRole::size, ExerciseRole::radius}) {
    const GuidedField field = role == ExerciseRole::size ? GuidedField::size : GuidedField::radius;
    const ExerciseSize* row = find_size(path.shape, role);
    const double value_m = size_of(path, role), most_m = row == nullptr ? 0 : row->driven_most_m;
    if (!sized || (row != nullptr && !row->required && value_m == 0)) continue;
    const double share_m = row != nullptr && row->share > 0 ? row->share * path.size_m : most_m;
    sized = problems.require(field, value_m, row == nullptr ? 0 : row->driven_least_m, share_m < most_m ? share_m : most_m);
  }
  problems.require(GuidedField::speed, path.speed_m_s, kGuidedSpeedLeast_m_s, limits.speed_m_s);
  const std::uint32_t laps_most = info->closed ? kGuidedLapsMost : 1;
  const bool counted = problems.require(GuidedField::laps, path.laps, 1, laps_most);
  if (!sized) return problems;
  const ReferencePath figure = figure_of(path);
  if (counted) problems.require(GuidedField::length, figure.length_m() * path.laps, 0, limits.length_m);
  // Curvature times the slowest speed must stay within the turning limit's share; faster ones are slowed in the curve.
  const double least_m = kGuidedSpeedLeast_m_s / (kGuidedYawShare_norm * limits.yaw_rate_rad_s);
  if (const ExerciseSize* curve = find_curve(path.shape); curve != nullptr && size_of(path, curve->role) > 0)
    problems.require(GuidedField::curve, size_of(path, curve->role), least_m / curve->curve, curve->driven_most_m);
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
