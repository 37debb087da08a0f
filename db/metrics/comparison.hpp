// A walk held against its exercise: the reference of each sample, and what Tables II and III are made of; or why there is none.
#pragma once
#include <vector>

#include "db/metrics/evaluate.hpp"
#include "db/metrics/no_figure.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

/// With more motion missing a walk is not compared with its exercise. A gap of this length anywhere in an eight of 12 m changes C by at most
/// 0.02 and J_N by at most 5 % (measured and held by test_db, Metrics.AShortGap…).
inline constexpr double kMissingMost_s = 0.5;
[[nodiscard]] inline double missing_s(const Walk& walk) { return static_cast<double>(walk.missing_samples) * kSample_s; }

/// Furthest shift that C_best tries.
inline constexpr double kLagMost_s = 2.0;
inline constexpr int kLagMost = static_cast<int>(samples_in(kLagMost_s));  ///< samples

/// The shift of x against y with the largest correlation (mean not removed, as cross_correlation), at most `most` samples to either side.
struct BestLag {
  double c = 0;
  int lag = 0;  ///< samples by which x comes before y
};
[[nodiscard]] std::optional<BestLag> best_lag(std::span<const double> x, std::span<const double> y, int most);

struct Comparison {
  NoFigure why = NoFigure::no_exercise;  ///< none: all below is there
  double start_m = 0;                    ///< place on the figure where the walk began
  double lap_m = 0;                      ///< length of the figure
  ReferenceColumns reference;
  std::optional<double> c;
  std::optional<BestLag> best;  ///< of the pelvis's turn against the path's
  std::optional<NormalisedIse> ise;
  double position_rms_m = 0;
  std::vector<double> distance_m;  ///< of each sample from its reference
  std::vector<double> lateral_m;   ///< across the path, left of it positive
  std::vector<double> heading_rad;
  std::vector<double> lap_s;  ///< of each whole time along the figure
};
[[nodiscard]] Comparison compare(const Walk& walk);

/// Root of the mean square; 0 for none.
[[nodiscard]] double rms(const std::vector<double>& values);

}  // namespace hoist::db
