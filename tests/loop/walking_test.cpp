// The patient leads: properties of walking.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "control/run/heap_watch.hpp"
#include "db/metrics/evaluate.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/seeds.hpp"

namespace hoist::tests {
namespace {

using contract::Fault;
using contract::Mode;

ClosedLoopOptions scenario(std::string_view name, double wish_m_s = 0.30) {
  ClosedLoopOptions options;
  options.world.scenario = sim::find_scenario(name);
  options.world.patient.wish_m_s = wish_m_s;
  return options;
}
bool was_stopped(const ClosedLoop& loop) {
  return std::any_of(loop.events().begin(), loop.events().end(), [](const contract::Event& event) {
    return event.kind == contract::EventKind::mode_changed && event.code == static_cast<std::uint32_t>(Mode::protective_stop);
  });
}

// The run as the recording would have it.
struct Columns {
  std::vector<double> x_m, y_m, psi_rad, dpsi_rad;
  void add(const contract::TickRecord& record) {
    x_m.push_back(static_cast<double>(record.x_m));
    y_m.push_back(static_cast<double>(record.y_m));
    psi_rad.push_back(static_cast<double>(record.psi_rad));
    dpsi_rad.push_back(static_cast<double>(record.dpsi_rad));
  }
};

struct EightResult {
  db::Evaluation evaluation;
  double seconds{};
};
EightResult walk_two_laps(ClosedLoop& loop) {
  const contract::ReferencePath& path = loop.world().patient().path();
  const contract::PathPose start = path.pose(0.0);
  EXPECT_TRUE(loop.run_until([&loop] { return loop.mode() == Mode::standby; }, 5.0));
  EXPECT_TRUE(loop.start(Mode::user));
  // Odometry began at zero while the hoist stood on the start mark; the server sets the pose of the figure before an exercise.
  EXPECT_NEAR(static_cast<double>(loop.record().psi_rad), start.psi_rad, 1e-6);
  Columns run;
  while (loop.world().patient().progress_m() < 2.0 * path.length_m() && loop.time_s() < 240.0) {
    loop.step();
    run.add(loop.record());
  }
  const auto evaluation = db::evaluate(path, {core::kTick_s, run.x_m, run.y_m, run.psi_rad, run.dpsi_rad});
  EXPECT_TRUE(evaluation.has_value());
  return {evaluation.value_or(db::Evaluation{}), static_cast<double>(run.x_m.size()) * core::kTick_s};
}
void set_pose_of_figure(ClosedLoop& loop) {
  const contract::PathPose start = loop.world().patient().path().pose(0.0);
  ASSERT_TRUE(loop.run_until([&loop] { return loop.mode() == Mode::standby; }, 5.0));
  loop.ask(contract::CommandKind::take_lease);
  loop.step();
  loop.ask(contract::CommandKind::set_pose, 0, start.x_m, start.y_m, start.psi_rad);
  loop.run(0.05);
}

TEST(Walking, TwoLapsOfTheEightCorrelateAndStayOnTheLine) {
  ClosedLoop loop(scenario("figure-eight"));
  set_pose_of_figure(loop);
  const EightResult result = walk_two_laps(loop);
  ASSERT_TRUE(result.evaluation.c && result.evaluation.ise);
  // Tables II and III for user control: C 0.87, J 6.7; the independent model: C 0.80 to 0.83, J 5.4 to 7.4 (SOURCES 3).
  EXPECT_GE(*result.evaluation.c, 0.75);
  EXPECT_LE(result.evaluation.ise->j, 15.0);
  EXPECT_LT(result.seconds, 150.0);
  EXPECT_FALSE(was_stopped(loop));
  // Odometry and truth agree as long as nothing slips.
  const sim::PlatformMotion& truth = loop.world().plant().platform();
  EXPECT_NEAR(static_cast<double>(loop.record().x_m), truth.x_m, 0.02);
  EXPECT_NEAR(static_cast<double>(loop.record().y_m), truth.y_m, 0.02);
  EXPECT_NEAR(static_cast<double>(loop.record().psi_rad), truth.psi_rad, 0.02);
  EXPECT_FALSE(loop.ever_raised(Fault::wheel_slip));
  EXPECT_NEAR(static_cast<double>(loop.record().fused_x_m), truth.x_m, 0.02);
  EXPECT_NEAR(static_cast<double>(loop.record().fused_y_m), truth.y_m, 0.02);
  EXPECT_NEAR(static_cast<double>(loop.record().fused_psi_rad), truth.psi_rad, 0.01);
}

ClosedLoopOptions preset(const contract::PresetInfo& info, std::string_view scenario_name, std::uint64_t seed) {
  ClosedLoopOptions options = scenario(scenario_name);
  options.world.seed = seed;
  options.world.patient = sim::PatientParams::random(seed);
  for (const contract::PresetValue& value : contract::kPresetValues)
    if (value.preset == info.name) contract::set_param_unchecked(options.params, contract::param_index(value.param), value.value);
  return options;
}

// Tables II and III for user control again, now of people of every build.
TEST(Walking, TheEightIsAsTrueWithEveryPreset) {
  for (const contract::PresetInfo& info : contract::kPresets) {
    SCOPED_TRACE(info.name);
    const auto seeds = static_cast<std::uint64_t>(seeds_for(24, 4, 1));
    double j = 0, c = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
      ClosedLoopOptions options = preset(info, "figure-eight", seed);
      options.world.patient.wish_m_s = 0.30;
      ClosedLoop loop(options);
      set_pose_of_figure(loop);
      const EightResult result = walk_two_laps(loop);
      ASSERT_TRUE(result.evaluation.c && result.evaluation.ise) << seed;
      EXPECT_FALSE(was_stopped(loop)) << seed;
      EXPECT_LT(result.seconds, 180.0) << seed;
      EXPECT_LE(result.evaluation.ise->j, 25.0) << seed;
      j += result.evaluation.ise->j / static_cast<double>(seeds);
      c += *result.evaluation.c / static_cast<double>(seeds);
    }
    std::printf("%s: J %.1f, C %.2f\n", std::string(info.name).c_str(), j, c);
    EXPECT_LE(j, 15.0);
    EXPECT_GE(c, 0.80);
  }
}

// The patient does not know the settings. On wet patches a push may rarely look like a fall or fail a sensor's own check. In all other
// walks the patient continues to lead.
TEST(Walking, H15_EveryPresetIsLedOnEveryFigure) {
  const auto seeds = static_cast<std::uint64_t>(seeds_for(24, 3, 1));
  for (const contract::PresetInfo& info : contract::kPresets) {
    for (const char* figure : {"figure-eight", "square", "straight", "slippery"}) {
      const bool wet = sim::find_scenario(figure)->slippery;
      std::uint64_t stops = 0;
      double walked_s = 0, led_s = 0;
      for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        SCOPED_TRACE(std::string(info.name) + ", " + figure + ", seed " + std::to_string(seed));
        ClosedLoop loop(preset(info, figure, seed));
        ASSERT_TRUE(loop.start(Mode::user));
        loop.run(1.5);
        for (int i = 0; i < 6000 && loop.mode() == Mode::user; ++i) {
          loop.step();
          walked_s += core::kTick_s;
          if (loop.world().patient().state() == sim::PatientState::leading) led_s += core::kTick_s;
        }
        const bool stopped = loop.mode() != Mode::user;
        EXPECT_FALSE(loop.ever_raised(Fault::patient_hanging));
        EXPECT_TRUE(!stopped || (wet && (loop.ever_raised(Fault::fall_detected) || loop.ever_raised(Fault::tilt_sensor_fault))));
        EXPECT_GT(static_cast<double>(loop.record().distance_m), stopped ? 0.0 : (wet ? 1.5 : 4.0));
        stops += stopped ? 1 : 0;
      }
      EXPECT_LE(stops, wet ? (seeds + 7) / 8 : 0) << info.name << ", " << figure;
      EXPECT_GE(led_s, (wet ? 0.5 : 0.99) * walked_s) << info.name << ", " << figure;
    }
  }
}

