// The option that removes the gait's sway from the wish: the same patient with and without it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "tests/support/closed_loop.hpp"

namespace hoist::tests {
namespace {

using contract::Fault;
using contract::Mode;

struct Walk {
  double stray_rad_s = 0;  // turn rate commanded around its own slow course
  double lean_stray_m_s = 0;
  double seconds = 0;
  bool stopped = false;
};

// The straight of 10 m. Stray is the rest of the commanded turn rate after its mean over two seconds, which are about a
// stride.
Walk straight(std::uint64_t seed, double calm_norm) {
  ClosedLoopOptions options;
  options.world.seed = seed;
  options.world.scenario = sim::find_scenario("straight");
  options.world.patient = sim::PatientParams::random(seed);
  options.world.patient.wish_m_s = 0.30;
  options.params.cadence_cancel_norm = calm_norm;
  ClosedLoop loop(options);
  Walk walk;
  if (!loop.start(Mode::user)) return walk;
  std::vector<double> turn, speed;
  while (!loop.world().patient().arrived() && loop.time_s() < 70.0) {
    loop.step();
    if (loop.time_s() < 18.0) continue;  // it learns for some strides
    turn.push_back(static_cast<double>(loop.record().yaw_rate_command_rad_s));
    speed.push_back(static_cast<double>(loop.record().speed_command_m_s));
  }
  const auto stray = [](const std::vector<double>& x) {
    constexpr std::size_t kHalf = 100;
    double sum = 0, squares = 0;
    std::size_t n = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
      sum += x[i];
      if (i < 2 * kHalf) continue;
      sum -= x[i - 2 * kHalf];
      const double left = x[i - kHalf] - sum / static_cast<double>(2 * kHalf);
      squares += left * left;
      ++n;
    }
    return n > 0 ? std::sqrt(squares / static_cast<double>(n)) : 0.0;
  };
  walk.seconds = static_cast<double>(turn.size()) * core::kTick_s;
  walk.stray_rad_s = stray(turn);
  walk.lean_stray_m_s = stray(speed);
  walk.stopped = loop.mode() != Mode::user;
  return walk;
}

TEST(Gait, ThreeFifthsOfTheStrayTurningAreGone) {
  double without = 0, with = 0;
  constexpr int kPatients = 8;
  for (std::uint64_t seed = 1; seed <= kPatients; ++seed) {
    const Walk paper = straight(seed, 0.0), calm = straight(seed, 1.0);
    ASSERT_GT(paper.seconds, 8.0) << seed;
    ASSERT_GT(calm.seconds, 8.0) << seed;
    EXPECT_FALSE(calm.stopped) << seed;
    std::printf("patient %d: stray %.2f deg/s, calmed %.2f deg/s; speed %.1f and %.1f mm/s\n", static_cast<int>(seed),
                paper.stray_rad_s / sim::kDegree_rad, calm.stray_rad_s / sim::kDegree_rad, 1000 * paper.lean_stray_m_s,
                1000 * calm.lean_stray_m_s);
    without += paper.stray_rad_s * paper.stray_rad_s;
    with += calm.stray_rad_s * calm.stray_rad_s;
  }
  std::printf("all: %.0f %% less\n", 100.0 * (1.0 - std::sqrt(with / without)));
  EXPECT_GT(std::sqrt(without / kPatients) / sim::kDegree_rad, 0.3) << "otherwise nothing was tested";
  EXPECT_LE(std::sqrt(with), 0.4 * std::sqrt(without));
}

TEST(Gait, OffItTakesNothingAndWhatItTakesIsRecorded) {
  for (const double calm_norm : {0.0, 1.0}) {
    ClosedLoopOptions options;
    options.world.scenario = sim::find_scenario("figure-eight");
    options.params.cadence_cancel_norm = calm_norm;
    ClosedLoop loop(options);
    ASSERT_TRUE(loop.start(Mode::user));
    double most_rad = 0;
    for (int i = 0; i < 3000; ++i) {
      loop.step();
      most_rad = std::fmax(most_rad, std::fabs(static_cast<double>(loop.record().gait_turn_rad)));
    }
    EXPECT_EQ(loop.mode(), Mode::user);
    if (calm_norm == 0.0) {
      EXPECT_EQ(most_rad, 0.0);
      EXPECT_EQ(loop.record().stride_hz, 0.0F);
    } else {
      EXPECT_GT(most_rad, 0.02);
      EXPECT_NEAR(loop.record().stride_hz, 0.57F, 0.1F);
    }
  }
}

// H15, H16: a fall is found as quickly with the option as without.
TEST(Gait, H15AFallIsFoundAsQuicklyWithTheOption) {
  double seconds[2] = {};
  for (const int on : {0, 1}) {
    ClosedLoopOptions options;
    options.world.scenario = sim::find_scenario("straight");
    options.world.patient.wish_m_s = 0.45;
    options.params.cadence_cancel_norm = on;
    ClosedLoop loop(options);
    ASSERT_TRUE(loop.start(Mode::user));
    loop.run(12.0);
    ASSERT_EQ(loop.mode(), Mode::user);
    loop.world().patient().trip();
    const double begin_s = loop.time_s();
    ASSERT_TRUE(loop.run_until([&loop] { return loop.mode() == Mode::protective_stop; }, 3.0));
    EXPECT_TRUE(loop.fault(Fault::fall_detected));
    seconds[on] = loop.time_s() - begin_s;
  }
  EXPECT_LE(seconds[1], seconds[0] + 0.1);
}

}  // namespace
}  // namespace hoist::tests
