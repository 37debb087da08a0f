// The frames of the outputs, the count of stops and the last resort of a stop: the rules of control/core/output/relay_feed.hpp,
// repeat_watch.hpp and hold_watch.hpp, written a second time from their descriptions. Each step must be judged alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <random>
#include <vector>

#include "control/core/output/hold_watch.hpp"
#include "control/core/output/relay_feed.hpp"
#include "control/core/output/repeat_watch.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

// H1, H23: a frame each 50 ms and at once when the relay is to open, with a change of the feed as long as it may stay closed.
TEST(OutputRules, H23TheOutputsAreToldEach50MsAndAnOpeningAtOnce) {
  using contract::AlarmLevel;
  constexpr std::array kLevels{AlarmLevel::none, AlarmLevel::low, AlarmLevel::medium, AlarmLevel::high};
  int frames = 0, cuts = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    RelayFeed relay;
    bool cut = false, feeds = true, sync = false, sync_told = false;
    unsigned level = 0;
    int since_ms = 0;
    contract::AlarmCommand alarm;
    for (int i = 0; i < 1000; ++i) {
      since_ms += 10;
      if (random() % 40 == 0) {
        relay.cut();
        cut = true;
        since_ms = 50;
        ++cuts;
      } else if (random() % 20 == 0) {
        relay.restore();
        cut = false;
      }
      if (random() % 15 == 0) feeds = !feeds;
      if (random() % 15 == 0) sync = !sync;
      if (random() % 15 == 0) alarm = {kLevels[random() % 4], kLevels[random() % 4]};
      FixedVector<contract::CanFrame, 4> out;
      relay.step(out, {feeds, sync, alarm});
      ASSERT_EQ(out.size(), since_ms == 50 ? 1U : 0U) << i;
      if (since_ms == 50) {
        since_ms = 0;
        if (feeds && !cut) level ^= contract::canopen::kRelayFeed;
        sync_told = sync;
        const unsigned bits = level | (cut ? contract::canopen::kRelayRelease : 0U) | (sync ? contract::canopen::kSyncOutput : 0U);
        const std::uint32_t id = contract::pdo_cob_id(contract::Pdo::io_rx1, contract::Node::io);
        ASSERT_TRUE((out[0] == contract::CanFrame{id, 2, 0, {static_cast<std::uint8_t>(bits), contract::alarm_byte(alarm)}})) << i;
        ++frames;
      }
      ASSERT_EQ(relay.is_cut(), cut);
      ASSERT_EQ(relay.level(), level);
      ASSERT_EQ(relay.sync_level(), sync_told ? 1 : 0);
    }
  }
  EXPECT_GT(frames, 3000);
  EXPECT_GT(cuts, 300);
}

// H22: the 32 newest stops, the oldest first. A stop is one too many when there are as many for its fault within the window as allowed.
struct StopRule {
  std::deque<StopHistory::Stop> stops;

  bool note(std::uint64_t fault, std::int64_t now_ns, const contract::Params& params) {
    if (stops.size() == 32) stops.pop_front();
    stops.push_back({now_ns, fault});
    std::uint32_t alike = 0;
    for (const StopHistory::Stop& stop : stops) alike += stop.fault == fault && within(stop, now_ns, params) ? 1U : 0U;
    return alike >= params.fault_stops_max;
  }
  bool expire(std::int64_t now_ns, const contract::Params& params) {
    if (stops.empty() || within(stops.front(), now_ns, params)) return false;
    stops.pop_front();
    return true;
  }
  static bool within(const StopHistory::Stop& stop, std::int64_t now_ns, const contract::Params& params) {
    return static_cast<double>(now_ns - stop.time_ns) <= 1e9 * params.fault_stops_window_s;
  }
};

