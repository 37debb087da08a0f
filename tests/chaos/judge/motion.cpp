#include "tests/chaos/judge/motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "control/contract/can_dictionary.hpp"
#include "tests/chaos/judge/deadlines.hpp"

namespace hoist::chaos {
namespace {

using contract::Mode;
using contract::Node;

constexpr double kTrack_m = 0.7;  // of the plant's wheels
// By this much the frames may tell an angle wrongly: what the sensor's filter hides.
constexpr double kHidden_rad = 2.0 * kDegree_rad, kHiddenSlope_rad = 0.7 * kDegree_rad;
// From a changed wish to the wheels: sensor, limiter with its jerk, servo.
constexpr double kKnown_s = 0.5;
constexpr std::size_t kLately = 30;  // steps
constexpr double kFollows_s = 0.3;   // for so long both drives have followed: what they did before is not the core's
// A ramp takes more time than its acceleration: the jerk rounds off both of its ends.
constexpr double kRampShare_norm = 0.8;
// In 1000 sessions of the whole product no motion was above its promise by more than half of these.
constexpr double kSlack_m_s = 0.04, kSlack_rad_s = 0.1, kBeside_m_s = 0.05;
// A drive that is beside its command for longer switches itself off.
constexpr double kLasting_s = 0.1, kShortly_s = 0.025;

}  // namespace

double Fading::beyond(bool asked, double motion, double keep_norm, double most_per_s) {
  if (asked) {
    unasked_s_ = left_ = 0;
    return -1.0;
  }
  unasked_s_ += kStep_s;
  left_ = unasked_s_ <= kKnown_s ? std::max({left_, motion, 0.0}) : std::max(left_ * keep_norm, left_ - most_per_s * kStep_s);
  return motion - left_;
}

bool Lasts::longer(bool holds, double least_s) {
  held_s_ = holds ? held_s_ + kStep_s : 0;
  return held_s_ > least_s;
}

// A gain that is changed in motion glides to its value by 20 % a second.
void Motion::take_gains(const View& view) {
  // NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): any other bit is a change
  const bool same = std::memcmp(&gains_, &view.params, sizeof gains_) == 0;
  if (view.mode == Mode::user || view.mode == Mode::protective_stop) {
    gains_glide_ = gains_glide_ || !same;
  } else {
    gains_glide_ = false;
    gains_ = view.params;
  }
}

void Motion::take_drives() {
  bool follow = true;
  for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
    const auto& drive = ears_->drive(side);
    follow = follow && drive.told_to_run && ears_->age(side == 0 ? Node::drive_left : Node::drive_right) <= 1 &&
             contract::canopen::drive::state(drive.status) == contract::canopen::drive::State::operation_enabled;
  }
  follow_s_ = follow ? follow_s_ + kStep_s : 0;
}

bool Motion::sensors_heard() const {
  for (const Node node : {Node::tilt_left, Node::tilt_right, Node::tilt_base})
    if (ears_->age(node) > 1 || !ears_->tilt(node).valid) return false;
  return true;
}

double Motion::told_lean_rad() const {
  return (ears_->tilt(Node::tilt_left).forward_rad + ears_->tilt(Node::tilt_right).forward_rad) / 2.0 -
         ears_->tilt(Node::tilt_base).forward_rad;
}

// What the frames tell of lean and turn, against the true ones.
bool Motion::told_rightly(const Truth& truth) const {
  const double turn_rad = (ears_->tilt(Node::tilt_right).forward_rad - ears_->tilt(Node::tilt_left).forward_rad) / 2.0;
  return sensors_heard() && std::fabs(told_lean_rad() - truth.forward_rad) < kHidden_rad &&
         std::fabs(turn_rad - truth.turn_rad) < kHidden_rad;
}

bool Motion::slopes(const View& view) const {
  const auto& base = ears_->tilt(Node::tilt_base);
  const Truth& truth = view.truth;
  constexpr double kEdge_rad = 0.1 * kDegree_rad;
  const bool told = ears_->age(Node::tilt_base) <= 1 && base.valid &&
                    std::hypot(base.forward_rad - truth.chassis_forward_rad, base.right_rad - truth.chassis_right_rad) < kHiddenSlope_rad;
  return told && std::hypot(base.forward_rad, base.right_rad) > view.params.base_tilt_slow_rad + kEdge_rad;
}

// The cap of this patient, the speed of a slope, and that of driving. A lower one is reached by the normal ramp.
bool Motion::too_fast(const View& view) {
  double promised_m_s = view.params.speed_m_s_max * view.params.speed_cap_norm;
  if (view.mode == Mode::remote) promised_m_s = std::min(promised_m_s, view.params.remote_speed_m_s_max);
  if (slopes(view)) promised_m_s = std::min(promised_m_s, view.params.base_tilt_speed_m_s_max);
  if (promised_.may_m_s < 0) promised_.may_m_s = std::fabs(view.speed_m_s);
  promised_.lower_s = promised_m_s < promised_.may_m_s ? promised_.lower_s + kStep_s : 0;
  if (promised_.lower_s == 0) promised_.may_m_s = promised_m_s;
  if (promised_.lower_s > kKnown_s)
    promised_.may_m_s = std::max(promised_m_s, promised_.may_m_s - kRampShare_norm * view.params.acceleration_m_s2_max * kStep_s);
  return promised_.faster.longer(std::fabs(view.speed_m_s) > promised_.may_m_s + kSlack_m_s + view.gives_m_s, kLasting_s);
}

