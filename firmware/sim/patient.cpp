#include "firmware/sim/patient.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::sim {
namespace {

constexpr double kStep_s = 0.001;
constexpr double kThought_s = 0.010;
constexpr double kWaitsBeforeSettingOff_s = 1.0;
/// The hoist moved more than 2 cm without a lean, or did not follow one within about 2.5 s (assumed).
constexpr double kMovedByItself_m = 0.02;
constexpr double kIgnoredLean_m = 0.05;
constexpr double kIgnoredTime_s = 2.5;
/// Signs that the therapist leads (assumed): the hoist does not slow under a lean back, speeds up beyond the wish, or hardly turns with a
/// turned pelvis. Speeding up is felt at once and counts more.
constexpr double kRolling_m_s = 0.05, kNotSlowing_m_s2 = -0.03, kLeanBack_m = 0.03;
constexpr double kFaster_m_s = 0.05, kFaster_m_s2 = 0.2, kFasterCounts_norm = 3.0;
constexpr double kTurned_rad = 0.1, kHardlyTurns_norm = 0.1, kTurnsSoon_rad_s2 = 0.02;
constexpr double kStill_m_s = 0.02, kStill_rad_s = 0.05;
/// A trial (assumed): once the hoist has stood this long, a lean of 4 to 7 cm; if the hoist rolls within kAnswersWithin_s, upright, which
/// must halve its speed. A sudden or large speed is not the patient's effect.
constexpr double kTriesAfter_s = 3.0, kTrialLean_m = 0.08, kTrialPush_per_s = 1.0;
constexpr double kAnswers_m_s = 0.03, kAnswersWithin_s = 4.0, kTrialMost_m_s = 0.25;
constexpr double kSlows_norm = 0.5, kSlowsWithin_s = 5.0;
/// The patient is helped upright once the hoist has stood this long.
constexpr double kHelpedAfter_s = 3.0;
/// Full sway from this speed on; below, steps are small, and a standing patient is still.
constexpr double kFullGait_m_s = 0.15;
constexpr double kGaitLag_s = 0.3;
/// Warp of the phase for a limp: the way from the left to the right takes longer than the way back by the limp's share of their mean.
constexpr double kLimp_rad = kPi / 4.0;
/// Pendulum of 1 m for the stumble (SOURCES 2.1) and the most that a body hanging over pushes.
constexpr double kPendulum_m = 1.0;
constexpr double kFallPush_m_s2 = 2.5;
constexpr double kFootBehind_m = 0.05;
constexpr double kAside_norm = 1e-6;  // less is forward or backward
/// Legs give way within this time; then the weight pulls forward.
constexpr double kCollapse_s = 0.4;
constexpr double kCollapsePush_m_s2 = 2.0;
/// Sideways the legs keep the body between the struts: 1 Hz, well damped.
constexpr double kCentre_rad_s = 6.28;
/// How hard the patient resists an uncomfortable lean.
constexpr double kComfort_n_m = 1200.0;
constexpr double kArrivalRoll_s = 0.9;
constexpr double kHastened_m_s = 0.08;  // festination: faster than wished (assumed)
constexpr double kStoppingLead_m_s = 0.25;
/// Bends are taken at a pace that needs no more than this turn rate (16 deg/s, half of what a full turn of the pelvis gives), never slower
/// than a stroll.
constexpr double kComfortableTurn_rad_s = 0.28;
constexpr double kSlowest_m_s = 0.15;
constexpr double kForeseenPiece_m = 0.3;
constexpr int kForeseenPieces = 5;
constexpr double kGentle_m_s2 = 0.08;
constexpr double kSlowerLag_s = 0.3;
constexpr double kFasterLag_s = 2.0;
/// Of each strut's 0.214 m to its stop, what a patient uses for lean, turn and sway together: 11.7 degrees; 14 in a hoist that answers weakly.
constexpr double kReach_m = 0.165, kReachMost_m = 0.20;
constexpr double kHalfWidth_m = 0.3;
/// What a lean brings: speed gained in a second for each metre. With the settings for walking, 0.15 m/s2 at full lean, 0.127 m: 1.18 (1.06 with
/// full lean at 0.141 m); with those as published 0.043 m/s2 at 0.185 m: 0.23. Judged between 0.01 and 0.06 m/s; a hoist that reacts late and
/// then suddenly is taken for one that another person drives.
constexpr double kUsualAnswer_per_s2 = 1.06, kLeastAnswer_per_s2 = 0.2;
constexpr double kRolls_m_s = 0.01, kUnderWay_m_s = 0.06, kSetsOffWithin_s = 4.0, kGently_m_s2 = 0.1;
/// Keeping a speed takes the lean that gains a tenth of it in a second (paper, tau_n 10 s).
constexpr double kKeeps_per_s = 0.1;
/// The lean for a lasting speed takes at most this share of the reach, so that some is left for a turn.
constexpr double kLeanShare_norm = 0.55;
/// The bend that patients have in mind: 0.8 m (the paper's figure of eight).
constexpr double kUsualBend_per_m = 1.25;

}  // namespace

