// The monitors of the wheels and of their power against their rules (monitor_bench.hpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/safety/monitor_bench.hpp"

namespace hoist::core::test {
namespace {

// Statuswords of CiA 402.
constexpr std::uint16_t kEnabled = 0x27, kSwitchedOn = 0x23, kSwitchOnDisabled = 0x40, kQuickStop = 0x07, kFaulted = 0x08,
                        kFaultReaction = 0x0F;

// ----- overspeed

class OverspeedRule {
 public:
  struct Verdict {
    bool trips;
    int code;
  };
  OverspeedRule(int apart_ticks, double top_m_s) : apart_ticks_(apart_ticks), top_m_s_(top_m_s) {}

  Verdict judge(const MonitorBench& at) {
    const Odometry& odometry = at.sensed.odometry;
    const std::array wheels{odometry.wheel_left_m_s, odometry.wheel_right_m_s};
    const std::array commands{at.left_command_m_s, at.right_command_m_s};
    const std::array drives{&at.sensed.left_drive, &at.sensed.right_drive};
    if (stray_.step(stray_current(*drives[0], wheels[0]) || stray_current(*drives[1], wheels[1])) >= 5) return {true, 0};
    if (!at.powered || std::max(drives[0]->fresh().age_ticks(), drives[1]->fresh().age_ticks()) >= 5) {
      reference_m_s_ = wheels;
      fast_ = apart_ = {};
      return {false, 0};
    }
    const bool fast = std::fabs(odometry.speed_m_s) > top_m_s_ + at.params.overspeed_margin_m_s;
    bool any_apart = false, all_held = true;
    for (std::size_t k = 0; k < 2; ++k) {
      // The wheel lags behind its command by 0.1 s.
      reference_m_s_[k] = 0.9 * reference_m_s_[k] + 0.1 * commands[k];
      if (std::fabs(wheels[k] - reference_m_s_[k]) <= at.params.following_error_m_s_max) continue;
      any_apart = true;
      const bool slower = std::fabs(wheels[k]) < std::fabs(reference_m_s_[k]), same_way = wheels[k] * reference_m_s_[k] >= 0;
      const bool pushes = std::fabs(drives[k]->current_a()) >= at.params.drive_current_limit_a / 2;
      all_held = all_held && slower && same_way && pushes;
    }
    fast_.step(fast);
    apart_.step(any_apart);
    return {fast_.ticks >= 5 || apart_.ticks >= apart_ticks_, any_apart && all_held && !fast ? 1 : 0};
  }

