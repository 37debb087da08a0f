// Ages of readings, the input node, the edges of its synchronisation input, and which node fills what: written a second time from the
// descriptions of control/core/estimate (freshness.hpp, io_sensor.hpp, sync_edges.hpp, estimate.hpp) and can_dictionary.def.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <random>

#include "control/core/estimate/estimate.hpp"
#include "control/core/estimate/sync_edges.hpp"

namespace hoist::core::test {
namespace {
namespace nodes_rule {

// H3, H4, H14: stale after 30 ms, lost after 50 ms; never heard is as old as can be.
TEST(FreshnessRule, H3H4H14AnAgeIsCountedInSteps) {
  for (const int last : {0, 1, 2, 3, 4, 5, 6, 100, 254, 255, 256, 600}) {
    Freshness fresh;
    EXPECT_EQ(fresh.age_ticks(), 255);
    EXPECT_TRUE(fresh.lost());
    fresh.next_tick();
    fresh.renew();
    for (int step = 0; step < last; ++step) fresh.next_tick();
    EXPECT_EQ(fresh.age_ticks(), std::min(last, 255));
    EXPECT_EQ(fresh.now(), last == 0) << last;
    EXPECT_EQ(fresh.stale(), last * 10 >= 30) << last;
    EXPECT_EQ(fresh.lost(), last * 10 >= 50) << last;
    fresh.forget();
    EXPECT_EQ(fresh.age_ticks(), 255);
  }
}

// After twenty edges in a row one in 50 steps: each edge told costs 50 steps of rest, and 1000 may be owed.
TEST(SyncEdgesRule, ALineThatNeverRestsDoesNotFillTheLog) {
  int held_back = 0, told = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    SyncEdges edges;
    bool before = seed % 2 == 0, level = before;
    ASSERT_FALSE(edges.changes(level)) << "where the line begins is no edge";
    int owed = 0, busy = 1;
    for (int i = 0; i < 3000; ++i) {
      if (random() % 200 == 0) busy = std::array{1, 2, 5, 60, 1000}[random() % 5];
      if (random() % static_cast<unsigned>(busy) == 0) level = !level;
      owed = std::max(owed - 1, 0);
      const bool edge = level != before, tell = edge && owed + 50 <= 1000;
      before = level;
      ASSERT_EQ(edges.changes(level), tell) << i;
      if (tell) owed += 50;
      told += tell;
      held_back += edge && !tell;
    }
  }
  EXPECT_GT(told, 3000);
  EXPECT_GT(held_back, 3000);
}

contract::CanFrame inputs(std::uint8_t bumpers, std::uint8_t switches) { return {0x188, 2, 0, {bumpers, switches}}; }
contract::CanFrame batteries(std::int16_t a_10mv, std::int16_t b_10mv) {
  const auto a = static_cast<std::uint16_t>(a_10mv), b = static_cast<std::uint16_t>(b_10mv);
  const auto byte = [](int value) { return static_cast<std::uint8_t>(value); };
  return {0x288, 8, 0, {byte(a % 256), byte(a / 256), byte(b % 256), byte(b / 256), 7, 7, 7, 7}};
}

TEST(IoRule, H12H13H14TheInputNodesFramesAreReadByTheRule) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    IoSensor io;
    int age = 255, battery_age = 255;
    unsigned bumpers = 0, switches = 0;
    double a_v = 0, b_v = 0;
    bool known = false;
    for (int i = 0; i < 500; ++i) {
      io.next_tick();
      age = std::min(age + 1, 255);
      battery_age = std::min(battery_age + 1, 255);
      if (random() % 3 != 0) {
        bumpers = random() % 256, switches = random() % 256, age = 0;
        io.take_inputs(inputs(static_cast<std::uint8_t>(bumpers), static_cast<std::uint8_t>(switches)));
      }
      if (random() % 20 == 0 && i % 300 < 40) {
        const auto a = static_cast<std::int16_t>(random()), b = static_cast<std::int16_t>(random());
        io.take_batteries(batteries(a, b));
        a_v = 0.01 * a, b_v = 0.01 * b, battery_age = 0, known = true;
      }
      if (random() % 150 == 0) {
        io.restart();
        age = battery_age = 255, bumpers = switches = 0, a_v = b_v = 0, known = false;
      }
      ASSERT_EQ(io.fresh().age_ticks(), age) << i;
      ASSERT_EQ(io.bumpers(), bumpers % 16) << i;
      ASSERT_EQ(io.switches(), switches) << i;
      ASSERT_EQ(io.emergency_stop_open(), switches % 2 == 1) << i;
      ASSERT_EQ(io.sync_input(), switches / 4 % 2 == 1) << i;
      ASSERT_EQ(io.battery_known(), known) << i;
      ASSERT_EQ(io.battery_now(), battery_age == 0) << i;
      for (const int ticks : {0, 1, 20, 100, 255, 256}) ASSERT_EQ(io.battery_silent(ticks), known && battery_age >= ticks) << i;
      ASSERT_NEAR(io.battery_a_v(), a_v, 1e-9) << i;
      ASSERT_NEAR(io.battery_b_v(), b_v, 1e-9) << i;
    }
  }
}

