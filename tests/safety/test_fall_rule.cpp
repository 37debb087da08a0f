// The fall guard against its rule, written a second time from its description (control/core/monitor/fall.hpp, DECISIONS 156): random leans of a
// body in a hoist that speeds up, brakes and stands. Each step must be judged alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "control/core/modes/mode_list.hpp"
#include "tests/safety/monitor_bench.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

struct Lean {
  double forward_deg, right_deg;
  [[nodiscard]] double length() const { return std::hypot(forward_deg, right_deg); }
};

/// Mean of both struts against the chassis.
Lean lean_of(const Estimate& sensed) {
  const auto degrees = [](double left_rad, double right_rad, double base_rad) { return ((left_rad + right_rad) / 2 - base_rad) / kDeg; };
  return {degrees(sensed.left_strut.alpha_rad(), sensed.right_strut.alpha_rad(), sensed.base.alpha_rad()),
          degrees(sensed.left_strut.beta_rad(), sensed.right_strut.beta_rad(), sensed.base.beta_rad())};
}
Lean rate_of(const Estimate& sensed) {
  const auto degrees = [](double left_rad_s, double right_rad_s, double base_rad_s) {
    return ((left_rad_s + right_rad_s) / 2 - base_rad_s) / kDeg;
  };
  return {degrees(sensed.left_strut.alpha_rate_rad_s(), sensed.right_strut.alpha_rate_rad_s(), sensed.base.alpha_rate_rad_s()),
          degrees(sensed.left_strut.beta_rate_rad_s(), sensed.right_strut.beta_rate_rad_s(), sensed.base.beta_rate_rad_s())};
}

class Rule {
 public:
  /// Whether this step is a fall. `speed_m_s` is the last command; `pushed`: on standby a wheel turns faster than 0.1 m/s; `stops`: protectively.
  bool falls(const Lean& lean, const Lean& rate, double speed_m_s, bool moving, bool pushed, bool stops) {
    const double change_m_s = speed_m_s - speed_m_s_, change_m_s2 = change_m_s / kTick_s;
    // Since it has become only slower, or only faster.
    grown_m_s_ = change_m_s * grown_m_s_ > 0 ? grown_m_s_ + change_m_s : change_m_s;
    speed_m_s_ = speed_m_s;
    ++since_push_ticks_;
    if (std::fabs(change_m_s2) >= 0.4 && std::fabs(grown_m_s_) >= 0.04) {
      since_push_ticks_ = 0;
      pushed_forward_ = change_m_s2 < 0;
    }
    const bool rests = lean.length() > 13;
    rest_ticks_ = rests ? rest_ticks_ + 1 : 0;
    stop_ticks_ = stops ? stop_ticks_ + 1 : 0;
    if (!rests) swings_ = false;
    if (!moving) return (pushed && rest_ticks_ >= 10) || (rest_ticks_ >= 60 && stop_ticks_ >= 60);
    // Thrown by the hoist itself: in the 0.3 s after its push, that way, and not mainly aside.
    const bool thrown =
        since_push_ticks_ < 30 && (lean.forward_deg > 0) == pushed_forward_ && std::fabs(lean.right_deg) <= std::fabs(lean.forward_deg);
    const bool by_braking = thrown && (speed_m_s == 0 || (speed_m_s > 0) == pushed_forward_);
    if (by_braking && rests) swings_ = true;
    if (rest_ticks_ >= (swings_ ? 60 : 10)) return true;
    if (by_braking) return false;
    // A quick lean counts 1.05 times to the side.
    const double counted_deg = std::hypot(lean.forward_deg, 1.05 * lean.right_deg);
    if (counted_deg <= (thrown ? 11.5 : 10.0)) return false;
    return (lean.forward_deg * rate.forward_deg + lean.right_deg * rate.right_deg) / lean.length() > 25;
  }

 private:
  double speed_m_s_ = 0, grown_m_s_ = 0;
  int since_push_ticks_ = 1000, rest_ticks_ = 0, stop_ticks_ = 0;
  bool pushed_forward_ = false, swings_ = false;
};