PatientParams PatientParams::random(std::uint64_t seed) {
  Random random(seed ^ 0x50617469656E74ULL);
  PatientParams p;
  const auto drawn = [&random](const PatientRange& range) { return random.uniform(range.least, range.most); };
  const PatientRanges& usual = kUsualPatients;
  p.mass_kg = drawn(usual.mass_kg);
  p.wish_m_s = drawn(usual.wish_m_s);
  p.leg_force_n = drawn(usual.leg_force_n);
  p.compensation_norm = drawn(usual.compensation_norm);
  p.drive_n_s_m = p.mass_kg * drawn(usual.drive_per_s);
  p.speed_lead_m_s = drawn(usual.speed_lead_m_s);
  p.reaction_s = drawn(usual.reaction_s);
  p.yaw_lag_s = drawn(usual.yaw_lag_s);
  p.look_ahead_m = drawn(usual.look_ahead_m);
  p.foresight_s = drawn(usual.foresight_s);
  p.sway_forward_m = drawn(usual.sway_forward_m);
  p.sway_lateral_m = drawn(usual.sway_lateral_m);
  p.sway_yaw_rad = drawn(usual.sway_yaw_deg) * kDegree_rad;
  p.stride_hz = drawn(usual.stride_hz);
  return p;
}

std::string_view patient_state_name(PatientState state) {
  switch (state) {
    case PatientState::standing:
      return "standing";
    case PatientState::waiting:
      return "waiting";
    case PatientState::leading:
      return "leading";
    case PatientState::following:
      return "following";
    case PatientState::trying:
      return "trying";
    case PatientState::tripping:
      return "tripping";
    case PatientState::collapsing:
      return "collapsing";
    case PatientState::hanging:
      return "hanging";
  }
  return "unknown";
}

Patient::Patient(const PatientParams& params, const Scenario& scenario)
    : params_(params), scenario_(&scenario), path_(scenario_path(scenario)), uneven_(params.variation) {
  adapt(kUsualAnswer_per_s2);
}

void Patient::restart(const Scenario& scenario) { *this = Patient(params_, scenario); }

void Patient::fall(PatientState how, double toward_rad) {
  if (fallen() || !std::isfinite(toward_rad)) return;
  state_ = how;
  state_s_ = 0.0;
  still_s_ = 0.0;
  fall_forward_norm_ = std::cos(toward_rad);
  fall_left_norm_ = std::fabs(std::sin(toward_rad)) > kAside_norm ? std::sin(toward_rad) : 0.0;
  // The trailing foot is already a little behind when it catches.
  foot_ahead_m_ = kFootBehind_m * fall_forward_norm_;
  foot_left_m_ = kFootBehind_m * fall_left_norm_;
}

// How much the hoist opposes the patient's lead; 0 for not at all.
double Patient::opposed_by(const PlatformMotion& now) const {
  if (now.speed_m_s > pace_m_s_ + kFaster_m_s && now.acceleration_m_s2 > kFaster_m_s2) return kFasterCounts_norm;
  if (now.speed_m_s > kRolling_m_s && now.acceleration_m_s2 > kNotSlowing_m_s2 && x_m_ < -kLeanBack_m) return 1.0;
  const double turn_rad = std::fabs(yaw_goal_rad_), way = std::copysign(1.0, yaw_goal_rad_);
  const double hardly_rad_s = kHardlyTurns_norm * params_.turn_habit_per_s * turn_rad;
  const bool turns = way * now.yaw_rate_rad_s >= hardly_rad_s || way * now.yaw_acceleration_rad_s2 > kTurnsSoon_rad_s2;
  return turn_rad > kTurned_rad && now.speed_m_s > kStill_m_s && !turns ? 1.0 : 0.0;
}