// Each node's messages keep alive that node alone, its restart forgets that node alone, and the core is no node that it could hear.
TEST(EstimateRule, H3H4H14EachNodeHasItsOwnSensor) {
  using contract::Node;
  const std::array nodes{Node::drive_left, Node::drive_right, Node::io, Node::tilt_left, Node::tilt_right, Node::tilt_base};
  std::array<int, 6> ages{};
  ages.fill(255);
  std::array<int, 6> valid_ages = ages;
  Estimate sensed;
  std::mt19937 random(1);
  std::uint8_t counter = 0;
  const auto tilt_frame = [&](int alpha, int beta, int status) {
    contract::CanFrame frame{0x185, 6, 0, {}};
    for (std::size_t i = 0; i < 2; ++i) {
      const auto word = static_cast<std::uint16_t>(i == 0 ? alpha : beta);
      frame.data[2 * i] = static_cast<std::uint8_t>(word % 256);
      frame.data[2 * i + 1] = static_cast<std::uint8_t>(word / 256);
    }
    frame.data[4] = static_cast<std::uint8_t>(status);
    frame.data[5] = counter;
    return frame;
  };
  std::array<std::array<int, 2>, 3> angles{};  // 0.001 deg
  std::array<int, 6> quiet{};                  // steps without a message still to come
  const std::array<TiltSensor*, 3> tilts{&sensed.left_strut, &sensed.right_strut, &sensed.base};
  for (int i = 0; i < 5000; ++i) {
    const auto ticks = static_cast<std::uint32_t>(1 + (random() % 10 == 0 ? 2 : 0));
    sensed.next_tick(ticks);
    ++counter;
    for (std::size_t node = 0; node < nodes.size(); ++node) {
      ages[node] = std::min(ages[node] + 1, 255);
      valid_ages[node] = std::min(valid_ages[node] + 1, 255);
      if (quiet[node] == 0 && random() % 40 == 0) quiet[node] = 2 + static_cast<int>(random() % 6);
      if (quiet[node] > 0 && --quiet[node] >= 0) continue;
      ages[node] = 0;
      if (node < 2) {
        const contract::CanFrame frame{0x181, 8, 0, {}};
        ASSERT_TRUE((node == 0 ? sensed.left_drive : sensed.right_drive).take_state(frame, 1e6));
      } else if (node == 2) {
        sensed.io.take_inputs(inputs(0, 0));
      } else {
        // An invalid sample tells that the node lives, and nothing else.
        const bool valid = random() % 4 != 0;
        const std::array<int, 2> now{static_cast<int>(random() % 20'000) - 10'000, static_cast<int>(random() % 20'000) - 10'000};
        tilts[node - 3]->take_angles(tilt_frame(now[0], now[1], valid ? 1 : 0));
        if (valid) angles[node - 3] = now, valid_ages[node] = 0;
      }
    }
    for (std::size_t node = 0; node < nodes.size(); ++node)
      ASSERT_EQ(sensed.heard(nodes[node]).age_ticks(), ages[node]) << i << ", " << node;
    ASSERT_EQ(sensed.heard(Node::core).age_ticks(), 255);
    const auto oldest_tilt = *std::max_element(valid_ages.begin() + 3, valid_ages.end());
    ASSERT_EQ(sensed.tilts_stale(), oldest_tilt >= 3) << i;
    ASSERT_EQ(sensed.tilts_lost(), oldest_tilt >= 5) << i;
    ASSERT_EQ(sensed.drives_lost(), std::max(ages[0], ages[1]) >= 5) << i;
    ASSERT_EQ(sensed.left_drive.sync_ticks(), ticks) << i;
    ASSERT_EQ(sensed.right_drive.sync_ticks(), ticks) << i;
    // A push of the chassis tilts all three alike and cancels.
    constexpr double kUnit = 0.001 * 3.14159265358979323846 / 180;
    const law::StrutAngles<double> struts = sensed.relative();
    ASSERT_NEAR(struts.alpha_left_rad, kUnit * (angles[0][0] - angles[2][0]), 1e-12) << i;
    ASSERT_NEAR(struts.alpha_right_rad, kUnit * (angles[1][0] - angles[2][0]), 1e-12) << i;
    ASSERT_NEAR(struts.beta_left_rad, kUnit * (angles[0][1] - angles[2][1]), 1e-12) << i;
    ASSERT_NEAR(struts.beta_right_rad, kUnit * (angles[1][1] - angles[2][1]), 1e-12) << i;
    if (i % 7 == 0) sensed.restart(Node::core);
    if (random() % 25 != 0) continue;
    const std::size_t node = random() % nodes.size();
    sensed.restart(nodes[node]);
    ages[node] = valid_ages[node] = 255;
    if (node >= 3) angles[node - 3] = {};
    ASSERT_EQ(sensed.heard(nodes[node]).age_ticks(), 255);
  }
}

}  // namespace nodes_rule
}  // namespace
}  // namespace hoist::core::test