/// Goes to a random place at a random pace, stays a while, and again.
class Wanderer {
 public:
  Wanderer(std::mt19937& random, std::vector<double> places, std::vector<double> paces_per_s)
      : random_(random), places_(std::move(places)), paces_per_s_(std::move(paces_per_s)) {}
  double step() {
    if (at_ == to_ && wait_ticks_-- <= 0) {
      to_ = one_of(places_) * (random_() % 2 == 0 ? 1 : -1);
      pace_per_s_ = one_of(paces_per_s_);
      wait_ticks_ = static_cast<int>(random_() % 80);
    }
    const double most = pace_per_s_ * kTick_s;
    return at_ += std::clamp(to_ - at_, -most, most);
  }

 private:
  double one_of(const std::vector<double>& all) { return all[random_() % all.size()]; }

  std::mt19937& random_;
  std::vector<double> places_, paces_per_s_;
  double at_ = 0, to_ = 0, pace_per_s_ = 0;
  int wait_ticks_ = 0;
};

class FallRule : public ::testing::Test {
 protected:
  // Where the body goes, and how fast, per second: never on a limit, where rounding decides.
  struct Body {
    Wanderer forward, right, base_forward, base_right;
  };
  static Body body(std::mt19937& random, std::vector<double> places, std::vector<double> paces) {
    return {{random, std::move(places), paces},
            {random, {0, 0, 0, 5, 9.7, 11, 13.5}, paces},
            {random, {0, 0, 1}, {1.7, 20.3}},
            {random, {0, 0, 1}, {1.7, 20.3}}};
  }
  void start(double acceleration_m_s2) {
    contract::Params params;
    params.remote_speed_m_s_max = 0.6;
    params.acceleration_m_s2_max = acceleration_m_s2;
    hoist_.emplace(params);
    rule_ = {};
    ASSERT_TRUE(hoist_->start(Mode::remote));
    hoist_->tilt_left.slew_deg = hoist_->tilt_right.slew_deg = hoist_->tilt_base.slew_deg = 5;
  }
  void lean(double forward_deg, double right_deg) {
    hoist_->lean(forward_deg);
    hoist_->tilt_left.beta_deg = hoist_->tilt_right.beta_deg = right_deg;
  }
  static constexpr double kLetGo = 9;
  /// One step, judged; whether it was a fall.
  bool falls(double stick) {
    const Mode mode = hoist_->state.mode;
    const bool moving = is_moving(mode), standby = mode == Mode::standby, stops = mode == Mode::protective_stop;
    const double told_m_s = (hoist_->state.left_command_m_s + hoist_->state.right_command_m_s) / 2;
    stick == kLetGo ? hoist_->hold(0, 0, false) : hoist_->hold(stick);
    hoist_->step();
    const Estimate& sensed = hoist_->state.sensed;
    const double turns_m_s = std::max(std::fabs(sensed.odometry.wheel_left_m_s), std::fabs(sensed.odometry.wheel_right_m_s));
    const bool expected = rule_.falls(lean_of(sensed), rate_of(sensed), told_m_s, moving, standby && turns_m_s > 0.1, stops);
    EXPECT_EQ(hoist_->has_fault(Fault::fall_detected), expected)
        << contract::kModes[static_cast<std::size_t>(hoist_->state.mode)].name << ", lean " << lean_of(sensed).forward_deg << " and "
        << lean_of(sensed).right_deg << " degrees at " << rate_of(sensed).forward_deg << " degrees/s, told " << told_m_s << " m/s";
    found_ += expected ? 1 : 0;
    return expected || HasFailure();
  }

  std::optional<ScriptedHoist> hoist_;
  Rule rule_;
  int found_ = 0;
};