TEST(Walking, ASlalomIsWalkedToItsEnd) {
  ClosedLoop loop(scenario("slalom"));
  set_pose_of_figure(loop);
  const contract::ReferencePath& path = loop.world().patient().path();
  ASSERT_TRUE(loop.start(Mode::user));
  Columns run;
  while (loop.world().patient().progress_m() < path.length_m() - 0.1 && loop.mode() == Mode::user && loop.time_s() < 180.0) {
    loop.step();
    run.add(loop.record());
  }
  EXPECT_GE(loop.world().patient().progress_m(), path.length_m() - 0.1);
  EXPECT_FALSE(was_stopped(loop));
  const auto evaluation = db::evaluate(path, {core::kTick_s, run.x_m, run.y_m, run.psi_rad, run.dpsi_rad});
  ASSERT_TRUE(evaluation && evaluation->ise && evaluation->c);
  std::printf("slalom: %.0f s, J %.1f, C %.2f\n", loop.time_s(), evaluation->ise->j, *evaluation->c);
  EXPECT_LE(evaluation->ise->j, 25.0);
  EXPECT_GE(*evaluation->c, 0.5);
}

TEST(Walking, TheSameOverTheSerialGateway) {
  ClosedLoopOptions options = scenario("figure-eight");
  options.through_gateway = true;
  ClosedLoop loop(options);
  set_pose_of_figure(loop);
  const EightResult result = walk_two_laps(loop);
  ASSERT_TRUE(result.evaluation.c && result.evaluation.ise);
  EXPECT_GE(*result.evaluation.c, 0.75);
  EXPECT_LE(result.evaluation.ise->j, 15.0);
  EXPECT_FALSE(was_stopped(loop));
}

