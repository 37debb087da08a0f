// What the drives' frames mean, how far the wheels went, and which wheel its motor turns: written a second time from the descriptions of
// control/core/estimate (drive_sensor.hpp, odometry.hpp, driven_wheel.hpp), can_dictionary.def and decisions 75 and 158.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <numbers>
#include <random>

#include "control/core/estimate/driven_wheel.hpp"
#include "control/core/estimate/odometry.hpp"
#include "control/core/types.hpp"

namespace hoist::core::test {
namespace {
namespace drive_rule {

int one_of(std::mt19937& random, std::initializer_list<int> all) { return all.begin()[random() % all.size()]; }

contract::CanFrame state_frame(std::uint16_t status, std::int32_t counts, std::int16_t current) {
  contract::CanFrame frame{0x181, 8, 0, {}};
  const auto put = [&frame](std::size_t at, std::uint32_t value, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) frame.data[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
  };
  put(0, status, 2);
  put(2, static_cast<std::uint32_t>(counts), 4);
  put(6, static_cast<std::uint16_t>(current), 2);
  return frame;
}
contract::CanFrame supply_frame(std::uint16_t error, std::uint16_t supply_10mv) {
  contract::CanFrame frame{0x281, 8, 0, {1, 2, 3, 4}};  // the speed, which is not used
  frame.data[4] = static_cast<std::uint8_t>(error % 256);
  frame.data[5] = static_cast<std::uint8_t>(error / 256);
  frame.data[6] = static_cast<std::uint8_t>(supply_10mv % 256);
  frame.data[7] = static_cast<std::uint8_t>(supply_10mv / 256);
  return frame;
}

// In time of the SYNCs: when the position was last told, and when the step before that.
struct DriveRule {
  int age = 255, supply_age = 255;  // steps
  std::int64_t waited = 0;          // ticks since the last position, at most ten minutes
  std::int64_t sync = 1;
  std::int64_t moved = 0, moved_in = 0;
  std::int64_t counts = 0;
  bool known = false;
  std::uint16_t status = 0, error = 0;
  double amps = 0, volts = 0;

