// What the frames of a tilt sensor mean, written a second time from the description of control/core/estimate/tilt_sensor.hpp and
// can_dictionary.def (hazards H4, H6 and H8). Random streams of samples: repeated, invalid, lost, late, smooth and lively ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <initializer_list>
#include <numbers>
#include <optional>
#include <random>
#include <utility>
#include <vector>

#include "control/core/estimate/tilt_sensor.hpp"

namespace hoist::core::test {
namespace {
namespace tilt_rule {

constexpr double kDegree = std::numbers::pi / 180;

contract::CanFrame frame_of(std::array<int, 3> words) {
  contract::CanFrame frame{0x285, 6, 0, {}};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto word = static_cast<std::uint16_t>(words[i]);
    frame.data[2 * i] = static_cast<std::uint8_t>(word % 256);
    frame.data[2 * i + 1] = static_cast<std::uint8_t>(word / 256);
  }
  return frame;
}

struct Sample {
  int alpha, beta;  // 0.001 deg
  std::uint8_t status, counter;
  bool operator==(const Sample&) const = default;
  [[nodiscard]] contract::CanFrame frame() const { return frame_of({alpha, beta, counter * 256 + status}); }
};

// Keeps all samples and works each value out from them anew.
class TiltRule {
 public:
  int fresh = 255, heard = 255, rates_age = 255;  // steps
  int repeated = 0, same_rates = 0;
  std::uint8_t status = 0;
  bool rates_now = false;
  double alpha = 0, beta = 0, alpha_rate = 0, beta_rate = 0;  // rad, rad/s
  std::array<int, 3> rates{};                                 // 0.01 deg/s: yaw, pitch, roll
  double yaw_bias = 0;

  void next_step() {
    for (int* age : {&fresh, &heard, &rates_age}) *age = std::min(*age + 1, 255);
    repeat_seen_ = rates_now = false;
  }

  void take(const Sample& sample, TiltZero zero) {
    heard = 0;
    status = sample.status;
    const bool valid = sample.status % 2 == 1;
    const bool repeats = valid && !samples_.empty() && samples_.back().counter == sample.counter;
    if (!repeats) repeated = 0;
    if (repeats && !std::exchange(repeat_seen_, true)) repeated = std::min(repeated + 1, 255);
    if (!valid || repeats) return;
    fresh = 0;
    alpha = 0.001 * kDegree * sample.alpha - zero.alpha_rad;
    beta = 0.001 * kDegree * sample.beta - zero.beta_rad;
    alpha_rate = beta_rate = 0;
    int after = 0;  // samples since the one before
    if (!samples_.empty()) after = (256 + sample.counter - samples_.back().counter) % 256;
    if (after > 0 && after <= 20) {
      alpha_rate = 0.001 * kDegree * (sample.alpha - samples_.back().alpha) / (0.01 * after);
      beta_rate = 0.001 * kDegree * (sample.beta - samples_.back().beta) / (0.01 * after);
    }
    samples_.push_back(sample);
    row_ = after == 1 ? row_ + 1 : 1;
    if (row_ < 3) return;
    const Sample *last = &samples_.back(), *middle = last - 1, *first = last - 2;
    lively_.push_back(std::abs(last->alpha - 2 * middle->alpha + first->alpha) > 2 ||
                      std::abs(last->beta - 2 * middle->beta + first->beta) > 2);
  }

  void take_rates(std::array<int, 3> sent, double bias) {
    const bool same = known_rates_ && sent[0] == rates[0] && std::abs(sent[1] - rates[1]) <= 1 && std::abs(sent[2] - rates[2]) <= 1;
    if (!same) same_rates = 0;
    if (same && !rates_now) same_rates = std::min(same_rates + 1, 255);
    known_rates_ = rates_now = true;
    rates_age = 0;
    rates = sent;
    yaw_bias = bias;
  }