 private:
  int apart_ticks_;
  double top_m_s_;
  std::array<double, 2> reference_m_s_{};
  Streak fast_, apart_, stray_;
};

TEST(OverspeedRule, H1EachStepOfTwoRandomWheelsIsJudgedByTheRule) {
  int found = 0, held = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    bench.params.speed_m_s_max = 0.4;
    const int apart_ticks = 5 + static_cast<int>(random.below(11));
    bench.params.following_error_s = about_steps_s(random, apart_ticks);
    Overspeed monitor;
    OverspeedRule rule(apart_ticks, 0.4);
    const std::array drives{&bench.sensed.left_drive, &bench.sensed.right_drive};
    const auto spells = [&random](std::uint32_t ticks, std::vector<double> values) {
      return Spells<double>(random, ticks, std::move(values));
    };
    const auto both = [](const Spells<double>& one) { return std::array{one, one}; };
    auto command_m_s = both(spells(100, {0, 0.3, -0.3, 0.45, 1.9}));
    auto off_m_s = both(spells(24, {0, 0, 0, 0.12, -0.2, 0.2, 0.35, -0.5}));
    auto current_a = both(spells(20, {0.5, -0.8, 1.4, 2.0, -2.5, 3.5, -4.0}));
    const Spells<bool> silence(random, 9, {false, false, false, false, false, false, true});
    std::array silent{silence, silence};
    const Spells<std::uint16_t> state(random, 60, {kEnabled, kEnabled, kEnabled, kSwitchedOn});
    std::array status{state, state};
    Spells<bool> powered(random, 150, {true, true, true, false});
    std::array<double, 2> follows_m_s{};
    for (int i = 0; i < 1500; ++i) {
      SCOPED_TRACE(i);
      std::array<double, 2> commands{}, wheels{};
      for (std::size_t k = 0; k < 2; ++k) {
        commands[k] = command_m_s[k].step();
        follows_m_s[k] += (commands[k] - follows_m_s[k]) * 0.1;
        wheels[k] = follows_m_s[k] + off_m_s[k].step();
        drives[k]->next_tick();
        const std::uint16_t word = status[k].step();
        const double amperes = current_a[k].step();
        if (!silent[k].step()) send_state(*drives[k], word, amperes);
        send_supply(*drives[k], 24);
      }
      bench.left_command_m_s = commands[0];
      bench.right_command_m_s = commands[1];
      bench.sensed.odometry.wheel_left_m_s = wheels[0];
      bench.sensed.odometry.wheel_right_m_s = wheels[1];
      bench.sensed.odometry.speed_m_s = (wheels[0] + wheels[1]) / 2;
      bench.powered = powered.step();
      const OverspeedRule::Verdict expected = rule.judge(bench);
      ASSERT_EQ(monitor.check(bench.view()), expected.trips);
      ASSERT_EQ(monitor.code(), expected.code);
      found += expected.trips ? 1 : 0;
      held += expected.code;
    }
  }
  EXPECT_GT(found, 1000);
  EXPECT_GT(held, 200);
}

// ----- wheel_slip

TEST(WheelSlipRule, H10EachStepOfRandomSlipsIsJudgedByTheRule) {
  int found = 0;
  for (unsigned seed = 1; seed <= 6; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    const int slip_ticks = 30 + static_cast<int>(random.below(60));
    bench.params.slip_stop_s = about_steps_s(random, slip_ticks);
    const Derived derived = derive(bench.params);
    WheelSlip monitor;
    Spells<double> slip_deg_s(random, 200, {0, 15, -25});
    Spells<bool> powered(random, 150, {true, true, true, false});
    TiltSample sample;
    for (int i = 0; i < 1500; ++i) {
      SCOPED_TRACE(i);
      Estimate& sensed = bench.sensed;
      sensed.next_tick();
      ++sample.counter;
      send_angles(sensed.base, sample);
      send_rates(sensed.base, {slip_deg_s.step(), 0, 0});
      for (DriveSensor* drive : {&sensed.left_drive, &sensed.right_drive}) send_state(*drive, kEnabled, 0, 300 * i);
      sensed.odometry.update(sensed.left_drive, sensed.right_drive, derived, kTick_s);
      sensed.fused.update(sensed.odometry, sensed.left_drive, sensed.right_drive, sensed.base, derived, kTick_s);
      bench.powered = powered.step();
      const bool expected = bench.powered && sensed.fused.slip_ticks() >= slip_ticks;
      ASSERT_EQ(monitor.check(bench.view()), expected);
      found += expected ? 1 : 0;
    }
  }
  EXPECT_GT(found, 300);
}

// ----- drive_left_fault, drive_right_fault

// One drive: a fault reported, half a second wanted and not enabled, or 50 ms dropped out.
class DriveRule {
 public:
  bool faulty(const DriveSensor& drive, std::uint16_t status) const {
    if (drive.fresh().age_ticks() >= 5) return false;
    return status == kFaulted || status == kFaultReaction || missing_.ticks >= 50 || (ran_ && missing_.ticks >= 5);
  }
  /// After the monitors, as the step's output.
  void note(const DriveSensor& drive, std::uint16_t status, bool wanted) {
    const bool counts = wanted && drive.fresh().age_ticks() < 5;
    missing_.step(counts && status != kEnabled);
    ran_ = counts && (ran_ || status == kEnabled);
  }