  void next_step(std::uint32_t ticks) {
    age = std::min(age + 1, 255);
    supply_age = std::min(supply_age + 1, 255);
    sync = ticks;
    waited = std::min<std::int64_t>(waited + ticks, 10 * 60 * 100);
    moved = moved_in = 0;
  }
  bool take(std::uint16_t status_word, std::int32_t position, std::int16_t current, double counts_per_tick_max) {
    age = 0;
    status = status_word;
    amps = 0.006 * current;  // thousandths of 6 A
    // The counter runs through 2^32.
    std::int64_t way = position - counts;
    if (way >= std::int64_t{1} << 31) way -= std::int64_t{1} << 32;
    if (way < -(std::int64_t{1} << 31)) way += std::int64_t{1} << 32;
    // All frames of one step together, in the time since the position was told before them.
    const double most = counts_per_tick_max * static_cast<double>(std::max<std::int64_t>(moved_in + waited, 1));
    const bool jump = known && std::abs(static_cast<double>(moved + way)) >= most;
    if (known && !jump) {
      moved += way;
      moved_in += waited;
    }
    known = true;
    counts = position;
    waited = 0;
    return !jump;
  }
  [[nodiscard]] bool lost() const { return age * 10 >= 50; }
  [[nodiscard]] bool enabled() const { return !lost() && (status & 0x6F) == 0x27; }
  // It stops on a ramp of its own: quick stop, or the reaction to a fault.
  [[nodiscard]] bool works() const { return enabled() || (status & 0x6F) == 0x07 || (status & 0x4F) == 0x0F; }
  [[nodiscard]] bool supply_known() const { return supply_age * 10 < 10 * 50; }
};

void expect_alike(const DriveSensor& drive, const DriveRule& rule) {
  ASSERT_EQ(drive.fresh().age_ticks(), rule.age);
  ASSERT_EQ(drive.fresh().lost(), rule.lost());
  ASSERT_EQ(drive.sync_ticks(), rule.sync);
  ASSERT_EQ(drive.moved_counts(), rule.moved);
  ASSERT_EQ(drive.moved_ticks(), rule.moved_in);
  ASSERT_EQ(drive.counts(), rule.counts);
  ASSERT_EQ(drive.position_known(), rule.known);
  ASSERT_EQ(drive.status_word(), rule.status);
  ASSERT_EQ(drive.error_code(), rule.error);
  ASSERT_EQ(drive.enabled(), rule.enabled());
  ASSERT_EQ(drive.works(), rule.works());
  ASSERT_EQ(drive.supply_known(), rule.supply_known());
  ASSERT_NEAR(drive.current_a(), rule.amps, 1e-9);
  ASSERT_NEAR(drive.supply_v(), rule.volts, 1e-9);
}

TEST(DriveRule, H3EachFrameIsReadByTheRule) {
  std::array<int, 2> jumps{};
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    DriveSensor drive;
    DriveRule rule;
    const double most = one_of(random, {100, 2865, 400'000});  // counts in a tick
    std::int64_t position = one_of(random, {0, 123, 2'147'483'600, -2'147'483'000});
    int silent = 0, supply_silent = 0;
    for (int i = 0; i < 1000; ++i) {
      const auto ticks = static_cast<std::uint32_t>(random() % 200 == 0 ? one_of(random, {59'998, 59'999, 60'000, 60'001, 100'000})
                                                                        : one_of(random, {1, 1, 1, 1, 1, 1, 1, 2, 3, 5}));
      drive.next_tick(ticks);
      rule.next_step(ticks);
      if (silent == 0 && random() % 40 == 0) silent = one_of(random, {1, 3, 4, 5, 6, 20, 300});
      if (supply_silent == 0) supply_silent = one_of(random, {4, 4, 4, 4, 4, 48, 49, 50, 51, 300});
      for (int frames = silent > 0 ? 0 : one_of(random, {1, 1, 1, 1, 1, 2, 3}); frames > 0; --frames) {
        const auto limit = static_cast<std::int64_t>(most * static_cast<double>(std::max<std::int64_t>(rule.moved_in + rule.waited, 1)));
        const std::int64_t way = one_of(random, {0, 0, 1, -1, 57, -80}) + (random() % 8 != 0 ? 0 : one_of(random, {-1, 1}) * limit);
        // Just at the limit it is a jump, one count less is none.
        const std::int64_t edge = random() % 10 != 0 ? way : one_of(random, {-1, 1}) * (limit - one_of(random, {0, 1, 2})) - rule.moved;
        position = static_cast<std::int32_t>(static_cast<std::uint32_t>(position + edge));
        const auto status = static_cast<std::uint16_t>(
            random() % 3 != 0 ? one_of(random, {0x00, 0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08, 0x237, 0x1627}) : random());
        const auto current = static_cast<std::int16_t>(random());
        const auto at = static_cast<std::int32_t>(position);
        const bool plausible = drive.take_state(state_frame(status, at, current), most);
        ASSERT_EQ(plausible, rule.take(status, at, current, most)) << i;
        ++jumps[plausible ? 1U : 0U];
      }
      silent -= silent > 0 ? 1 : 0;
      ASSERT_NO_FATAL_FAILURE(expect_alike(drive, rule)) << i;
      if (--supply_silent == 0) {
        const auto error = static_cast<std::uint16_t>(random()), supply = static_cast<std::uint16_t>(random());
        drive.take_supply(supply_frame(error, supply));
        rule.error = error;
        rule.volts = 0.01 * supply;
        rule.supply_age = 0;
      }
      if (random() % 300 == 0) {
        drive.restart();
        rule = DriveRule{};
      }
      ASSERT_NO_FATAL_FAILURE(expect_alike(drive, rule)) << i;
    }
  }
  EXPECT_GT(jumps[0], 1000);
  EXPECT_GT(jumps[1], 10'000);
}

// Equations (19) to (23), as printed: the heading before the step.
TEST(OdometryRule, TheTrackFollowsTheWheelsByTheEquations) {
  std::array<int, 2> stood{};
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    contract::Params params;
    params.wheel_left_scale_norm = 0.01 * one_of(random, {95, 100, 103});
    params.wheel_right_scale_norm = 0.01 * one_of(random, {97, 100, 108});
    params.track_width_m = 0.1 * one_of(random, {5, 7, 9});
    const Derived derived = derive(params);
    const double per_count_m = 2 * std::numbers::pi * params.wheel_radius_m / params.encoder_counts_per_turn;
    DriveSensor left, right;
    Odometry odometry;
    double x_m = 0, y_m = 0, psi_rad = 0, way_m = 0, left_m_s = 0, right_m_s = 0;
    std::int32_t left_counts = 0, right_counts = 0;
    int left_age = 255, right_age = 255;
    std::array<int, 2> slope{};
    for (int i = 0; i < 800; ++i) {
      const auto ticks = static_cast<std::uint32_t>(one_of(random, {1, 1, 1, 1, 1, 1, 2, 4}));
      left.next_tick(ticks);
      right.next_tick(ticks);
      left_age = std::min(left_age + 1, 255);
      right_age = std::min(right_age + 1, 255);
      // 19 counts in 10 ms are 0.02 m/s.
      if (i % 50 == 0)
        for (int& one : slope) one = one_of(random, {0, 0, 1, -1, 15, -15, 18, 19, -19, 20, 23, 400, -900});
      const bool left_silent = i / 100 % 3 == 1 && i % 100 < 40 && i % 20 < 8, right_silent = i / 100 % 3 == 2 && i % 20 < 7;
      const bool begins = left.position_known() && right.position_known();
      if (!left_silent) static_cast<void>(left.take_state(state_frame(0x27, left_counts += slope[0], 0), 1e6));
      if (!right_silent) static_cast<void>(right.take_state(state_frame(0x27, right_counts += slope[1], 0), 1e6));
      if (!left_silent) left_age = 0;
      if (!right_silent) right_age = 0;
      odometry.update(left, right, derived, kTick_s);
      if (!begins) continue;
      const double left_m = left.moved_counts() * per_count_m * params.wheel_left_scale_norm;
      const double right_m = right.moved_counts() * per_count_m * params.wheel_right_scale_norm;
      const double travel_m = (left_m + right_m) / 2;
      x_m += travel_m * std::cos(psi_rad);
      y_m += travel_m * std::sin(psi_rad);
      psi_rad += (right_m - left_m) / params.track_width_m;
      way_m += std::abs(travel_m);
      // A speed is told anew with each report, over the time since the one before.
      if (!left_silent) left_m_s = left_m / (0.01 * left.moved_ticks());
      if (!right_silent) right_m_s = right_m / (0.01 * right.moved_ticks());
      const bool stands = left_age < 5 && right_age < 5 && std::abs(left_m_s) < 0.02 && std::abs(right_m_s) < 0.02;
      ++stood[stands ? 1 : 0];
      ASSERT_NEAR(odometry.pose.x_m, x_m, 1e-9) << i;
      ASSERT_NEAR(odometry.pose.y_m, y_m, 1e-9) << i;
      ASSERT_NEAR(odometry.pose.psi_rad, psi_rad, 1e-9) << i;
      ASSERT_NEAR(odometry.distance_m, way_m, 1e-9) << i;
      ASSERT_NEAR(odometry.wheel_left_m_s, left_m_s, 1e-9) << i;
      ASSERT_NEAR(odometry.wheel_right_m_s, right_m_s, 1e-9) << i;
      ASSERT_NEAR(odometry.speed_m_s, (left_m_s + right_m_s) / 2, 1e-9) << i;
      ASSERT_NEAR(odometry.yaw_rate_rad_s, (right_m_s - left_m_s) / params.track_width_m, 1e-9) << i;
      ASSERT_EQ(odometry.standing_still, stands) << i;
    }
  }
  EXPECT_GT(stood[0], 1000);
  EXPECT_GT(stood[1], 1000);
}

// Decisions 75 and 158.
TEST(DrivenWheelRule, H1ACurrentSaysWhetherTheMotorTurnsTheWheel) {
  std::array<int, 4> seen{};
  std::mt19937 random(1);
  for (int i = 0; i < 15'000; ++i) {
    DriveSensor drive;
    const auto supply = static_cast<std::uint16_t>(one_of(random, {0, 100, 1500, 2000, 2600, 4000}));
    const int supply_age = one_of(random, {0, 0, 3, 49, 50, 255}), age = one_of(random, {0, 0, 1, 4, 5, 255});
    const auto status = static_cast<std::uint16_t>(one_of(random, {0x40, 0x21, 0x23, 0x27, 0x07, 0x0F, 0x08}));
    const auto current = static_cast<std::int16_t>(one_of(random, {-1, 1}) * one_of(random, {0, 1, 83, 130, 166, 167, 300, 340, 1000}));
    for (int ago = 60; ago >= 0; --ago) {
      drive.next_tick();
      if (ago == supply_age) drive.take_supply(supply_frame(0, supply));
      if (ago == age) static_cast<void>(drive.take_state(state_frame(status, 0, current), 1e6));
    }
    ASSERT_EQ(drive.fresh().age_ticks(), age);
    ASSERT_EQ(drive.supply_known(), supply_age < 50);
    const double amps = age < 255 ? 0.006 * current : 0;
    const double wheel_m_s =
        0.01 * one_of(random, {-1, 1}) * one_of(random, {0, 1, 4, 6, 9, 11, 30, 39, 42, 52, 55, 69, 71, 104, 110, 200});
    const double command_m_s = 0.01 * one_of(random, {0, 0, 2, -2, 30, -30, 50, -50});
    const bool lost = age >= 5;
    const bool works = status == 0x27 || status == 0x07 || status == 0x0F;
    // Of a motor that is fed the current flows along its motion.
    const bool along = amps * wheel_m_s > 0 && std::abs(amps) > 1.0;
    const bool drives = !lost && along && std::abs(wheel_m_s) > std::abs(command_m_s) + 0.05;
    ASSERT_EQ(motor_drives(drive, wheel_m_s, command_m_s), drives) << i;
    // A wheel that is pushed generates 34.5 V for each m/s, and feeds a supply from 0.93 of it on; of an unknown supply any motion does.
    const double generated_v = 34.5 * std::abs(wheel_m_s);
    const bool feeds = amps * wheel_m_s < 0 && std::abs(wheel_m_s) > 0.05 && (supply_age >= 50 || generated_v > 0.93 * 0.01 * supply);
    const bool stray = !lost && !works && std::abs(amps) > 1.0 && !feeds;
    ASSERT_EQ(stray_current(drive, wheel_m_s), stray) << i << ": " << wheel_m_s << " m/s, " << amps << " A, " << 0.01 * supply << " V";
    seen[0] += drives;
    seen[1] += stray && amps * wheel_m_s < 0;
    seen[2] += stray && amps * wheel_m_s >= 0;
    seen[3] += feeds && !lost && !works && std::abs(amps) > 1.0;
  }
  for (const int count : seen) EXPECT_GT(count, 200);
}

}  // namespace drive_rule
}  // namespace
}  // namespace hoist::core::test
