// GUIDED: the hoist drives an exercise by itself while hold-to-run is held. Releasing it stops the hoist, holding it
// again continues. Lost commands end GUIDED as they end REMOTE. A lean neither speeds the hoist up nor steers it; a
// patient who lags behind slows it, down to standstill (law/patient_lag.hpp). All monitors stay active.
#pragma once
#include <cmath>

#include "control/core/law/path_follower.hpp"
#include "control/core/law/patient_lag.hpp"
#include "control/core/modes/hold_to_run.hpp"
#include "control/core/modes/mode.hpp"
#include "control/core/standstill.hpp"

namespace hoist::core {

struct GuidedMode {
  static constexpr contract::Mode kMode = contract::Mode::guided;

  static void enter(CoreState& state) noexcept {
    state.remote.begin(state.time_ns, state.params.remote_stop_age_s);
    state.guided.begin(state.sensed.pose(), state.start.number);
  }

  static Wish step(CoreState& state, double dt_s) noexcept {
    using contract::GuidedEnd;
    const contract::Params& p = state.params;
    GuidedRun& run = state.guided;
    run.locate(state.sensed.pose());
    const bool asked = state.in_mode.leaving;
    const Hand hand = feel_hand(state);
    if (hand.leaving) {
      // The cause that already ended the mode (a request or a fault), else the release.
      run.end(asked ? (soft_fault(state) ? GuidedEnd::stopped : GuidedEnd::asked)
                    : (state.in_mode.remote_lost ? GuidedEnd::commands_lost : GuidedEnd::driver_gone));
      run.phase = GuidedPhase::ending;
      run.slow_down(run.share_norm(), false);
      return {0, 0, state.in_mode.braking, at_rest(state)};
    }
    if (!(std::fabs(run.cross_m()) <= p.guided_deviation_m_max) ||
        (run.phase != GuidedPhase::turning && !(std::fabs(run.heading_error_rad()) <= kHeadingMost_rad))) {
      return leave(state, GuidedEnd::off_path);
    }
    if (!state.in_mode.powered) return {};
    run.slow_down(share_for_lag(state, dt_s), hand.held);
    if (!hand.held) return {0, 0, Braking::remote, false};
    if (run.phase == GuidedPhase::waiting) run.phase = GuidedPhase::following;
    return run.phase == GuidedPhase::turning ? turn(state, hand) : follow(state, hand);
  }

 private:
  /// Beyond this distance the law is no longer a small correction.
  static constexpr double kHeadingMost_rad = 1.0;
  /// Gentler than the normal ramp, so that the patient sees the end coming and the ramp's own rounding has room.
  static constexpr double kApproach_m_s2 = 0.3, kApproachShare_norm = 0.6;
  static constexpr double kApproachYaw_rad_s2 = 1.0, kApproachYawShare_norm = 0.5;
  /// Delay of a changed command: one step, the limiter's rounding and the drive's lag.
  static constexpr double kLag_s = 0.08;
  /// A curve begins over this time at least.
  static constexpr double kCurveRamp_s = 0.4;
  /// A waiting hoist stands before the lean counts as hanging (H16), for any value of that parameter.
  static constexpr double kBelowHanging_norm = 0.9;
  static constexpr double kCreep_m_s = 0.03;
  static constexpr double kCreep_rad_s = 0.05, kTurned_rad = 0.008;

  /// Angles that are not fresh say nothing about the patient: the share stays, and lost sensors have their own stop.
  static double share_for_lag(const CoreState& state, double dt_s) noexcept {
    const Estimate& sensed = state.sensed;
    const GuidedRun& run = state.guided;
    if (sensed.tilts_stale()) return run.share_norm();
    const Derived& d = state.derived;
    const law::Pelvis<double>& pelvis = state.intent.pelvis();
    const double left_rad_s = sensed.left_strut.alpha_rate_rad_s() - sensed.base.alpha_rate_rad_s();
    const double right_rad_s = sensed.right_strut.alpha_rate_rad_s() - sensed.base.alpha_rate_rad_s();
    // On the line both struts lean back together; in a turn on the spot one against the other.
    double lag_rad = (d.neutral.dx0_m - pelvis.dx_m) / d.geometry.strut_length_m;
    double rate_rad_s = -(left_rad_s + right_rad_s) / 2;
    if (run.phase == GuidedPhase::turning) {
      const double way = run.corner_rad() > 0 ? 1.0 : -1.0;
      lag_rad = way * (d.neutral.dpsi0_rad - pelvis.dpsi_rad) * d.geometry.strut_spacing_m / d.geometry.strut_length_m;  // (3)
      rate_rad_s = way * (left_rad_s - right_rad_s) / 2;
    }
    law::PatientLagConfig<double> config{state.params.guided_lag_start_rad};
    config.stop_rad = least(config.stop_rad, kBelowHanging_norm * state.params.hang_tilt_rad);
    return law::patient_lag_step(config, run.share_norm(), lag_rad, rate_rad_s, dt_s);
  }