  [[nodiscard]] int lively() const {
    if (lively_.size() < 30) return -1;
    return static_cast<int>(std::count(lively_.end() - 30, lively_.end(), true));
  }
  [[nodiscard]] std::optional<Sample> last() const { return samples_.empty() ? std::nullopt : std::optional(samples_.back()); }

 private:
  std::vector<Sample> samples_;  // valid and new
  std::vector<bool> lively_;     // of each sample that has two before it in a row
  int row_ = 0;
  bool repeat_seen_ = false, known_rates_ = false;
};

void expect_alike(const TiltSensor& sensor, const TiltRule& rule) {
  ASSERT_EQ(sensor.fresh().age_ticks(), rule.fresh);
  ASSERT_EQ(sensor.heard().age_ticks(), rule.heard);
  ASSERT_EQ(sensor.rates_fresh().age_ticks(), rule.rates_age);
  ASSERT_EQ(sensor.repeated_frames(), rule.repeated);
  ASSERT_EQ(sensor.same_rates(), rule.same_rates);
  ASSERT_EQ(sensor.lively_samples(), rule.lively());
  ASSERT_EQ(sensor.rates_now(), rule.rates_now);
  for (unsigned bit = 1; bit < 256; bit *= 2) ASSERT_EQ(sensor.has(static_cast<std::uint8_t>(bit)), (rule.status / bit) % 2 == 1) << bit;
  ASSERT_NEAR(sensor.alpha_rad(), rule.alpha, 1e-12);
  ASSERT_NEAR(sensor.beta_rad(), rule.beta, 1e-12);
  ASSERT_NEAR(sensor.alpha_rate_rad_s(), rule.alpha_rate, 1e-9);
  ASSERT_NEAR(sensor.beta_rate_rad_s(), rule.beta_rate, 1e-9);
  const auto last = rule.last().value_or(Sample{});
  ASSERT_NEAR(sensor.sent_alpha_rad(), 0.001 * kDegree * last.alpha, 1e-12);
  ASSERT_NEAR(sensor.sent_beta_rad(), 0.001 * kDegree * last.beta, 1e-12);
  ASSERT_NEAR(sensor.sent_yaw_rate_rad_s(), 0.01 * kDegree * rule.rates[0], 1e-12);
  ASSERT_NEAR(sensor.yaw_rate_rad_s(), 0.01 * kDegree * rule.rates[0] - rule.yaw_bias, 1e-12);
  ASSERT_NEAR(sensor.pitch_rate_rad_s(), 0.01 * kDegree * rule.rates[1], 1e-12);
  ASSERT_NEAR(sensor.roll_rate_rad_s(), 0.01 * kDegree * rule.rates[2], 1e-12);
}

// A strut that moves, and its node: an angle bends by so much from sample to sample.
struct Node {
  std::mt19937& random;
  int slope_alpha = 0, slope_beta = 0;
  Sample now{0, 0, 1, 0};

