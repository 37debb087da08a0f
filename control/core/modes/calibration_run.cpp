#include "control/core/modes/calibration_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "control/core/calibrate/gyro_bias.hpp"
#include "control/core/calibrate/sensor_zero.hpp"
#include "control/core/calibrate/strut_geometry.hpp"
#include "control/core/calibrate/wheel_signs.hpp"
#include "control/core/calibrate/wheel_travel.hpp"
#include "control/core/events.hpp"
#include "control/core/standstill.hpp"

namespace hoist::core {

using contract::CalibrationPart;
using contract::CalibrationPhase;
using contract::CalibrationReason;
using contract::CalibrationStep;
using contract::CalibrationStepInfo;
using contract::Event;
using contract::EventKind;
using contract::ParamName;
using contract::Refusal;
using contract::refusal_bit;

namespace {

constexpr double kRadPerDeg = 3.14159265358979323846 / 180.0;
constexpr double kAnything = 1e12;
constexpr std::size_t kLeftCounts = 6, kRightCounts = 7, kYaw = 8;

// What must rest, for how long and how still. A filtered angle at rest wanders by some hundredths of a degree, a gyroscope by half a degree a
// second (measured on the nodes' own filters with the noise of firmware/sim/imu.hpp); a person leaning on the hoist moves it more.
struct Stillness {
  std::uint32_t ticks;
  double angle_rad, counts, yaw_rad_s;
};
// An empty harness is stiller than a standing person, who sways by several millimetres in five seconds: 0.15 degrees are 2 mm at the bar.
constexpr Stillness kEmptyHarness{500, 0.15 * kRadPerDeg, 20, 2.0 * kRadPerDeg};
constexpr Stillness kGyroRest{500, 0.25 * kRadPerDeg, 20, 2.0 * kRadPerDeg};
constexpr Stillness kBarRest{100, 0.40 * kRadPerDeg, 40, kAnything};
constexpr Stillness kWheelsRest{50, kAnything, 20, kAnything};

constexpr Stillness stillness(CalibrationStep step) noexcept {
  switch (step) {
    case CalibrationStep::zero:
      return kEmptyHarness;
    case CalibrationStep::gyro:
      return kGyroRest;
    case CalibrationStep::strut_length:
    case CalibrationStep::strut_spacing:
    case CalibrationStep::struts:
      return kBarRest;
    default:
      return kWheelsRest;
  }
}

// Two positions always lie on a line: only a third one reveals a misread value.
static_assert(contract::find_calibration_step("strut_length")->samples >= 3 &&
              contract::find_calibration_step("strut_spacing")->samples >= 3);

// Of the wheel sensors' step: enough to be sure of a sign.
constexpr double kPushLeast_m = 0.3, kTurnLeast_m = 0.2;
// A patient whose harness moved further than this within a second did not stand still (commands.cpp).
constexpr double kNeutralSpread_m = 0.02;

constexpr std::size_t row_of(ParamName name) { return contract::param_index(name); }
double design(ParamName name) noexcept { return contract::kParams[row_of(name)].default_value; }

const CalibrationStepInfo& info_of(CalibrationStep step) noexcept {
  return contract::kCalibrationSteps[static_cast<std::size_t>(step) - 1];
}

void tell(CoreState& state, EventKind kind, std::uint32_t item, double value, double before = 0) noexcept {
  Event event;
  event.kind = kind;
  event.code = static_cast<std::uint32_t>(state.in_mode.calibration.step);
  event.item = item;
  event.value = value;
  event.before = before;
  emit(state, event);
}

void refuse(CoreState& state, CalibrationReason reason) noexcept {
  Calibration& c = state.in_mode.calibration;
  c.phase = CalibrationPhase::refused;
  c.reason = reason;
  c.waiting = false;
  c.result.rows.clear();
}

void propose(CoreState& state, ParamName name, double value) noexcept {
  static_cast<void>(state.in_mode.calibration.result.rows.push_back({row_of(name), value}));
}

// Offers the result if it is a valid set of parameters.
void offer(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  contract::Params next = state.params;
  for (const Staging::Row& row : c.result.rows) {
    if (contract::check_param(row.index, row.value) != contract::ParamCheck::ok) return refuse(state, CalibrationReason::implausible);
    contract::set_param_unchecked(next, row.index, row.value);
  }
  if (contract::check_param_set(next) != nullptr) return refuse(state, CalibrationReason::implausible);
  for (const Staging::Row& row : c.result.rows)
    tell(state, EventKind::calibration_result, contract::kParams[row.index].id, row.value, contract::get_param(state.params, row.index));
  c.phase = CalibrationPhase::result;
  c.reason = CalibrationReason::none;
  c.done_percent = 100;
}

void propose_one(CoreState& state, ParamName name, const Outcome& outcome) noexcept {
  state.in_mode.calibration.result.rows.clear();
  if (!outcome.good()) return refuse(state, outcome.reason);
  propose(state, name, outcome.value);
  offer(state);
}

StillWindow<kCalibrationChannels>::Values look(const CoreState& state) noexcept {
  const Estimate& sensed = state.sensed;
  const Calibration& c = state.in_mode.calibration;
  return {sensed.left_strut.sent_alpha_rad(), sensed.left_strut.sent_beta_rad(),   sensed.right_strut.sent_alpha_rad(),
          sensed.right_strut.sent_beta_rad(), sensed.base.sent_alpha_rad(),        sensed.base.sent_beta_rad(),
          static_cast<double>(c.left_counts), static_cast<double>(c.right_counts), sensed.base.sent_yaw_rate_rad_s()};
}

double widest_angle_rad(const StillWindow<kCalibrationChannels>& window) noexcept {
  double widest = 0;
  for (std::size_t i = 0; i < kLeftCounts; ++i) widest = window.spread(i) > widest ? window.spread(i) : widest;
  return widest;
}

// Distances since begin_way().
double left_way_m(const CoreState& state) noexcept {
  const Calibration& c = state.in_mode.calibration;
  return static_cast<double>(c.left_counts - c.left_from) * state.derived.odometry.left_m_per_count;
}
double right_way_m(const CoreState& state) noexcept {
  const Calibration& c = state.in_mode.calibration;
  return static_cast<double>(c.right_counts - c.right_from) * state.derived.odometry.right_m_per_count;
}

void begin_way(Calibration& c) noexcept {
  c.left_from = c.left_counts;
  c.right_from = c.right_counts;
  c.turned_rad = 0;
  c.started = true;
}

// True once everything has rested as long as this step requires.
bool rests(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  const Stillness want = stillness(c.step);
  StillWindow<kCalibrationChannels>::Values bounds{};
  for (std::size_t i = 0; i < kLeftCounts; ++i) bounds[i] = want.angle_rad;
  bounds[kLeftCounts] = bounds[kRightCounts] = want.counts;
  bounds[kYaw] = want.yaw_rad_s;
  ++c.restless_ticks;
  if (!c.still.add(look(state), bounds)) {
    c.phase = CalibrationPhase::resting;
    c.done_percent = 0;
    return false;
  }
  if (c.still.ticks() * 2 == want.ticks) c.first_half = c.still;
  c.phase = CalibrationPhase::measuring;
  c.done_percent = static_cast<std::uint8_t>(c.still.ticks() * 100 / want.ticks);
  return c.still.ticks() >= want.ticks;
}

void begin_resting(Calibration& c) noexcept {
  c.still.restart();
  c.restless_ticks = 0;
}

void finish_zero(CoreState& state) noexcept {
  constexpr std::array kZeros{ParamName::left_alpha_zero_rad, ParamName::left_beta_zero_rad,  ParamName::right_alpha_zero_rad,
                              ParamName::right_beta_zero_rad, ParamName::base_alpha_zero_rad, ParamName::base_beta_zero_rad};
  Calibration& c = state.in_mode.calibration;
  c.result.rows.clear();
  for (std::size_t i = 0; i < kZeros.size(); ++i) {
    const Outcome zero = sensor_zero(c.still.mean(i));
    if (!zero.good()) return refuse(state, zero.reason);
    propose(state, kZeros[i], zero.value);
  }
  // A neutral measured with the old zeros is invalid with the new ones.
  propose(state, ParamName::neutral_lean_m, 0.0);
  propose(state, ParamName::neutral_turn_rad, 0.0);
  offer(state);
}

void finish_gyro(CoreState& state) noexcept {
  const Calibration& c = state.in_mode.calibration;
  double drift_rad = 0;
  for (std::size_t i = 0; i < kLeftCounts; ++i) {
    // The mean of the whole window differs from the first half's by half the difference of the two halves.
    const double drift = 2.0 * std::fabs(c.still.mean(i) - c.first_half.mean(i));
    drift_rad = drift > drift_rad ? drift : drift_rad;
  }
  propose_one(state, ParamName::base_yaw_bias_rad_s, gyro_bias(c.still.mean(kYaw), drift_rad));
}

void watch_neutral(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  ++c.restless_ticks;
  const auto posture = state.intent.last_second();
  c.value = static_cast<float>(posture.dx_spread_m);
  c.phase = CalibrationPhase::resting;
  // The posture before the step began does not count.
  if (!posture.complete || c.restless_ticks < kNeutralTicks || posture.dx_spread_m > kNeutralSpread_m) return;
  c.result.rows.clear();
  propose(state, ParamName::neutral_lean_m, posture.dx_m);
  propose(state, ParamName::neutral_turn_rad, posture.dpsi_rad);
  offer(state);
  if (c.phase == CalibrationPhase::refused) c.reason = CalibrationReason::posture_too_far;
}

// Of the pairs; the last tenth is the result itself.
std::uint8_t pairs_percent(const Calibration& c) noexcept {
  const std::size_t wanted = info_of(c.step).samples;
  return static_cast<std::uint8_t>(c.pairs.size() >= wanted ? 90 : c.pairs.size() * 100 / wanted);
}

// Another pair is complete: as soon as there are enough, a result.
void judge_pairs(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  const CalibrationStepInfo& info = info_of(c.step);
  c.idle_ticks = 0;
  c.phase = CalibrationPhase::operator_;
  c.reason = CalibrationReason::none;
  c.done_percent = pairs_percent(c);
  if (c.pairs.size() < info.samples) return;
  if (!c.pairs.both_directions()) {
    c.reason = CalibrationReason::one_direction;
    return;
  }
  switch (c.step) {
    case CalibrationStep::strut_length:
      return propose_one(state, ParamName::strut_length_m, strut_length(c.pairs, design(ParamName::strut_length_m)));
    case CalibrationStep::strut_spacing:
      return propose_one(state, ParamName::strut_spacing_m,
                         strut_spacing(c.pairs, state.params.strut_length_m, design(ParamName::strut_spacing_m)));
    case CalibrationStep::wheel_radius:
      return propose_one(state, ParamName::wheel_radius_m, wheel_radius(c.pairs, info.least, design(ParamName::wheel_radius_m)));
    case CalibrationStep::track:
      return propose_one(state, ParamName::track_width_m, track_width(c.pairs, info.least, design(ParamName::track_width_m)));
    default:
      return;
  }
}

void take_pair(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  c.waiting = false;
  // The zeros in force are taken off: they were set first (their order on the screen).
  const contract::Params& p = state.params;
  const auto& w = c.still;
  const double tan_left = std::tan(w.mean(0) - p.left_alpha_zero_rad - (w.mean(4) - p.base_alpha_zero_rad));
  const double tan_right = std::tan(w.mean(2) - p.right_alpha_zero_rad - (w.mean(4) - p.base_alpha_zero_rad));
  double sensed = 0, measured = c.entered;
  const double left_m = left_way_m(state), right_m = right_way_m(state);
  switch (c.step) {
    case CalibrationStep::strut_length:
      sensed = (tan_left + tan_right) / 2.0;
      break;
    case CalibrationStep::strut_spacing:
      sensed = tan_right - tan_left;
      measured = std::sin(c.entered);
      break;
    case CalibrationStep::wheel_radius:
      if (!pushed_straight(left_m, right_m)) return refuse(state, CalibrationReason::not_straight);
      sensed = (left_m + right_m) / 2.0 / p.wheel_radius_m;
      break;
    case CalibrationStep::track:
      sensed = right_m - left_m;
      break;
    default:
      return;
  }
  // The sensors saw almost no movement, although the operator entered one.
  if (!(std::fabs(sensed) > 0.02)) return refuse(state, CalibrationReason::too_little);
  if (!c.pairs.add(sensed, measured)) return;
  begin_way(c);
  tell(state, EventKind::calibration_sample, static_cast<std::uint32_t>(c.pairs.size()), c.entered);
  judge_pairs(state);
}

// The figure that the screen shows while a pair is measured: of wheels that turn, or of a bar that is held.
double shown_of_wheels(const CoreState& state) noexcept {
  const double left_m = left_way_m(state), right_m = right_way_m(state);
  if (state.in_mode.calibration.step == CalibrationStep::wheel_radius) return (left_m + right_m) / 2.0;
  return (right_m - left_m) / state.params.track_width_m;
}
double shown_of_bar(const CoreState& state) noexcept {
  const law::StrutAngles<double> struts = state.sensed.relative();
  const double left_m = state.params.strut_length_m * std::tan(struts.alpha_left_rad),
               right_m = state.params.strut_length_m * std::tan(struts.alpha_right_rad);
  if (state.in_mode.calibration.step == CalibrationStep::strut_length) return (left_m + right_m) / 2.0;
  // A rigid bar, as what is entered is taken (DECISIONS.md, 32); while hands pull at it, the struts may be further apart than it can turn them.
  return std::asin(std::clamp((right_m - left_m) / state.params.strut_spacing_m, -1.0, 1.0));
}

bool wheels_moved(const CoreState& state) noexcept {
  return state.sensed.left_drive.moved_counts() != 0 || state.sensed.right_drive.moved_counts() != 0;
}

// Wheel travel is measured from rest to rest: waits for the first.
void wait_for_start(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  if (rests(state)) {
    begin_way(c);
    c.phase = CalibrationPhase::operator_;
    c.done_percent = 0;
  } else if (c.restless_ticks >= kCalibrationRestTicks) {
    refuse(state, CalibrationReason::not_still);
  }
}

void watch_pairs(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  const bool wheels = c.step == CalibrationStep::wheel_radius || c.step == CalibrationStep::track;
  c.value = static_cast<float>(wheels ? shown_of_wheels(state) : shown_of_bar(state));
  if (wheels && !c.started) return wait_for_start(state);
  if (wheels && wheels_moved(state)) c.idle_ticks = 0;
  if (!c.waiting) return;
  if (rests(state)) return take_pair(state);
  if (c.restless_ticks < kCalibrationRestTicks) return;
  c.waiting = false;
  c.phase = CalibrationPhase::operator_;
  c.done_percent = pairs_percent(c);
  c.reason = CalibrationReason::not_still;
}

// 0, or why this square is not taken.
std::uint32_t square_refusals(const Calibration& c, const contract::Command& command) noexcept {
  const CalibrationStepInfo& info = info_of(CalibrationStep::square);
  const auto part = static_cast<CalibrationPart>(command.a);
  if (part != CalibrationPart::left_square && part != CalibrationPart::right_square) return refusal_bit(Refusal::unknown_item);
  const double side_m = command.v0;
  // An error as large as a side is not an error of odometry.
  if (!(side_m >= info.least && side_m <= info.most && std::fabs(command.v1) <= side_m && std::fabs(command.v2) <= side_m))
    return refusal_bit(Refusal::out_of_range);
  if (c.left_squares.count() + c.right_squares.count() >= MeasuredPairs::kMost) return refusal_bit(Refusal::out_of_order);
  // All squares of one set are of one size.
  if (c.side_m > 0 && std::fabs(side_m - c.side_m) > 0.001 * side_m) return refusal_bit(Refusal::inconsistent_set);
  return 0;
}

void propose_square_result(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  const SquareResult found = umbmark(c.side_m, c.left_squares.mean(), c.right_squares.mean(), state.params.track_width_m);
  c.result.rows.clear();
  if (found.reason != CalibrationReason::none) return refuse(state, found.reason);
  propose(state, ParamName::track_width_m, state.params.track_width_m * found.track_norm);
  propose(state, ParamName::wheel_left_scale_norm, state.params.wheel_left_scale_norm * found.left_scale_norm);
  propose(state, ParamName::wheel_right_scale_norm, state.params.wheel_right_scale_norm * found.right_scale_norm);
  offer(state);
}

std::uint32_t take_square(CoreState& state, const contract::Command& command) noexcept {
  Calibration& c = state.in_mode.calibration;
  if (const std::uint32_t refusals = square_refusals(c, command); refusals != 0) return refusals;
  const bool turned_left = static_cast<CalibrationPart>(command.a) == CalibrationPart::left_square;
  c.side_m = command.v0;
  (turned_left ? c.left_squares : c.right_squares).add({command.v1, command.v2});
  c.idle_ticks = 0;
  const std::size_t left = c.left_squares.count(), right = c.right_squares.count();
  tell(state, EventKind::calibration_sample, static_cast<std::uint32_t>(left + right), c.side_m);
  const bool one_direction = left == 0 || right == 0;
  c.phase = CalibrationPhase::operator_;
  c.done_percent = 50;
  c.reason = left + right >= info_of(CalibrationStep::square).samples && one_direction ? CalibrationReason::one_direction
                                                                                       : CalibrationReason::none;
  if (!one_direction) propose_square_result(state);
  return 0;
}

// A push straight ahead or a turn to the left has ended at rest.
void judge_wheels(CoreState& state, double left_m, double right_m) noexcept {
  Calibration& c = state.in_mode.calibration;
  const CalibrationReason reason = c.turning ? judge_turn(left_m, right_m, c.turned_rad) : judge_push(left_m, right_m);
  if (reason != CalibrationReason::none) return refuse(state, reason);
  tell(state, EventKind::calibration_sample, c.turning ? 2 : 1, static_cast<double>(c.value));
  if (c.turning) return offer(state);
  c.turning = true;
  begin_way(c);
  begin_resting(c);
}

void watch_encoders(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  const bool was_measuring = c.started;
  const bool resting = rests(state);
  c.done_percent = c.turning ? 50 : 0;
  if (!was_measuring) {
    c.phase = CalibrationPhase::resting;
    if (resting) begin_way(c), begin_resting(c);
    return;
  }
  c.phase = CalibrationPhase::operator_;
  const double left_m = left_way_m(state), right_m = right_way_m(state);
  c.value = static_cast<float>(c.turning ? c.turned_rad : (left_m + right_m) / 2.0);
  if (wheels_moved(state)) c.idle_ticks = 0;
  const double further_m = std::fabs(left_m) > std::fabs(right_m) ? std::fabs(left_m) : std::fabs(right_m);
  if (resting && further_m >= (c.turning ? kTurnLeast_m : kPushLeast_m)) judge_wheels(state, left_m, right_m);
}

void watch_bumpers(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  const std::uint8_t before = c.bumpers.next();
  const CalibrationReason reason = c.bumpers.step(state.sensed.io.bumpers());
  c.phase = CalibrationPhase::operator_;
  c.done_percent = static_cast<std::uint8_t>(c.bumpers.next() * 25);
  c.value = static_cast<float>(c.bumpers.next());
  if (reason != CalibrationReason::none) return refuse(state, reason);
  if (c.bumpers.next() == before) return;
  c.idle_ticks = 0;
  tell(state, EventKind::calibration_sample, c.bumpers.next(), static_cast<double>(before));
  if (c.bumpers.done()) offer(state);
}

StrutCheck::Angles struts_held(const StillWindow<kCalibrationChannels>& still) noexcept {
  return {still.mean(0), still.mean(1), still.mean(2), still.mean(3)};
}

void watch_struts(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  const bool still = rests(state);
  if (!c.started) {
    c.phase = CalibrationPhase::resting;
    if (still) c.upright = struts_held(c.still), c.started = true, begin_resting(c);
    return;
  }
  const std::uint8_t before = c.struts.next();
  const auto now = look(state);
  c.struts.follow(StrutCheck::Angles{now[0], now[1], now[2], now[3]} - c.upright);
  const CalibrationReason reason = still ? c.struts.held(struts_held(c.still) - c.upright) : CalibrationReason::none;
  // The struts find their way back by themselves.
  c.phase = c.struts.coming_back() ? CalibrationPhase::resting : CalibrationPhase::operator_;
  c.done_percent = static_cast<std::uint8_t>(c.struts.next() * 100 / StrutCheck::kMotions);
  c.value = static_cast<float>(c.struts.next());
  if (reason != CalibrationReason::none) return refuse(state, reason);
  if (c.struts.next() == before) return;
  c.idle_ticks = 0;
  begin_resting(c);
  tell(state, EventKind::calibration_sample, c.struts.next(), static_cast<double>(before));
  if (c.struts.done()) offer(state);
}

void watch_rest(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  const bool gyro = c.step == CalibrationStep::gyro;
  const bool complete = rests(state);
  c.value = static_cast<float>(gyro ? c.still.mean(kYaw) : widest_angle_rad(c.still));
  if (complete) {
    if (gyro) {
      finish_gyro(state);
    } else {
      finish_zero(state);
    }
  } else if (c.restless_ticks >= kCalibrationRestTicks + stillness(c.step).ticks) {
    refuse(state, gyro ? CalibrationReason::not_still : CalibrationReason::harness_sways);
  }
}

// One step of what is measured now.
void watch_step(CoreState& state) noexcept {
  switch (state.in_mode.calibration.step) {
    case CalibrationStep::zero:
    case CalibrationStep::gyro:
      return watch_rest(state);
    case CalibrationStep::neutral:
      return watch_neutral(state);
    case CalibrationStep::strut_length:
    case CalibrationStep::strut_spacing:
    case CalibrationStep::wheel_radius:
    case CalibrationStep::track:
      return watch_pairs(state);
    case CalibrationStep::encoders:
      return watch_encoders(state);
    case CalibrationStep::bumpers:
      return watch_bumpers(state);
    case CalibrationStep::struts:
      return watch_struts(state);
    case CalibrationStep::square:  // the operator enters everything
    case CalibrationStep::none:
      return;
  }
}

}  // namespace

std::uint32_t calibration_refusals(const CoreState& state, const CalibrationStepInfo& info) noexcept {
  const Estimate& sensed = state.sensed;
  std::uint32_t bits = 0;
  if (state.mode != contract::Mode::standby && state.mode != contract::Mode::calibrate) bits |= refusal_bit(Refusal::not_standby);
  if (sensed.tilts_stale() || sensed.base.rates_fresh().stale() || sensed.drives_lost() || sensed.io.fresh().lost())
    bits |= refusal_bit(Refusal::nodes_missing);
  // Each step begins at rest; the tilt filters must have converged.
  if (!at_rest(state)) bits |= refusal_bit(Refusal::moving);
  const bool angles = info.step == CalibrationStep::zero || info.step == CalibrationStep::neutral || info.step == CalibrationStep::gyro ||
                      info.step == CalibrationStep::strut_length || info.step == CalibrationStep::strut_spacing ||
                      info.step == CalibrationStep::struts;
  const bool settled = sensed.left_strut.has(tilt_status::kConverged) && sensed.right_strut.has(tilt_status::kConverged) &&
                       sensed.base.has(tilt_status::kConverged);
  if (angles && !settled) bits |= refusal_bit(Refusal::sensors_settling);
  return bits;
}

void begin_calibration(CoreState& state, CalibrationStep step) noexcept {
  Calibration& c = state.in_mode.calibration;
  c = Calibration{};
  c.step = step;
  const bool waits = step == CalibrationStep::strut_length || step == CalibrationStep::strut_spacing || step == CalibrationStep::square ||
                     step == CalibrationStep::bumpers;
  c.phase = waits ? CalibrationPhase::operator_ : CalibrationPhase::resting;
}

std::uint32_t measure_calibration(CoreState& state, const contract::Command& command) noexcept {
  Calibration& c = state.in_mode.calibration;
  if (!std::isfinite(command.v0) || !std::isfinite(command.v1) || !std::isfinite(command.v2)) return refusal_bit(Refusal::not_finite);
  // CALIBRATE without a step has nothing to measure.
  if (c.step == CalibrationStep::none) return refusal_bit(Refusal::out_of_order);
  const CalibrationStepInfo& info = info_of(c.step);
  // Only in a step with an entry, and only after the previous entry was processed.
  const bool ready = c.phase == CalibrationPhase::operator_ || c.phase == CalibrationPhase::result;
  if (info.unit.empty() || !ready || c.waiting || c.pairs.full()) return refusal_bit(Refusal::out_of_order);
  if (c.step == CalibrationStep::square) return take_square(state, command);
  if (static_cast<CalibrationPart>(command.a) != CalibrationPart::whole) return refusal_bit(Refusal::unknown_item);
  if (!(std::fabs(command.v0) >= info.least && std::fabs(command.v0) <= info.most)) return refusal_bit(Refusal::out_of_range);
  c.entered = command.v0;
  c.waiting = true;
  c.idle_ticks = 0;
  c.reason = CalibrationReason::none;
  c.result.rows.clear();
  begin_resting(c);
  c.phase = CalibrationPhase::resting;
  return 0;
}

bool advance_calibration(CoreState& state, double dt_s) noexcept {
  Calibration& c = state.in_mode.calibration;
  const Estimate& sensed = state.sensed;
  c.left_counts += sensed.left_drive.moved_counts();
  c.right_counts += sensed.right_drive.moved_counts();
  c.turned_rad += sensed.base.yaw_rate_rad_s() * dt_s;
  if (sensed.tilts_lost() || sensed.base.rates_fresh().lost() || sensed.drives_lost()) {
    c.reason = CalibrationReason::sensor_lost;
    return false;
  }
  if (++c.idle_ticks >= kCalibrationIdleTicks) {
    const bool no_bumper = c.step == CalibrationStep::bumpers && c.phase == CalibrationPhase::operator_;
    // A refused step that was not taken up again ends with what was refused: the records would else know only the wait.
    if (c.phase != CalibrationPhase::refused) c.reason = no_bumper ? CalibrationReason::bumper_dead : CalibrationReason::timed_out;
    return false;
  }
  if (c.phase != CalibrationPhase::result && c.phase != CalibrationPhase::refused) watch_step(state);
  return true;
}

void end_calibration(CoreState& state) noexcept {
  Calibration& c = state.in_mode.calibration;
  if (c.step == CalibrationStep::none) return;
  if (!c.used && c.reason == CalibrationReason::none) c.reason = CalibrationReason::cancelled;
  Event event;
  event.kind = EventKind::calibration_ended;
  event.code = static_cast<std::uint32_t>(c.step);
  event.bits = c.used ? 1 : 0;
  event.item = c.used ? 0U : static_cast<std::uint32_t>(c.reason);
  emit(state, event);
}

bool calibration_valid(const CoreState& state) noexcept { return state.params.calibrated_zero_s > 0 || state.master.simulated(); }

namespace {
// The checks that a part which is new, or was plugged elsewhere, makes due again.
constexpr std::array kPartChecks{ParamName::calibrated_encoders_s, ParamName::calibrated_bumpers_s, ParamName::calibrated_struts_s};
}  // namespace

bool parts_checked(const CoreState& state) noexcept {
  if (state.master.simulated()) return true;
  if (state.params.calibrated_nodes_id != static_cast<double>(state.master.nodes_id())) return false;
  for (const ParamName check : kPartChecks)
    if (!(contract::get_param(state.params, row_of(check)) > 0)) return false;
  return true;
}

void sign_parts(const CoreState& state, Staging& set) noexcept {
  const ParamName date = info_of(state.in_mode.calibration.step).date;
  if (std::find(kPartChecks.begin(), kPartChecks.end(), date) == kPartChecks.end()) return;
  const auto id = static_cast<double>(state.master.nodes_id());
  if (state.params.calibrated_nodes_id == id) return;
  static_cast<void>(set.rows.push_back({row_of(ParamName::calibrated_nodes_id), id}));
  for (const ParamName check : kPartChecks)
    if (check != date) static_cast<void>(set.rows.push_back({row_of(check), 0.0}));
}

}  // namespace hoist::core