void Patient::enter(PatientState state) {
  state_ = state;
  state_s_ = 0.0;
  ignored_s_ = opposed_s_ = 0.0;
}

// The response at setting off shows how much lean a speed takes.
void Patient::feel_answer(const PlatformMotion& now) {
  if (now.speed_m_s < kRolls_m_s) {
    sets_off_ = true;
    set_off_s_ = set_off_lean_m_s_ = 0.0;
  } else if (sets_off_) {
    set_off_s_ += kThought_s;
    set_off_lean_m_s_ += std::max(x_m_, 0.0) * kThought_s;
    const bool under_way = now.speed_m_s >= kUnderWay_m_s;
    if (under_way && now.acceleration_m_s2 < kGently_m_s2) adapt((kUnderWay_m_s - kRolls_m_s) / std::max(set_off_lean_m_s_, 1e-6));
    sets_off_ = !under_way && set_off_s_ < kSetsOffWithin_s;
  }
}

// Less speed for a lean: uses more of the reach and walks more slowly, because lean and turn share it.
void Patient::adapt(double answer_per_s2) {
  const double sway_m = params_.sway_forward_m + kHalfWidth_m * params_.sway_yaw_rad;
  const double turn_s = kHalfWidth_m * kUsualBend_per_m / params_.turn_habit_per_s;
  const auto bend_m_s = [&](double reach_m, double per_s2) { return (reach_m - sway_m) / (kKeeps_per_s / per_s2 + turn_s); };
  const double answer = std::clamp(answer_per_s2, kLeastAnswer_per_s2, kUsualAnswer_per_s2);
  reach_m_ = std::min(params_.reach_m * kUsualAnswer_per_s2 / answer, kReachMost_m);
  fast_m_s_ = kLeanShare_norm * (reach_m_ - sway_m) / (kKeeps_per_s / answer);
  ease_norm_ = std::min(bend_m_s(reach_m_, answer) / bend_m_s(kReach_m, kUsualAnswer_per_s2), 1.0);
}

void Patient::evaluate_leading(const PlatformMotion& now) {
  feel_answer(now);
  ignored_s_ = x_m_ > kIgnoredLean_m && now.speed_m_s < kStill_m_s ? ignored_s_ + kThought_s : 0.0;
  // Who stops by itself does not blame the hoist for rolling out.
  const double opposed = uneven_.frozen() || uneven_.resting() ? 0.0 : opposed_by(now);
  opposed_s_ = opposed > 0.0 ? opposed_s_ + opposed * kThought_s : 0.0;
  distrusts_ = ignored_s_ > kIgnoredTime_s;
  if (params_.always_leads) distrusts_ = false, opposed_s_ = 0.0;
  if (distrusts_ || opposed_s_ > params_.yields_after_s) {
    enter(PatientState::following);
  } else if (scenario_->trip_after_s > 0.0 && state_s_ >= scenario_->trip_after_s) {
    trip();
  }
}

// A hoist that the patient leads goes with the lean and slows without it. A hoist that the therapist drives does not do both.
void Patient::evaluate_trial(const PlatformMotion& now) {
  const bool leaning = trial_lean_m_ > 0.0;
  const bool late = state_s_ > (leaning ? kAnswersWithin_s : kSlowsWithin_s);
  if (late || now.acceleration_m_s2 > kFaster_m_s2 || now.speed_m_s > kTrialMost_m_s) {
    enter(PatientState::following);
    still_s_ = 0.0;
  } else if (leaning && now.speed_m_s > kAnswers_m_s) {
    trial_lean_m_ = trial_speed_m_s_ = state_s_ = 0.0;
  } else if (!leaning) {
    trial_speed_m_s_ = std::max(trial_speed_m_s_, now.speed_m_s);
    if (now.speed_m_s < kSlows_norm * trial_speed_m_s_) enter(PatientState::leading);
  }
}

