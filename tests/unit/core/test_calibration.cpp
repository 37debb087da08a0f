// CALIBRATE through its commands: who may, what is refused, how it ends, what becomes parameters.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "control/contract/calibration.hpp"
#include "control/core/serve/param_keeper.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::CalibrationPhase;
using contract::CalibrationReason;
using contract::CalibrationStep;
using contract::Role;

constexpr double kToday_s = 1'790'000'000.0;

std::uint32_t begin(ScriptedHoist& hoist, CalibrationStep step, Role role = Role::engineer, std::uint32_t client = 7) {
  return hoist.ask(CommandKind::begin_calibration, client, static_cast<std::uint32_t>(step), static_cast<std::uint32_t>(role), 1.0);
}
const Calibration& calibration(const ScriptedHoist& hoist) { return hoist.state.in_mode.calibration; }

TEST(Calibrate, OnlyTheDriverInTheStepsRoleBegins) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  EXPECT_EQ(begin(hoist, CalibrationStep::strut_length, Role::therapist), refusal_bit(Refusal::not_allowed));
  EXPECT_EQ(begin(hoist, CalibrationStep::zero, Role::viewer), refusal_bit(Refusal::not_allowed));
  EXPECT_EQ(begin(hoist, CalibrationStep::zero, Role::therapist, 8), refusal_bit(Refusal::no_lease));
  EXPECT_EQ(hoist.ask(CommandKind::begin_calibration, 7, 0, 2), refusal_bit(Refusal::unknown_item));
  EXPECT_EQ(hoist.ask(CommandKind::begin_calibration, 7, 99, 2), refusal_bit(Refusal::unknown_item));
  EXPECT_EQ(hoist.ask(CommandKind::begin_calibration, 7, 1, 77, 1.0), refusal_bit(Refusal::not_allowed));
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_EQ(begin(hoist, CalibrationStep::zero, Role::therapist), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::calibrate);
}

// No sensor tells a motionless patient from an empty harness; a zero taken with a patient would make the hoist move off.
TEST(Calibrate, StepsForAnEmptyHarnessNeedItsConfirmation) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (const contract::CalibrationStepInfo& info : contract::kCalibrationSteps) {
    const auto step = static_cast<std::uint32_t>(info.step);
    const bool strut = info.step == CalibrationStep::zero || info.step == CalibrationStep::strut_length ||
                       info.step == CalibrationStep::strut_spacing || info.step == CalibrationStep::struts;
    for (const double unconfirmed : {0.0, 0.5, -1.0, 2.0, std::numeric_limits<double>::quiet_NaN()})
      EXPECT_EQ(hoist.ask(CommandKind::begin_calibration, 7, step, 2, unconfirmed), strut ? refusal_bit(Refusal::harness_unconfirmed) : 0U)
          << info.name << ' ' << unconfirmed;
    EXPECT_EQ(hoist.ask(CommandKind::begin_calibration, 7, step, 2, 1.0), 0U) << info.name;
    ASSERT_EQ(hoist.ask(CommandKind::cancel_calibration), 0U);
  }
}

TEST(Calibrate, AllReasonsAreToldAtOnce) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  const std::uint32_t bits = begin(hoist, CalibrationStep::strut_length, Role::therapist, 8);
  EXPECT_EQ(bits, refusal_bit(Refusal::not_allowed) | refusal_bit(Refusal::no_lease) | refusal_bit(Refusal::not_standby));
  EXPECT_EQ(hoist.state.mode, Mode::user);
}

