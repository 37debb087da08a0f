// The modes that move the hoist, one step at a time from random states, against their rules written a second time: from
// hazards H17 to H21, for GUIDED from DECISIONS.md (48 to 50, 120 to 123), for USER from Algorithms 1 and 2 of the paper.
// Compared: what ends the mode, how it brakes, and what it asks of the limiter.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "control/core/law/path_follower.hpp"
#include "control/core/modes/mode_list.hpp"
#include "tests/unit/core/dice.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test::rule {
namespace {

using contract::GuidedEnd;
using contract::GuidedPath;
using contract::GuidedShape;
using contract::SpeedCause;

constexpr std::uint64_t kEcho_ns = 5'000'000'000;
constexpr double kNear = 1e-7;

/// The therapist's hand and the way to it.
struct HandCase {
  bool held = false, awaits_middle = false, led = true, server = true;
  double age_s = 0, speed_norm = 0, yaw_norm = 0;
};
/// What the hand leaves of the mode.
struct HandRule {
  bool leaving = false, drives = false, lost = false;
  double fresh_norm = 0;
  Braking braking = Braking::none;
};

/// A random hand, and the state with it.
HandCase set_hand(CoreState& state, Dice& dice) {
  HandCase hand;
  contract::Params& p = state.params;
  p.remote_slow_age_s = dice.any(0.05, 0.2);
  p.remote_stop_age_s = dice.any(0.21, 0.25);
  hand.held = dice.chance(0.8);
  hand.awaits_middle = dice.chance(0.2);
  hand.age_s = dice.chance(0.5) ? dice.any(0, p.remote_slow_age_s) : dice.any(0, 0.3);
  if (hand.held) {
    hand.speed_norm = dice.any(0.1, 1) * (dice.chance(0.5) ? 1 : -1);
    hand.yaw_norm = dice.any(-1, 1);
  }
  state.lease.holder = 7;
  state.lease.epoch = state.in_mode.epoch = 4;
  state.remote.reset();
  std::uint64_t sequence = 0;
  const auto send = [&](double speed_norm, double yaw_norm, bool held) {
    EXPECT_TRUE(state.remote.take({4, 7, ++sequence, kEcho_ns, speed_norm, yaw_norm, held ? 1U : 0U}, state.lease, kEcho_ns, 1.0));
  };
  // A stick that was pushed when the mode began counts only after it was at its middle; a late release is no such middle.
  send(1, 0, true);
  state.remote.begin(kEcho_ns, 1.0);
  if (!hand.awaits_middle) send(0, 0, true);
  if (hand.held) send(hand.speed_norm, hand.yaw_norm, true);
  if (!hand.held) {
    EXPECT_TRUE(state.remote.take({4, 7, ++sequence, kEcho_ns, 0, 0, 0}, state.lease, kEcho_ns + 1, 0.0));
  }
  state.time_ns = kEcho_ns + static_cast<std::uint64_t>(std::llround(hand.age_s * 1e9));
  hand.age_s = static_cast<double>(state.time_ns - kEcho_ns) * 1e-9;
  if (dice.chance(0.1)) {
    hand.led = false;
    (dice.chance(0.5) ? state.lease.holder : state.lease.epoch) = 0;
  }
  hand.server = !dice.chance(0.05);
  state.server = {};
  for (const std::uint64_t beat : {1U, 2U}) static_cast<void>(state.server.update(hand.server ? beat : 1U));
  state.in_mode.leaving = dice.chance(0.2);
  state.in_mode.remote_lost = dice.chance(0.1);
  const Braking before[] = {Braking::soft, Braking::remote, Braking::protective, Braking::bumper};
  state.in_mode.braking = state.in_mode.leaving ? before[dice.below(std::size(before))] : Braking::none;
  return hand;
}

/// H17 to H21. Old commands end the mode, and so does a driver who is gone; then it brakes at least as hard as a release. A release always
/// brakes at its full rate, whatever ends the mode.
HandRule hand_rule(const CoreState& before, const HandCase& hand) {
  const contract::Params& p = before.params;
  const bool lost = hand.held && hand.age_s >= p.remote_stop_age_s;
  const bool ends = lost || !hand.led || !hand.server;
  HandRule rule;
  rule.leaving = before.in_mode.leaving || ends;
  rule.lost = before.in_mode.remote_lost || (lost && !before.in_mode.leaving);
  const bool as_release = ends || (rule.leaving && !hand.held);
  rule.braking = as_release ? std::max(before.in_mode.braking, Braking::remote) : before.in_mode.braking;
  rule.drives = !rule.leaving && hand.held && !hand.awaits_middle;
  const double left_norm = (p.remote_stop_age_s - hand.age_s) / (p.remote_stop_age_s - p.remote_slow_age_s);
  if (rule.drives) rule.fresh_norm = std::fmin(left_norm, 1.0);
  return rule;
}

void set_motion(CoreState& state, Dice& dice) {
  const contract::Params& p = state.params;
  state.in_mode.powered = dice.chance(0.95);
  state.sensed.odometry.standing_still = dice.chance(0.5);
  state.limiter.reset();
  if (dice.chance(0.3)) return;
  state.limiter.start_from(p, dice.any(0, p.speed_m_s_max), dice.any(-p.yaw_rate_rad_s_max, p.yaw_rate_rad_s_max));
  // It accelerates or slows.
  const double wish_m_s = dice.chance(0.7) ? p.speed_m_s_max : 0.0;
  for (std::size_t i = dice.below(15); i > 0; --i)
    state.limiter.step(p, Braking::none, wish_m_s, state.limiter.yaw_rate_rad_s(), false, 0.01);
}
bool rests(const CoreState& state) { return state.limiter.at_rest() && state.sensed.odometry.standing_still; }

void expect_wish(const Wish& wish, const Wish& rule) {
  EXPECT_NEAR(wish.speed.m_s(), rule.speed.m_s(), kNear);
  EXPECT_EQ(wish.speed.cause(), rule.speed.cause());
  EXPECT_NEAR(wish.yaw_rate_rad_s, rule.yaw_rate_rad_s, kNear);
  EXPECT_EQ(wish.braking, rule.braking);
  EXPECT_EQ(wish.done, rule.done);
}
void expect_hand(const CoreState& state, const CoreState& before, const HandCase& hand, const HandRule& rule) {
  EXPECT_EQ(state.in_mode.leaving, rule.leaving);
  EXPECT_EQ(state.in_mode.remote_lost, rule.lost);
  EXPECT_EQ(state.in_mode.braking, rule.braking);
  const bool lost = hand.held && hand.age_s >= before.params.remote_stop_age_s;
  EXPECT_EQ(state.remote.held(), hand.held && !lost);
  EXPECT_EQ(state.remote.awaits_neutral(), hand.awaits_middle || lost) << "what comes back must pass the middle";
}

/// In GUIDED, every node answers.
CoreState running() {
  ScriptedHoist hoist;
  EXPECT_TRUE(hoist.start(Mode::guided));
  return hoist.state;
}

TEST(HoldToRun, DrivingFollowsTheStickAsLongAsTheHandIsThere) {
  const CoreState base = running();
  Dice dice(1);
  for (int i = 0; i < 4000 && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = base;
    contract::Params& p = before.params;
    p.remote_speed_m_s_max = dice.any(0.05, 0.6);
    p.remote_yaw_rate_rad_s_max = dice.any(0.05, 0.87);
    const HandCase hand = set_hand(before, dice);
    set_motion(before, dice);
    const HandRule rule = hand_rule(before, hand);
    Wish wanted;
    if (rule.leaving) {
      wanted = {0, 0, rule.braking, rests(before)};
    } else if (before.in_mode.powered && !rule.drives) {
      wanted.braking = Braking::remote;
    } else if (before.in_mode.powered) {
      wanted.speed = LimitedSpeed{hand.speed_norm * p.remote_speed_m_s_max};
      wanted.speed.share(rule.fresh_norm, SpeedCause::command_age);
      wanted.yaw_rate_rad_s = hand.yaw_norm * p.remote_yaw_rate_rad_s_max * rule.fresh_norm;
    }
    CoreState state = before;
    expect_wish(RemoteMode::step(state, 0.01), wanted);
    expect_hand(state, before, hand, rule);
    CoreState other = before;
    const Hand felt = feel_hand(other);
    EXPECT_EQ(felt.leaving, rule.leaving);
    EXPECT_EQ(felt.held, rule.drives);
    EXPECT_NEAR(felt.fresh_norm, rule.fresh_norm, kNear);
  }
}

// Both modes forget a hold that is too old, and a stick that is pushed must pass its middle.
TEST(HoldToRun, AModeBeginsWithoutTheHoldOfBefore) {
  CoreState base = running();
  base.lease = {4, 7};
  for (const bool guided : {false, true})
    for (const double stick_norm : {0.0, 0.5})
      for (const double age_s : {0.1, 0.3}) {
        SCOPED_TRACE(testing::Message() << guided << ' ' << stick_norm << ' ' << age_s);
        CoreState state = base;
        state.remote.reset();
        ASSERT_TRUE(state.remote.take({4, 7, 1, kEcho_ns, stick_norm, 0, 1}, state.lease, kEcho_ns, 1.0));
        state.time_ns = kEcho_ns + static_cast<std::uint64_t>(age_s * 1e9);
        guided ? GuidedMode::enter(state) : RemoteMode::enter(state);
        EXPECT_EQ(state.remote.held(), age_s < state.params.remote_stop_age_s);
        EXPECT_EQ(state.remote.awaits_neutral(), stick_norm > 0);
      }
}

constexpr GuidedPath kExercises[] = {
    {{GuidedShape::straight, false, 2.0, 0}, 0.3, 1}, {{GuidedShape::square, false, 0.8, 0}, 0.3, 2},
    {{GuidedShape::square, true, 0.8, 0}, 0.3, 1},    {{GuidedShape::square, false, 2.0, 0.4}, 0.3, 1},
    {{GuidedShape::circle, true, 0.8, 0}, 0.3, 1},    {{GuidedShape::eight, false, 1.0, 0.8}, 0.3, 1},
    {{GuidedShape::slalom, false, 2.0, 0}, 0.3, 1},
};

/// Both struts and the chassis at new angles, with a rate.
void set_tilts(CoreState& state, Dice& dice) {
  const auto set = [&](TiltSensor& tilt, double middle_deg, double reach_deg) {
    tilt.restart();
    const double alpha_deg = middle_deg + dice.any(-reach_deg, reach_deg), step_deg = dice.chance(0.5) ? 0 : dice.any(-0.3, 0.3);
    for (int i = 0; i < 2; ++i) {
      contract::CanFrame frame{0, 6, 0, {}};
      contract::write_slot(frame, contract::pdo_slot(contract::Pdo::tilt_tx1, 0x6010), std::lround((alpha_deg + i * step_deg) * 1000));
      contract::write_slot(frame, contract::pdo_slot(contract::Pdo::tilt_tx1, 0x2120), 3);
      contract::write_slot(frame, contract::pdo_slot(contract::Pdo::tilt_tx1, 0x2121), i + 1);
      tilt.take_angles(frame);
    }
  };
  const double lean_deg = dice.any(-12, 2);
  set(state.sensed.left_strut, lean_deg, 4);
  set(state.sensed.right_strut, lean_deg, 4);
  set(state.sensed.base, 0, 2);
  const std::size_t age = dice.below(6);
  TiltSensor* const late[] = {&state.sensed.left_strut, &state.sensed.right_strut, &state.sensed.base};
  if (dice.chance(0.5))
    for (std::size_t i = 0; i < age; ++i) late[dice.below(3)]->next_tick();
  state.intent.update(state.sensed, state.derived, 0.05, 0, 0.01);
}

/// The share of its speed for a patient who lags (120, 121).
double lag_share(const CoreState& before, bool turns, double corner_rad, double dt_s) {
  const contract::Params& p = before.params;
  const Estimate& sensed = before.sensed;
  if (sensed.tilts_stale()) return before.guided.share_norm();
  const double base_rad = sensed.base.alpha_rad(), base_rad_s = sensed.base.alpha_rate_rad_s();
  const double left = std::tan(sensed.left_strut.alpha_rad() - base_rad), right = std::tan(sensed.right_strut.alpha_rad() - base_rad);
  const double left_rad_s = sensed.left_strut.alpha_rate_rad_s() - base_rad_s,
               right_rad_s = sensed.right_strut.alpha_rate_rad_s() - base_rad_s;
  // Lean against the motion, measured from the neutral lean.
  double lag_rad = p.neutral_lean_m / p.strut_length_m - (left + right) / 2;
  double lag_rad_s = -(left_rad_s + right_rad_s) / 2;
  if (turns) {
    // Half the difference of the struts, against the turn: in a turn to the left the right strut leads.
    const double turned_rad = std::atan(p.strut_length_m * (right - left) / (2 * p.strut_spacing_m));
    const double way = corner_rad > 0 ? 1 : -1;
    lag_rad = way * (p.neutral_turn_rad - turned_rad) * p.strut_spacing_m / p.strut_length_m;
    lag_rad_s = way * -(right_rad_s - left_rad_s) / 2;
  }
  // None from 9 degrees on, or from 0.9 of the hanging limit; 0.2 s ahead; falls by 1.0 and rises by 0.4 a second.
  const double none_rad = std::fmin(9 * kDeg, 0.9 * p.hang_tilt_rad);
  const double wanted = std::clamp((none_rad - lag_rad - 0.2 * lag_rad_s) / (none_rad - p.guided_lag_start_rad), 0.0, 1.0);
  const double share = before.guided.share_norm();
  return std::clamp(wanted, share - 1.0 * dt_s, share + 0.4 * dt_s);
}

/// One step of an exercise from a random place, and what it must come to.
class GuidedStep {
 public:
  GuidedStep(const CoreState& base, std::uint32_t seed) : dice_(seed), before_(base) {
    set_params();
    hand_ = set_hand(before_, dice_);
    place();
    set_motion(before_, dice_);
    set_tilts(before_, dice_);
    before_.guided.slow_down(dice_.any(0, 1), true);
    before_.latched = dice_.chance(0.5) ? 0 : contract::FaultBits{1} << contract::kFaults[dice_.below(contract::kFaults.size())].bit;
    dt_s_ = dice_.chance(0.3) ? 0.01 : 3.0;
  }
  void check() {
    work_out();
    CoreState state = before_;
    expect_wish(GuidedMode::step(state, dt_s_), wish_);
    EXPECT_EQ(state.in_mode.leaving, leaving_);
    EXPECT_EQ(state.in_mode.braking, braking_);
    EXPECT_EQ(state.guided.phase, phase_);
    EXPECT_EQ(state.guided.ended(), end_);
    EXPECT_NEAR(state.guided.share_norm(), share_norm_, kNear);
    EXPECT_EQ(state.guided.held_back(), held_back_);
    const GuidedRun& after = next_leg_ ? after_next_ : run_;
    EXPECT_EQ(state.guided.last_leg(), after.last_leg());
    EXPECT_NEAR(state.guided.left_m(), end_ == GuidedEnd::finished ? 0.0 : after.left_m(), kNear);
    if (!std::isnan(after.cross_m())) {
      EXPECT_NEAR(state.guided.cross_m(), after.cross_m(), kNear);
    }
  }