TEST(Walking, TheSameWithEveryFrameStuffedToItsLongest) {
  ClosedLoopOptions options = scenario("figure-eight");
  options.world.worst_stuffing = true;
  ClosedLoop loop(options);
  set_pose_of_figure(loop);
  const EightResult result = walk_two_laps(loop);
  ASSERT_TRUE(result.evaluation.ise);
  EXPECT_LE(result.evaluation.ise->j, 15.0);
  EXPECT_FALSE(was_stopped(loop));
  const double load = static_cast<double>(loop.world().bus_counters().busy_ns) / static_cast<double>(loop.world().time_ns());
  EXPECT_LT(load, 0.60);  // bus plan: 46.8 % with the strut's rates off, the chassis' on top
}

// SOURCES 3: 90 % of the wish after 3.2 / 4.7 / 6.1 s with a largest lean of 8.6 / 9.1 / 9.8 degrees, on the independent model. This
// patient is another model, so a fifth more is allowed; the fall monitor's 10 degrees plus the filter's error is the hard limit.
struct StraightCase {
  double wish_m_s;
  double until_s;
  double lean_deg;
};
class Straight : public testing::TestWithParam<StraightCase> {};
TEST_P(Straight, ReachesTheWishLeansLittleAndStops) {
  const StraightCase& expected = GetParam();
  ClosedLoop loop(scenario("straight", expected.wish_m_s));
  ASSERT_TRUE(loop.start(Mode::user));
  ASSERT_TRUE(loop.run_until([&loop] { return loop.world().patient().state() == sim::PatientState::leading; }, 3.0));
  const double begin_s = loop.time_s();
  double reached_s = -1.0, most_lean_rad = 0.0, stop_x_m = -1.0, fastest_m_s = 0.0;
  while (loop.time_s() < begin_s + 70.0) {
    loop.step();
    const sim::PlatformMotion& at = loop.world().plant().platform();
    if (reached_s < 0.0 && at.speed_m_s >= 0.9 * expected.wish_m_s) reached_s = loop.time_s() - begin_s;
    if (stop_x_m < 0.0 && loop.world().patient().arrived()) stop_x_m = at.x_m;
    most_lean_rad = std::max(most_lean_rad, std::fabs(std::atan(loop.world().patient().harness().dx_m / 0.8)));
    fastest_m_s = std::max(fastest_m_s, at.speed_m_s);
  }
  EXPECT_GT(reached_s, 1.0);
  EXPECT_LE(reached_s, 1.2 * expected.until_s);
  EXPECT_LE(most_lean_rad / sim::kDegree_rad, std::min(1.2 * expected.lean_deg, 10.0));
  EXPECT_LE(fastest_m_s, 0.66);
  EXPECT_FALSE(was_stopped(loop));
  // Design: 0.37 m from 0.45 m/s. In proportion to the square of the speed, and half as much again.
  EXPECT_GT(stop_x_m, 0.0);
  EXPECT_LT(loop.world().plant().platform().x_m - stop_x_m, 1.5 * 0.37 * std::pow(expected.wish_m_s / 0.45, 2.0) + 0.1);
  EXPECT_LT(std::fabs(loop.world().plant().platform().speed_m_s), 0.002);
}
INSTANTIATE_TEST_SUITE_P(Wishes, Straight,
                         testing::Values(StraightCase{0.30, 3.2, 8.6}, StraightCase{0.45, 4.7, 9.1}, StraightCase{0.60, 6.1, 9.8}));

