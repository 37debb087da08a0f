// The speed of a motor and the heat of its winding against their rules, written a second time in double from their descriptions
// (firmware/nodes/drive/speed_estimate.hpp and winding.hpp, DECISIONS.md 13 to 15; hazards H2 and H11). Each step must be judged alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>
#include <numeric>
#include <random>

#include "firmware/nodes/drive/speed_estimate.hpp"
#include "firmware/nodes/drive/winding.hpp"

namespace hoist::firmware {
namespace {

// The edge time's speed, within a count of the difference; without an edge at most one count in the time since the last.
class SpeedRule {
 public:
  void begin(std::int32_t at_counts) { *this = SpeedRule(at_counts); }
  SpeedRule() = default;
  explicit SpeedRule(std::int32_t at_counts) : at_counts_(at_counts) {}

  double step(std::int32_t at_counts, std::uint32_t edge_us) {
    const double moved = static_cast<std::int32_t>(static_cast<std::uint32_t>(at_counts) - static_cast<std::uint32_t>(at_counts_));
    at_counts_ = at_counts;
    if (moved == 0) {
      quiet_ms_ = std::min(quiet_ms_ + 1, 10'000);
      if (intervals_us_.empty()) speed_ = 0;
      speed_ = std::clamp(speed_, -1.0 / quiet_ms_, 1.0 / quiet_ms_);
      return speed_;
    }
    const double sense = moved > 0 ? 1 : -1, counted = std::fabs(moved);
    const bool timed = edge_us != 0 && edge_us != 0xFFFFFFFF && counted <= 3;
    const double interval_us = edge_us;
    // Only intervals of one steady motion in which each edge was seen say the same.
    if (!timed || sense != sense_ || counted > 1) intervals_us_.clear();
    if (!intervals_us_.empty() && std::max(interval_us / intervals_us_.back(), intervals_us_.back() / interval_us) > 2)
      intervals_us_.clear();
    sense_ = sense;
    quiet_ms_ = 0;
    speed_ = sense * counted;
    if (!timed) return speed_;
    intervals_us_.push_back(std::min(interval_us, 1e6));
    if (intervals_us_.size() > 4) intervals_us_.pop_front();  // four edges are a line of the encoder
    const double mean_us = std::accumulate(intervals_us_.begin(), intervals_us_.end(), 0.0) / static_cast<double>(intervals_us_.size());
    speed_ = sense * std::clamp(1000 / mean_us, counted - 1, counted + 1);
    return speed_;
  }

 private:
  std::int32_t at_counts_ = 0;
  double speed_ = 0, sense_ = 0;
  int quiet_ms_ = 0;
  std::deque<double> intervals_us_;
};

TEST(DriveRules, H2EachMillisecondOfAnEncoderGivesTheSpeedOfTheRule) {
  constexpr std::uint32_t kUnknown = 0xFFFFFFFF;
  int slow_seen = 0, timed_seen = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
    SpeedEstimate estimate;
    SpeedRule rule;
    std::uint32_t at_counts = seed % 2 == 0 ? 0x7FFFFFF0U : 0xFFFFFFF0U;  // it wraps and passes zero
    estimate.restart(static_cast<std::int32_t>(at_counts));
    rule.begin(static_cast<std::int32_t>(at_counts));
    std::uint32_t sense = 1, interval_us = 1000;
    for (int pass = 0; pass < 150; ++pass) {
      if (random() % 10 == 0) sense = 0U - sense;
      if (random() % 10 == 0) interval_us = one_of(std::array{2U, 400U, 700U, 1000U, 3000U, 20'000U, 400'000U, 700'000U, 1'000'000U});
      if (random() % 40 == 0) {
        at_counts += one_of(std::array{0U, 5U, 1000U});
        estimate.restart(static_cast<std::int32_t>(at_counts));
        rule.begin(static_cast<std::int32_t>(at_counts));
      }
      // Some steps with an edge each, then a pause.
      const int edges = one_of(std::array{1, 1, 2, 3, 5, 9}), quiet = one_of(std::array{0, 0, 1, 2, 3, 20, 1005});
      const std::uint32_t size = random() % 4 != 0 ? 1 : one_of(std::array{1U, 2U, 3U, 4U, 5U, 70U});
      for (int i = 0; i < edges + quiet; ++i) {
        std::uint32_t edge_us = interval_us;
        switch (random() % 12) {
          case 0:
            edge_us = one_of(std::array{0U, 1U, kUnknown, kUnknown, kUnknown - 1, 999'999U, 1'000'001U, 2'000'000U, 2'000'001U});
            break;
          case 1:
            edge_us = 2 * interval_us + random() % 3 - 1;  // twice as long is still one motion
            break;
          case 2:
            edge_us = (interval_us + random() % 3) / 2;
            break;
          case 3:
          case 4:
          case 5:
          case 6:
            edge_us = interval_us - interval_us * (random() % 40) / 100;
            break;
          default:
            break;
        }
        const bool edge = i < edges;
        if (edge) at_counts += sense * (i == 0 ? size : 1);
        const double shown = estimate.step(static_cast<std::int32_t>(at_counts), edge_us);
        const double meant = rule.step(static_cast<std::int32_t>(at_counts), edge_us);
        ASSERT_NEAR(shown, meant, 2e-7 * std::fabs(meant)) << "pass " << pass << ", millisecond " << i << " of " << edges << " + " << quiet;
        slow_seen += meant != 0 && std::fabs(meant) < 0.01 ? 1 : 0;
        timed_seen += edge && std::floor(meant) != meant ? 1 : 0;
      }
    }
  }
  EXPECT_GT(slow_seen, 1000);
  EXPECT_GT(timed_seen, 5000);
}

// A pause of more than ten seconds counts as ten.
TEST(DriveRules, H2AMotorThatStandsForLongIsNearlyStill) {
  SpeedEstimate estimate;
  SpeedRule rule;
  for (const std::int32_t at_counts : {1, 2, 1}) {
    ASSERT_FLOAT_EQ(estimate.step(at_counts, 900'000), static_cast<float>(rule.step(at_counts, 900'000)));
    for (int i = 0; i < 10'010; ++i) {
      const double meant = rule.step(at_counts, 900'000);
      ASSERT_NEAR(estimate.step(at_counts, 900'000), meant, 2e-7 * std::fabs(meant)) << i;
    }
  }
}

// dT/dt = (i^2 R(T) R_th - (T - T_ambient)) / tau, in steps of 10 ms.
class WindingRule {
 public:
  void start(const WindingConfig& config) { *this = WindingRule(config.ambient_c + 50.0); }
  void step(const WindingConfig& config, double current_a) {
    squares_a2_[static_cast<std::size_t>(count_)] = current_a * current_a;
    if (++count_ < 10) return;
    count_ = 0;
    const double mean_a2 = std::accumulate(squares_a2_.begin(), squares_a2_.end(), 0.0) / 10;
    const double loss_w = mean_a2 * config.resistance_ohm * (1 + 0.0039 * (at_c - 25));
    at_c += 0.010 * (loss_w * config.thermal_resistance_k_w - (at_c - config.ambient_c)) / config.time_constant_s;
    at_c = std::isnan(at_c) ? -50 : std::clamp(at_c, -50.0, 1000.0);
  }
  // 30 % of the current at the limit, all of it 15 K below.
  [[nodiscard]] double share(double limit_c) const { return 0.3 + 0.7 * std::clamp((limit_c - at_c) / 15, 0.0, 1.0); }
  [[nodiscard]] bool too_hot(double limit_c) const { return at_c > limit_c + 5; }

  WindingRule() = default;
  explicit WindingRule(double begin_c) : at_c(begin_c) {}
  double at_c = 0;

 private:
  std::array<double, 10> squares_a2_{};
  int count_ = 0;
};

TEST(DriveRules, H11EachMillisecondOfAWindingIsJudgedByTheRule) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kEndless = std::numeric_limits<float>::infinity();
  int folded = 0, hot = 0, coldest = 0, hottest = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto one_of = [&random](const auto& all) { return all[random() % all.size()]; };
    WindingConfig config;
    config.ambient_c = one_of(std::array{-70.0F, 10.0F, 25.0F, 40.0F, 60.0F});
    config.resistance_ohm = one_of(std::array{0.4F, 1.2F, 3.0F});
    config.thermal_resistance_k_w = one_of(std::array{0.6F, 1.3F, 2.5F});
    config.time_constant_s = one_of(std::array{0.2F, 1.0F, 20.0F});
    Winding winding;
    WindingRule rule;
    winding.start(config);
    rule.start(config);
    float current_a = 0;
    for (int i = 0; i < 8000; ++i) {
      if (i % 500 == 0) current_a = one_of(std::array{0.0F, 2.0F, -5.0F, 7.0F, -9.0F, 12.0F, 40.0F});
      if (i % 2000 == 0) config.limit_c = rule.at_c > 0 ? static_cast<float>(rule.at_c) + one_of(std::array{-20.0F, 2.0F, 20.0F}) : 120;
      const bool odd = random() % 4000 == 0;
      const float now_a = odd ? one_of(std::array{kNan, kEndless, 1e15F}) : current_a * (1.0F - 0.01F * static_cast<float>(random() % 20));
      winding.step_1ms(config, now_a);
      rule.step(config, now_a);
      if (random() % 3001 == 0) {  // also between two steps of the model
        winding.start(config);
        rule.start(config);
      }
      ASSERT_NEAR(winding.temperature_c(), rule.at_c, 0.02) << "millisecond " << i;
      ASSERT_NEAR(winding.current_share(config), rule.share(config.limit_c), 0.002) << "millisecond " << i;
      // Apart by what two ways to add up may differ.
      if (std::fabs(rule.at_c - config.limit_c - 5) > 0.02) {
        ASSERT_EQ(winding.too_hot(config), rule.too_hot(config.limit_c)) << "millisecond " << i;
      }
      folded += rule.share(config.limit_c) < 1 && rule.share(config.limit_c) > 0.3 ? 1 : 0;
      hot += rule.too_hot(config.limit_c) ? 1 : 0;
      coldest += rule.at_c == -50 ? 1 : 0;
      hottest += rule.at_c == 1000 ? 1 : 0;
    }
  }
  EXPECT_GT(folded, 10'000);
  EXPECT_GT(hot, 10'000);
  EXPECT_GT(coldest, 1000);
  EXPECT_GT(hottest, 1000);
}

}  // namespace
}  // namespace hoist::firmware