 private:
  void set_params() {
    contract::Params& p = before_.params;
    p.neutral_lean_m = dice_.any(-0.03, 0.03);
    p.neutral_turn_rad = dice_.any(-0.05, 0.05);
    p.strut_length_m = dice_.any(0.5, 1.0);
    p.strut_spacing_m = dice_.any(0.4, 0.8);
    p.speed_m_s_max = dice_.any(0.2, 0.65);
    p.speed_cap_norm = dice_.any(0.5, 1);
    p.yaw_rate_rad_s_max = dice_.any(0.2, 0.87);
    p.remote_yaw_rate_rad_s_max = dice_.any(0.2, 0.87);
    p.acceleration_m_s2_max = dice_.any(0.1, 0.5);
    p.jerk_m_s3_max = dice_.any(0.5, 5);
    p.yaw_acceleration_rad_s2_max = dice_.any(0.3, 2.1);
    p.guided_deviation_m_max = dice_.any(0.05, 0.4);
    p.guided_lag_start_rad = dice_.any(0.02, 0.08);
    p.hang_tilt_rad = dice_.any(0.1, 0.25);
    before_.derived = derive(p);
  }

  /// The hoist somewhere on a leg of the exercise, often about its end.
  void place() {
    GuidedPath path = kExercises[dice_.below(std::size(kExercises))];
    path.speed_m_s = dice_.any(0.05, 0.65);
    const contract::ReferencePath figure = contract::figure_of(path);
    const law::Pose<double> begin{dice_.any(-5, 5), dice_.any(-5, 5), dice_.any(-5, 5)};
    GuidedRun& run = before_.guided;
    run.load(path);
    run.begin(begin, 1);
    const bool corners = run.has_corners();
    const double leg_m = corners ? path.size_m : figure.length_m() * path.laps;
    const std::size_t leg = corners ? dice_.below(4 * path.laps) : 0;
    for (std::size_t i = 0; i < leg; ++i) run.next_leg();
    const contract::PathPose start = figure.pose(0);
    const double turn_rad = begin.psi_rad - start.psi_rad;
    const auto floor = [&](double s_m, double ahead_m, double left_m, double off_rad) {
      // The end of a leg looks along that leg.
      const contract::PathPose at = figure.pose(std::fmin(s_m, leg_m * static_cast<double>(leg + 1) - 1e-5));
      const std::complex<double> place_m = std::complex<double>(at.x_m - start.x_m, at.y_m - start.y_m) +
                                           std::polar(1.0, at.psi_rad) * std::complex<double>(ahead_m, left_m);
      const std::complex<double> on_m = std::complex<double>(begin.x_m, begin.y_m) + std::polar(1.0, turn_rad) * place_m;
      return law::Pose<double>{on_m.real(), on_m.imag(), at.psi_rad + turn_rad + off_rad};
    };
    const bool turns = corners && dice_.chance(0.5);
    const double begin_m = leg_m * static_cast<double>(leg), end_m = begin_m + leg_m;
    const double s_m = turns || dice_.chance(0.4) ? end_m - dice_.any(0, 0.02) : dice_.any(begin_m, end_m);
    for (double way_m = begin_m; way_m < s_m; way_m += 0.4) run.locate(floor(way_m, 0, 0, 0));
    const double corner_rad = path.clockwise ? -std::numbers::pi / 2 : std::numbers::pi / 2;
    const double off_rad = turns && dice_.chance(0.7) ? corner_rad + (dice_.chance(0.5) ? dice_.any(-0.015, 0.015) : dice_.any(-0.5, 0.5))
                                                      : dice_.any(-1, 1) * (dice_.chance(0.2) ? 1.4 : 0.2);
    const double left_m = dice_.any(-1, 1) * (dice_.chance(0.2) ? 0.5 : 0.04), ahead_m = dice_.chance(0.3) ? dice_.any(0, 0.02) : 0.0;
    before_.sensed.fused.set_pose(dice_.chance(0.01) ? law::Pose<double>{NAN, 0, 0} : floor(s_m, ahead_m, left_m, off_rad));
    run.phase = turns ? GuidedPhase::turning : (dice_.chance(0.3) ? GuidedPhase::waiting : GuidedPhase::following);
  }