TEST_F(FallRule, H15EachStepOfARandomBodyIsJudgedByTheRule) {
  for (unsigned seed = 1; seed <= 500; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    start(seed % 4 == 0 ? 0.3 : 0.5);
    Body at = body(random, {0, 6, 9.5, 11, 12.5, 13.5, 14}, {10.3, 20.7, 24.1, 27.3, 45.1});
    double stick = 0;
    for (int i = 0; i < 400; ++i) {
      // Also what creeps at 0.03 and 0.05 m/s, and is let go.
      if (random() % 60 == 0) stick = std::array{-1.0, 0.0, 0.0, 1.0, 0.05, -0.05, 0.08, -0.08, kLetGo, kLetGo, kLetGo}[random() % 11];
      // Who lies in the stop of a hoist that stands anyway is no news.
      if (seed % 5 == 0 && i == 150) hoist_->send(CommandKind::stop);
      const double forward_deg = at.forward.step();
      lean(forward_deg, at.right.step());
      hoist_->tilt_base.alpha_deg = at.base_forward.step();
      hoist_->tilt_base.beta_deg = at.base_right.step();
      if (falls(stick)) break;
    }
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(found_, 150);
}

// The swing that the hoist's own brake begins: leans that go out before it, in it, and when it ends, and come again.
TEST_F(FallRule, H15EachStepOfABodyThatIsThrownIsJudgedByTheRule) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    start(0.5);
    const double way = seed % 4 == 0 ? -1 : 1;
    for (int i = 0; i < 130; ++i) ASSERT_FALSE(falls(way));
    const int out_tick = static_cast<int>(random() % 180) - 60;
    const double pace_deg = std::array{0.203, 0.271, 0.449}[random() % 3];  // never on a limit, where rounding decides
    const double side = random() % 5 == 0 ? -way : way;
    double at_deg = 0, to_deg = 13.5;
    for (int i = -60; i < 260; ++i) {
      if (i >= out_tick) {
        if (at_deg == to_deg && random() % 12 == 0) to_deg = to_deg > 13 ? 12.6 : 13.5;
        at_deg += std::clamp(to_deg - at_deg, -pace_deg, pace_deg);
      }
      lean(side * at_deg, 0);
      if (falls(i < 0 ? way : 0)) break;
    }
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(found_, 50);
}

// On standby: a body that goes into the stops and comes back, on wheels that stand, creep or are pushed, one or both.
TEST_F(FallRule, H15EachStepOfABodyThatPushesTheHoistOnStandbyIsJudgedByTheRule) {
  for (unsigned seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    hoist_.emplace();
    rule_ = {};
    ASSERT_TRUE(hoist_->ready());
    hoist_->tilt_left.slew_deg = hoist_->tilt_right.slew_deg = hoist_->tilt_base.slew_deg = 5;
    Body at = body(random, {0, 9.5, 12.5, 13.5, 14}, {20.7, 45.1});
    for (int i = 0; i < 200; ++i) {
      if (random() % 30 == 0) {
        hoist_->drive_left.forced_m_s = std::array{0.0, 0.0, 0.09, 0.11, -0.11, 0.3}[random() % 6];
        hoist_->drive_right.forced_m_s = random() % 2 == 0 ? hoist_->drive_left.forced_m_s : 0;
      }
      const double forward_deg = at.forward.step();
      lean(forward_deg, at.right.step());
      if (!falls(0)) continue;
      EXPECT_EQ(hoist_->state.mode, Mode::protective_stop);
      break;
    }
    ASSERT_FALSE(HasFailure());
  }
  EXPECT_GT(found_, 30);
  EXPECT_LT(found_, 90);
}

