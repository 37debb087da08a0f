// The last resort of a stop and the states of one drive: the rules of control/core/output/runaway_watch.hpp and drive_control.hpp, written a
// second time from their descriptions. Each step must be judged alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <random>

#include "control/core/output/drive_control.hpp"
#include "control/core/output/runaway_watch.hpp"

namespace hoist::core::test::out_drives {
namespace {

using contract::Mode;
using contract::Pdo;
namespace cia402 = contract::canopen::drive;

// What a drive says of itself. `age_steps`: since its last report; lost from 5 on.
struct Drive {
  std::uint16_t status = 0x27;
  int current_raw = 0;   // 6 mA
  double supply_v = 25;  // 0: never told
  int age_steps = 0;

  [[nodiscard]] bool lost() const { return age_steps >= 5; }
  [[nodiscard]] double current_a() const { return current_raw * 0.006; }
  // Enabled, or on its own ramp.
  [[nodiscard]] bool bridge_works() const { return status == 0x27 || status == 0x07 || status == 0x0F; }
  [[nodiscard]] DriveSensor sensor() const {
    DriveSensor made;
    if (supply_v > 0) {
      contract::CanFrame supply{0, 8, 0, {}};
      contract::write_slot(supply, contract::pdo_slot(Pdo::drive_tx2, 0x2211), std::lround(supply_v * 100));
      made.take_supply(supply);
    }
    contract::CanFrame frame{0, 8, 0, {}};
    contract::write_slot(frame, contract::pdo_slot(Pdo::drive_tx1, 0x6041), status);
    contract::write_slot(frame, contract::pdo_slot(Pdo::drive_tx1, 0x6078), current_raw);
    static_cast<void>(made.take_state(frame, 1e9));
    for (int i = 0; i < age_steps; ++i) made.next_tick();
    return made;
  }
};

// Faster than this it feeds the supply.
double generates_from_m_s(const Drive& drive) { return std::max(0.05, 0.93 * drive.supply_v / 34.5); }

// estimate/driven_wheel.hpp: fed along its motion beyond what it was told, or fed through a bridge that is off.
bool fed(const Drive& drive, double wheel_m_s, double should_m_s) {
  if (drive.lost()) return false;
  const double along_a = wheel_m_s > 0 ? drive.current_a() : -drive.current_a();
  if (std::fabs(wheel_m_s) > std::fabs(should_m_s) + 0.05 && along_a > 1) return true;
  const bool generates = std::fabs(wheel_m_s) > generates_from_m_s(drive) && along_a <= 0;
  return !drive.bridge_works() && !generates && std::fabs(drive.current_a()) > 1;
}

// In a protective stop 0.3 A are enough as a mean over 0.1 s of currents of 1 A at most, of a wheel that turns, and no faster than a motor could.
struct FedSlowly {
  double mean_a = 0;

  bool step(const Drive& drive, double wheel_m_s, int dt_ms) {
    const bool off = !drive.lost() && !drive.bridge_works();
    mean_a = off ? mean_a + (std::clamp(drive.current_a(), -1.0, 1.0) - mean_a) * dt_ms / 100 : 0;
    return off && std::fabs(wheel_m_s) > 0.05 && std::fabs(wheel_m_s) <= generates_from_m_s(drive) && std::fabs(mean_a) > 0.3;
  }
};

// More than 3 A against the motion: harder than the holding brake, 8 N m of 30 * 0.115 N m/A.
bool brakes(const Drive& drive, double wheel_m_s) {
  return !drive.lost() && drive.bridge_works() && drive.current_a() * (wheel_m_s > 0 ? -1 : 1) > 3;
}

// How long something has been faster than it was told and has not slowed down: by less than a fifth of the brake's 1.2 m/s2 in 0.3 s.
struct Unslowed {
  double from = 0;
  int ms = 0;

  void step(bool counts, double now, double should, double beside, double slowing, int dt_ms) {
    const double fast = std::fabs(now);
    const bool good = !counts || fast <= std::fabs(should) + beside || from - fast > slowing;
    from = good ? fast : std::max(from, fast);
    ms = good ? 0 : ms + dt_ms;
  }
};

struct Seen {
  Drive left, right;
  double left_m_s = 0, right_m_s = 0, turn_rad_s = 0;
  bool rates_lost = false;
};

struct RunawayRule {
  double left_m_s = 0, right_m_s = 0;  // what the wheels should do
  int driven_ms = 0, stands_steps = 0;
  bool stood = false;
  Unslowed left, right, turn;
  FedSlowly left_fed, right_fed;

