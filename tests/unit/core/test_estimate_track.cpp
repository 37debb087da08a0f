// The track that the gyroscope corrects against its rule, written a second time from the descriptions of
// control/core/estimate/fused_odometry.hpp and decisions 18, 40, 66 and 91 (H10): random walks with slips, biases that wander and jump, lost
// messages, left-out steps and new calibrations. Each step must be tracked alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <initializer_list>
#include <numbers>
#include <random>

#include "control/contract/can_dictionary.hpp"
#include "control/core/estimate/estimate.hpp"
#include "control/core/types.hpp"

namespace hoist::core::test {
namespace {
namespace track_rule {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double square(double value) { return value * value; }

struct Step {
  double way_m, turn_rad, wheel_rad_s;  // of the encoders
  bool gyro;
  double gyro_rad_s, calibrated_rad_s;
  int ticks;  // between the newest two SYNCs
  bool stands;
};

class TrackRule {
 public:
  double x_m = 0, y_m = 0, psi_rad = 0, yaw_rad_s = 0, bias_rad_s = 0, slip_rad_s = 0;
  bool used = false, slips = false;
  int taught = 0, clamped = 0, ended = 0;  // how often a rule came true

  void step(const Step& now) {
    stood_ = now.stands ? stood_ + 1 : 0;
    const double before_rad = kept_rad_ + gap_rad_;
    if (now.gyro) {
      // A new calibration takes its own part of the bias away, whenever it came.
      if (known_) bias_rad_s -= now.calibrated_rad_s - calibrated_rad_s_;
      calibrated_rad_s_ = now.calibrated_rad_s;
      known_ = true;
      watch(now);
    } else {
      if (used) agree();
      slip_rad_s = 0;
      yaw_rad_s = now.wheel_rad_s;
    }
    used = now.gyro;
    const double turn_rad = now.turn_rad + kept_rad_ + gap_rad_ - before_rad;
    x_m += now.way_m * std::cos(psi_rad + turn_rad / 2);
    y_m += now.way_m * std::sin(psi_rad + turn_rad / 2);
    psi_rad += turn_rad;
  }
  // From noticing to the last sign.
  [[nodiscard]] int slip_steps() const { return slip_steps_ - quiet_steps_; }

 private:
  void watch(const Step& now) {
    if (now.ticks <= 4) predict(now, 0.01 * now.ticks);
    const double true_rad_s = now.gyro_rad_s - bias_rad_s;
    if (now.ticks == 1) slip_rad_s += (now.wheel_rad_s - true_rad_s - slip_rad_s) * 0.01 / 0.05;
    judge(std::abs(now.wheel_rad_s));
    yaw_rad_s = slips ? true_rad_s : now.wheel_rad_s;
    if (!slips) {
      given_rad_ *= 1 - 0.01 / 0.3;
      correct(std::abs(now.wheel_rad_s) <= 5 * kDegree);
    } else if (stood_ >= 300 && std::abs(now.gyro_rad_s) <= 3 * kDegree) {
      // Who stands for three seconds does not turn: a new bias.
      ++taught;
      clamped += std::abs(bias_rad_s - slip_rad_s) > 3 * kDegree;
      bias_rad_s = std::clamp(bias_rad_s - slip_rad_s, -3 * kDegree, 3 * kDegree);
      gap_rad_ = slip_rad_s = 0;
      agree();
      bias_var_ = square(0.0175);
    }
  }
  // Noise of the gyroscope's class: 0.01 degrees per root second; its bias wanders by 0.001 degrees/s, at rest it may be learnt within two seconds.
  void predict(const Step& now, double span_s) {
    gap_rad_ += (now.gyro_rad_s - bias_rad_s) * span_s - now.turn_rad;
    gap_var_ += span_s * (span_s * bias_var_ - 2 * both_var_) + square(0.01 * kDegree) * span_s;
    both_var_ -= span_s * bias_var_;
    bias_var_ += (stood_ >= 50 ? 30 : 1) * square(0.001 * kDegree) * span_s;
  }
  void judge(double wheel_rad_s) {
    remembered_rad_s_ += (wheel_rad_s - remembered_rad_s_) * 0.01 / 0.3;
    const double turning_rad_s = std::max(wheel_rad_s, remembered_rad_s_);
    if (slips) {
      slip_steps_ = std::min(slip_steps_ + 1, 65'535);
      const bool quiet = std::abs(slip_rad_s) < 2 * kDegree + 0.05 * turning_rad_s;
      quiet_steps_ = quiet ? quiet_steps_ + 1 : 0;
      ended += quiet_steps_ == 20;
      if (quiet_steps_ == 20) agree();
    } else if (std::abs(gap_rad_) > kDegree + (0.04 * 0.5 + 0.01) * turning_rad_s) {
      slips = true;
      slip_steps_ = 1;
      gap_rad_ += given_rad_;  // taken back
    }
  }
  // The encoders say that there is no gap.
  void correct(bool straight) {
    const double noise = square((stood_ >= 50 ? 0.012 : 0.06) * kDegree);
    const double gap_gain = gap_var_ / (gap_var_ + noise), bias_gain = straight ? both_var_ / (gap_var_ + noise) : 0;
    const double told_rad = gap_rad_;
    gap_rad_ -= gap_gain * told_rad;
    given_rad_ += gap_gain * told_rad;
    const double learnt_rad_s = bias_rad_s - bias_gain * told_rad;
    clamped += std::abs(learnt_rad_s) > 3 * kDegree;
    bias_rad_s = std::clamp(learnt_rad_s, -3 * kDegree, 3 * kDegree);
    bias_var_ -= bias_gain * both_var_;
    both_var_ *= 1 - gap_gain;
    gap_var_ *= 1 - gap_gain;
  }
  // Their difference becomes part of the track.
  void agree() {
    kept_rad_ += gap_rad_;
    gap_rad_ = given_rad_ = 0;
    gap_var_ = square(0.06 * kDegree);
    both_var_ = 0;
    slips = false;
    slip_steps_ = quiet_steps_ = 0;
  }

  double kept_rad_ = 0, gap_rad_ = 0, given_rad_ = 0, calibrated_rad_s_ = 0, remembered_rad_s_ = 0;
  double gap_var_ = 0, both_var_ = 0, bias_var_ = square(0.0175);
  int stood_ = 0, slip_steps_ = 0, quiet_steps_ = 0;
  bool known_ = false;
};

// Encoders and gyroscope of a hoist, as frames.
struct Hoist {
  contract::Params params;
  Derived derived = derive(params);
  Estimate sensed;
  TrackRule rule;
  double left_m = 0, right_m = 0;
  std::uint8_t counter = 0;