// Which of the states, from what the patient feels.
void Patient::decide(const PatientSenses& senses) {
  state_s_ += kThought_s;
  const PlatformMotion& now = senses.platform;
  const bool still = std::fabs(now.speed_m_s) < kStill_m_s && std::fabs(now.yaw_rate_rad_s) < kStill_rad_s;
  still_s_ = still ? still_s_ + kThought_s : 0.0;
  if (fallen()) {
    if (still_s_ >= kHelpedAfter_s && state_s_ >= kHelpedAfter_s) {
      enter(PatientState::following);
      distrusts_ = true;
    }
    return;
  }
  if (!senses.brakes_released) {
    if (state_ != PatientState::standing) state_s_ = 0.0;
    state_ = PatientState::standing;
    distrusts_ = false;
    adapt(kUsualAnswer_per_s2);  // settings may have changed while the drives are off
    return;
  }
  if (!senses.held) {
    // Who is not held by anything stands still and lets the hoist go.
    if (state_ != PatientState::following) enter(PatientState::following);
    distrusts_ = true;
    return;
  }
  switch (state_) {
    case PatientState::standing:
      enter(PatientState::waiting);
      begin_x_m_ = now.x_m;
      begin_y_m_ = now.y_m;
      break;
    case PatientState::waiting:
      if (!params_.always_leads && std::hypot(now.x_m - begin_x_m_, now.y_m - begin_y_m_) > kMovedByItself_m) {
        distrusts_ = true;
        enter(PatientState::following);
      } else if (state_s_ >= kWaitsBeforeSettingOff_s && scenario_->figure != Figure::free) {
        pace_m_s_ = params_.wish_m_s;
        enter(PatientState::leading);
      }
      break;
    case PatientState::leading:
      evaluate_leading(now);
      break;
    case PatientState::following:
      if (!distrusts_ && still_s_ >= kTriesAfter_s) {
        trial_lean_m_ = kTrialLean_m;
        enter(PatientState::trying);
      }
      break;
    case PatientState::trying:
      evaluate_trial(now);
      break;
    default:
      break;
  }
}

