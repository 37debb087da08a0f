// GUIDED: the hoist drives exercises with a patient while the therapist holds hold-to-run. Measured by the true position on the floor, and
// by odometry.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "control/contract/guided_path.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/seeds.hpp"

namespace hoist::tests {
namespace {

using contract::Fault;
using contract::GuidedEnd;
using contract::GuidedPath;
using contract::GuidedShape;
using contract::Mode;

constexpr double kTurn_rad = 2.0 * std::numbers::pi;

ClosedLoopOptions standing() {
  ClosedLoopOptions options;
  options.world.scenario = sim::find_scenario("figure-eight");
  return options;
}

/// Where the machine truly is, against where it began.
struct Place {
  double x_m = 0, y_m = 0, psi_rad = 0;
};
Place true_place(ClosedLoop& loop, const sim::PlatformMotion& begun) {
  const sim::PlatformMotion& now = loop.world().plant().platform();
  const double dx_m = now.x_m - begun.x_m, dy_m = now.y_m - begun.y_m;
  const double cos_psi = std::cos(begun.psi_rad), sin_psi = std::sin(begun.psi_rad);
  return {cos_psi * dx_m + sin_psi * dy_m, cos_psi * dy_m - sin_psi * dx_m, now.psi_rad - begun.psi_rad};
}

/// An exercise held all along: distance from the line, and place of standstill.
struct Drive {
  double square_sum_m2 = 0, worst_m = 0, top_m_s = 0;
  int samples = 0;
  Place end;
  GuidedEnd ended = GuidedEnd::none;