// A wheel whose drive is sound and which nothing pushes turns as it is told.
bool Motion::beside_its_drive(const View& view) {
  bool beside = false;
  for (const std::size_t side : {std::size_t{0}, std::size_t{1}}) {
    const double off_m_s = std::fabs(view.truth.wheel_m_s[side] - ears_->drive(side).followed_m_s);
    beside = beside_[side].longer(off_m_s > kBeside_m_s + view.gives_m_s, kShortly_s) || beside;
  }
  return beside;
}

// Who turns to one side is not turned to the other. What is left of a turn before fades as slowly as the filter may let it.
bool Motion::turns_against(const View& view) {
  const contract::Params& p = view.params;
  const double neutral_rad = p.strut_spacing_m / 2.0 / p.strut_length_m * p.neutral_turn_rad;
  const double turn_rad = view.truth.turn_rad - neutral_rad;
  const bool clear = std::fabs(turn_rad) > p.turn_dead_band_norm * p.turn_range_rad + kHidden_rad;
  const double against_rad_s = turn_rad > 0 ? -view.yaw_rate_rad_s : view.yaw_rate_rad_s;
  const double keep_norm = std::exp(-kStep_s / p.turn_tau_normal_s);
  const double beyond_rad_s = against_.turn.beyond(!clear, against_rad_s, keep_norm, kRampShare_norm * p.yaw_acceleration_rad_s2_max);
  return against_.turns.longer(beyond_rad_s > kSlack_rad_s + 2.0 * view.gives_m_s / kTrack_m, kLasting_s);
}

// Who leans against the motion brakes it, the harder the farther.
bool Motion::goes_against(const View& view) {
  const contract::Params& p = view.params;
  const double lean_rad = view.truth.forward_rad - p.neutral_lean_m / p.strut_length_m;
  const double beyond_norm = (std::fabs(lean_rad) - kHidden_rad) / p.lean_range_rad - p.lean_dead_band_norm;
  const double keep_norm = std::exp(-std::max(0.0, beyond_norm) / p.braking_softness_norm);
  const double against_m_s = lean_rad > 0 ? -view.speed_m_s : view.speed_m_s;
  const double beyond_m_s = against_.lean.beyond(beyond_norm <= 0, against_m_s, keep_norm, kRampShare_norm * p.acceleration_m_s2_max);
  return against_.goes.longer(beyond_m_s > kSlack_m_s + view.gives_m_s, kLasting_s);
}

// What the lean that the frames tell may have asked for, by the published law (equations (4) to (7)) and the gains in force: it grows by the filtered
// part, fades in the dead-band, and is braked by a lean against the motion. While the wheels still go the old way the law may have turned round and
// grow the other way. Each step in favour of the hoist.
double Motion::asked_for_m_s(const View& view) {
  const contract::Params& p = view.params;
  constexpr double kEdge_norm = 0.01, kGoes_m_s = 0.05;
  const double lean_rad = told_lean_rad() - p.neutral_lean_m / p.strut_length_m;
  const double lean_norm = std::clamp(lean_rad / p.lean_range_rad, -1.0, 1.0), size_norm = std::min(1.0, std::fabs(lean_norm) + kEdge_norm);
  const double beyond_norm = std::fabs(lean_norm) - p.lean_dead_band_norm;
  const double full_m_s = p.lean_gain_filtered_units * p.speed_per_unit_m_s * size_norm;
  const double most_m_s = std::min(full_m_s, p.lean_filtered_units_max * p.speed_per_unit_m_s);
  // What a cap has held back does not come when it ends.
  if (promised_.may_m_s >= 0) asked_.filtered_m_s = std::min(asked_.filtered_m_s, promised_.may_m_s + kSlack_m_s);
  const auto grow = [&](double& filtered_m_s) {
    filtered_m_s = std::max(filtered_m_s, std::min(most_m_s, filtered_m_s + (full_m_s - filtered_m_s) * kStep_s / p.lean_tau_normal_s));
  };
  if (beyond_norm < -kEdge_norm) {
    for (double* filtered_m_s : {&asked_.filtered_m_s, &asked_.turned_m_s}) *filtered_m_s *= std::exp(-kStep_s / p.lean_tau_release_s);
  } else if (lean_norm * view.speed_m_s < 0 && std::fabs(view.speed_m_s) > kGoes_m_s) {
    asked_.filtered_m_s *= std::exp(-std::max(0.0, beyond_norm - kEdge_norm) / p.braking_softness_norm);
    grow(asked_.turned_m_s);
    asked_.turned_m_s += p.reversal_gain_norm * most_m_s;
  } else {
    asked_.filtered_m_s = std::max(asked_.filtered_m_s, std::exchange(asked_.turned_m_s, 0.0));
    grow(asked_.filtered_m_s);
  }
  return std::max(asked_.filtered_m_s, asked_.turned_m_s) + p.lean_gain_direct_units * p.speed_per_unit_m_s * size_norm;
}