TEST(OutputRules, H22StopsAreCountedByFaultWithinTheWindow) {
  int too_many = 0, expired = 0, full = 0;
  for (unsigned seed = 1; seed <= 150; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
    contract::Params params;
    params.fault_stops_max = 2 + seed % 4;
    params.fault_stops_window_s = seed % 5 == 0 ? 3600 : seed % 2 == 0 ? 60 : 600;
    const auto window_ns = static_cast<std::int64_t>(params.fault_stops_window_s) * 1'000'000'000;
    const std::uint64_t faults = 3 + random() % 28;
    RepeatWatch watch;
    StopRule rule;
    std::int64_t now_ns = 5'000'000'000;
    for (int i = 0; i < 250; ++i) {
      // Never just at the edge of the window.
      now_ns += 1 + static_cast<std::int64_t>(random() % 999'999);
      now_ns += random() % 4 == 0 ? window_ns / one_of(std::array{1, 2, 3, 9}) - one_of(std::array{0, 1'000'000})
                                  : 1'000'000'000 * static_cast<std::int64_t>(1 + random() % 20);
      const auto time_ns = static_cast<std::uint64_t>(now_ns);
      const std::uint64_t what = random() % 60;
      if (what == 0) {  // out of service has been acknowledged
        watch.forget();
        rule.stops.clear();
      } else if (what == 1) {  // the core starts with a history of any bytes
        StopHistory history;
        history.count = one_of(std::array<std::uint64_t, 6>{0, 3, 31, 32, 33, ~std::uint64_t{0}});
        history.out_of_service = random();
        for (std::size_t k = 0; k < history.stops.size(); ++k)
          history.stops[k] = {now_ns - window_ns + static_cast<std::int64_t>(k) * 1'000'000'000 - 1000, random() % faults};
        watch.restore(history);
        rule.stops.assign(history.stops.begin(), history.stops.begin() + static_cast<int>(std::min<std::uint64_t>(history.count, 32)));
      } else if (what < 25) {
        const bool any = rule.expire(now_ns, params);
        ASSERT_EQ(watch.expire(time_ns, params), any) << i;
        expired += any ? 1 : 0;
      } else {
        full += rule.stops.size() == 32 ? 1 : 0;
        const std::uint64_t fault = random() % faults;
        const bool over = rule.note(fault, now_ns, params);
        ASSERT_EQ(watch.note(static_cast<std::uint8_t>(fault), time_ns, params), over) << i;
        too_many += over ? 1 : 0;
      }
      const StopHistory& history = watch.history();
      ASSERT_EQ(history.count, rule.stops.size()) << i;
      ASSERT_EQ(history.out_of_service, 0U);
      for (std::size_t k = 0; k < rule.stops.size(); ++k) {
        ASSERT_EQ(history.stops[k].time_ns, rule.stops[k].time_ns) << i << ", stop " << k;
        ASSERT_EQ(history.stops[k].fault, rule.stops[k].fault) << i << ", stop " << k;
      }
    }
  }
  EXPECT_GT(too_many, 1000);
  EXPECT_GT(expired, 1000);
  EXPECT_GT(full, 300);
}

// What the core has measured, and whether that is a hoist on live drives that moves.
struct Measured {
  Estimate sensed;
  bool gyroscope_sound = true, moves = false;
};

// H2: 0.05 m/s at a wheel that reports, or 4 degrees a second of a chassis that does. A wheel whose motor brakes it with more than 3 A, harder than
// its holding brake could, does not count, nor does one whose drive is off or silent; nor does the turn then, nor that of a gyroscope that has an
// alarm.
std::vector<Measured> all_measured(bool moves) {
  std::vector<Measured> all;
  int cases = 0;
  constexpr std::array kWheels_m_s{0.0, 0.049, -0.049, 0.051, -0.051, 0.2};
  struct Hardware {
    bool left_off = false, right_off = false, left_silent = false, right_silent = false, rates_silent = false;
    double left_a = 0, right_a = 0;
  };
  constexpr std::array<Hardware, 15> kHardware{{{},
                                                {.left_off = true},
                                                {.right_off = true},
                                                {.left_off = true, .right_off = true},
                                                {.left_silent = true},
                                                {.right_silent = true},
                                                {.left_silent = true, .right_silent = true},
                                                {.rates_silent = true},
                                                {.left_silent = true, .rates_silent = true},
                                                {.right_off = true, .rates_silent = true},
                                                {.left_a = -3.1},
                                                {.left_off = true, .left_a = -3.1},
                                                {.right_a = 3.1},
                                                {.left_a = 2.9, .right_a = -2.9},
                                                {.left_a = 3.1, .right_a = -3.1}}};
  for (const Hardware& hardware : kHardware) {
    for (const double turn_deg_s : {0.0, 3.9, -3.9, 4.15, -4.15, 30.0}) {
      ScriptedHoist hoist;
      EXPECT_TRUE(hoist.start(Mode::user));
      hoist.tilt_base.yaw_rate_deg_s = turn_deg_s;
      hoist.step(3);
      hoist.drive_left.fault = hardware.left_off;
      hoist.drive_right.fault = hardware.right_off;
      hoist.drive_left.current_a = hardware.left_a;
      hoist.drive_right.current_a = hardware.right_a;
      hoist.drive_left.silent = hardware.left_silent;
      hoist.drive_right.silent = hardware.right_silent;
      hoist.tilt_base.rates_silent = hardware.rates_silent;
      hoist.step(20);
      const bool live = !(hardware.left_off || hardware.left_silent) || !(hardware.right_off || hardware.right_silent);
      for (const double left_m_s : kWheels_m_s) {
        for (const double right_m_s : kWheels_m_s) {
          Measured one{hoist.state.sensed};
          one.sensed.odometry.wheel_left_m_s = left_m_s;
          one.sensed.odometry.wheel_right_m_s = right_m_s;
          const auto pushed = [](double wheel_m_s, double current_a, bool off) {
            return std::fabs(wheel_m_s) > 0.05 && (off || (std::fabs(current_a) > 3 && wheel_m_s * current_a < 0));
          };
          const bool left_pushed = hardware.left_silent || pushed(left_m_s, hardware.left_a, hardware.left_off),
                     right_pushed = hardware.right_silent || pushed(right_m_s, hardware.right_a, hardware.right_off);
          const bool rolls = (std::fabs(left_m_s) > 0.05 && !left_pushed) || (std::fabs(right_m_s) > 0.05 && !right_pushed);
          one.gyroscope_sound = ++cases % 5 != 0;
          const bool turns = !hardware.rates_silent && one.gyroscope_sound && std::fabs(turn_deg_s) > 4 && !left_pushed && !right_pushed;
          one.moves = live && (rolls || turns);
          if (one.moves == moves) all.push_back(one);
        }
      }
    }
  }
  return all;
}

// Both drives are let go, once, when the hoist has moved for 0.3 s and has been commanded to stand for a second.
TEST(OutputRules, H2AHoistThatMovesOnAfterItsStopIsLetGo) {
  const std::vector<Measured> moving = all_measured(true), standing = all_measured(false);
  const contract::Params params;
  int cuts = 0, held = 0;
  for (unsigned seed = 1; seed <= 400; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
    HoldWatch watch;
    Limiter limiter;
    bool ramps = true, moves = false, cut = false;
    int stands_ms = 0, moves_ms = 0, ramp_left = 0, move_left = 0;
    for (int i = 0; i < 400; ++i) {
      if (ramp_left-- == 0) {
        ramps = !ramps;
        ramp_left = ramps ? one_of(std::array{0, 3}) : one_of(std::array{97, 98, 99, 160, 400});
        if (ramps) {
          limiter.start_from(params, random() % 2 == 0 ? 0.2 : 0.0, 0.1);
        } else {
          limiter.reset();
        }
      }
      if (move_left-- == 0) {
        moves = !moves;
        move_left = moves ? one_of(std::array{10, 27, 28, 28, 29, 35}) : one_of(std::array{0, 3, 60});
      }
      const std::vector<Measured>& all = moves ? moving : standing;
      stands_ms = ramps ? 0 : stands_ms + 10;
      moves_ms = moves ? moves_ms + 10 : 0;
      const bool now = !cut && stands_ms >= 1000 && moves_ms >= 300;
      cut = cut || now;
      const Measured& measured = all[random() % all.size()];
      ASSERT_EQ(watch.step(limiter, measured.sensed, measured.gyroscope_sound), now)
          << i << ": " << stands_ms << " ms, " << moves_ms << " ms";
      ASSERT_EQ(watch.cut(), cut) << i;
    }
    ++(cut ? cuts : held);
  }
  EXPECT_GT(cuts, 100);
  EXPECT_GT(held, 30);
}

}  // namespace
}  // namespace hoist::core::test
