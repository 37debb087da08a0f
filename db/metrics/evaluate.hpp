// A recorded run judged against the figure it was walked on: projection (D27), then C of Table II and J_N of Table III.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "control/contract/reference_path.hpp"
#include "db/metrics/cross_correlation.hpp"
#include "db/metrics/normalised_ise.hpp"

namespace hoist::db {

/// The rate at which J_N is comparable with the paper's tables (D29); evaluate_at_metric_rate resamples to it.
inline constexpr double kMetricRate_hz = 100.0;

/// One run, evenly sampled, from the start of the figure; all columns of one length.
struct RunColumns {
  double dt_s{};
  std::span<const double> x_m;  ///< odometry, in the figure's frame
  std::span<const double> y_m;
  std::span<const double> psi_rad;
  std::span<const double> dpsi_rad;  ///< equation (3) as printed
};

/// The place on the figure where this pose belongs, within one lap: the nearest by J_N's own measure (1 m^2 = 1 rad^2). None when the pose is
/// further than kPlaceMost from every place, or nearly as near to another one.
inline constexpr double kPlaceMost = 0.5;
[[nodiscard]] std::optional<double> place_on(const contract::ReferencePath& path, const contract::PathPose& pose);

struct Evaluation {
  std::optional<double> c;           ///< Table II; none when one of the two signals is zero throughout
  std::optional<NormalisedIse> ise;  ///< Table III; none when the reference covered no length
};

/// The reference of one sample.
struct ReferencePoint {
  double s_m{};
  TrackPoint at;
  double omega_rad_s{};  ///< Omega_r: backward difference of the unwrapped heading / time passed, first 0
};

/// A run that is judged sample by sample; nothing of the samples is kept. Projects each one, arc length never decreasing from start_m. Over
/// missing steps the window grows by the way between both samples.
class RunEvaluation {
 public:
  RunEvaluation(const contract::ReferencePath& path, double dt_s, double start_m, double window_m = contract::kProjectionWindow_m)
      : path_(path), dt_s_(dt_s), window_m_(window_m), reference_{start_m, {}, 0.0} {}
  /// `passed`: steps since the sample before, 1 without a gap.
  const ReferencePoint& add(const TrackPoint& run, double dpsi_rad, std::uint64_t passed = 1);
  /// No value at all without samples, or with one that is not finite.
  [[nodiscard]] std::optional<Evaluation> value() const;

 private:
  contract::ReferencePath path_;
  double dt_s_, window_m_;
  bool begun_ = false, finite_ = true;
  TrackPoint last_;
  ReferencePoint reference_;
  CrossCorrelation correlation_;
  NormalisedIseSum ise_;
};

/// C, J and L at the rate the run was sampled. No value at all for columns of different length, none, a sample that is not finite,
/// a dt or a path that is not usable.
[[nodiscard]] std::optional<Evaluation> evaluate(const contract::ReferencePath& path, const RunColumns& run,
                                                 double window_m = contract::kProjectionWindow_m);

/// The same after linear resampling to 100 Hz, so that J_N of recordings made at other rates can be compared.
[[nodiscard]] std::optional<Evaluation> evaluate_at_metric_rate(const contract::ReferencePath& path, const RunColumns& run,
                                                                double window_m = contract::kProjectionWindow_m);

}  // namespace hoist::db