 private:
  Streak missing_;
  bool ran_ = false;
};

TEST(DriveFaultRule, H2EachStepOfTwoRandomDrivesIsJudgedByTheRule) {
  int found = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    DriveFault<true> left;
    DriveFault<false> right;
    std::array<DriveRule, 2> rules;
    const std::array drives{&bench.sensed.left_drive, &bench.sensed.right_drive};
    const Spells<std::uint16_t> states(random, seed % 2 == 0 ? 12 : 90,
                                       {kEnabled, kEnabled, kSwitchedOn, kSwitchOnDisabled, kQuickStop, kFaulted, kFaultReaction});
    std::array status{states, states};
    const Spells<bool> silence(random, 8, {false, false, false, false, false, false, false, false, true});
    std::array silent{silence, silence};
    Spells<bool> wanted(random, 200, {true, true, false});
    Spells<Mode> mode(random, 300, {Mode::user, Mode::remote, Mode::init});
    std::array<std::uint16_t, 2> words{};
    for (int i = 0; i < 1500; ++i) {
      SCOPED_TRACE(i);
      bench.mode = mode.step();
      for (std::size_t k = 0; k < 2; ++k) {
        drives[k]->next_tick();
        const std::uint16_t word = status[k].step();
        if (silent[k].step()) continue;
        words[k] = word;
        send_state(*drives[k], word, 0);
      }
      const bool judged = bench.mode != Mode::init;
      const std::array expected{judged && rules[0].faulty(*drives[0], words[0]), judged && rules[1].faulty(*drives[1], words[1])};
      ASSERT_EQ(left.check(bench.view()), expected[0]);
      ASSERT_EQ(right.check(bench.view()), expected[1]);
      found += expected[0] || expected[1] ? 1 : 0;
      const bool run = wanted.step();
      const Running running = run ? Running::begin : Running::off;
      static_cast<void>(bench.left_control.step(*drives[0], running, false));
      static_cast<void>(bench.right_control.step(*drives[1], running, false));
      for (std::size_t k = 0; k < 2; ++k) rules[k].note(*drives[k], words[k], run);
    }
  }
  EXPECT_GT(found, 1000);
}

// ----- emergency_stop

TEST(EmergencyStopRule, EachStepOfARandomChainIsJudgedByTheRule) {
  int opened = 0, unpowered = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    EmergencyStopOpen monitor;
    const std::array drives{&bench.sensed.left_drive, &bench.sensed.right_drive};
    const Spells<double> supplies_v(random, 400, {25, 15, 8, 8, 8, 3});
    std::array supply_v{supplies_v, supplies_v};
    const Spells<bool> supply_silences(random, 90, {false, false, false, false, false, false, true});
    std::array supply_silent{supply_silences, supply_silences};
    Spells<bool> all_off(random, 350, {false, true});
    Spells<double> battery_v(random, 600, {12.8, 12.8, 8});
    Spells<bool> io_silent(random, 10, {false, false, false, false, false, true}), pressed(random, 80, {false, false, false, false, true});
    Spells<bool> relay_cut(random, 300, {false, false, false, false, true});
    Spells<Mode> mode(random, 500, {Mode::user, Mode::emergency_stop, Mode::standby, Mode::user, Mode::init});
    bool open = false, batteries_told = false;
    double told_v = 0;
    std::array<double, 2> told_supply_v{};
    Streak gone;
    for (int i = 0; i < 1500; ++i) {
      SCOPED_TRACE(i);
      bench.mode = mode.step();
      bench.relay_cut = relay_cut.step();
      IoSensor& io = bench.sensed.io;
      io.next_tick();
      const bool press = pressed.step();
      if (!io_silent.step()) {
        send_inputs(io, 0, press ? 1 : 0);
        open = press;
      }
      const double both_v = 2 * battery_v.step();
      // The batteries come a while after the inputs.
      if (i > 300) {
        told_v = both_v;
        batteries_told = true;
        send_batteries(io, told_v / 2 + 4, told_v / 2 - 4);
      }
      bool all_gone = true;
      const bool off = all_off.step();
      for (std::size_t k = 0; k < 2; ++k) {
        drives[k]->next_tick();
        const double drawn_v = supply_v[k].step(), volts = off ? 8 : drawn_v;
        if (!supply_silent[k].step()) {
          send_supply(*drives[k], volts);
          told_supply_v[k] = volts;
        }
        all_gone = all_gone && drives[k]->supply_known() && told_supply_v[k] < 12;
      }
      const bool tells = io.fresh().age_ticks() < 5 && batteries_told && told_v > 20;
      const bool lost = gone.step(all_gone && tells && !bench.relay_cut && bench.mode != Mode::init) >= 100;
      ASSERT_EQ(monitor.check(bench.view()), open || lost);
      opened += open ? 1 : 0;
      unpowered += lost ? 1 : 0;
    }
  }
  EXPECT_GT(opened, 500);
  EXPECT_GT(unpowered, 300);
}