  struct Sent {
    bool angles = true, valid = true, rates = true, left = true, right = true;
  };
  void step(double speed_m_s, double wheels_deg_s, double gyro_deg_s, const Sent& sent, std::uint32_t ticks = 1) {
    using contract::Pdo;
    const double half_m_s = wheels_deg_s * kDegree * params.track_width_m / 2;
    left_m += (speed_m_s - half_m_s) * kTick_s * ticks;
    right_m += (speed_m_s + half_m_s) * kTick_s * ticks;
    counter = static_cast<std::uint8_t>(counter + ticks);
    sensed.next_tick(ticks);
    contract::CanFrame angles{0x187, 6, 0, {}}, rates{0x287, 6, 0, {}};
    contract::write_slot(angles, contract::pdo_slot(Pdo::tilt_tx1, 0x2120), sent.valid ? 3 : 2);
    contract::write_slot(angles, contract::pdo_slot(Pdo::tilt_tx1, 0x2121), counter);
    contract::write_slot(rates, contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 1), std::lround(gyro_deg_s * 100));
    if (sent.angles) sensed.base.take_angles(angles);
    if (sent.rates) sensed.base.take_rates(rates, derived.base_yaw_bias_rad_s);
    if (sent.left) take(sensed.left_drive, left_m / derived.odometry.left_m_per_count);
    if (sent.right) take(sensed.right_drive, right_m / derived.odometry.right_m_per_count);
    sensed.odometry.update(sensed.left_drive, sensed.right_drive, derived, kTick_s);
    sensed.fused.update(sensed.odometry, sensed.left_drive, sensed.right_drive, sensed.base, derived, kTick_s);
    const int left_counts = sensed.left_drive.moved_counts(), right_counts = sensed.right_drive.moved_counts();
    const double left_way_m = left_counts * derived.odometry.left_m_per_count,
                 right_way_m = right_counts * derived.odometry.right_m_per_count;
    rule.step({(left_way_m + right_way_m) / 2, (right_way_m - left_way_m) / params.track_width_m, sensed.odometry.yaw_rate_rad_s,
               sensed.base.rates_fresh().age_ticks() < 5 && sensed.base.fresh().age_ticks() < 5, sensed.base.yaw_rate_rad_s(),
               derived.base_yaw_bias_rad_s, static_cast<int>(ticks), left_counts == 0 && right_counts == 0 && !sensed.drives_lost()});
  }
  void take(DriveSensor& drive, double counts) {
    contract::CanFrame frame{0x181, 8, 0, {}};
    contract::write_slot(frame, contract::pdo_slot(contract::Pdo::drive_tx1, 0x6064), std::llround(counts));
    EXPECT_TRUE(drive.take_state(frame, 1e9));
  }
  void expect_alike() const {
    const FusedOdometry& fused = sensed.fused;
    ASSERT_EQ(fused.slipping(), rule.slips);
    ASSERT_EQ(fused.slip_ticks(), rule.slip_steps());
    ASSERT_EQ(fused.gyro_used(), rule.used);
    ASSERT_NEAR(fused.gyro_bias_rad_s(), rule.bias_rad_s, 1e-11);
    ASSERT_NEAR(fused.slip_rate_rad_s(), rule.slip_rad_s, 1e-11);
    ASSERT_NEAR(fused.yaw_rate_rad_s(), rule.yaw_rad_s, 1e-11);
    ASSERT_NEAR(fused.pose().psi_rad, rule.psi_rad, 1e-11);
    ASSERT_NEAR(fused.pose().x_m, rule.x_m, 1e-10);
    ASSERT_NEAR(fused.pose().y_m, rule.y_m, 1e-10);
  }
};

TEST(TrackRule, H10EachStepIsTrackedByTheRule) {
  int taught = 0, clamped = 0, ended = 0;
  std::array<int, 2> slipped{}, used{};
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const auto one_of = [&random](std::initializer_list<double> all) { return all.begin()[random() % all.size()]; };
    Hoist hoist;
    double bias_deg_s = one_of({0, 0.3, -0.8}), drift_deg_s = 0;
    for (int stretch = 0; stretch < 12; ++stretch) {
      // Some hoists get a new bias while they drive, and then rest.
      const bool jumps = seed % 4 == 0 && stretch % 2 == 1, rests = seed % 4 == 0 && !jumps;
      const bool stands = rests || (!jumps && random() % 2 == 0);
      const double speed_m_s = stands ? 0 : one_of({0.2, 0.4, -0.1}), turn_deg_s = stands ? 0 : one_of({0, 0, 4.8, 5.2, -5.5, 20, -45});
      const double slip_deg_s = random() % 2 == 0 ? 0 : one_of({1.5, 3, -6, 8, 15, -40});
      const int slip_from = static_cast<int>(random() % 60), slip_to = slip_from + static_cast<int>(one_of({10, 20, 60, 200, 1000}));
      if (!rests && random() % 2 == 0) bias_deg_s = one_of({0.2, -1.2, 2.5, -2.6, 3.02, -3.02, 3.5});
      if (jumps) bias_deg_s = std::abs(bias_deg_s) > 2 ? 0 : one_of({2.5, 3.02, -3.02});
      drift_deg_s = random() % 4 == 0 ? one_of({0.002, -0.002, 0.004}) * (rests ? 0 : 1) : 0;
      if (!rests && random() % 4 == 0) {
        hoist.params.base_yaw_bias_rad_s = one_of({0, 0.5, -1}) * kDegree;
        hoist.derived = derive(hoist.params);
      }
      if (random() % 8 == 0) {
        // Somewhere else; what is known about gyroscope and slip stays.
        hoist.sensed.fused.set_pose({1, -2, 0.5});
        hoist.rule.x_m = 1, hoist.rule.y_m = -2, hoist.rule.psi_rad = 0.5;
      }
      const int lost = rests ? 0 : static_cast<int>(random() % 7);  // what is lost now and then
      const int long_loss = static_cast<int>(one_of({2, 4, 5, 9, 60}));
      for (int i = 0, steps = rests ? 400 : static_cast<int>(one_of({60, 150, 400})); i < steps; ++i) {
        const double noise_deg_s = 0.17 * (static_cast<double>(random() % 2001) / 1000 - 1);
        const double slip_now_deg_s = i >= slip_from && i < slip_to && !stands ? slip_deg_s : 0;
        bias_deg_s = std::clamp(bias_deg_s + drift_deg_s, -4.0, 4.0);
        const bool gone = i % 50 < long_loss;
        const Hoist::Sent sent{lost != 1 || !gone, lost != 2 || !gone, lost != 3 || !gone, lost != 4 || !gone, lost != 5 || !gone};
        const auto ticks = lost == 6 && random() % 20 == 0 ? static_cast<std::uint32_t>(one_of({2, 3, 4, 5, 8})) : 1U;
        hoist.step(speed_m_s, turn_deg_s, turn_deg_s + slip_now_deg_s + bias_deg_s + noise_deg_s, sent, ticks);
        ASSERT_NO_FATAL_FAILURE(hoist.expect_alike()) << stretch << ", " << i;
        ++slipped[hoist.rule.slips ? 1 : 0];
        ++used[hoist.rule.used ? 1 : 0];
      }
    }
    taught += hoist.rule.taught;
    clamped += hoist.rule.clamped;
    ended += hoist.rule.ended;
  }
  EXPECT_GT(slipped[0], 10'000);
  EXPECT_GT(slipped[1], 10'000);
  EXPECT_GT(used[0], 50);
  EXPECT_GT(taught, 20);
  EXPECT_GT(clamped, 1000);
  EXPECT_GT(ended, 20);
}

TEST(TrackRule, H10ASlipOfElevenMinutesStaysASlip) {
  Hoist hoist;
  for (int i = 0; i < 300; ++i) hoist.step(0, 0, 0, {});
  for (int i = 0; i < 65'700; ++i) hoist.step(0, 20, 0, {});
  ASSERT_NO_FATAL_FAILURE(hoist.expect_alike());
  EXPECT_EQ(hoist.sensed.fused.slip_ticks(), 65'535);
  EXPECT_TRUE(hoist.sensed.slipping());
}

}  // namespace track_rule
}  // namespace
}  // namespace hoist::core::test