TEST(Calibrate, TheZerosBecomeParametersAsOneSetWithTheirDate) {
  ScriptedHoist hoist;
  hoist.tilt_left.alpha_deg = 1.5;
  hoist.tilt_right.beta_deg = -2.0;
  hoist.tilt_base.alpha_deg = 0.7;
  ASSERT_TRUE(hoist.to_standby());
  ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
  contract::Params leaning = hoist.state.params;
  leaning.neutral_lean_m = 0.03;
  leaning.calibrated_neutral_s = kToday_s - 86400;
  install_params(hoist.state, leaning);
  ASSERT_EQ(begin(hoist, CalibrationStep::zero, Role::therapist), 0U);
  EXPECT_NE(hoist.ask(CommandKind::use_calibration, 7, 0, 0, kToday_s), 0U) << "there is no result yet";
  hoist.step(520);
  ASSERT_EQ(calibration(hoist).phase, CalibrationPhase::result);
  EXPECT_EQ(hoist.state.params.left_alpha_zero_rad, 0.0) << "not before it is used";
  EXPECT_EQ(hoist.ask(CommandKind::use_calibration, 7, 0, 0, 0.0), refusal_bit(Refusal::out_of_range)) << "a date that means never";
  EXPECT_EQ(hoist.ask(CommandKind::use_calibration, 7, 0, 0, std::numeric_limits<double>::quiet_NaN()), refusal_bit(Refusal::out_of_range));
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0.2;  // pushed
  hoist.step(5);
  EXPECT_EQ(hoist.ask(CommandKind::use_calibration, 7, 0, 0, kToday_s), refusal_bit(Refusal::moving));
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = NAN;
  hoist.step(50);
  const auto version = hoist.state.parameter_version;
  EXPECT_EQ(hoist.ask(CommandKind::use_calibration, 7, 0, 0, kToday_s), 0U);
  EXPECT_TRUE(hoist.out.params_changed);
  EXPECT_EQ(hoist.state.parameter_version, version + 1) << "one set";
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  constexpr double kDegree = 3.14159265358979323846 / 180.0;
  EXPECT_NEAR(hoist.state.params.left_alpha_zero_rad, 1.501 * kDegree, 2e-5);
  EXPECT_NEAR(hoist.state.params.right_beta_zero_rad, -2.0 * kDegree, 2e-5);
  EXPECT_NEAR(hoist.state.params.base_alpha_zero_rad, 0.701 * kDegree, 2e-5);
  EXPECT_EQ(hoist.state.params.neutral_lean_m, 0.0) << "it was taken against the old zeros";
  EXPECT_EQ(hoist.state.params.calibrated_neutral_s, 0.0);
  EXPECT_EQ(hoist.state.params.calibrated_zero_s, kToday_s);
  hoist.step(5);
  EXPECT_NEAR(hoist.state.sensed.left_strut.alpha_rad(), 0.0, 5e-5);
  // H7: a new zero is no movement.
  EXPECT_EQ(hoist.count(EventKind::fault_raised), 0);
}

TEST(Calibrate, CancellingLosingTheLeaseAndStopKeepTheOldValues) {
  for (int how = 0; how < 4; ++how) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    ASSERT_EQ(begin(hoist, CalibrationStep::zero, Role::therapist), 0U);
    hoist.step(530);
    ASSERT_EQ(calibration(hoist).phase, CalibrationPhase::result);
    if (how == 0) {
      EXPECT_EQ(hoist.ask(CommandKind::cancel_calibration), 0U);
    }
    if (how == 1) {
      EXPECT_EQ(hoist.ask_mode(Mode::standby), 0U);
    }
    if (how == 2) {
      EXPECT_EQ(hoist.ask(CommandKind::release_lease), 0U);
    }
    if (how == 3) {
      EXPECT_EQ(hoist.ask(CommandKind::stop), 0U);
    }
    hoist.step(2);
    EXPECT_EQ(hoist.state.mode, how == 3 ? Mode::protective_stop : Mode::standby) << how;
    EXPECT_EQ(hoist.count(EventKind::calibration_ended), 1) << how;
    EXPECT_EQ(hoist.count(EventKind::parameter_changed), 0) << how;
    EXPECT_EQ(hoist.state.params.calibrated_zero_s, 0.0);
  }
}