// ----- battery_low, battery_empty, battery_uneven, supply_high

// The voltage over one second, and a limit that moves when the alarm is on.
class BatteryRule {
 public:
  double smoothed_v(double now_v) {
    smooth_v_ = known_ ? (smooth_v_ + kTick_s * now_v) / (1 + kTick_s) : now_v;
    known_ = true;
    return smooth_v_;
  }

 private:
  double smooth_v_ = 0;
  bool known_ = false;
};

TEST(BatteryRule, H12EachStepOfTwoRandomBatteriesIsJudgedByTheRule) {
  int low_steps = 0, empty_steps = 0, uneven_steps = 0, high_steps = 0;
  for (unsigned seed = 1; seed <= 18; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    BatteryBelow<Fault::battery_low, &contract::Params::battery_low_v> low;
    BatteryBelow<Fault::battery_empty, &contract::Params::battery_empty_v> empty;
    BatteryUneven uneven;
    SupplyHigh high;
    BatteryRule sum, difference;
    bool is_low = false, is_empty = false, is_uneven = false, is_high = false;
    Spells<double> sum_v(random, 300, {25.6, 23.2, 22.9, 22.15, 21.8, 20, 29.35, 29.65, 31}),
        apart_v(random, 300, {0, 0.45, 0.47, 0.6, -0.6, 1, -1.5});
    for (int i = 0; i < 2000; ++i) {
      SCOPED_TRACE(i);
      const double together_v = sum_v.step(), between_v = apart_v.step();
      if (random.once_in(700)) bench.sensed.io.restart();
      const bool told = !random.once_in(40);
      if (told) send_batteries(bench.sensed.io, (together_v + between_v) / 2, (together_v - between_v) / 2);
      const bool known = bench.sensed.io.battery_known();
      if (known) {
        const double a_v = bench.sensed.io.battery_a_v(), b_v = bench.sensed.io.battery_b_v();
        const double smooth_v = sum.smoothed_v(a_v + b_v), smooth_apart_v = std::fabs(difference.smoothed_v(a_v - b_v));
        is_low = smooth_v < (is_low ? 23.3 : 23.0);
        is_empty = smooth_v < (is_empty ? 22.3 : 22.0);
        is_high = smooth_v > (is_high ? 29.2 : 29.5);
        is_uneven = smooth_apart_v > (is_uneven ? 0.4 : 0.5);
      }
      ASSERT_EQ(low.check(bench.view()), known && is_low);
      ASSERT_EQ(empty.check(bench.view()), known && is_empty);
      ASSERT_EQ(uneven.check(bench.view()), known && is_uneven);
      ASSERT_EQ(high.check(bench.view()), known && is_high);
      low_steps += is_low ? 1 : 0;
      empty_steps += is_empty ? 1 : 0;
      uneven_steps += is_uneven ? 1 : 0;
      high_steps += is_high ? 1 : 0;
    }
  }
  EXPECT_GT(low_steps, 1000);
  EXPECT_GT(empty_steps, 1000);
  EXPECT_GT(uneven_steps, 1000);
  EXPECT_GT(high_steps, 1000);
}

}  // namespace
}  // namespace hoist::core::test