TEST(Walking, AStandingPatientIsNotMoved) {
  ClosedLoop loop(scenario("stand"));
  ASSERT_TRUE(loop.start(Mode::user));
  const sim::PlatformMotion before = loop.world().plant().platform();
  loop.run(120.0);
  EXPECT_EQ(loop.mode(), Mode::user);
  const sim::PlatformMotion& after = loop.world().plant().platform();
  EXPECT_LT(std::hypot(after.x_m - before.x_m, after.y_m - before.y_m), 0.005);
  EXPECT_LT(std::fabs(after.psi_rad - before.psi_rad), 0.5 * sim::kDegree_rad);
}

TEST(Walking, ManyPatientsNeverTripAGuard) {
  double simulated_s = 0.0;
  for (const char* figure : {"straight", "figure-eight"}) {
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      ClosedLoopOptions options = scenario(figure);
      options.world.patient = sim::PatientParams::random(seed);
      options.world.seed = seed;
      ClosedLoop loop(options);
      ASSERT_TRUE(loop.start(Mode::user)) << figure << " seed " << seed;
      loop.run(45.0);
      EXPECT_FALSE(was_stopped(loop)) << figure << " seed " << seed;
      EXPECT_EQ(loop.mode(), Mode::user) << figure << " seed " << seed;
      // They do walk.
      EXPECT_GT(static_cast<double>(loop.record().distance_m), 4.0) << figure << " seed " << seed;
      simulated_s += loop.time_s();
    }
  }
  EXPECT_GT(simulated_s, 1000.0);
}

// H15, H16: a patient who does not know that the walk ends keeps pushing while the hoist brakes.
TEST(Walking, H15_EndingAWalkIsNoFall) {
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(seeds_for(60, 30, 4)); ++seed) {
    ClosedLoopOptions options = scenario(seed % 2 == 0 ? "straight" : "figure-eight");
    options.world.patient = sim::PatientParams::random(seed);
    options.world.seed = seed;
    ClosedLoop loop(options);
    ASSERT_TRUE(loop.start(Mode::user)) << "seed " << seed;
    loop.run(7.0 + 0.1 * static_cast<double>(seed));
    ASSERT_EQ(loop.mode(), Mode::user) << "seed " << seed;
    loop.ask(contract::CommandKind::request_mode, static_cast<std::uint32_t>(Mode::standby));
    ASSERT_TRUE(loop.run_until([&loop] { return loop.mode() != Mode::user; }, 4.0));
    EXPECT_EQ(loop.mode(), Mode::standby) << "seed " << seed;
    EXPECT_FALSE(was_stopped(loop)) << "seed " << seed;
    EXPECT_FALSE(loop.ever_raised(Fault::patient_hanging)) << "seed " << seed;
  }
}