  [[nodiscard]] double rms_m() const { return samples > 0 ? std::sqrt(square_sum_m2 / samples) : 0; }
};

Drive drive(ClosedLoop& loop, double at_most_s) {
  Drive run;
  const sim::PlatformMotion begun = loop.world().plant().platform();
  loop.hold_stick(0.0, 0.0);
  const double begun_s = loop.time_s();
  while (loop.mode() == Mode::guided && loop.time_s() < begun_s + at_most_s) {
    loop.step();
    const contract::TickRecord& r = loop.record();
    const double cross_m = static_cast<double>(r.guided_cross_track_m);
    run.square_sum_m2 += cross_m * cross_m;
    ++run.samples;
    run.worst_m = std::fmax(run.worst_m, std::fabs(cross_m));
    run.top_m_s = std::fmax(run.top_m_s, static_cast<double>(r.speed_m_s));
  }
  loop.let_go();
  loop.run(0.5);
  run.end = true_place(loop, begun);
  run.ended = static_cast<GuidedEnd>(loop.record().guided_end);
  return run;
}

constexpr double kEnd_m = 0.03, kEnd_rad = 2.0 * std::numbers::pi / 180.0;

void expect_end(const Drive& run, double x_m, double y_m = 0) {
  EXPECT_EQ(run.ended, GuidedEnd::finished);
  EXPECT_LT(std::hypot(run.end.x_m - x_m, run.end.y_m - y_m), kEnd_m);
  EXPECT_LT(std::fabs(std::remainder(run.end.psi_rad, kTurn_rad)), kEnd_rad);
}

TEST(Guided, TheFigureOfEightStaysWithinTwoCentimetres) {
  ClosedLoop loop(standing());
  ASSERT_TRUE(loop.start_guided({GuidedShape::eight, false, 1.0, 0.8, 0.3, 2}));
  const Drive run = drive(loop, 120.0);
  EXPECT_LT(run.rms_m(), 0.02);
  EXPECT_GT(run.rms_m(), 1e-5) << "too good to be measured";
  EXPECT_LT(run.worst_m, 0.03);
  EXPECT_NEAR(run.top_m_s, 0.3, 0.01);
  expect_end(run, 0.0);
  EXPECT_EQ(loop.record().stop_cause, 0U);
}

TEST(Guided, EveryShapeEndsWhereItShould) {
  struct Case {
    const char* name;
    GuidedPath path;
    double x_m, turns, y_m = 0;
  };
  const Case cases[] = {
      {"straight", {GuidedShape::straight, false, 3.0, 0, 0.5, 1}, 3.0, 0},
      {"square", {GuidedShape::square, false, 1.5, 0, 0.3, 1}, 0, 1},
      {"square to the right", {GuidedShape::square, true, 1.5, 0, 0.3, 1}, 0, -1},
      {"round square", {GuidedShape::square, false, 2.0, 0.5, 0.4, 1}, 0, 1},
      {"circle", {GuidedShape::circle, false, 0.8, 0, 0.3, 1}, 0, 1},
      {"circle to the right, twice", {GuidedShape::circle, true, 0.8, 0, 0.3, 2}, 0, -2},
      {"tight circle, asked too fast", {GuidedShape::circle, false, 0.4, 0, 0.6, 1}, 0, 1},
      {"eight of tangent circles", {GuidedShape::eight, true, 0.7, 0.7, 0.25, 1}, 0, 0},
      {"slalom", {GuidedShape::slalom, false, 2.0, 0, 0.4, 1}, 10.0, 0, 2.0 * contract::kSlalomCurve_norm},
      {"slalom to the right", {GuidedShape::slalom, true, 1.75, 0, 0.3, 1}, 8.75, 0, -1.75 * contract::kSlalomCurve_norm},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    ClosedLoop loop(standing());
    ASSERT_TRUE(loop.start_guided(c.path));
    const Drive run = drive(loop, 120.0);
    expect_end(run, c.x_m, c.y_m);
    EXPECT_NEAR(run.end.psi_rad / kTurn_rad, c.turns, 0.02);
    EXPECT_LT(run.worst_m, 0.03);
    EXPECT_EQ(loop.record().stop_cause, 0U);
    EXPECT_EQ(loop.mode(), Mode::standby);
  }
}

// Poles 0.1 m thick stand where the console tells: at the least spacing that the hoist drives, no bumper touches one.
TEST(Guided, TheTightestSlalomTouchesNoPole) {
  const double spacing_m = contract::find_size(GuidedShape::slalom, contract::ExerciseRole::size)->driven_least_m;
  for (const bool right : {false, true}) {
    SCOPED_TRACE(right);
    ClosedLoop loop(standing());
    const sim::PlatformMotion begun = loop.world().plant().platform();
    for (int pole = 1; pole <= 4; ++pole) {
      const double ahead_m = pole * spacing_m, left_m = (right ? -0.5 : 0.5) * contract::kSlalomCurve_norm * spacing_m;
      const double cos_psi = std::cos(begun.psi_rad), sin_psi = std::sin(begun.psi_rad);
      ASSERT_TRUE(loop.world().plant().add_obstacle(
          {begun.x_m + cos_psi * ahead_m - sin_psi * left_m, begun.y_m + sin_psi * ahead_m + cos_psi * left_m, 0.05}));
    }
    ASSERT_TRUE(loop.start_guided({GuidedShape::slalom, right, spacing_m, 0, 0.4, 1}));
    EXPECT_EQ(drive(loop, 120.0).ended, GuidedEnd::finished);
    EXPECT_EQ(loop.record().stop_cause, 0U);
  }
}

// The tight circle is requested at 0.6 m/s and may turn at 30 degrees per second, of which a curve takes 80 %.
TEST(Guided, ACurveIsDrivenAsSlowlyAsItNeeds) {
  ClosedLoop loop(standing());
  ASSERT_TRUE(loop.start_guided({GuidedShape::circle, false, 0.4, 0, 0.6, 1}));
  const Drive run = drive(loop, 60.0);
  EXPECT_LT(run.top_m_s, 0.8 * 0.5236 * 0.4 + 0.01);
  EXPECT_GT(run.top_m_s, 0.8 * 0.5236 * 0.4 - 0.02);
}

// A wide curve that turns slowly enough may still be too fast for the outer wheel: 0.6 m/s on 1 m would be 0.81 m/s there. With a low jerk
// it must slow down earlier.
TEST(Guided, H1_ACurveIsDrivenAsSlowlyAsItsOuterWheelNeeds) {
  for (const double jerk_m_s3 : {3.0, 1.0, 0.5}) {
    for (const double radius_m : {1.0, 0.6, 0.4}) {
      ClosedLoopOptions options = standing();
      options.params.remote_yaw_rate_rad_s_max = options.params.yaw_rate_rad_s_max;
      options.params.jerk_m_s3_max = jerk_m_s3;
      for (const GuidedPath& path :
           {GuidedPath{GuidedShape::eight, false, 1.5, radius_m, 0.6, 1}, GuidedPath{GuidedShape::square, false, 3.0, radius_m, 0.6, 1},
            GuidedPath{GuidedShape::square, false, 2.3, radius_m, 0.6, 1}}) {
        ClosedLoop loop(options);
        ASSERT_TRUE(loop.start_guided(path));
        const Drive run = drive(loop, 90.0);
        EXPECT_GT(run.top_m_s, 0.45) << "on the straight";
        EXPECT_LT(run.worst_m, 0.03) << jerk_m_s3 << " m/s3, radius " << radius_m << " m";
        EXPECT_EQ(run.ended, GuidedEnd::finished);
        EXPECT_EQ(loop.record().stop_cause, 0U);
      }
    }
  }
}

// The hoist must not roll beyond the end of a short line, also with a low jerk.
TEST(Guided, AShortWayEndsWhereItShouldWhateverTheJerk) {
  for (const double jerk_m_s3 : {0.5, 0.7, 1.0, 3.0, 10.0})
    for (const double length_m : {0.5, 0.8, 1.2, 2.0}) {
      ClosedLoopOptions options = standing();
      options.params.jerk_m_s3_max = jerk_m_s3;
      ClosedLoop loop(options);
      ASSERT_TRUE(loop.start_guided({GuidedShape::straight, false, length_m, 0, 0.65, 1}));
      const Drive run = drive(loop, 60.0);
      EXPECT_EQ(run.ended, GuidedEnd::finished);
      EXPECT_NEAR(run.end.x_m, length_m, 0.05) << jerk_m_s3 << " m/s3, " << length_m << " m";
    }
}

// H17: a dozen releases on the way do not change line and end.
TEST(Guided, LettingGoAgainAndAgainStaysOnTheLine) {
  ClosedLoop loop(standing());
  ASSERT_TRUE(loop.start_guided({GuidedShape::eight, false, 1.0, 0.8, 0.4, 1}));
  const sim::PlatformMotion begun = loop.world().plant().platform();
  double worst_m = 0;
  int stops = 0;
  for (; loop.mode() == Mode::guided && stops < 40; ++stops) {
    loop.hold_stick(0.0, 0.0);
    for (int i = 0; i < 250 && loop.mode() == Mode::guided; ++i) {
      loop.step();
      worst_m = std::fmax(worst_m, std::fabs(static_cast<double>(loop.record().guided_cross_track_m)));
    }
    loop.let_go();
    loop.run(1.5);
    EXPECT_NEAR(loop.world().plant().platform().speed_m_s, 0.0, 0.01);
  }
  EXPECT_GT(stops, 10);
  EXPECT_EQ(static_cast<GuidedEnd>(loop.record().guided_end), GuidedEnd::finished);
  EXPECT_LT(worst_m, 0.05);
  const Place end = true_place(loop, begun);
  EXPECT_LT(std::hypot(end.x_m, end.y_m), kEnd_m);
}

// H17
TEST(Guided, SilenceEndsItWithinItsDistance) {
  ClosedLoop loop(standing());
  ASSERT_TRUE(loop.start_guided({GuidedShape::straight, false, 10.0, 0, 0.3, 1}));
  loop.hold_stick(0.0, 0.0);
  loop.run(5.0);
  const sim::PlatformMotion before = loop.world().plant().platform();
  ASSERT_NEAR(before.speed_m_s, 0.3, 0.01);
  loop.fall_silent();
  loop.run(2.0);
  const sim::PlatformMotion& after = loop.world().plant().platform();
  EXPECT_LT(std::hypot(after.x_m - before.x_m, after.y_m - before.y_m), 0.20);
  EXPECT_NEAR(after.speed_m_s, 0.0, 1e-3);
  EXPECT_TRUE(loop.ever_raised(Fault::remote_command_lost));
  EXPECT_EQ(loop.mode(), Mode::standby);
  // Returning commands move nothing.
  loop.hold_stick(0.0, 0.0);
  loop.run(2.0);
  EXPECT_NEAR(loop.world().plant().platform().speed_m_s, 0.0, 1e-3);
  EXPECT_EQ(loop.mode(), Mode::standby);
}

// H15, H16: the button is held after the patient has set off, slower in bends than the hoist. The hoist waits, also when the patient never
// yields, and no monitor trips.
TEST(Guided, H15_H16_AHoistThatLeadsWaitsForWhoWalksSlower) {
  const GuidedPath paths[] = {{GuidedShape::eight, false, 1.0, 0.8, 0.3, 1}, {GuidedShape::eight, true, 1.0, 0.8, 0.3, 1}};
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(seeds_for(22, 8, 2)); ++seed)
    for (const bool stubborn : {false, true})
      for (const GuidedPath& path : paths) {
        ClosedLoopOptions options = standing();
        options.world.seed = seed + 1;
        if (seed > 0) options.world.patient = sim::PatientParams::random(seed);
        if (stubborn) options.world.patient.yields_after_s = sim::PatientParams::kStubborn_s;
        SCOPED_TRACE(testing::Message() << seed << (stubborn ? ", never yields" : "") << (path.clockwise ? ", left loop first" : ""));
        ClosedLoop loop(options);
        ASSERT_TRUE(loop.start_guided(path));
        loop.run(1.5);
        const Drive run = drive(loop, 240.0);
        EXPECT_EQ(run.ended, GuidedEnd::finished);
        EXPECT_LT(run.worst_m, 0.03);
        EXPECT_EQ(loop.record().stop_cause, 0U);
      }
}

// Without a patient the exercise keeps its speed, and the phase never says that the hoist waits.
TEST(Guided, AnEmptyHoistWaitsForNobody) {
  ClosedLoop loop(standing());
  loop.world().hold_bar(0.0, 0.0, 0.0);
  ASSERT_TRUE(loop.start_guided({GuidedShape::square, false, 2.0, 0, 0.6, 1}));
  bool waited = false;
  loop.on_step([&waited](const core::TickInputs&, const core::TickOutputs& out) {
    waited = waited || static_cast<core::GuidedPhase>(out.record.guided_phase) == core::GuidedPhase::for_patient;
  });
  const Drive run = drive(loop, 90.0);
  expect_end(run, 0.0);
  EXPECT_NEAR(run.top_m_s, 0.6, 0.01);
  EXPECT_FALSE(waited);
}

// H15: an uninformed patient sets off in the second before the therapist holds. Each shape is driven to its end, also with pauses, on lines
// that do and do not match the patient's own.
TEST(Guided, H15_APatientWhoHasSetOffIsLedToTheEnd) {
  const GuidedPath paths[] = {{GuidedShape::eight, false, 1.0, 0.8, 0.3, 1},
                              {GuidedShape::square, false, 2.0, 0, 0.3, 1},
                              {GuidedShape::straight, false, 6.0, 0, 0.3, 1}};
  const auto seeds = static_cast<std::uint64_t>(seeds_for(66, 12, 3));
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    for (const double pause_s : {0.0, 4.5 + 0.1 * static_cast<double>(seed % 22)}) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", pauses of " + std::to_string(pause_s) + " s");
      ClosedLoopOptions options = standing();
      options.world.seed = seed;
      options.world.patient = sim::PatientParams::random(seed);
      ClosedLoop loop(options);
      ASSERT_TRUE(loop.start_guided(paths[seed % 3]));
      loop.run(1.5);
      ASSERT_EQ(loop.world().patient().state(), sim::PatientState::leading);
      loop.hold_stick(0.0, 0.0);
      loop.run(9.0);
      for (int held = 0; held < 30 && loop.mode() == Mode::guided; ++held) {
        if (pause_s > 0) {
          loop.let_go();
          loop.run(pause_s);
          loop.hold_stick(0.0, 0.0);
        }
        loop.run(6.0);
      }
      EXPECT_EQ(static_cast<GuidedEnd>(loop.record().guided_end), GuidedEnd::finished);
      EXPECT_EQ(loop.record().stop_cause, 0U);
    }
  }
}

// H15, H13: the guards are on although the patient does not lead.
TEST(Guided, AFallAndABumperStillStopTheHoist) {
  for (const bool fall : {true, false}) {
    SCOPED_TRACE(fall ? "fall" : "bumper");
    ClosedLoop loop(standing());
    ASSERT_TRUE(loop.start_guided({GuidedShape::straight, false, 10.0, 0, 0.3, 1}));
    loop.hold_stick(0.0, 0.0);
    loop.run(6.0);
    if (fall)
      loop.world().patient().trip();
    else
      loop.world().plant().force_bumper(0, true);
    EXPECT_TRUE(loop.run_until([&loop] { return loop.mode() == Mode::protective_stop; }, 2.0));
    EXPECT_TRUE(loop.ever_raised(fall ? Fault::fall_detected : Fault::bumper_pressed));
    EXPECT_EQ(static_cast<GuidedEnd>(loop.record().guided_end), GuidedEnd::stopped);
  }
}

}  // namespace
}  // namespace hoist::tests
