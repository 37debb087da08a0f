// A recorded run judged against the figure it was walked on: projection (D27), then C of Table II and J_N of Table III.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "control/contract/reference_path.hpp"
#include "db/metrics/normalised_ise.hpp"

namespace hoist::db {

/// The rate at which J_N is comparable with the paper's tables (D29); evaluate_at_metric_rate resamples to it.
inline constexpr double kMetricRate_hz = 100.0;

/// One run, evenly sampled; all columns of one length.
struct RunColumns {
  double dt_s{};
  std::span<const double> x_m;  ///< odometry, in the figure's frame
  std::span<const double> y_m;
  std::span<const double> psi_rad;
  std::span<const double> dpsi_rad;  ///< equation (3) as printed
  /// Step of each sample; empty = one after the other. Where steps are missing, rates are over the time that passed.
  std::span<const std::uint64_t> tick{};
  double start_m{};  ///< place on the figure of the first sample
};

/// The place on the figure where this pose belongs, within one lap: the nearest by J_N's own measure (1 m^2 = 1 rad^2). None when the pose is
/// further than kPlaceMost from every place, or nearly as near to another one.
inline constexpr double kPlaceMost = 0.5;
[[nodiscard]] std::optional<double> place_on(const contract::ReferencePath& path, const contract::PathPose& pose);

/// The reference sample of each odometry sample.
struct ReferenceColumns {
  std::vector<double> s_m;
  std::vector<double> x_m;
  std::vector<double> y_m;
  std::vector<double> psi_rad;
  std::vector<double> omega_rad_s;  ///< Omega_r: backward difference of the unwrapped heading / time passed, first 0
};

struct Evaluation {
  std::optional<double> c;           ///< Table II; none when one of the two signals is zero throughout
  std::optional<NormalisedIse> ise;  ///< Table III; none when the reference covered no length
};

/// Projects each sample, arc length never decreasing from start_m. Over missing steps the window grows by the way between both samples.
[[nodiscard]] ReferenceColumns reference_of(const contract::ReferencePath& path, const RunColumns& run,
                                            double window_m = contract::kProjectionWindow_m);

/// C, J and L at the rate the run was sampled. No value at all for columns of different length, none, a sample that is not finite,
/// a dt or a path that is not usable. `reference` gets what the run was held against.
[[nodiscard]] std::optional<Evaluation> evaluate(const contract::ReferencePath& path, const RunColumns& run,
                                                 double window_m = contract::kProjectionWindow_m, ReferenceColumns* reference = nullptr);

/// The same after linear resampling to 100 Hz, so that J_N of recordings made at other rates can be compared.
[[nodiscard]] std::optional<Evaluation> evaluate_at_metric_rate(const contract::ReferencePath& path, const RunColumns& run,
                                                                double window_m = contract::kProjectionWindow_m);

}  // namespace hoist::db
