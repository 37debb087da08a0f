// A walk held against its exercise: the reference of each sample, and what Tables II and III are made of; or why there is none. Samples come one
// by one, none is kept.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "db/metrics/evaluate.hpp"
#include "db/metrics/no_figure.hpp"
#include "db/metrics/walk.hpp"

namespace hoist::db {

/// With more motion missing a walk is not compared with its exercise. A gap of this length anywhere in an eight of 12 m changes C by at most
/// 0.02 and J_N by at most 5 %, and the timed speed by at most 2 % (measured and held by test_db, Metrics.AShortGap…).
inline constexpr double kMissingMost_s = 0.5;
[[nodiscard]] inline double missing_s(const Walk& walk) { return static_cast<double>(walk.missing_samples) * kSample_s; }

/// Furthest shift that is tried.
inline constexpr double kLagMost_s = 2.0;
inline constexpr std::size_t kLagMost = samples_in(kLagMost_s);  ///< samples

struct BestLag {
  double c = 0;
  int lag = 0;  ///< samples by which x comes before y
};
/// The shift of x against y with the largest correlation (mean not removed, as CrossCorrelation), at most kLagMost samples to either side.
class BestLagSearch {
 public:
  void add(double x, double y);
  /// No value where CrossCorrelation has none.
  [[nodiscard]] std::optional<BestLag> value() const;

 private:
  static constexpr std::size_t kWindow = kLagMost + 1;
  // The last kWindow samples stand in a row from next_ on, oldest first: each is written twice, kWindow apart.
  using Window = std::array<double, 2 * kWindow>;
  Window x_{}, y_{};
  std::size_t next_ = 0;
  double x2_ = 0, y2_ = 0;
  // Of earlier x with today's y, and of today's x with earlier y: [kLagMost] without a shift, [0] with the furthest.
  std::array<double, kWindow> x_before_{}, y_before_{};
  CrossCorrelation at_zero_;
};

/// From leaving the start of the figure to coming to it again, by the clock: pauses count.
class Laps {
 public:
  Laps(double start_m, double lap_m) : start_m_(start_m), lap_m_(lap_m) {}
  void add(double s_m, std::uint64_t tick);
  [[nodiscard]] std::uint64_t count() const { return count_; }
  [[nodiscard]] double mean_s() const { return count_ == 0 ? 0.0 : sum_s_ / static_cast<double>(count_); }
  [[nodiscard]] double best_s() const { return best_s_; }

 private:
  double start_m_, lap_m_;
  bool begun_ = false, left_ = false;
  std::uint64_t begin_tick_ = 0, count_ = 0;
  double sum_s_ = 0, best_s_ = 0;
};

struct Comparison {
  NoFigure why = NoFigure::no_exercise;  ///< none: all below is there
  double start_m = 0, end_m = 0;         ///< places on the figure, along it, where the walk began and ended
  double lap_m = 0;                      ///< length of the figure
  std::optional<double> c;
  std::optional<BestLag> best;  ///< of the pelvis's turn against the path's
  std::optional<NormalisedIse> ise;
  double position_rms_m = 0;
  double distance_mean_m = 0, distance_max_m = 0;  ///< of a sample from its reference
  double lateral_rms_m = 0;                        ///< across the path
  double heading_rms_rad = 0;
  std::optional<double> lap_mean_s, lap_best_s;  ///< of each whole time along the figure
};

class Comparer {
 public:
  /// Without a path there is nothing to compare with.
  explicit Comparer(const std::optional<contract::ReferencePath>& path) : path_(path) {}
  /// The next sample that counts. `from_mark`: the walk began at the start of the figure. Gives its place along the figure, if it has one.
  std::optional<double> add(const WalkSample& sample, bool from_mark);
  [[nodiscard]] Comparison result(const Walk& walk) const;

 private:
  struct Run {
    Run(const contract::ReferencePath& path, double begin_m)
        : start_m(begin_m), evaluation(path, kSample_s, begin_m), laps(begin_m, path.length_m()) {}
    double start_m, end_m = 0;
    RunEvaluation evaluation;
    BestLagSearch best;
    Laps laps;
    std::uint64_t tick = 0;
    double position2 = 0, lateral2 = 0, heading2 = 0;  // sums of squares
    double distance = 0, distance_max = 0;             // sum and largest
  };
  std::optional<contract::ReferencePath> path_;
  bool begun_ = false;
  std::optional<Run> run_;  // nothing where the start is not clear
};

}  // namespace hoist::db