  bool step(Mode mode, bool moving, const Seen& seen, double told_left_m_s, double told_right_m_s, double track_m, int dt_ms) {
    // A drive follows with a lag of 0.1 s.
    left_m_s += (told_left_m_s - left_m_s) * dt_ms / 100;
    right_m_s += (told_right_m_s - right_m_s) * dt_ms / 100;
    const bool stops = mode == Mode::protective_stop;
    if (!stops) stood = false, stands_steps = 0;
    const bool left_driven = left_fed.step(seen.left, seen.left_m_s, dt_ms),
               right_driven = right_fed.step(seen.right, seen.right_m_s, dt_ms);
    if (moving) {
      driven_ms = 0;
      left = right = turn = {};
      return false;
    }
    const bool driven =
        (stops && (left_driven || right_driven)) || fed(seen.left, seen.left_m_s, left_m_s) || fed(seen.right, seen.right_m_s, right_m_s);
    driven_ms = std::max(0, driven_ms + (driven ? dt_ms : -dt_ms));
    if (stops && !stood) {
      // The first standstill: ten steps of all that reports, and at least two of the three do.
      const bool stands =
          (seen.left.lost() || std::fabs(seen.left_m_s) < 0.05) && (seen.right.lost() || std::fabs(seen.right_m_s) < 0.05) &&
          (seen.rates_lost || std::fabs(seen.turn_rad_s) < 0.07) && seen.left.lost() + seen.right.lost() + seen.rates_lost < 2;
      stands_steps = stands ? stands_steps + 1 : 0;
      stood = stands_steps == 10;
    }
    if (!stops || stood) {
      left = right = turn = {};
    } else {
      left.step(!seen.left.lost() && !brakes(seen.left, seen.left_m_s), seen.left_m_s, left_m_s, 0.15, 0.072, dt_ms);
      right.step(!seen.right.lost() && !brakes(seen.right, seen.right_m_s), seen.right_m_s, right_m_s, 0.15, 0.072, dt_ms);
      turn.step((seen.left.lost() || seen.right.lost()) && !seen.rates_lost, seen.turn_rad_s, (right_m_s - left_m_s) / track_m, 0.25,
                0.072 / 0.35, dt_ms);
    }
    return std::max({driven_ms, left.ms, right.ms, turn.ms}) >= 300;
  }
};

// How a speed goes on: it holds, slows down as a brake does or does not, or is what it was told and a little more.
struct Course {
  double m_s = 0, falls_m_s2 = 0, beside_m_s = 0;
  bool follows = false;