TEST(Calibrate, NoWheelIsEverPoweredAndPushingIsNoFault) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(begin(hoist, CalibrationStep::wheel_radius), 0U);
  hoist.step(60);
  ASSERT_EQ(calibration(hoist).phase, CalibrationPhase::operator_);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0.5;
  for (int i = 0; i < 400; ++i) {
    hoist.step();
    ASSERT_NE(hoist.drive_left.status, 0x27);
    ASSERT_EQ(hoist.command_m_s(), 0.0);
  }
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0.0;
  EXPECT_EQ(hoist.state.mode, Mode::calibrate);
  EXPECT_EQ(hoist.count(EventKind::fault_raised), 0);
  hoist.step(5);
  ASSERT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 0, 0, 2.1), 0U);
  hoist.step(60);
  EXPECT_EQ(hoist.count(EventKind::calibration_sample), 1);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = -0.5;
  hoist.step(400);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0.0;
  hoist.step(5);
  ASSERT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 0, 0, -2.1), 0U);
  hoist.step(60);
  ASSERT_EQ(calibration(hoist).phase, CalibrationPhase::result);
  ASSERT_EQ(hoist.ask(CommandKind::use_calibration, 7, 0, 0, kToday_s), 0U);
  EXPECT_NEAR(hoist.state.params.wheel_radius_m, 0.105, 1e-4);
}

TEST(Calibrate, HostileFiguresChangeNothing) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 0, 0, 1.0), refusal_bit(Refusal::out_of_order)) << "nothing is calibrated";
  ASSERT_EQ(begin(hoist, CalibrationStep::strut_length), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 8, 0, 0, 0.1), refusal_bit(Refusal::no_lease));
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 0, 0, kNaN), refusal_bit(Refusal::not_finite));
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 0, 0, 0.1, kNaN), refusal_bit(Refusal::not_finite));
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 0, 0, 0.31), refusal_bit(Refusal::out_of_range));
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 0, 0, 0.0), refusal_bit(Refusal::out_of_range));
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 1, 0, 0.1), refusal_bit(Refusal::unknown_item));
  EXPECT_EQ(calibration(hoist).pairs.size(), 0U);
  ASSERT_EQ(begin(hoist, CalibrationStep::square), 0U) << "another step is begun without leaving the mode";
  EXPECT_EQ(hoist.count(EventKind::calibration_ended), 1);
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 0, 0, 3.0), refusal_bit(Refusal::unknown_item)) << "left or right?";
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 1, 0, 3.0, 4.0, 0.0), refusal_bit(Refusal::out_of_range));
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 1, 0, 3.0, 0.1, -0.1), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 2, 0, 2.0, 0.1, 0.1), refusal_bit(Refusal::inconsistent_set)) << "another size";
}

TEST(Calibrate, TwoSquaresBecomeTrackAndWheels) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(begin(hoist, CalibrationStep::square), 0U);
  // Corners 2 % too far, sides straight: a track 2 % narrower than assumed.
  constexpr double kCorner_rad = 0.02 * 3.14159265358979323846 / 2.0;
  const double error_m = 2.0 * 3.0 * kCorner_rad;
  ASSERT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 1, 0, 3.0, error_m, -error_m), 0U);
  EXPECT_EQ(calibration(hoist).phase, CalibrationPhase::operator_);
  ASSERT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 1, 0, 3.0, error_m, -error_m), 0U);
  EXPECT_EQ(calibration(hoist).reason, CalibrationReason::one_direction);
  ASSERT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 2, 0, 3.0, error_m, error_m), 0U);
  ASSERT_EQ(calibration(hoist).phase, CalibrationPhase::result);
  ASSERT_EQ(hoist.ask(CommandKind::use_calibration, 7, 0, 0, kToday_s), 0U);
  EXPECT_NEAR(hoist.state.params.track_width_m, 0.70 / 1.02, 2e-3);
  EXPECT_NEAR(hoist.state.params.wheel_left_scale_norm, 1.0, 1e-9);
  EXPECT_NEAR(hoist.state.params.wheel_right_scale_norm, 1.0, 1e-9);
}

