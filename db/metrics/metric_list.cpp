#include "db/metrics/metric_list.hpp"

#include <array>

#include "db/metrics/run_summary.hpp"

namespace hoist::db {

namespace {

template <double RunSummary::*member>
std::optional<double> of_summary(const MetricInput& input) {
  const auto summary = run_summary(input.run);
  return summary ? std::optional<double>((*summary).*member) : std::nullopt;
}

template <double RunDeviation::*member>
std::optional<double> of_deviation(const MetricInput& input) {
  if (input.path == nullptr) return std::nullopt;
  const auto deviation = run_deviation(*input.path, input.run);
  return deviation ? std::optional<double>((*deviation).*member) : std::nullopt;
}

std::optional<double> correlation(const MetricInput& input) {
  if (input.path == nullptr) return std::nullopt;
  const auto evaluation = evaluate_at_metric_rate(*input.path, input.run);
  return evaluation ? evaluation->c : std::nullopt;
}

template <double NormalisedIse::*member>
std::optional<double> of_ise(const MetricInput& input) {
  if (input.path == nullptr) return std::nullopt;
  const auto evaluation = evaluate_at_metric_rate(*input.path, input.run);
  return evaluation && evaluation->ise ? std::optional<double>((*evaluation->ise).*member) : std::nullopt;
}

constexpr std::array kMetrics = {
    Metric{"duration_s", "s", "How long the run took.", false, &of_summary<&RunSummary::duration_s>},
    Metric{"distance_m", "m", "How far the hoist went.", false, &of_summary<&RunSummary::distance_m>},
    Metric{"mean_speed_m_s", "m/s", "Distance over duration.", false, &of_summary<&RunSummary::mean_speed_m_s>},
    Metric{"position_rms_m", "m", "Typical distance from the figure on the floor.", true, &of_deviation<&RunDeviation::position_rms_m>},
    Metric{"heading_rms_rad", "rad", "Typical difference from the figure's direction.", true,
           &of_deviation<&RunDeviation::heading_rms_rad>},
    Metric{"turn_correlation_norm", "", "How well pelvis turn and path turn agree, -1 to 1 (C, Table II).", true, &correlation},
    Metric{"normalised_ise", "", "Squared error of the whole run per metre of path at 100 Hz (J_N, equation 24).", true,
           &of_ise<&NormalisedIse::j>},
    Metric{"reference_length_m", "m", "Length of the stretch of the figure that was walked (L).", true, &of_ise<&NormalisedIse::length_m>},
};

}  // namespace

std::span<const Metric> metric_list() { return kMetrics; }

}  // namespace hoist::db