  void work_out() {
    const HandRule rule = hand_rule(before_, hand_);
    const contract::Params& p = before_.params;
    run_ = before_.guided;
    run_.locate(before_.sensed.pose());
    leaving_ = rule.leaving;
    braking_ = rule.braking;
    phase_ = run_.phase;
    share_norm_ = run_.share_norm();
    held_back_ = run_.held_back();
    if (rule.leaving) {
      const contract::FaultInfo* fault = nullptr;
      for (const contract::FaultInfo& row : contract::kFaults)
        if (before_.latched == contract::FaultBits{1} << row.bit) fault = &row;
      const bool soft = fault != nullptr && fault->reaction == contract::Reaction::soft_stop;
      stop(before_.in_mode.leaving ? (soft ? GuidedEnd::stopped : GuidedEnd::asked)
                                   : (rule.lost ? GuidedEnd::commands_lost : GuidedEnd::driver_gone));
      return;
    }
    const bool turns = phase_ == GuidedPhase::turning;
    // Off the line, also by an angle that the law no longer corrects gently; a turn on the spot has any angle.
    if (!(std::fabs(run_.cross_m()) <= p.guided_deviation_m_max) || (!turns && !(std::fabs(run_.heading_error_rad()) <= 1.0))) {
      stop(GuidedEnd::off_path);
      return;
    }
    if (!before_.in_mode.powered) return;
    share_norm_ = lag_share(before_, turns, run_.corner_rad(), dt_s_);
    held_back_ = rule.drives && share_norm_ < 1;
    if (!rule.drives) {
      wish_.braking = Braking::remote;
      return;
    }
    if (phase_ == GuidedPhase::waiting) phase_ = GuidedPhase::following;
    turns ? turn(rule.fresh_norm) : follow(rule.fresh_norm);
  }
  void stop(GuidedEnd reason) {
    end_ = reason;
    leaving_ = true;
    braking_ = std::max(braking_, Braking::soft);
    phase_ = GuidedPhase::ending;
    held_back_ = false;
    wish_ = {0, 0, braking_, rests(before_)};
  }