// Where the pelvis should point: pure pursuit of the line ahead, minus the present turn.
void Patient::steer(const PlatformMotion& seen) {
  progress_m_ = path_.project(seen.x_m, seen.y_m, progress_m_);
  const double ahead_s = params_.reaction_s + params_.foresight_s;
  const double psi_rad = seen.psi_rad + seen.yaw_rate_rad_s * ahead_s;
  const double way_m = seen.speed_m_s * params_.reaction_s;
  const double x_m = seen.x_m + way_m * std::cos(seen.psi_rad);
  const double y_m = seen.y_m + way_m * std::sin(seen.psi_rad);
  const double look_ahead_m = ease_norm_ * params_.look_ahead_m;  // the look-ahead shrinks with the speed
  contract::PathPose goal = path_.pose(progress_m_ + look_ahead_m);
  if (!path_.closed() && progress_m_ + look_ahead_m > path_.length_m()) {
    // Past the end of a straight one looks on in its direction.
    const double beyond_m = progress_m_ + look_ahead_m - path_.length_m();
    goal.x_m += beyond_m * std::cos(goal.psi_rad);
    goal.y_m += beyond_m * std::sin(goal.psi_rad);
  }
  const double bearing_rad = std::remainder(std::atan2(goal.y_m - y_m, goal.x_m - x_m) - psi_rad, 2.0 * kPi);
  const double distance_m = std::max(0.3, std::hypot(goal.x_m - x_m, goal.y_m - y_m));
  // Arc through the goal, at the speed of the moment; a patient setting off already looks where to go.
  const double speed_m_s = std::max(seen.speed_m_s, 0.15);
  const double wanted_rad_s = 2.0 * speed_m_s * std::sin(std::clamp(bearing_rad, -kPi / 2.0, kPi / 2.0)) / distance_m;
  const double sway_m = params_.sway_forward_m + kHalfWidth_m * params_.sway_yaw_rad;
  const double left_over_m = std::max(reach_m_ - sway_m - std::fabs(x_m_), 0.0);
  const double limit_rad = std::min(params_.yaw_limit_rad, std::asin(std::min(left_over_m / kHalfWidth_m, 1.0)));
  yaw_goal_rad_ = std::clamp(wanted_rad_s / params_.turn_habit_per_s, -limit_rad, limit_rad);
  // Leaning and turning share the struts' reach (the stops): one walks slower where the line bends, and slows down before it does.
  const double needed_per_m = std::fabs(2.0 * std::sin(std::clamp(bearing_rad, -kPi / 2.0, kPi / 2.0)) / distance_m);
  double pace_goal_m_s =
      std::min({params_.wish_m_s, fast_m_s_, std::max(kSlowest_m_s, ease_norm_ * kComfortableTurn_rad_s / std::max(needed_per_m, 1e-3))});
  double psi_here_rad = path_.pose(progress_m_).psi_rad;
  for (int piece = 0; piece < kForeseenPieces; ++piece) {
    const double psi_there_rad = path_.pose(progress_m_ + (piece + 1) * kForeseenPiece_m).psi_rad;
    const double bend_per_m = std::max(std::fabs(psi_there_rad - psi_here_rad) / kForeseenPiece_m, 1e-3);
    psi_here_rad = psi_there_rad;
    const double in_bend_m_s = std::max(kSlowest_m_s, ease_norm_ * kComfortableTurn_rad_s / bend_per_m);
    pace_goal_m_s = std::min(pace_goal_m_s, std::sqrt(in_bend_m_s * in_bend_m_s + 2.0 * kGentle_m_s2 * piece * kForeseenPiece_m));
  }
  const double pace_change_m_s = pace_goal_m_s - pace_m_s_;
  pace_m_s_ += pace_change_m_s * (kThought_s / (pace_change_m_s < 0.0 ? kSlowerLag_s : kFasterLag_s));
  if (!path_.closed() && progress_m_ >= path_.length_m() - kArrivalRoll_s * std::fabs(seen.speed_m_s)) arrived_ = true;
}

// A patient who follows turns towards the line ahead, as far as anticipated, and trails behind the hoist's own turning.
void Patient::turn_along(const PlatformMotion& felt) {
  if (params_.anticipation_norm == 0.0 && params_.trailing_s == 0.0) return;
  steer(felt);
  yaw_goal_rad_ = params_.anticipation_norm * yaw_goal_rad_ - params_.trailing_s * felt.yaw_rate_rad_s;
  yaw_goal_rad_ = std::clamp(yaw_goal_rad_, -params_.yaw_limit_rad, params_.yaw_limit_rad);
}

void Patient::think(const PatientSenses& senses) {
  decide(senses);
  uneven_.decide_10ms(senses.platform.speed_m_s > kRolling_m_s, state_ == PatientState::leading && !arrived_);
  memories_[memory_at_] = {senses.platform, senses.springs.forward_n};
  const auto back =
      static_cast<std::size_t>(std::clamp(std::lround(params_.reaction_s / kThought_s), 0L, static_cast<long>(kMemories) - 1));
  const Memory& felt = memories_[(memory_at_ + kMemories - back) % kMemories];
  memory_at_ = (memory_at_ + 1) % kMemories;

  push_goal_m_s_ = felt.platform.speed_m_s;
  compensation_n_ = 0.0;
  yaw_goal_rad_ = 0.0;
  gait_goal_norm_ = 0.0;
  const double pace_norm = std::min(1.0, std::fabs(senses.platform.speed_m_s) / kFullGait_m_s);
  switch (state_) {
    case PatientState::leading: {
      steer(felt.platform);
      const bool stops = arrived_ || uneven_.resting();
      const double wish_m_s = stops ? 0.0 : pace_m_s_ + (uneven_.festinating() ? kHastened_m_s : 0.0);
      const double least_m_s = felt.platform.speed_m_s - (stops ? kStoppingLead_m_s : params_.speed_lead_m_s);
      push_goal_m_s_ = std::clamp(wish_m_s, least_m_s, felt.platform.speed_m_s + params_.speed_lead_m_s);
      // To stop, the patient lets the springs push the body back past upright, which brakes the hoist.
      compensation_n_ = stops ? 0.0 : params_.compensation_norm * felt.spring_n;
      gait_goal_norm_ = pace_norm;
      break;
    }
    case PatientState::trying:
      push_goal_m_s_ += kTrialPush_per_s * (trial_lean_m_ - x_m_);
      compensation_n_ = params_.compensation_norm * felt.spring_n;
      [[fallthrough]];
    case PatientState::following:
      if (state_ == PatientState::following) turn_along(felt.platform);
      gait_goal_norm_ = 0.6 * pace_norm;
      break;
    default:
      break;
  }
  if (frozen() || !senses.held) {
    // Feet on the spot: the legs hold the body where it is on the floor, also against the hoist.
    push_goal_m_s_ = compensation_n_ = yaw_goal_rad_ = gait_goal_norm_ = 0.0;
  }
  if (holds_turn_) yaw_goal_rad_ = held_turn_rad_;
}