// In a stop the body that its ramp throws comes back within 0.6 s; one that stays out has fallen.
TEST(FallInAStop, H15H16WhoStaysInTheStopsHasFallen) {
  struct Stay {
    double lean_deg;
    int ticks;
    bool falls, told = false;
  };
  // Once told, it lasts until the lean is below the quick one's limit.
  for (const Stay stay : {Stay{13.5, 59, false}, Stay{13.5, 60, true}, Stay{-13.5, 60, true}, Stay{12.5, 500, false},
                          Stay{10.5, 1, true, true}, Stay{9.5, 1, false, true}}) {
    SCOPED_TRACE(stay.lean_deg);
    SCOPED_TRACE(stay.ticks);
    MonitorBench bench;
    bench.mode = Mode::protective_stop;
    bench.moving = false;
    if (stay.told) bench.latched = contract::fault_bit(Fault::fall_detected);
    FallDetected monitor;
    bool falls = false;
    for (int i = 0; i < stay.ticks; ++i) {
      send_angles(bench.sensed.left_strut, {.alpha_deg = stay.lean_deg});
      send_angles(bench.sensed.right_strut, {.alpha_deg = stay.lean_deg});
      send_angles(bench.sensed.base, {});
      falls = monitor.check(bench.view());
      if (i + 1 < stay.ticks) {
        EXPECT_FALSE(falls) << i;
      }
    }
    EXPECT_EQ(falls, stay.falls);
  }
}

// Struts that are held while straps are fastened, and a stop then.
TEST(FallInAStop, H15WhatWasHeldBeforeTheStopIsJudgedFromItOn) {
  MonitorBench bench;
  bench.moving = false;
  FallDetected monitor;
  for (int i = 0; i < 300; ++i) {
    send_angles(bench.sensed.left_strut, {.alpha_deg = 14});
    send_angles(bench.sensed.right_strut, {.alpha_deg = 14});
    send_angles(bench.sensed.base, {});
    bench.mode = i < 200 ? Mode::standby : Mode::protective_stop;
    ASSERT_EQ(monitor.check(bench.view()), i >= 259) << i;
  }
}

// The last angles of silent sensors tell nothing of the patient: neither is a fall found in them, nor do they keep its alarm.
TEST(FallInAStop, H15SilentSensorsTellOfNoFall) {
  for (const bool told : {false, true}) {
    SCOPED_TRACE(told);
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(200, 0.9);
    ASSERT_EQ(hoist.ask(CommandKind::stop), 0U);
    hoist.lean(14);
    hoist.step(told ? 100 : 30);
    EXPECT_EQ(hoist.has_fault(Fault::fall_detected), told);
    hoist.tilt_left.silent = hoist.tilt_right.silent = true;
    hoist.lean(0);
    hoist.step(500);
    EXPECT_EQ(hoist.has_fault(Fault::fall_detected), told) << "what was told waits for its release";
    EXPECT_EQ(hoist.state.conditions & contract::fault_bit(Fault::fall_detected), 0U);
    ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
    EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U) << "sensors that do not come back hold nobody in the stop";
    EXPECT_EQ(hoist.state.mode, Mode::init);
    hoist.tilt_left.silent = hoist.tilt_right.silent = false;
    EXPECT_TRUE(hoist.reach(Mode::standby));
  }
}

// Elsewhere than on standby a hoist may be pushed, as in the steps of the calibration, and a drive that is silent tells nothing of its wheel.
TEST(FallOnStandby, H15OnlyThereAndOnlyByWheelsThatAreHeard) {
  for (const contract::ModeInfo& mode : contract::kModes) {
    if (mode.moving || mode.value == static_cast<int>(Mode::protective_stop)) continue;
    for (const bool silent : {false, true}) {
      MonitorBench bench;
      bench.mode = static_cast<Mode>(mode.value);
      bench.moving = bench.powered = false;
      send_angles(bench.sensed.left_strut, {.alpha_deg = 14});
      send_angles(bench.sensed.right_strut, {.alpha_deg = 14});
      send_angles(bench.sensed.base, {});
      send_state(bench.sensed.left_drive, 0x40, 0);
      if (!silent) send_state(bench.sensed.right_drive, 0x40, 0);
      bench.sensed.odometry.wheel_left_m_s = 0.3;
      FallDetected monitor;
      bool falls = false;
      for (int i = 0; i < 20; ++i) falls = monitor.check(bench.view());
      EXPECT_EQ(falls, bench.mode == Mode::standby && !silent) << mode.name << (silent ? ", a drive is silent" : "");
    }
  }
}

}  // namespace
}  // namespace hoist::core::test