  void step(double should_m_s, double noise_m_s, double dt_s) {
    if (follows) m_s = should_m_s + (should_m_s < 0 ? -beside_m_s : beside_m_s);
    m_s -= std::copysign(std::min(std::fabs(m_s), falls_m_s2 * dt_s), m_s);
    m_s += noise_m_s;
  }
};

TEST(OutRunaway, H1AStopThatDoesNotStopIsSeenAfter300MsOfAnyOfItsThreeSigns) {
  int alarms = 0, quiet = 0, by_wheel = 0, by_turn = 0, by_current = 0, stood = 0;
  for (unsigned seed = 1; seed <= 200; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
    const int dt_ms = seed % 5 == 0 ? 20 : 10;
    const double dt_s = dt_ms / 1000.0, track_m = one_of(std::array{0.7, 0.4, 1.1});
    RunawayWatch watch;
    RunawayRule rule;
    Seen seen;
    Estimate sensed;
    Course left, right, turn;
    Mode mode = Mode::user;
    double told_left_m_s = 0, told_right_m_s = 0;
    const auto drive = [&](Drive& what) {
      what.status = one_of(std::array<std::uint16_t, 8>{0x27, 0x27, 0x27, 0x40, 0x08, 0x07, 0x0F, 0x21});
      what.current_raw = one_of(std::array{0, 49, -51, 100, -100, 166, -166, 168, -168, 499, -499, 501, -501});
      what.supply_v = one_of(std::array{0.0, 13.0, 20.0, 25.0});
      what.age_steps = one_of(std::array{0, 0, 0, 4, 5, 9});
    };
    const auto course = [&](Course& what, double scale) {
      what = {.m_s = scale * one_of(std::array{0.0, 0.0, 0.04, 0.06, 0.2, 0.3, 0.6, 0.9}) * (random() % 2 == 0 ? 1 : -1),
              .falls_m_s2 = scale * one_of(std::array{0.0, 0.0, 0.2, 0.23, 0.26, 0.5}),
              .beside_m_s = scale * one_of(std::array{0.0, 0.045, 0.055, 0.14, 0.16}),
              .follows = random() % 4 == 0};
    };
    for (int i = 0, mode_left = 0, drives_left = 0, left_left = 0, right_left = 0, turn_left = 0, told_left = 0; i < 400; ++i) {
      if (mode_left-- == 0) {
        mode = one_of(std::array{Mode::protective_stop, Mode::protective_stop, Mode::standby, Mode::user});
        mode_left = mode == Mode::user ? 3 : one_of(std::array{1, 40, 90, 200});
      }
      if (told_left-- == 0) {
        told_left_m_s = one_of(std::array{0.0, 0.0, 0.3, -0.3, 0.6});
        told_right_m_s = random() % 2 == 0 ? told_left_m_s : one_of(std::array{0.0, 0.2, -0.2});
        told_left = one_of(std::array{5, 60, 150});
      }
      const bool drives_change = drives_left-- == 0;
      if (drives_change) {
        seen.left = seen.right = {};
        if (random() % 3 != 0) drive(seen.left);
        if (random() % 3 != 0) drive(seen.right);
        seen.rates_lost = random() % 5 == 0;
        drives_left = one_of(std::array{2, 8, 25, 27, 28, 29, 33, 60, 100});
      }
      if (left_left-- == 0) course(left, 1), left_left = one_of(std::array{0, 8, 11, 28, 29, 30, 31, 60});
      if (right_left-- == 0) course(right, 1), right_left = one_of(std::array{0, 8, 11, 28, 29, 30, 31, 60});
      if (turn_left-- == 0) course(turn, 1 / 0.35), turn_left = one_of(std::array{0, 8, 11, 28, 29, 30, 31, 60});
      left.step(rule.left_m_s, 1e-4 * unit(random), dt_s);
      right.step(rule.right_m_s, 1e-4 * unit(random), dt_s);
      turn.step((rule.right_m_s - rule.left_m_s) / track_m, 3e-4 * unit(random), dt_s);
      if (drives_change) {
        sensed.left_drive = seen.left.sensor();
        sensed.right_drive = seen.right.sensor();
      }
      sensed.odometry.wheel_left_m_s = seen.left_m_s = left.m_s;
      sensed.odometry.wheel_right_m_s = seen.right_m_s = right.m_s;
      contract::CanFrame rates{0, 6, 0, {}};
      constexpr contract::PdoSlot kYaw = contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 1);
      contract::write_slot(rates, kYaw, std::lround(turn.m_s * 180 / std::numbers::pi / kYaw.scale));
      sensed.base.take_rates(rates);
      for (int age = 0; seen.rates_lost && age < 5; ++age) sensed.base.next_tick();
      seen.turn_rad_s = sensed.base.yaw_rate_rad_s();
      const bool moving = mode == Mode::user;
      const bool alarm = rule.step(mode, moving, seen, told_left_m_s, told_right_m_s, track_m, dt_ms);
      ASSERT_EQ(watch.step(mode, moving, sensed, told_left_m_s, told_right_m_s, track_m, dt_s), alarm) << i;
      ++(alarm ? alarms : quiet);
      by_current += rule.driven_ms == 300 ? 1 : 0;
      by_wheel += rule.left.ms == 300 || rule.right.ms == 300 ? 1 : 0;
      by_turn += rule.turn.ms == 300 ? 1 : 0;
      stood += rule.stood ? 1 : 0;
    }
  }
  EXPECT_GT(quiet, 30'000);
  EXPECT_GT(alarms, 5000);
  EXPECT_GT(by_current, 100);
  EXPECT_GT(by_wheel, 100);
  EXPECT_GT(by_turn, 30);
  EXPECT_GT(stood, 1000);
}

// One drive on its way through CiA 402.
struct DriveRule {
  int resets_left = 0, missing_steps = 0;
  bool was_enabled = false, runs = false, ran = false;