  void follow(double fresh_norm) {
    const contract::Params& p = before_.params;
    if (run_.leg_left_m() <= 0.008) {
      if (!run_.has_corners())
        stop(GuidedEnd::finished);
      else if (rests(before_))
        phase_ = GuidedPhase::turning;
      return;
    }
    const double yaw_most_rad_s = std::fmin(p.yaw_rate_rad_s_max, p.remote_yaw_rate_rad_s_max);
    const double now_m_s = before_.limiter.speed_m_s(), slow_m_s2 = std::fmin(0.3, 0.6 * p.acceleration_m_s2_max);
    // A curve begins over 0.4 s, or in the time in which the turn rate can be turned round; half of it before, and 0.08 s early.
    const double ramp_s = std::fmax(0.4, 2 * yaw_most_rad_s / p.yaw_acceleration_rad_s2_max);
    const double ahead = run_.curvature_ahead(now_m_s * (0.08 - ramp_s / 2), now_m_s * (0.08 + ramp_s / 2));
    const double curve = law::path_curvature<double>({}, {run_.cross_m(), run_.heading_error_rad(), ahead});
    // Slowing begins 0.08 s late, and by the way in which the jerk takes the acceleration from what it is to the full deceleration.
    const double swing_m_s2 = std::fmax(before_.limiter.acceleration_m_s2(), 0) + slow_m_s2, swing_s = swing_m_s2 / p.jerk_m_s3_max;
    const double late_m = now_m_s * 0.08 + now_m_s * swing_s * swing_m_s2 / (2 * slow_m_s2);
    double speed_m_s = std::fmin(run_.wish().speed_m_s, p.speed_m_s_max * p.speed_cap_norm);
    speed_m_s = std::fmin(speed_m_s, run_.curve_speed(0.8 * yaw_most_rad_s, WheelRoom{p}, slow_m_s2, late_m));
    if (curve != 0) speed_m_s = std::fmin(speed_m_s, yaw_most_rad_s / std::fabs(curve));
    // To the end with this deceleration, and the last bit at 3 cm/s.
    const double end_m_s = std::sqrt(std::fmax(2 * slow_m_s2 * (run_.leg_left_m() - late_m), 0));
    speed_m_s = std::fmin(speed_m_s, std::fmax(end_m_s, 0.03));
    wish_.speed = LimitedSpeed{speed_m_s};
    wish_.speed.share(share_norm_, SpeedCause::patient_lag);
    wish_.speed.share(fresh_norm, SpeedCause::command_age);
    wish_.yaw_rate_rad_s = curve * now_m_s;
  }