  static Wish leave(CoreState& state, contract::GuidedEnd reason) noexcept {
    state.guided.end(reason);
    state.guided.phase = GuidedPhase::ending;
    state.guided.slow_down(state.guided.share_norm(), false);
    state.in_mode.leaving = true;
    if (state.in_mode.braking < Braking::soft) state.in_mode.braking = Braking::soft;
    return {0, 0, state.in_mode.braking, at_rest(state)};
  }

  static Wish follow(CoreState& state, const Hand& hand) noexcept {
    const contract::Params& p = state.params;
    const contract::GuidedLimits limits = contract::guided_limits(p);
    GuidedRun& run = state.guided;
    if (run.leg_left_m() <= GuidedRun::kArrived_m) {
      if (!run.has_corners()) return leave(state, contract::GuidedEnd::finished);
      if (at_rest(state)) run.phase = GuidedPhase::turning;
      return {};
    }
    const double now_m_s = std::fabs(state.limiter.speed_m_s());
    // A curve is entered half before and half behind its begin on the figure, so that no heading is left over, and earlier by the lag.
    const double sharpest_s = 2.0 * limits.yaw_rate_rad_s / p.yaw_acceleration_rad_s2_max;
    const double ramp_s = sharpest_s > kCurveRamp_s ? sharpest_s : kCurveRamp_s;
    const double kappa = run.curvature_ahead(now_m_s * (kLag_s - ramp_s / 2), now_m_s * (kLag_s + ramp_s / 2));
    const double curve = law::path_curvature<double>({}, {run.cross_m(), run.heading_error_rad(), kappa});
    const double slow_m_s2 = least(kApproach_m_s2, kApproachShare_norm * p.acceleration_m_s2_max);
    double speed_m_s = least(run.wish().speed_m_s, limits.speed_m_s);
    // Slowing begins late by the lag, and by the time in which the jerk turns the present acceleration round.
    const double turns_m_s2 = std::fmax(state.limiter.acceleration_m_s2(), 0.0) + slow_m_s2;
    const double late_m = now_m_s * (kLag_s + turns_m_s2 * turns_m_s2 / (2.0 * p.jerk_m_s3_max * slow_m_s2));
    speed_m_s = least(speed_m_s, run.curve_speed(contract::kGuidedYawShare_norm * limits.yaw_rate_rad_s, WheelRoom{p}, slow_m_s2, late_m));
    // The corrected curve keeps its radius and only the speed falls; the limiter bounds the outer wheel.
    if (curve != 0) speed_m_s = least(speed_m_s, limits.yaw_rate_rad_s / std::fabs(curve));
    const double approach = law::approach_speed(run.leg_left_m() - late_m, 0.0, slow_m_s2);
    speed_m_s = least(speed_m_s, approach > kCreep_m_s ? approach : kCreep_m_s);
    LimitedSpeed speed{speed_m_s};
    speed.share(run.share_norm(), contract::SpeedCause::patient_lag);
    speed.share(hand.fresh_norm, contract::SpeedCause::command_age);
    return {speed, curve * now_m_s, Braking::none, false};
  }

  static Wish turn(CoreState& state, const Hand& hand) noexcept {
    const contract::Params& p = state.params;
    GuidedRun& run = state.guided;
    const double left_rad = run.corner_rad();
    if (std::fabs(left_rad) <= kTurned_rad) {
      if (!at_rest(state)) return {};
      if (run.last_leg()) return leave(state, contract::GuidedEnd::finished);
      run.next_leg();
      run.locate(state.sensed.pose());
      run.phase = GuidedPhase::following;
      return {};
    }
    const double slow_rad_s2 = least(kApproachYaw_rad_s2, kApproachYawShare_norm * p.yaw_acceleration_rad_s2_max);
    const double approach = law::approach_speed(std::fabs(left_rad) - std::fabs(state.limiter.yaw_rate_rad_s()) * kLag_s, 0.0, slow_rad_s2);
    // Never slower than the creep: a pelvis that does not follow at all ends in the alarm of twisted struts.
    const double most_rad_s = contract::kGuidedYawShare_norm * contract::guided_limits(p).yaw_rate_rad_s * run.share_norm();
    const double rate = std::fmax(least(most_rad_s, approach), kCreep_rad_s);
    return {0, (left_rad > 0 ? rate : -rate) * hand.fresh_norm, Braking::none, false};
  }

  [[nodiscard]] static bool soft_fault(const CoreState& state) noexcept {
    for (const contract::FaultInfo& fault : contract::kFaults)
      if (fault.reaction == contract::Reaction::soft_stop && (state.latched >> fault.bit & 1U) != 0) return true;
    return false;
  }
  [[nodiscard]] static double least(double a, double b) noexcept { return a < b ? a : b; }
};

}  // namespace hoist::core