TEST(Calibrate, ALostSensorEndsIt) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(begin(hoist, CalibrationStep::strut_length), 0U);
  hoist.tilt_left.silent = true;
  hoist.step(20);
  EXPECT_NE(hoist.state.mode, Mode::calibrate);
  EXPECT_EQ(hoist.count(EventKind::parameter_changed), 0);
}

// Rates are a separate message. Without it the last value stays, which looks like a gyroscope at perfect rest.
TEST(Calibrate, H4SilenceOfTheTurnRateEndsIt) {
  for (const CalibrationStep step :
       {CalibrationStep::zero, CalibrationStep::gyro, CalibrationStep::encoders, CalibrationStep::strut_length}) {
    const std::string who = "step " + std::to_string(static_cast<int>(step));
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    hoist.tilt_base.yaw_rate_deg_s = 2.0;
    hoist.step(3);
    ASSERT_EQ(begin(hoist, step), 0U) << who;
    hoist.step(10);
    hoist.tilt_base.rates_silent = true;
    hoist.tilt_base.yaw_rate_deg_s = 0.0;
    hoist.step(4);
    EXPECT_EQ(hoist.state.mode, Mode::calibrate) << who << ": a few frames may get lost";
    hoist.step(600);
    EXPECT_EQ(hoist.state.mode, Mode::protective_stop) << who;
    EXPECT_TRUE(hoist.has_fault(contract::Fault::tilt_base_lost)) << who;
    EXPECT_EQ(hoist.count(EventKind::calibration_ended), 1) << who;
    EXPECT_NE(hoist.ask(CommandKind::use_calibration, 7, 0, 0, kToday_s), 0U) << who;
    EXPECT_EQ(hoist.count(EventKind::parameter_changed), 0) << who;
    // Nor does it restart until they arrive again.
    EXPECT_NE(begin(hoist, step) & refusal_bit(Refusal::nodes_missing), 0U) << who;
    hoist.tilt_base.rates_silent = false;
    hoist.step(3);
    EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U) << who;
    hoist.step(120);
    EXPECT_EQ(begin(hoist, step), 0U) << who;
  }
}

// Two places are always on a line; the third one shows that at the first the bar was three centimetres short of what was entered.
TEST(Calibrate, AStrutIsNotMeasuredByTwoPlaces) {
  struct Place {
    double true_m, entered_m;
  };
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(begin(hoist, CalibrationStep::strut_length), 0U);
  const auto measure = [&](Place place) {
    hoist.tilt_left.alpha_deg = hoist.tilt_right.alpha_deg = std::atan(place.true_m / hoist.state.params.strut_length_m) / kDeg;
    hoist.step(30);
    ASSERT_EQ(hoist.ask(CommandKind::measure_calibration, 7, 0, 0, place.entered_m), 0U);
    hoist.step(110);
  };
  measure({0.09, 0.12});
  measure({-0.12, -0.12});
  EXPECT_EQ(hoist.count(EventKind::calibration_sample), 2);
  EXPECT_EQ(calibration(hoist).phase, CalibrationPhase::operator_);
  EXPECT_TRUE(calibration(hoist).result.rows.empty());
  measure({0.06, 0.06});
  EXPECT_EQ(hoist.count(EventKind::calibration_sample), 3);
  EXPECT_EQ(calibration(hoist).phase, CalibrationPhase::refused);
  EXPECT_EQ(calibration(hoist).reason, CalibrationReason::disagree);
}

// Hazard table 2.3: patients walk only on a hoist whose struts have been zeroed. A simulated one reports it.
TEST(Calibrate, ARealHoistThatWasNeverZeroedDoesNotStart) {
  for (const bool zeroed : {false, true}) {
    contract::Params params;
    params.calibrated_zero_s = zeroed ? kToday_s : 0.0;
    ScriptedHoist hoist(params);
    hoist.real = true;
    ASSERT_TRUE(hoist.ready());
    EXPECT_EQ(hoist.ask_mode(Mode::user), (zeroed ? 0U : refusal_bit(Refusal::not_calibrated)) | refusal_bit(Refusal::parts_unchecked));
  }
  ScriptedHoist simulated;
  ASSERT_TRUE(simulated.ready());
  EXPECT_EQ(simulated.ask_mode(Mode::user), 0U);
}