  void turn(double fresh_norm) {
    const contract::Params& p = before_.params;
    const double left_rad = run_.corner_rad();
    if (std::fabs(left_rad) <= 0.008) {
      if (!rests(before_)) return;
      if (run_.last_leg()) {
        stop(GuidedEnd::finished);
        return;
      }
      next_leg_ = true;
      after_next_ = run_;
      after_next_.next_leg();
      after_next_.locate(before_.sensed.pose());
      phase_ = GuidedPhase::following;
      return;
    }
    const double slow_rad_s2 = std::fmin(1.0, 0.5 * p.yaw_acceleration_rad_s2_max);
    const double seen_rad = std::fabs(left_rad) - 0.08 * std::fabs(before_.limiter.yaw_rate_rad_s());
    const double end_rad_s = std::sqrt(std::fmax(2 * slow_rad_s2 * seen_rad, 0));
    const double most_rad_s = 0.8 * std::fmin(p.yaw_rate_rad_s_max, p.remote_yaw_rate_rad_s_max) * share_norm_;
    // Never slower than the creep, also for a patient who does not follow.
    const double rate_rad_s = std::fmax(std::fmin(most_rad_s, end_rad_s), 0.05);
    wish_.yaw_rate_rad_s = std::copysign(rate_rad_s, left_rad) * fresh_norm;
  }