double Patient::fall_push_n(const PlatformMotion& platform) {
  switch (state_) {
    case PatientState::tripping: {
      // The foot is caught; the pelvis falls over it like an inverted pendulum, until the harness holds. A foot that has slipped goes along.
      foot_ahead_m_ += (std::max(fall_forward_norm_, 0.0) * platform.speed_m_s + x_rate_m_s_) * kStep_s;
      const double lean_m_s2 = kGravity_m_s2 / kPendulum_m * foot_ahead_m_;
      return params_.mass_kg * std::clamp(lean_m_s2, -kFallPush_m_s2, kFallPush_m_s2);
    }
    case PatientState::collapsing:
      return fall_forward_norm_ * params_.mass_kg * kCollapsePush_m_s2 * std::min(1.0, state_s_ / kCollapse_s);
    case PatientState::hanging: {
      // Weight in the harness; what movement is left is damped by dragging feet.
      const double wanted_m_s2 = 9.0 * (hang_m_ - x_m_) - 6.0 * x_rate_m_s_;
      return params_.mass_kg * (wanted_m_s2 + platform.acceleration_m_s2);
    }
    default:
      return 0.0;
  }
}

// Sideways, as fall_push_n: what pushes the pelvis, for each kilogram.
double Patient::fall_aside_m_s2() {
  if (state_ == PatientState::collapsing) return fall_left_norm_ * kCollapsePush_m_s2 * std::min(1.0, state_s_ / kCollapse_s);
  foot_left_m_ += y_rate_m_s_ * kStep_s;
  return std::clamp(kGravity_m_s2 / kPendulum_m * foot_left_m_, -kFallPush_m_s2, kFallPush_m_s2);
}