// The checks of a technician on the scripted hoist, each to its result and used.
void check_wheels(ScriptedHoist& hoist) {
  ASSERT_EQ(begin(hoist, CalibrationStep::encoders), 0U);
  hoist.step(60);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0.4;
  hoist.step(100);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0;
  hoist.step(60);
  hoist.drive_left.forced_m_s = -0.3;
  hoist.drive_right.forced_m_s = 0.3;
  hoist.tilt_base.yaw_rate_deg_s = 0;  // the scripted chassis turns with its wheels
  hoist.step(100);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0;
  hoist.step(60);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = NAN;
}
void check_bumpers(ScriptedHoist& hoist) {
  ASSERT_EQ(begin(hoist, CalibrationStep::bumpers), 0U);
  for (int strip = 0; strip < 4; ++strip) {
    hoist.step(10);
    hoist.io.bumpers = static_cast<std::uint8_t>(1U << strip);
    hoist.step(10);
    hoist.io.bumpers = 0;
  }
  hoist.step(10);
}
// Where each strut goes, in degrees: forward and to the right.
struct Struts {
  double left_alpha, left_beta, right_alpha, right_beta;
};
void hold(ScriptedHoist& hoist, const Struts& at) {
  hoist.tilt_left.alpha_deg = at.left_alpha;
  hoist.tilt_left.beta_deg = at.left_beta;
  hoist.tilt_right.alpha_deg = at.right_alpha;
  hoist.tilt_right.beta_deg = at.right_beta;
  hoist.step(150);
}
constexpr Struts kUpright{0, 0, 0, 0}, kForward{9, 0.5, 8, -0.5}, kToTheRight{0.5, 8, -0.5, 8}, kTurnedLeft{-8, 0.3, 8, 0.3};
void check_struts(ScriptedHoist& hoist) {
  ASSERT_EQ(begin(hoist, CalibrationStep::struts), 0U);
  for (const Struts& motion : {kForward, kToTheRight, kTurnedLeft}) {
    hold(hoist, kUpright);
    hold(hoist, motion);
  }
}
void use(ScriptedHoist& hoist) {
  ASSERT_EQ(calibration(hoist).phase, CalibrationPhase::result) << static_cast<int>(calibration(hoist).reason);
  ASSERT_EQ(hoist.ask(CommandKind::use_calibration, 7, 0, 0, kToday_s), 0U);
  hold(hoist, kUpright);
}

// H2, H7, H13: what is mounted wrongly steers the wrong way. So nothing moves before the sides and signs were seen, and again when a part is new.
TEST(Calibrate, ARealHoistDoesNotStartWithPartsThatNobodyChecked) {
  contract::Params params;
  params.calibrated_zero_s = kToday_s;
  ScriptedHoist hoist(params);
  hoist.real = true;
  std::uint32_t serial = 0x1001;
  hoist.each([&serial](contract::Node, FakeNode& node) { node.serial = serial++; });
  ASSERT_TRUE(hoist.ready());
  const std::array checks{check_wheels, check_bumpers, check_struts};
  const std::array dates{&contract::Params::calibrated_encoders_s, &contract::Params::calibrated_bumpers_s,
                         &contract::Params::calibrated_struts_s};
  for (const auto check : checks) {
    EXPECT_EQ(hoist.ask_mode(Mode::user), refusal_bit(Refusal::parts_unchecked));
    check(hoist);
    use(hoist);
  }
  for (const auto date : dates) EXPECT_EQ(hoist.state.params.*date, kToday_s);
  EXPECT_EQ(hoist.ask_mode(Mode::user), 0U);
  EXPECT_EQ(hoist.ask_mode(Mode::standby), 0U);
  hoist.step(50);

  // The same parts after a break; then another one, and two that changed places.
  const contract::Params signed_params = hoist.state.params;
  for (int change = 0; change < 3; ++change) {
    SCOPED_TRACE(change);
    ScriptedHoist next(signed_params);
    next.real = true;
    serial = 0x1001;
    next.each([&serial](contract::Node, FakeNode& node) { node.serial = serial++; });
    if (change == 1) next.io.serial = 0x2000;
    if (change == 2) std::swap(next.tilt_left.serial, next.tilt_right.serial);
    ASSERT_TRUE(next.ready());
    EXPECT_EQ(next.ask_mode(Mode::user), change == 0 ? 0U : refusal_bit(Refusal::parts_unchecked));
    if (change == 0) continue;
    // A check counts for the parts it was made with, so the other ones are due again.
    check_struts(next);
    use(next);
    EXPECT_EQ(next.state.params.calibrated_bumpers_s, 0.0);
    EXPECT_EQ(next.state.params.calibrated_encoders_s, 0.0);
    EXPECT_EQ(next.ask_mode(Mode::user), refusal_bit(Refusal::parts_unchecked));
  }
}