  Dice dice_;
  CoreState before_;
  HandCase hand_;
  double dt_s_ = 0;
  // What must come out.
  GuidedRun run_, after_next_;
  Wish wish_;
  bool leaving_ = false, held_back_ = false, next_leg_ = false;
  Braking braking_ = Braking::none;
  GuidedPhase phase_ = GuidedPhase::none;
  GuidedEnd end_ = GuidedEnd::none;
  double share_norm_ = 1;
};

TEST(HoldToRun, AnExerciseAsksForWhatItsRulesSay) {
  const CoreState base = running();
  for (std::uint32_t seed = 0; seed < 6000 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    GuidedStep(base, seed).check();
  }
}

// Algorithms 1 and 2 on the harness, with the gains as they are in force now.
TEST(UserMode, AsksForWhatBothAlgorithmsSay) {
  const CoreState base = running();
  Dice dice(3);
  for (int i = 0; i < 3000 && !testing::Test::HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = base;
    contract::Params& p = before.live;
    p.lean_dead_band_norm = dice.any(0, 0.5);
    p.lean_tau_normal_s = dice.any(0.5, 60);
    p.lean_tau_release_s = dice.any(0.1, 20);
    p.braking_softness_norm = dice.any(0.5, 50);
    p.reversal_gain_norm = dice.any(0, 0.01);
    p.lean_gain_direct_units = dice.any(0, 10);
    p.lean_gain_filtered_units = dice.any(0, 100);
    p.lean_filtered_units_max = dice.any(1, 100);
    before.params.speed_cap_norm = dice.any(0.2, 1);
    const bool slopes = dice.chance(0.3);
    if (slopes) before.latched |= contract::fault_bit(Fault::base_tilt_high);
    p.speed_per_unit_m_s = dice.any(0.002, 0.05);
    p.turn_dead_band_norm = dice.any(0, 0.5);
    p.turn_tau_normal_s = dice.any(0.1, 20);
    p.turn_tau_release_s = dice.any(0.02, 5);
    p.turn_gain_direct_units = dice.any(0, 10);
    p.turn_gain_filtered_units = dice.any(0, 100);
    p.yaw_rate_per_unit_rad_s = dice.any(0.001, 0.05);
    set_tilts(before, dice);
    set_motion(before, dice);
    before.lean = {dice.any(-40, 40), dice.any(-40, 40)};
    before.turn = {dice.any(-40, 40), dice.any(-40, 40)};
    before.in_mode.leaving = dice.chance(0.1);
    before.in_mode.braking = before.in_mode.leaving ? Braking::soft : Braking::none;
    const double u = before.intent.lean_norm(), u_turn = before.intent.turn_norm(), dt_s = 0.01;

    Wish wanted;
    // The floor, this patient's cap and the law's own bound: the least of them.
    double most = before.params.speed_m_s_max * before.params.speed_cap_norm;
    if (slopes) most = std::min(most, before.params.base_tilt_speed_m_s_max);
    most = std::min(most / p.speed_per_unit_m_s, p.lean_filtered_units_max);
    double v = before.lean.v_units, v_f = before.lean.v_f_units, w = before.turn.omega_units, w_f = before.turn.omega_f_units;
    if (before.in_mode.leaving) {
      v = v_f = w = w_f = 0;
      wanted = {0, 0, Braking::soft, rests(before)};
    } else if (before.in_mode.powered) {
      v_f = std::clamp(v_f, -most, most);
      if (std::fabs(u) < p.lean_dead_band_norm) {
        v = v_f = v_f * std::exp(-dt_s / p.lean_tau_release_s);
      } else {
        const double forced = p.lean_gain_filtered_units * u, keep = std::exp(-dt_s / p.lean_tau_normal_s);
        const double brake = std::exp(-(std::fabs(u) - p.lean_dead_band_norm) / p.braking_softness_norm);
        v_f = u * v < 0 ? brake * v_f + p.reversal_gain_norm * forced : keep * v_f + (1 - keep) * forced;
        v_f = std::clamp(v_f, -most, most);
        v = p.lean_gain_direct_units * u + v_f;
      }
      if (std::fabs(u_turn) < p.turn_dead_band_norm) {
        // Inside the dead-band the input is discarded (D9).
        w = w_f = w_f * std::exp(-dt_s / p.turn_tau_release_s);
      } else {
        const double keep = std::exp(-dt_s / p.turn_tau_normal_s);
        w_f = keep * w_f + (1 - keep) * p.turn_gain_filtered_units * u_turn;
        w = p.turn_gain_direct_units * u_turn + w_f;
      }
      wanted = {v * p.speed_per_unit_m_s, w * p.yaw_rate_per_unit_rad_s, Braking::none, false};
    }
    CoreState state = before;
    expect_wish(UserMode::step(state, dt_s), wanted);
    EXPECT_NEAR(state.lean.v_units, v, kNear);
    EXPECT_NEAR(state.lean.v_f_units, v_f, kNear);
    EXPECT_NEAR(state.turn.omega_units, w, kNear);
    EXPECT_NEAR(state.turn.omega_f_units, w_f, kNear);
    UserMode::enter(state);
    for (const double left : {state.lean.v_units, state.lean.v_f_units, state.turn.omega_units, state.turn.omega_f_units})
      EXPECT_EQ(left, 0);
  }
}

}  // namespace
}  // namespace hoist::core::test::rule