TEST(Walking, H7_TightTurnsOfTheSquareAreNoImplausibleTilt) {
  for (std::uint64_t seed = 0; seed < static_cast<std::uint64_t>(seeds_for(40, 20, 2)); ++seed) {
    ClosedLoopOptions options = scenario("square");
    options.world.patient = sim::PatientParams::random(seed);
    options.world.seed = seed;
    ClosedLoop loop(options);
    ASSERT_TRUE(loop.start(Mode::user)) << "seed " << seed;
    loop.run(60.0);
    EXPECT_FALSE(was_stopped(loop)) << "seed " << seed;
    EXPECT_GT(static_cast<double>(loop.record().distance_m), 6.0) << "seed " << seed;
  }
}

TEST(Walking, SameSeedSameRunBitForBit) {
  const auto digest = [](std::uint64_t seed) {
    ClosedLoopOptions options = scenario("figure-eight");
    options.world.seed = seed;
    ClosedLoop loop(options);
    EXPECT_TRUE(loop.start(Mode::user));
    loop.run(30.0);
    return loop.digest();
  };
  const std::uint64_t first = digest(5);
  EXPECT_EQ(digest(5), first);
  EXPECT_NE(digest(6), first);  // the sensors' noise reaches the wheels
}

TEST(Walking, NeitherWorldNorCoreAllocatesOnceUnderWay) {
  ClosedLoop loop(scenario("figure-eight"));
  ASSERT_TRUE(loop.start(Mode::user));
  loop.run(5.0);
  const std::uint64_t before = run::heap_requests();
  loop.run(20.0);
  EXPECT_EQ(run::heap_requests(), before);
  EXPECT_GT(before, 0U);  // the counter does count
}

TEST(Walking, LosingAFrameNowAndThenIsNotFelt) {
  ClosedLoop loop(scenario("figure-eight"));
  std::uint64_t count = 0;
  // Every 97th frame of any kind: every deadline tolerates one lost command or sample.
  loop.world().set_frame_fault([&count](std::size_t, const contract::CanFrame&, std::uint64_t) {
    return bus::BusFault{++count % 97 == 0 ? bus::BusFault::Kind::drop : bus::BusFault::Kind::none, 0, 0};
  });
  ASSERT_TRUE(loop.start(Mode::user));
  loop.run(60.0);
  EXPECT_GT(loop.world().bus_counters().dropped, 400U);
  EXPECT_EQ(loop.mode(), Mode::user);
  EXPECT_FALSE(was_stopped(loop));
}

TEST(Walking, EndsInStandbyWhenTheDriverAsks) {
  ClosedLoop loop(scenario("straight"));
  ASSERT_TRUE(loop.start(Mode::user));
  loop.run(8.0);
  ASSERT_GT(loop.record().speed_m_s, 0.2F);
  loop.ask(contract::CommandKind::request_mode, static_cast<std::uint32_t>(Mode::standby));
  double hardest_m_s2 = 0.0, last_m_s = static_cast<double>(loop.record().speed_command_m_s);
  EXPECT_TRUE(loop.run_until(
      [&] {
        const double now_m_s = static_cast<double>(loop.record().speed_command_m_s);
        hardest_m_s2 = std::max(hardest_m_s2, (last_m_s - now_m_s) / core::kTick_s);
        last_m_s = now_m_s;
        return loop.mode() == Mode::standby;
      },
      4.0));
  EXPECT_LE(hardest_m_s2, 0.55);  // R1
  EXPECT_TRUE(loop.run_until([&loop] { return !loop.world().drives_enabled(); }, 2.0));
  loop.run(0.05);  // a thought later the patient has felt the brakes
  EXPECT_EQ(loop.world().patient().state(), sim::PatientState::standing);
}

}  // namespace
}  // namespace hoist::tests