// A part that is exchanged while the hoist is on; and a line that garbles a number once.
TEST(Calibrate, APartThatIsExchangedWhileTheHoistIsOnIsSeen) {
  ScriptedHoist hoist;
  hoist.real = true;
  hoist.each([](contract::Node, FakeNode& node) { node.serial = 0x77; });
  ASSERT_TRUE(hoist.ready());
  const std::uint32_t id = hoist.state.master.nodes_id();
  for (const bool other : {false, true}) {
    hoist.drive_left.garbled_sub = 4;
    hoist.drive_left.garble = 0x100;
    if (other) hoist.drive_left.serial = 0x78;
    hoist.drive_left.booted = false;
    hoist.step(300);
    ASSERT_TRUE(hoist.state.master.all_running());
    EXPECT_EQ(hoist.state.master.nodes_id() != id, other);
  }
}

// Struts that seem to lean sideways far apart are implausible besides, and stop the step (tilt_implausible).
TEST(Calibrate, H7EachStrutSensorIsOnItsStrutAndTheRightWayRound) {
  struct Wrong {
    Struts forward, right, left;
    CalibrationReason found;
  };
  for (const Wrong& wrong : {
           Wrong{{-9, 0, 8, 0}, {}, {}, CalibrationReason::left_strut_turned},
           Wrong{{9, 0, -8, 0}, {}, {}, CalibrationReason::right_strut_turned},
           Wrong{{-9, 0, -8, 0}, {}, {}, CalibrationReason::bar_other_way},
           Wrong{{0.5, 0.5, 9, 0}, {}, {}, CalibrationReason::left_strut_askew},
           Wrong{{9, 0, 0.2, 0.2}, {}, {}, CalibrationReason::right_strut_askew},
           Wrong{{0, 9, 0, 9}, {}, {}, CalibrationReason::bar_other_way},
           Wrong{kForward, {0, -8, 0, -8}, {}, CalibrationReason::bar_other_way},
           Wrong{kForward, kForward, {}, CalibrationReason::bar_other_way},
           Wrong{kForward, kToTheRight, {8, 0, -8, 0}, CalibrationReason::struts_swapped},
           Wrong{kForward, kToTheRight, kForward, CalibrationReason::bar_other_way},
           // What is too small is waited for.
           Wrong{{5, 0, 5, 0}, {-5, 0, -5, 0}, {5, 5, 5, 5}, CalibrationReason::none},
       }) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    ASSERT_EQ(begin(hoist, CalibrationStep::struts), 0U);
    for (const Struts& motion : {wrong.forward, wrong.right, wrong.left}) {
      hold(hoist, kUpright);
      hold(hoist, motion);
      if (calibration(hoist).phase == CalibrationPhase::refused) break;
    }
    EXPECT_NE(calibration(hoist).phase, CalibrationPhase::result);
    EXPECT_EQ(calibration(hoist).reason, wrong.found);
  }
}

}  // namespace
}  // namespace hoist::core::test
