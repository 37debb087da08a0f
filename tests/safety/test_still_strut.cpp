// The guard against a cut strap against its rule, written a second time from its description (control/core/monitor/still_strut.hpp): two struts that
// swing sideways by themselves, on a hoist that rolls, creeps, stands and turns, in every mode that moves. Each step must be judged alike.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <random>

#include "control/core/modes/mode_list.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

// In degrees: how far each strut has swung about where it has been lately.
struct Swing {
  double mean = 0, square = 0;
  void begin(double at) { mean = at, square = 0; }
  void go_on(double at) {
    mean += (at - mean) / 201;
    square += ((at - mean) * (at - mean) - square) / 101;
  }
};

// 0 none, 2 left, 3 right, as HOIST_DETAIL of tilt_implausible counts.
class StillRule {
 public:
  int still(const ScriptedHoist& hoist, bool moving) {
    const Estimate& sensed = hoist.state.sensed;
    const double left = (sensed.left_strut.beta_rad() - sensed.base.beta_rad()) / kDeg;
    const double right = (sensed.right_strut.beta_rad() - sensed.base.beta_rad()) / kDeg;
    if (!moving || std::abs(sensed.odometry.speed_m_s) <= 0.1) {
      left_.begin(left);
      right_.begin(right);
    }
    left_.go_on(left);
    right_.go_on(right);
    left_ticks_ = right_.square > 0.25 && left_.square < 0.1 * right_.square ? left_ticks_ + 1 : 0;
    right_ticks_ = left_.square > 0.25 && right_.square < 0.1 * left_.square ? right_ticks_ + 1 : 0;
    return left_ticks_ >= 150 ? 2 : right_ticks_ >= 150 ? 3 : 0;
  }

 private:
  Swing left_, right_;
  int left_ticks_ = 0, right_ticks_ = 0;
};

TEST(StillStrut, H7EachStepOfTwoStrutsThatSwingByThemselvesIsJudgedByTheRule) {
  constexpr std::array kMotions{Mode::user, Mode::remote, Mode::guided};
  std::array<int, 4> found{};
  std::array<int, kMotions.size()> found_in{};
  for (unsigned seed = 1; seed <= 120; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
    contract::Params params;
    params.slip_stop_s = 10;            // the chassis turns without its wheels
    params.strut_apart_rad_max = 0.13;  // the struts' other rule waits
    ScriptedHoist hoist(params);
    const std::size_t motion = seed % kMotions.size();
    ASSERT_TRUE(hoist.ready());
    if (kMotions[motion] == Mode::guided) {
      ASSERT_EQ(hoist.ask_guided({contract::GuidedShape::straight, false, 10.0, 0, 0.3, 1}), 0U);
    } else {
      ASSERT_EQ(hoist.ask_mode(kMotions[motion]), 0U);
    }
    ASSERT_TRUE(hoist.run_until_powered());
    hoist.floor_grips = false;
    hoist.sway_deg = 0;
    StillRule rule;
    double lean_deg = 6, twist_deg = 0, left_deg = 0, right_deg = 0, second_s = 1.1, aside_deg = 0;
    for (int i = 0; i < 1500; ++i) {
      if (i % 300 == 0) {
        left_deg = one_of(std::array{0.0, 0.2, 0.3, 0.65, 0.75, 1.2, 2.0});
        right_deg = one_of(std::array{0.0, 0.3, 0.6, 0.75, 1.0, 2.0});
        second_s = one_of(std::array{0.9, 1.1, 1.7});
        aside_deg = one_of(std::array{0.0, 0.0, 2.0});
      }
      if (random() % 250 == 0) lean_deg = one_of(std::array{0.0, 2.0, 4.0, 6.0, -6.0});
      if (random() % 300 == 0) hoist.tilt_base.yaw_rate_deg_s = one_of(std::array{0.0, 0.0, 10.0, -20.0});
      if (random() % 300 == 0) twist_deg = one_of(std::array{0.0, 0.0, 1.0, 5.0});
      const double phase = 2 * 3.14159 * 0.01 * i / second_s;
      hoist.tilt_left.beta_deg = aside_deg + left_deg * std::sin(phase);
      hoist.tilt_right.beta_deg = aside_deg + right_deg * std::sin(phase);
      hoist.lean(lean_deg, twist_deg);
      const bool moving = is_moving(hoist.state.mode);
      hoist.drive_for(1, 0.9);
      const int still = rule.still(hoist, moving);
      ASSERT_EQ(hoist.has_fault(Fault::tilt_implausible), still != 0)
          << i << ", code " << hoist.out.record.tilt_implausible_code << ", " << still;
      ASSERT_EQ(int{hoist.out.record.tilt_implausible_code}, still) << i;
      if (still == 0) continue;
      ++found[static_cast<std::size_t>(still)];
      EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
      ++found_in[motion];
      break;
    }
  }
  EXPECT_GT(found[2], 15);
  EXPECT_GT(found[3], 15);
  EXPECT_LT(found[2] + found[3], 110);
  for (std::size_t motion = 0; motion < kMotions.size(); ++motion) EXPECT_GT(found_in[motion], 8) << "motion " << motion;
}

}  // namespace
}  // namespace hoist::core::test