bool Motion::beyond_the_lean(const View& view) {
  const contract::Params& p = view.params;
  asked_.lately_m_s.push_back(asked_for_m_s(view));
  if (asked_.lately_m_s.size() > kLately) asked_.lately_m_s.pop_front();
  asked_.may_m_s = std::max(*std::max_element(asked_.lately_m_s.begin(), asked_.lately_m_s.end()),
                            asked_.may_m_s - kRampShare_norm * p.acceleration_m_s2_max * kStep_s);
  // A ramp whose end comes nearer than its jerk lets it turn round.
  const double overshoots_m_s = p.acceleration_m_s2_max * p.acceleration_m_s2_max / (2.0 * p.jerk_m_s3_max);
  return asked_.faster.longer(std::fabs(view.speed_m_s) > asked_.may_m_s + overshoots_m_s + kSlack_m_s + view.gives_m_s, kLasting_s);
}

// An exercise waits for a patient who truly lags: from the lag in force on it goes more slowly, and one degree below the hanging alarm it stands. A
// lag counts when it lasted, and less by what sensors hide. A slower speed comes over a second, and the ramp.
bool Motion::drags(const View& view) {
  const contract::Params& p = view.params;
  constexpr double kStands_rad = 9.0 * kDegree_rad, kBelowHanging_norm = 0.9, kFalls_per_s = 1.0, kUnsure_rad = 1.0 * kDegree_rad;
  const double stands_rad = std::min(kStands_rad, kBelowHanging_norm * p.hang_tilt_rad);
  lag_.lately_rad.push_back(p.neutral_lean_m / p.strut_length_m - std::max(view.truth.forward_rad, told_lean_rad()));
  if (lag_.lately_rad.size() > kLately) lag_.lately_rad.pop_front();
  const double lag_rad = *std::min_element(lag_.lately_rad.begin(), lag_.lately_rad.end()) - kUnsure_rad;
  const double wanted_norm = std::clamp((stands_rad - lag_rad) / (stands_rad - p.guided_lag_start_rad), 0.0, 1.0);
  lag_.share_norm = lag_.lately_rad.size() < kLately ? 1.0 : std::max(wanted_norm, lag_.share_norm - kFalls_per_s * kStep_s);
  const double most_m_s = lag_.share_norm * std::min(exercise_m_s_, p.speed_m_s_max * p.speed_cap_norm);
  if (lag_.may_m_s < 0) lag_.may_m_s = std::fabs(view.speed_m_s);
  lag_.may_m_s = std::max(most_m_s, lag_.may_m_s - kRampShare_norm * p.acceleration_m_s2_max * kStep_s);
  return lag_.drags.longer(std::fabs(view.speed_m_s) > lag_.may_m_s + kSlack_m_s + view.gives_m_s, kLasting_s);
}

Motion::Broken Motion::after_step(const Told& told, const Truth& truth, bool sound, bool free) {
  const auto mode = static_cast<Mode>(told.record.mode);
  const View view{told.params,
                  truth,
                  mode,
                  (truth.wheel_m_s[0] + truth.wheel_m_s[1]) / 2.0,
                  (truth.wheel_m_s[1] - truth.wheel_m_s[0]) / kTrack_m,
                  Deadlines::rest_m_s(truth)};
  take_gains(view);
  take_drives();
  const bool follow = follow_s_ > kFollows_s && free;
  Broken broken;
  const auto judge = [&](bool wrong, std::string_view what, double value) {
    if (wrong && broken.what.empty()) broken = {what, value};
  };
  if (follow && sound)
    judge(beside_its_drive(view), "I2: a sound drive turns its wheel otherwise than it is told", truth.fastest_m_s);
  else
    beside_ = {};
  if (follow && moves(mode))
    judge(too_fast(view), "I2: faster than promised for this patient or floor", view.speed_m_s);
  else
    promised_ = {};
  if (follow && mode == Mode::user && !gains_glide_ && told_rightly(truth)) {
    judge(turns_against(view), "I2: turns against the patient", view.yaw_rate_rad_s);
    judge(goes_against(view), "I2: goes against the patient's lean", view.speed_m_s);
  } else {
    against_ = {};
  }
  // The filter begins at zero with each walk; what it holds is known as long as every frame came.
  asked_known_ = mode != Mode::user || (asked_known_ && !gains_glide_ && sensors_heard());
  if (mode != Mode::user)
    asked_ = {};
  else if (asked_known_)
    judge(beyond_the_lean(view) && follow, "I2: faster than the patient's lean asks for", view.speed_m_s);
  if (follow && mode == Mode::guided && told_rightly(truth))
    judge(drags(view), "I2: an exercise drags the patient", view.speed_m_s);
  else
    lag_ = {};
  return broken;
}

}  // namespace hoist::chaos