  std::uint16_t step(std::uint16_t status, bool lost, Running wanted, bool cut) {
    if (wanted == Running::off || cut || lost) {
      was_enabled = false;
      missing_steps = 0;
    } else if (status == 0x27) {
      was_enabled = true;
      missing_steps = 0;
    } else {
      ++missing_steps;
    }
    ran = runs;
    const std::uint16_t control = lead(status, wanted, cut);
    runs = control == 0x0F;
    return control;
  }

  std::uint16_t lead(std::uint16_t status, Running wanted, bool cut) {
    if (resets_left > 0) {
      // 50 steps at most, as long as the drive reports its fault; a rising edge every fourth step.
      --resets_left;
      if (status != 0x08) resets_left = 0;
      return resets_left % 4 == 0 ? 0x00 : 0x80;
    }
    if (cut || status == 0x08 || status == 0x0F) return 0x00;  // off, or at fault
    // In a motion nothing else that a drive says takes it out, and nothing brings it in.
    if (wanted == Running::go_on) return ran ? 0x0F : 0x06;
    if (status == 0x07) return 0x02;  // its quick stop is left to finish
    if (wanted == Running::off || status == 0x00 || status == 0x40) return 0x06;
    return status == 0x21 ? 0x07 : 0x0F;
  }

  [[nodiscard]] bool refuses(int start_steps, int dropped_steps) const {
    return missing_steps >= start_steps || (was_enabled && missing_steps >= dropped_steps);
  }
};

TEST(OutDriveControl, H2EachStateHasItsControlwordAndADriveThatDoesNotRunIsSeen) {
  int refused = 0, dropped = 0, resets = 0, longest = 0;
  for (unsigned seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
    DriveControl control;
    DriveRule rule;
    Drive drive;
    DriveSensor sensor;
    Running wanted = Running::begin;
    bool cut = false;
    for (int i = 0, left = 0; i < 700; ++i) {
      if (left-- == 0) {
        drive = {.status = one_of(std::array<std::uint16_t, 10>{0x27, 0x27, 0x23, 0x21, 0x40, 0x00, 0x07, 0x0F, 0x08, 0x08}),
                 .age_steps = one_of(std::array{0, 0, 0, 4, 5})};
        sensor = drive.sensor();
        left = one_of(std::array{0, 1, 3, 4, 5, 48, 49, 50, 60});
        wanted = one_of(std::array{Running::off, Running::go_on, Running::begin, Running::begin});
        cut = random() % 8 == 0;
        if (seed % 30 == 0) {  // one that never does what it is asked to
          wanted = Running::begin;
          cut = false;
          left = 700;
          drive.status = 0x21;
          sensor = Drive{.status = 0x21}.sensor();
          drive.age_steps = 0;
        }
        if (random() % 5 == 0) {
          control.reset_fault();
          rule.resets_left = 50;
          ++resets;
        }
      }
      ASSERT_EQ(control.step(sensor, wanted, cut), rule.step(drive.status, drive.lost(), wanted, cut)) << i;
      ASSERT_EQ(control.resetting(), rule.resets_left > 0) << i;
      ASSERT_EQ(control.begins(), rule.runs && !rule.ran) << i;
      ASSERT_EQ(control.goes_on(), rule.runs && rule.ran) << i;
      const auto start_steps = one_of(std::array<std::uint8_t, 4>{kEnableTicksMax, 6, 100, 255});
      const auto dropped_steps = one_of(std::array<std::uint8_t, 4>{kDroppedTicksMax, 3, 100, 255});
      ASSERT_EQ(control.refuses_to_run(start_steps, dropped_steps), rule.refuses(start_steps, dropped_steps)) << i;
      ASSERT_EQ(control.refuses_to_run(kEnableTicksMax, kDroppedTicksMax), rule.refuses(50, 5)) << i;
      refused += rule.refuses(50, 5) ? 1 : 0;
      dropped += rule.refuses(50, 5) && !rule.refuses(50, 50) ? 1 : 0;
      longest = std::max(longest, rule.missing_steps);
    }
  }
  EXPECT_GT(refused, 10'000);
  EXPECT_GT(dropped, 500);
  EXPECT_GT(resets, 500);
  EXPECT_GT(longest, 600);
}

}  // namespace
}  // namespace hoist::core::test::out_drives
