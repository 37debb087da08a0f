// Every change of the mode: what begins anew, what is told, who may ask (control/README.md, "Modes"; control/DECISIONS.md, 27, 28, 37, 38,
// 54, 77 and 84; the words of supervisor.hpp, service.hpp, calibration_entry.hpp and of the modes that do not move), written a second time.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "control/core/modes/calibration_run.hpp"
#include "control/core/modes/mode_list.hpp"
#include "control/core/supervise/calibration_entry.hpp"
#include "control/core/supervise/refusals.hpp"
#include "control/core/supervise/service.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/test_supervise_bench.hpp"

namespace hoist::core::test::supervise {
namespace {

using contract::CalibrationReason;
using contract::CalibrationStep;
using contract::GuidedEnd;

constexpr std::uint32_t number(Mode mode) { return static_cast<std::uint32_t>(mode); }
constexpr std::uint8_t cause_of(Fault fault) { return static_cast<std::uint8_t>(static_cast<unsigned>(fault) + 1); }

/// An exercise that was driven for 0.7 of its 2 m, ended or not.
void set_exercise(CoreState& state, GuidedEnd end) {
  state.guided = {};
  state.guided.load({contract::GuidedShape::straight, false, 2.0, 0, 0.2, 1});
  state.guided.begin({}, 3);
  for (int i = 0; i <= 7; ++i) state.guided.locate({0.1 * i, 0, 0});
  state.guided.end(end);
  state.start = {3, 55};
}

TEST(SuperviseModes, EveryChangeBeginsFromZeroAndIsTold) {
  Dice dice(7);
  for (int round = 0; round < 12; ++round)
    for (const Transition& row : kTransitions) {
      SCOPED_TRACE(testing::Message() << number(row.from) << " to " << number(row.to) << ", " << round);
      CoreState before = bases().ready;
      set_situation(before, row.from, dice);
      InMode& in_mode = before.in_mode;
      in_mode.braking = Braking::remote;
      in_mode.leaving = in_mode.powered = in_mode.remote_lost = in_mode.service.on = true;
      in_mode.causes = 1;
      in_mode.epoch = 77;
      in_mode.ticks = 5;
      const bool measures = dice.chance(0.5);
      if (measures) in_mode.calibration.step = CalibrationStep::square;
      before.still.ticks = 100;
      before.clear.ticks = 7;
      before.lean = {0.3, 0.2};
      before.turn = {0.1, 0.05};
      before.limiter.start_from(before.params, 0.3, 0.1);
      before.sensed.odometry.speed_m_s = 0.25;
      before.sensed.odometry.yaw_rate_rad_s = -0.2;
      const GuidedEnd end = dice.of({GuidedEnd::none, GuidedEnd::finished, GuidedEnd::asked});
      set_exercise(before, end);
      if (row.to == Mode::guided) before.guided.load({contract::GuidedShape::circle, false, 1.0, 0, 0.2, 1});
      CoreState state = before;
      const Told told(state);
      change_mode(state, row.to);
      EXPECT_EQ(state.mode, row.to);
      EXPECT_EQ(state.in_mode.epoch, before.lease.epoch);
      EXPECT_TRUE(state.in_mode.braking == Braking::none && !state.in_mode.leaving && !state.in_mode.powered && !state.in_mode.remote_lost);
      EXPECT_TRUE(state.in_mode.causes == 0 && state.in_mode.silent.ticks == 0 && state.in_mode.ticks == 0 && !state.in_mode.service.on);
      EXPECT_EQ(state.in_mode.calibration.step, CalibrationStep::none);
      EXPECT_EQ(state.still.ticks, 0);
      EXPECT_TRUE(state.lean.v_units == 0 && state.lean.v_f_units == 0 && state.turn.omega_units == 0 && state.turn.omega_f_units == 0);
      // A stop goes on from the ramp, or from the speed at which a hoist without drives was pushed.
      const bool stops = row.to == Mode::protective_stop, ramp = moves(row.from);
      EXPECT_EQ(state.limiter.speed_m_s(), !stops ? 0.0 : (ramp ? 0.3 : 0.25));
      EXPECT_EQ(state.limiter.yaw_rate_rad_s(), !stops ? 0.0 : (ramp ? 0.1 : -0.2));
      EXPECT_EQ(state.clear.ticks, row.to == Mode::init ? 0 : 7);
      EXPECT_EQ(state.remote.awaits_neutral(), contract::led_by_hand(row.to) && !before.remote.neutral());
      EXPECT_FALSE(row.to == Mode::guided && state.guided.loaded()) << "the exercise has been placed";
      const auto modes = told.of(EventKind::mode_changed);
      ASSERT_EQ(modes.size(), 1U);
      EXPECT_EQ(modes[0].code, number(row.to));
      EXPECT_EQ(modes[0].item, number(row.from));
      EXPECT_EQ(told.of(EventKind::calibration_ended).size(), row.from == Mode::calibrate && measures ? 1U : 0U);
      const auto ends = told.of(EventKind::guided_ended);
      ASSERT_EQ(ends.size(), row.from == Mode::guided ? 1U : 0U);
      if (row.from == Mode::guided) {
        EXPECT_EQ(ends[0].code, static_cast<std::uint32_t>(end == GuidedEnd::none ? GuidedEnd::stopped : end)) << "the first reason counts";
        EXPECT_NEAR(ends[0].value, end == GuidedEnd::finished ? 0.0 : 1.3, 1e-6);
      }
      EXPECT_EQ(state.start.exercise, row.from == Mode::guided && end == GuidedEnd::finished ? 0U : 55U) << "one that is over cannot go on";
    }
}

/// Who may be asked for: the modes that the driver can begin, and their end.
std::uint32_t request_rule(const CoreState& state, Mode to) {
  const bool starts = moves(to) || to == Mode::calibrate;
  if (!starts && to != Mode::standby) return refusal_bit(Refusal::unknown_item);
  if (to == Mode::standby && (state.mode == Mode::standby || moves(state.mode) || state.mode == Mode::calibrate)) return 0;
  // A request in another mode is answered with every reason.
  if (state.mode != Mode::standby)
    return refusal_bit(Refusal::not_standby) | where_it_stands(state) | (moves(to) ? start_refusals(state, to) : 0U);
  if (to == Mode::calibrate) return at_rest(state) ? 0U : refusal_bit(Refusal::moving);
  return start_refusals(state, to);
}

/// Often nothing is against a start.
void ease(CoreState& state) {
  const CoreState& ready = bases().ready;
  const Mode mode = state.mode;
  const InMode in_mode = state.in_mode;
  const GuidedRun guided = state.guided;
  state = ready;
  state.mode = mode;
  state.in_mode = in_mode;
  state.guided = guided;
}

TEST(SuperviseModes, ARequestIsAnsweredByTheRuleAndMotionEndsGently) {
  Dice dice(8);
  int changed = 0;
  for (int i = 0; i < 900 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    const Mode mode = dice.chance(0.4) ? Mode::standby : kEveryMode[dice.below(std::size(kEveryMode))];
    set_situation(before, mode, dice);
    if (dice.chance(0.3)) ease(before);
    before.in_mode.braking = dice.of({Braking::none, Braking::soft, Braking::remote});
    for (const Mode to : kEveryMode) {
      SCOPED_TRACE(testing::Message() << number(mode) << " to " << number(to));
      CoreState state = before;
      const Told told(state);
      const std::uint32_t bits = request_mode(state, to);
      ASSERT_EQ(bits, request_rule(before, to));
      const bool ramp = moves(mode) && to == Mode::standby;
      const bool enters = bits == 0 && !ramp && to != mode;
      EXPECT_EQ(state.mode, enters ? to : mode);
      EXPECT_EQ(told.of(EventKind::mode_changed).size(), enters ? 1U : 0U);
      EXPECT_EQ(state.in_mode.leaving, ramp);
      if (!enters) {
        EXPECT_EQ(state.in_mode.braking, ramp ? std::max(before.in_mode.braking, Braking::soft) : before.in_mode.braking);
      }
      changed += enters ? 1 : 0;
    }
    CoreState state = before;
    const Told told(state);
    finish_mode(state);
    EXPECT_EQ(state.mode, mode == Mode::init || moves(mode) || mode == Mode::calibrate ? Mode::standby : mode);
  }
  EXPECT_GT(changed, 150);
}

TEST(SuperviseModes, AHoistThatMustGoOutOfServiceDoesSoAsSoonAsItStands) {
  Dice dice(9);
  int out = 0;
  for (int i = 0; i < 3000 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    constexpr Mode kWays[] = {Mode::init, Mode::standby, Mode::calibrate, Mode::protective_stop};
    const Mode mode = dice.chance(0.7) ? kWays[dice.below(4)] : kEveryMode[dice.below(std::size(kEveryMode))];
    set_situation(before, mode, dice);
    if (dice.chance(0.8)) before.latched |= dice.of({kTooMany, breakdowns(), breakdowns() & ~kTooMany});
    before.stops_changed = false;
    before.acknowledgement.wait({41, 7, 3, 0, 20, false});
    before.stop_cause = static_cast<std::uint8_t>(dice.below(34));
    if (before.latched != 0 && dice.chance(0.4)) {
      std::uint8_t some = 0;
      while ((before.latched >> some & 1U) == 0) ++some;
      before.stop_cause = static_cast<std::uint8_t>(some + 1);
    }
    CoreState state = before;
    const Told told(state);
    serve_breakdown(state);
    const bool open = mode == Mode::init || (mode == Mode::protective_stop && before.still.ticks >= 100) ||
                      ((mode == Mode::standby || mode == Mode::calibrate) && at_rest(before));
    const FaultBits broken = before.latched & breakdowns();
    const bool goes = broken != 0 && open;
    EXPECT_EQ(state.mode, goes ? Mode::fault : mode);
    EXPECT_EQ(state.latched, before.latched);
    EXPECT_EQ(state.stops_changed, goes);
    EXPECT_EQ(state.acknowledgement.waits(), !goes);
    // Too many stops are no cause of their own: what stopped the hoist last stays it, if it is in force.
    std::uint8_t cause = before.stop_cause;
    const bool in_force = cause != 0 && (before.latched & FaultBits{1} << (cause - 1)) != 0;
    if (goes && !(in_force && broken == kTooMany))
      cause = cause_of((broken & set_of({Fault::parameters_corrupt})) != 0 ? Fault::parameters_corrupt : Fault::control_fault);
    EXPECT_EQ(state.stop_cause, cause);
    out += goes ? 1 : 0;
  }
  EXPECT_GT(out, 350);
}

// 84: the count of stops and "out of service" survive a restart; 77: so does a relay that was cut for a runaway.
TEST(SuperviseModes, OutOfServiceSurvivesARestart) {
  Dice dice(10);
  const FaultBits machine = stops() & ~kNoMachine;
  int again = 0, cut = 0;
  for (int i = 0; i < 2000 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    before.latched = some_faults(dice);
    if (dice.chance(0.5)) before.latched |= kTooMany;
    if (dice.chance(0.3)) static_cast<void>(before.repeats.note(6, before.time_ns, before.params));
    const StopHistory history = stop_history(before);
    EXPECT_EQ(history.out_of_service, (before.latched & kTooMany) != 0 ? before.latched & (kTooMany | machine) : 0);
    EXPECT_EQ(history.count, before.repeats.history().count);
    StopHistory stored = history;
    if (dice.chance(0.5)) stored.out_of_service = some_faults(dice) | (dice.chance(0.7) ? kTooMany : 0);
    CoreState state;
    state.started = dice.chance(0.2);
    const Told told(state);
    const bool started = state.started;
    restore_stops(state, stored);
    EXPECT_EQ(state.repeats.history().count, started ? 0 : stored.count);
    const bool out = !started && (stored.out_of_service & kTooMany) != 0;
    const FaultBits kept = out ? stored.out_of_service & (kTooMany | machine) : 0;
    EXPECT_EQ(state.latched, kept);
    EXPECT_EQ(told.faults(EventKind::fault_raised), kept);
    EXPECT_EQ(state.mode, out ? Mode::fault : Mode::init);
    EXPECT_EQ(state.relay.is_cut(), (kept & set_of({Fault::overspeed})) != 0);
    EXPECT_EQ(state.stop_cause, out ? cause_of(Fault::control_fault) : 0);
    again += out ? 1 : 0;
    cut += state.relay.is_cut() ? 1 : 0;
  }
  EXPECT_GT(again, 300);
  EXPECT_GT(cut, 10);
}

// 27: an engineer takes STANDBY or INIT there; the time since the tool's last word begins.
TEST(SuperviseModes, ServiceBeginsInInitOrAtRestOnStandby) {
  Dice dice(11);
  for (int i = 0; i < 400 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    const Mode mode = dice.chance(0.4) ? Mode::standby : kEveryMode[dice.below(std::size(kEveryMode))];
    set_situation(before, mode, dice);
    before.in_mode.epoch = 99;
    before.in_mode.service.quiet_ticks = 150;
    std::uint32_t against = 0;
    if (mode != Mode::init)
      against = mode != Mode::standby ? refusal_bit(Refusal::not_standby) | where_it_stands(before)
                                      : (at_rest(before) ? 0U : refusal_bit(Refusal::moving));
    CoreState state = before;
    const Told told(state);
    EXPECT_EQ(begin_service(state), against);
    EXPECT_EQ(state.mode, against == 0 ? Mode::init : mode);
    EXPECT_EQ(told.of(EventKind::mode_changed).size(), against == 0 && mode == Mode::standby ? 1U : 0U);
    EXPECT_EQ(state.in_mode.service.on, against == 0);
    EXPECT_EQ(state.in_mode.epoch, against == 0 ? before.lease.epoch : 99U);
    EXPECT_EQ(state.in_mode.service.quiet_ticks, against == 0 ? 0 : 150);
  }
}

constexpr std::array kTilts{&Estimate::left_strut, &Estimate::right_strut, &Estimate::base};

/// The server lives or not.
bool set_server(CoreState& state, Dice& dice) {
  const bool alive = dice.chance(0.85);
  state.server = {};
  for (const std::uint64_t beat : {1U, 2U}) static_cast<void>(state.server.update(alive ? beat : 1U));
  return alive;
}
void expect_nothing_asked(const Wish& wish, bool done) {
  EXPECT_EQ(wish.speed.m_s(), 0.0);
  EXPECT_EQ(wish.yaw_rate_rad_s, 0.0);
  EXPECT_EQ(wish.braking, Braking::none);
  EXPECT_EQ(wish.done, done);
}

// README: all nodes ready for 0.1 s; 27: service ends with two silent seconds, a lease change or a lost server.
TEST(SuperviseModes, InitWaitsUntilEverythingIsThereForATenthOfASecond) {
  Dice dice(12);
  int ready_steps = 0, done = 0, services = 0;
  for (int i = 0; i < 5000 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState state = bases().ready;
    const Facts facts = set_situation(state, Mode::init, dice);
    const bool alive = set_server(state, dice);
    Estimate& sensed = state.sensed;
    const double left_v = dice.of({25.0, 25.0, 5.0}), right_v = dice.of({25.0, 25.0, 5.0}), battery_v = dice.of({12.8, 12.8, 5.0});
    sensed.left_drive.take_supply(supply(0, left_v));
    sensed.right_drive.take_supply(supply(0, right_v));
    contract::CanFrame volts{0, 8, 0, {}};
    for (const contract::PdoSlot& slot :
         {contract::pdo_slot(contract::Pdo::io_tx2, 0x6401, 1), contract::pdo_slot(contract::Pdo::io_tx2, 0x6401, 2)})
      contract::write_slot(volts, slot, std::lround(battery_v * 100));
    if (facts.volts_known) sensed.io.take_batteries(volts);
    const bool no_power = left_v < 12 && right_v < 12 && battery_v > 10 && facts.volts_known;
    const bool left_resets = dice.chance(0.05), right_resets = dice.chance(0.05);
    state.left_control = state.right_control = {};
    if (left_resets) state.left_control.reset_fault();
    if (right_resets) state.right_control.reset_fault();
    state.bus_settle_ticks = dice.of<std::uint8_t>({0, 0, 0, 0, 0, 0, 1, 50});
    const bool failed = std::any_of(kTilts.begin(), kTilts.end(), [&](TiltSensor Estimate::*tilt) {
      return (sensed.*tilt).has(tilt_status::kSelfTestFailed) || (sensed.*tilt).has(tilt_status::kGyroSaturated);
    });
    const bool ready = state.bus_settle_ticks == 0 && facts.running && facts.angles_ms < 30 && !failed && facts.rates_ms < 30 &&
                       !facts.drive_lost && !facts.io_lost && facts.volts_known && !no_power && !left_resets && !right_resets;
    const int before = dice.of({0, 5, 8, 9, 10});
    state.clear.ticks = static_cast<std::uint16_t>(before);
    const bool service = dice.chance(0.2), same_lease = dice.chance(0.8);
    const int quiet = dice.of({0, 100, 197, 198, 199});
    state.in_mode.service.on = service;
    state.in_mode.service.quiet_ticks = static_cast<std::uint8_t>(quiet);
    state.in_mode.epoch = same_lease ? state.lease.epoch : state.lease.epoch + 1;
    const Wish wish = InitMode::step(state, 0.01);
    if (service) {
      const bool goes_on = state.lease.holder != 0 && same_lease && alive && quiet + 1 < 200;
      EXPECT_EQ(state.in_mode.service.on, goes_on);
      EXPECT_EQ(state.in_mode.service.quiet_ticks, goes_on ? quiet + 1 : 0);
      EXPECT_EQ(state.clear.ticks, 0) << "and then everything is waited for again";
      expect_nothing_asked(wish, false);
      ++services;
      continue;
    }
    EXPECT_EQ(state.clear.ticks, ready ? std::min(before + 1, 10) : 0);
    expect_nothing_asked(wish, ready && before + 1 >= 10);
    ready_steps += ready ? 1 : 0;
    done += wish.done ? 1 : 0;
  }
  EXPECT_GT(ready_steps, 120);
  EXPECT_GT(done, 40);
  EXPECT_GT(services, 400);
}

// README: it ends by request, after 60 s without progress, or when lease holder, server or a sensor is lost.
TEST(SuperviseModes, CalibrateGoesOnWhileItIsLedAndEverySensorIsThere) {
  Dice dice(13);
  int goes_on = 0;
  for (int i = 0; i < 2000 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState state = bases().ready;
    const Facts facts = set_situation(state, Mode::calibrate, dice);
    const bool alive = set_server(state, dice), same_lease = dice.chance(0.8);
    state.in_mode.epoch = same_lease ? state.lease.epoch : state.lease.epoch + 1;
    begin_calibration(state, CalibrationStep::square);
    const std::uint32_t idle = dice.of({0U, 5998U, 5999U});
    state.in_mode.calibration.idle_ticks = idle;
    const Wish wish = CalibrateMode::step(state, 0.01);
    const bool led = state.lease.holder != 0 && same_lease && alive;
    const bool lost = facts.angles_ms >= 50 || facts.rates_ms >= 50 || facts.drive_lost;
    const bool late = idle + 1 >= 6000;
    expect_nothing_asked(wish, !led || lost || late);
    EXPECT_EQ(state.in_mode.calibration.reason, !led   ? CalibrationReason::cancelled
                                                : lost ? CalibrationReason::sensor_lost
                                                : late ? CalibrationReason::timed_out
                                                       : CalibrationReason::none);
    goes_on += wish.done ? 0 : 1;
  }
  EXPECT_GT(goes_on, 200);
}

// A step begins from STANDBY, or another one in CALIBRATE: then the one before has ended without a result.
TEST(SuperviseModes, ACalibrationStepBeginsAndEndsByTheRule) {
  Dice dice(14);
  int begun = 0;
  for (int i = 0; i < 1500 && !HasFailure(); ++i) {
    SCOPED_TRACE(i);
    CoreState before = bases().ready;
    const Mode mode = dice.chance(0.1) ? kEveryMode[dice.below(std::size(kEveryMode))] : dice.of({Mode::standby, Mode::calibrate});
    set_situation(before, mode, dice);
    if (dice.chance(0.5)) ease(before);
    before.in_mode.epoch = 99;
    const bool measures = mode == Mode::calibrate && dice.chance(0.7);
    const auto reason = dice.of({CalibrationReason::none, CalibrationReason::not_still});
    if (measures) {
      begin_calibration(before, CalibrationStep::track);
      before.in_mode.calibration.reason = reason;
      before.in_mode.calibration.idle_ticks = 700;
    }
    const contract::CalibrationStepInfo& info = contract::kCalibrationSteps[dice.below(contract::kCalibrationSteps.size())];
    const std::uint32_t against = calibration_refusals(before, info);
    CoreState state = before;
    const Told told(state);
    ASSERT_EQ(enter_calibration(state, info), against);
    EXPECT_EQ(state.mode, against == 0 ? Mode::calibrate : mode);
    EXPECT_EQ(told.of(EventKind::mode_changed).size(), against == 0 && mode == Mode::standby ? 1U : 0U);
    EXPECT_EQ(told.of(EventKind::calibration_ended).size(), against == 0 && measures ? 1U : 0U);
    EXPECT_EQ(state.in_mode.calibration.step, against == 0 ? info.step : before.in_mode.calibration.step);
    EXPECT_EQ(state.in_mode.calibration.idle_ticks, against == 0 || !measures ? 0U : 700U);
    EXPECT_EQ(state.in_mode.epoch, against == 0 ? before.lease.epoch : 99U);
    begun += against == 0 ? 1 : 0;
    if (!measures) continue;
    // Its end says whether the result is used; else the last word is the operator's.
    const bool used = dice.chance(0.5);
    CoreState left = before;
    const Told end(left);
    leave_calibration(left, used);
    EXPECT_EQ(left.mode, Mode::standby);
    const auto ended = end.of(EventKind::calibration_ended);
    ASSERT_EQ(ended.size(), 1U);
    EXPECT_EQ(ended[0].bits, used ? 1U : 0U);
    EXPECT_EQ(ended[0].item, used ? 0U : static_cast<std::uint32_t>(CalibrationReason::cancelled));
  }
  EXPECT_GT(begun, 200);
}

TEST(SuperviseModes, AProtectiveStopHoldsWithTheBrakingOfItsCause) {
  CoreState state = bases().ready;
  for (const Braking braking : {Braking::protective, Braking::bumper}) {
    state.in_mode.braking = braking;
    const Wish wish = ProtectiveStopMode::step(state, 0.01);
    EXPECT_TRUE(wish.speed.m_s() == 0 && wish.yaw_rate_rad_s == 0 && wish.braking == braking && !wish.done);
  }
}

}  // namespace
}  // namespace hoist::core::test::supervise