void Patient::step_1ms(const PatientSenses& senses) {
  if (tick_ == 0) think(senses);
  tick_ = (tick_ + 1) % kThoughtTicks;

  // Fore and aft: legs against springs.
  const double own_m_s = senses.platform.speed_m_s + x_rate_m_s_;
  double legs_n = 0.0;
  // Who falls out of both straps soon lies on the floor.
  const bool lies = fallen() && !senses.held;
  if (lies) {
    legs_n = -params_.drive_n_s_m * own_m_s;
  } else if (fallen()) {
    legs_n = fall_push_n(senses.platform);
    if (state_ == PatientState::hanging) legs_n += senses.springs.forward_n;
  } else {
    legs_n = compensation_n_ + params_.drive_n_s_m * (push_goal_m_s_ - own_m_s);
    if (x_m_ > params_.comfort_m) legs_n -= kComfort_n_m * (x_m_ - params_.comfort_m);
    legs_n = std::clamp(legs_n, -params_.leg_force_n, params_.leg_force_n);
    // Standing or led: the feet go with the frame, and with the push of a frame that starts or brakes.
    if (state_ != PatientState::leading && state_ != PatientState::trying)
      legs_n += params_.mass_kg * 0.5 * senses.platform.acceleration_m_s2;
  }
  x_rate_m_s_ += ((legs_n - senses.springs.forward_n) / params_.mass_kg - senses.platform.acceleration_m_s2) * kStep_s;
  x_m_ += x_rate_m_s_ * kStep_s;
  // Sideways: the legs keep the body in the middle, or where this patient leans, as long as they carry it.
  double legs_aside_m_s2 = -kCentre_rad_s * (kCentre_rad_s * (y_m_ - params_.lean_left_m) + 1.6 * y_rate_m_s_);
  if (lies)
    legs_aside_m_s2 = -params_.drive_n_s_m / params_.mass_kg * y_rate_m_s_;
  else if (falls_aside())
    legs_aside_m_s2 = fall_aside_m_s2();
  const double aside_m_s2 = legs_aside_m_s2 - senses.springs.left_n / params_.mass_kg;
  y_rate_m_s_ += aside_m_s2 * kStep_s;
  y_m_ += y_rate_m_s_ * kStep_s;
  // Pelvis: two equal lags that together take yaw_lag_s.
  const double half_lag_s = params_.yaw_lag_s / 2.0;
  const double yaw_rad_s2 = (yaw_goal_rad_ - yaw_rad_) / (half_lag_s * half_lag_s) - 2.0 * yaw_rate_rad_s_ / half_lag_s;
  yaw_rate_rad_s_ += yaw_rad_s2 * kStep_s;
  yaw_rad_ += yaw_rate_rad_s_ * kStep_s;

  // Gait on top. Lateral and yaw swing once a stride, forward twice (anatomy: SOURCES 3).
  gait_norm_ += (gait_goal_norm_ - gait_norm_) * (kStep_s / kGaitLag_s);
  HarnessMotion next{x_m_, y_m_, yaw_rad_, x_rate_m_s_, y_rate_m_s_, yaw_rate_rad_s_};
  uneven_.step_1ms(gait_norm_, phase_rad_, !fallen());
  if (gait_norm_ > 1e-4) {
    const double rate_rad_s =
        uneven_.tempo_norm() * 2.0 * kPi * (params_.stride_hz + params_.stride_hz_per_m_s * std::fabs(senses.platform.speed_m_s));
    phase_rad_ += rate_rad_s * kStep_s;
    if (phase_rad_ > 2.0 * kPi) phase_rad_ -= 2.0 * kPi;
    // A held leg: the sway lingers on one side. The rate of the warped phase follows.
    const double limp = params_.limp_norm;
    const double warped_rad = limp == 0.0 ? phase_rad_ : phase_rad_ + kLimp_rad * limp * std::cos(phase_rad_);
    const double warped_rate_rad_s = limp == 0.0 ? rate_rad_s : rate_rad_s * (1.0 - kLimp_rad * limp * std::sin(phase_rad_));
    const double sine = std::sin(warped_rad);
    const double cosine = std::cos(warped_rad);
    const double forward_m = params_.sway_forward_m * gait_norm_ * uneven_.forward().value;
    const double aside_m = params_.sway_lateral_m * gait_norm_ * uneven_.aside().value;
    const double twist_rad = params_.sway_yaw_rad * gait_norm_ * uneven_.twist().value;
    next.dx_m += forward_m * 2.0 * sine * cosine;
    next.dx_rate_m_s += forward_m * 2.0 * warped_rate_rad_s * (cosine * cosine - sine * sine);
    next.dy_m += aside_m * cosine;
    next.dy_rate_m_s -= aside_m * warped_rate_rad_s * sine;
    next.yaw_rad += twist_rad * sine;
    next.yaw_rate_rad_s += twist_rad * warped_rate_rad_s * cosine;
    // Growing and shrinking steps.
    next.dx_rate_m_s += params_.sway_forward_m * gait_norm_ * uneven_.forward().rate * 2.0 * sine * cosine;
    next.dy_rate_m_s += params_.sway_lateral_m * gait_norm_ * uneven_.aside().rate * cosine;
    next.yaw_rate_rad_s += params_.sway_yaw_rad * gait_norm_ * uneven_.twist().rate * sine;
  }
  uneven_.add_to(next, params_.sway_forward_m, params_.sway_lateral_m, params_.sway_yaw_rad);
  harness_ = next;
}

}  // namespace hoist::sim
