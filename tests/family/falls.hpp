// True falls and faints of the family: are they found, and in time? Judged by the body alone, not by what the sensors show or the guards'
// parameters say.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string_view>

#include "tests/family/walks.hpp"

namespace hoist::family {

enum class FallKind : std::uint8_t { forward, backward, left, right, faint_forward, faint_backward, faint_aside, faint_down };
inline constexpr std::array<std::string_view, 8> kFallNames{"falls forward",  "falls backward",  "falls left",      "falls right",
                                                            "faints forward", "faints backward", "faints sideways", "faints straight down"};
constexpr std::string_view fall_name(FallKind kind) { return kFallNames[static_cast<std::size_t>(kind)]; }

/// What the body must have done for the hoist to owe a stop (SOURCES 2.1, 2.2; faults.def): H15 past 10 degrees outward with 25 degrees a
/// second, or past 13 for 0.1 s; H16 past 10 degrees for 2 s, or drawn along faster than 0.1 m/s without a swing. The budgets
/// are those of the faults, and one step for the moment between two.
inline constexpr double kFallTilt_rad = 10.0 * sim::kDegree_rad, kFallRate_rad_s = 25.0 * sim::kDegree_rad;
inline constexpr double kLying_rad = 13.0 * sim::kDegree_rad, kLying_s = 0.1;
inline constexpr double kFallBudget_s = 0.080 + 0.010, kHangBudget_s = 2.600 + 0.010, kDrawn_m_s = 0.1;

/// The lean of the body, from its true place in the harness.
class TrueLean {
 public:
  void see(const sim::HarnessMotion& harness, double seconds);
  [[nodiscard]] double lean_rad() const { return lean_rad_; }
  [[nodiscard]] double outward_rad_s() const { return rate_rad_s_; }
  [[nodiscard]] double aside_m() const { return aside_m_; }

 private:
  double lean_rad_ = 0, rate_rad_s_ = 0, aside_m_ = 0;
  bool first_ = true;
};

enum class FallEnd : std::uint8_t { found, late, at_rest, not_begun };
struct FallResult {
  FallEnd end = FallEnd::not_begun;
  double found_s = 0;                       ///< from the fall's first moment to the alarm, or to the end of the mode
  double owed_from_s = -1, owed_by_s = -1;  ///< since the fall's first moment; negative: nothing was owed
  double lean_rad = 0;                      ///< of the body when the mode ended
  bool fall = false;                        ///< owed by H15; otherwise by H16, or nothing was owed yet
};

/// Walks for some seconds, falls, and tells how it ended. `see` is called after every step from the fall's first moment on.
[[nodiscard]] FallResult fall(const WalkOptions& options, FallKind kind, const std::function<void(Walk&, double since_s)>& see = {});

}  // namespace hoist::family