  int one_of(std::initializer_list<int> all) { return all.begin()[random() % all.size()]; }
  void go_on(int& angle, int& slope, int bend) {
    slope += bend;
    if (std::abs(slope) > 150) slope = 0;
    angle += slope;
    if (std::abs(angle) > 30'000) angle = 0;
  }
  void sample(bool lively) {
    const bool alpha = random() % 2 == 0;
    go_on(now.alpha, slope_alpha, lively && alpha ? one_of({-3, 3, 4, 40}) : one_of({-2, -1, 0, 1, 2}));
    go_on(now.beta, slope_beta, lively && !alpha ? one_of({-3, 3, -4, -40}) : one_of({-2, -1, 0, 1, 2}));
    ++now.counter;
  }
};

enum class Stretch { plain, smooth, repeated, invalid, gaps, late, silent, kinds };

TEST(TiltRule, H4H6H8EachFrameIsReadByTheRule) {
  int most_repeats = 0, most_same = 0, oldest = 0, least_lively = 30, most_lively = 0;
  for (unsigned seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    TiltSensor sensor;
    TiltRule rule;
    Node node{random};
    TiltZero zero;
    double bias = 0;
    std::array<int, 3> rates{500, 0, 0};
    // 1, too: a first sample is not the next one of a sensor that has sent none.
    constexpr std::array<std::uint8_t, 7> kFirst{0, 1, 2, 5, 20, 21, 255};
    node.now.counter = kFirst[seed % kFirst.size()];
    bool begun = false;
    for (int stretch = 0; stretch < 20; ++stretch) {
      const auto kind = static_cast<Stretch>(random() % static_cast<unsigned>(Stretch::kinds));
      const int steps = node.one_of({1, 2, 3, 10, 40, 60, 280});
      if (random() % 3 == 0) zero = {0.01 * node.one_of({-3, 0, 2}), 0.01 * node.one_of({-1, 0, 4})};
      if (random() % 3 == 0) bias = 0.01 * node.one_of({-2, 0, 1});
      const bool dead_gyro = random() % 2 == 0;
      for (int i = 0; i < steps; ++i) {
        sensor.next_tick();
        rule.next_step();
        const auto send = [&] {
          sensor.take_angles(node.now.frame(), zero);
          rule.take(node.now, zero);
        };
        const auto sample = [&](bool lively) {
          if (std::exchange(begun, true)) node.sample(lively);
        };
        node.now.status = static_cast<std::uint8_t>(random() | 1U);
        if (kind == Stretch::invalid) node.now.status = static_cast<std::uint8_t>(node.now.status - (random() % 4 == 0 ? 0 : 1));
        if (kind != Stretch::repeated || (steps < 100 && random() % 6 == 0)) sample(kind == Stretch::plain && random() % 3 == 0);
        // A lost frame now and then, or many; more than 20 samples are too many for a rate.
        if (kind == Stretch::gaps)
          for (int lost = node.one_of({0, 0, 0, 1, 2, 17, 18, 19, 20, 21, 100}); lost > 0; --lost) sample(true);
        if (kind != Stretch::silent) send();
        if (kind == Stretch::repeated && random() % 3 == 0) send();
        if (kind == Stretch::late && random() % 2 == 0) {
          if (random() % 2 == 0) sample(random() % 2 == 0);
          send();
        }
        ASSERT_NO_FATAL_FAILURE(expect_alike(sensor, rule)) << stretch << ", " << i;
        if (kind == Stretch::silent && random() % 64 != 0) continue;
        for (int frames = node.one_of({1, 1, 1, 2, 0}) + (dead_gyro ? 1 : 0); frames > 0; --frames) {
          if (!dead_gyro || random() % 100 == 0) rates[random() % 3] += node.one_of({-2, -1, 0, 1, 2});
          if (dead_gyro) rates[1 + random() % 2] += node.one_of({-1, 0, 1});
          sensor.take_rates(frame_of(rates), bias);
          rule.take_rates(rates, bias);
        }
        ASSERT_NO_FATAL_FAILURE(expect_alike(sensor, rule)) << stretch << ", " << i;
        most_repeats = std::max(most_repeats, rule.repeated);
        most_same = std::max(most_same, rule.same_rates);
        if (rule.last()) oldest = std::max(oldest, rule.fresh);
        if (rule.lively() >= 0) least_lively = std::min(least_lively, rule.lively());
        most_lively = std::max(most_lively, rule.lively());
      }
      // The node restarts: nothing is known any more.
      if (random() % 12 != 0) continue;
      sensor.restart();
      rule = TiltRule{};
      begun = false;
      rates[0] += 7;
      node.now.counter = kFirst[random() % kFirst.size()];
      ASSERT_NO_FATAL_FAILURE(expect_alike(sensor, rule));
    }
  }
  // The streams reach all that is counted.
  EXPECT_EQ(most_repeats, 255);
  EXPECT_EQ(most_same, 255);
  EXPECT_EQ(oldest, 255);
  EXPECT_EQ(least_lively, 0);
  EXPECT_GT(most_lively, 10);
}

}  // namespace tilt_rule
}  // namespace
}  // namespace hoist::core::test
