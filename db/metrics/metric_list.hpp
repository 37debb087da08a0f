// THE figures of a session, in the order in which they are shown: one file each, one row each below. REST, OpenAPI, `hoist metrics`, the JSON
// export, the console and the page of figures (metrics.gen.md) follow from it.
#pragma once
#include <array>
#include <tuple>

#include "control/contract/check.hpp"
#include "db/metrics/figures/C.hpp"
#include "db/metrics/figures/C_best.hpp"
#include "db/metrics/figures/C_best_lag_s.hpp"
#include "db/metrics/figures/J_N.hpp"
#include "db/metrics/figures/J_T_m_s.hpp"
#include "db/metrics/figures/back_time_s.hpp"
#include "db/metrics/figures/balance_events.hpp"
#include "db/metrics/figures/bouts.hpp"
#include "db/metrics/figures/cadence_steps_min.hpp"
#include "db/metrics/figures/completion_norm.hpp"
#include "db/metrics/figures/cross_track_max_m.hpp"
#include "db/metrics/figures/cross_track_mean_m.hpp"
#include "db/metrics/figures/dead_band_norm.hpp"
#include "db/metrics/figures/effort_s_m.hpp"
#include "db/metrics/figures/interventions.hpp"
#include "db/metrics/figures/lap_time_best_s.hpp"
#include "db/metrics/figures/lap_time_mean_s.hpp"
#include "db/metrics/figures/ldlj.hpp"
#include "db/metrics/figures/max_speed_m_s.hpp"
#include "db/metrics/figures/mean_speed_m_s.hpp"
#include "db/metrics/figures/missing_s.hpp"
#include "db/metrics/figures/motion_s.hpp"
#include "db/metrics/figures/out_time_s.hpp"
#include "db/metrics/figures/patient_led_norm.hpp"
#include "db/metrics/figures/protective_stops.hpp"
#include "db/metrics/figures/reference_length_m.hpp"
#include "db/metrics/figures/rms_heading_rad.hpp"
#include "db/metrics/figures/rms_lateral_m.hpp"
#include "db/metrics/figures/rms_pose_m.hpp"
#include "db/metrics/figures/rms_position_m.hpp"
#include "db/metrics/figures/sparc.hpp"
#include "db/metrics/figures/start_latency_s.hpp"
#include "db/metrics/figures/step_asymmetry_norm.hpp"
#include "db/metrics/figures/step_regularity_norm.hpp"
#include "db/metrics/figures/step_symmetry_norm.hpp"
#include "db/metrics/figures/steps.hpp"
#include "db/metrics/figures/stopping_way_m.hpp"
#include "db/metrics/figures/stops.hpp"
#include "db/metrics/figures/stride_regularity_norm.hpp"
#include "db/metrics/figures/stride_time_cv_norm.hpp"
#include "db/metrics/figures/stride_time_s.hpp"
#include "db/metrics/figures/task_distance_m.hpp"
#include "db/metrics/figures/task_time_s.hpp"
#include "db/metrics/figures/timed_speed_m_s.hpp"
#include "db/metrics/figures/turn_angle_rad.hpp"
#include "db/metrics/figures/turn_lead_s.hpp"
#include "db/metrics/figures/turn_time_s.hpp"
#include "db/metrics/figures/turning_time_s.hpp"
#include "db/metrics/figures/turns_left.hpp"
#include "db/metrics/figures/turns_right.hpp"
#include "db/metrics/figures/under_way_s.hpp"
#include "db/metrics/figures/walked_m.hpp"
#include "db/metrics/figures/walking_s.hpp"
#include "db/metrics/figures/walking_speed_m_s.hpp"
#include "db/metrics/metric.hpp"

namespace hoist::db {

// clang-format off
using MetricList = std::tuple<
    figures::TaskTime,
    figures::TaskDistance,
    figures::TimedSpeed,
    figures::OutTime,
    figures::TurningTime,
    figures::BackTime,
    figures::Correlation,
    figures::CorrelationBest,
    figures::CorrelationLag,
    figures::PathError,
    figures::PathErrorTime,
    figures::ReferenceLength,
    figures::PoseError,
    figures::PositionError,
    figures::LateralError,
    figures::HeadingError,
    figures::CrossTrackMean,
    figures::CrossTrackMax,
    figures::Completion,
    figures::LapTimeMean,
    figures::LapTimeBest,
    figures::UnderWay,
    figures::MotionTime,
    figures::MissingTime,
    figures::Walked,
    figures::MeanSpeed,
    figures::MaxSpeed,
    figures::Bouts,
    figures::WalkingTime,
    figures::WalkingSpeed,
    figures::Stops,
    figures::Steps,
    figures::Interventions,
    figures::ProtectiveStops,
    figures::PatientLed,
    figures::Cadence,
    figures::StrideTime,
    figures::StrideRegularity,
    figures::StepRegularity,
    figures::StepSymmetry,
    figures::StrideVariability,
    figures::StepAsymmetry,
    figures::Sparc,
    figures::Ldlj,
    figures::TurnsLeft,
    figures::TurnsRight,
    figures::TurnAngle,
    figures::TurnTime,
    figures::TurnLead,
    figures::StartLatency,
    figures::StoppingWay,
    figures::DeadBandShare,
    figures::Effort,
    figures::BalanceEvents>;
// clang-format on

inline constexpr std::array kMetrics = std::apply([](auto... metric) { return std::array{decltype(metric)::kInfo...}; }, MetricList{});
static_assert(contract::unique_by(kMetrics, [](const MetricInfo& m) { return m.key; }), "two figures have one key");
static_assert(contract::all_rows(kMetrics, [](const MetricInfo& m) { return m.nullable || m.gate.empty(); }),
              "a figure with a gate may be absent");

/// All figures of a walk, in the order of kMetrics.
using Figures = std::array<Figure, kMetrics.size()>;
[[nodiscard]] inline Figures figures_of(const Analysis& analysis) {
  return std::apply([&analysis](auto... metric) { return Figures{decltype(metric)::of(analysis)...}; }, MetricList{});
}

}  // namespace hoist::db
