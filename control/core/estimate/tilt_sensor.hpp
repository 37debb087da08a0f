// One tilt sensor (left strut, right strut or chassis): TPDO1 with angles, status and sample counter, TPDO2 with rates.
#pragma once
#include <array>
#include <bit>
#include <cstdint>
#include <numbers>

#include "control/contract/can_dictionary.hpp"
#include "control/core/base/derived.hpp"
#include "control/core/estimate/freshness.hpp"

namespace hoist::core {

/// Bits of 2120h.
namespace tilt_status {
inline constexpr std::uint8_t kValid = 1, kConverged = 2, kAccelerationOutOfRange = 4, kGyroSaturated = 8, kSelfTestFailed = 16;
}

class TiltSensor {
 public:
  void next_tick() noexcept {
    fresh_.next_tick();
    heard_.next_tick();
    rates_fresh_.next_tick();
    repeat_counted_ = false;
    rates_counted_ = false;
  }

  void take_angles(const contract::CanFrame& frame, TiltZero zero = {}) noexcept {
    using contract::Pdo;
    constexpr auto kAlpha = contract::pdo_slot(Pdo::tilt_tx1, 0x6010), kBeta = contract::pdo_slot(Pdo::tilt_tx1, 0x6020);
    constexpr auto kStatus = contract::pdo_slot(Pdo::tilt_tx1, 0x2120), kCounter = contract::pdo_slot(Pdo::tilt_tx1, 0x2121);
    const auto counter = static_cast<std::uint8_t>(contract::read_slot(frame, kCounter));
    const auto status = static_cast<std::uint8_t>(contract::read_slot(frame, kStatus));
    const auto steps = static_cast<std::uint8_t>(counter - counter_);
    heard_.renew();
    status_ = status;
    if ((status & tilt_status::kValid) == 0) {
      // The node itself marks the sample invalid (H8): a counter that stands then does not mean a frozen sensor.
      repeated_frames_ = 0;
      return;
    }
    // A repeated sample is not fresh: the bus controller of a hung processor may repeat its last frame (H6). Checked
    // once a step at most: frames that a serial line delayed and delivers together would answer SYNCs too close to each
    // other.
    if (known_ && steps == 0) {
      if (!repeat_counted_ && repeated_frames_ < kOldestTicks) ++repeated_frames_;
      repeat_counted_ = true;
      return;
    }
    repeated_frames_ = 0;
    counter_ = counter;
    judge_liveliness(
        {static_cast<std::int32_t>(contract::read_slot(frame, kAlpha)), static_cast<std::int32_t>(contract::read_slot(frame, kBeta))},
        known_ && steps == 1);
    const double alpha_rad = static_cast<double>(contract::read_slot(frame, kAlpha)) * (kAlpha.scale * kRadPerDeg);
    const double beta_rad = static_cast<double>(contract::read_slot(frame, kBeta)) * (kBeta.scale * kRadPerDeg);
    // Rates come from angles as sent: a new zero is no movement. The sensor's own counter tells how much time lies between two samples,
    // whatever the bus did to the frames.
    if (known_ && steps <= kRateGapSteps) {
      const double span_s = static_cast<double>(steps) * kSample_s;
      alpha_rate_rad_s_ = (alpha_rad - sent_alpha_rad_) / span_s;
      beta_rate_rad_s_ = (beta_rad - sent_beta_rad_) / span_s;
    } else {
      alpha_rate_rad_s_ = 0;
      beta_rate_rad_s_ = 0;
    }
    known_ = true;
    sent_alpha_rad_ = alpha_rad;
    sent_beta_rad_ = beta_rad;
    alpha_rad_ = alpha_rad - zero.alpha_rad;
    beta_rad_ = beta_rad - zero.beta_rad;
    fresh_.renew();
  }

  void take_rates(const contract::CanFrame& frame, double yaw_bias_rad_s = 0) noexcept {
    using contract::Pdo;
    constexpr auto kYaw = contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 1), kPitch = contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 2),
                   kRoll = contract::pdo_slot(Pdo::tilt_tx2, 0x2110, 3);
    const std::array<std::int32_t, 3> raw = {static_cast<std::int32_t>(contract::read_slot(frame, kYaw)),
                                             static_cast<std::int32_t>(contract::read_slot(frame, kPitch)),
                                             static_cast<std::int32_t>(contract::read_slot(frame, kRoll))};
    // Yaw is as measured; pitch and roll are without the bias that the filter goes on learning, which moves them by a digit now and then.
    const auto near = [&](std::size_t i) { return raw[i] - raw_rates_[i] <= 1 && raw_rates_[i] - raw[i] <= 1; };
    if (raw[0] != raw_rates_[0] || !near(1) || !near(2)) {
      same_rates_ = 0;
    } else if (!rates_counted_ && same_rates_ < kOldestTicks) {
      ++same_rates_;  // once a step: frames that arrive together prove nothing
    }
    rates_counted_ = true;
    rates_fresh_.renew();
    raw_rates_ = raw;
    sent_yaw_rate_rad_s_ = static_cast<double>(contract::read_slot(frame, kYaw)) * (kYaw.scale * kRadPerDeg);
    yaw_rate_rad_s_ = sent_yaw_rate_rad_s_ - yaw_bias_rad_s;
    pitch_rate_rad_s_ = static_cast<double>(contract::read_slot(frame, kPitch)) * (kPitch.scale * kRadPerDeg);
    roll_rate_rad_s_ = static_cast<double>(contract::read_slot(frame, kRoll)) * (kRoll.scale * kRadPerDeg);
  }

  /// The node reported a restart: its counter and its filter begin again.
  void restart() noexcept { *this = TiltSensor{}; }

  /// A valid sample that was new. `heard` also counts repeated and invalid ones: the node lives.
  [[nodiscard]] const Freshness& fresh() const noexcept { return fresh_; }
  [[nodiscard]] const Freshness& heard() const noexcept { return heard_; }
  /// The message with the rates.
  [[nodiscard]] const Freshness& rates_fresh() const noexcept { return rates_fresh_; }
  /// With the calibrated zero taken off.
  [[nodiscard]] double alpha_rad() const noexcept { return alpha_rad_; }
  [[nodiscard]] double beta_rad() const noexcept { return beta_rad_; }
  /// As the sensor sent them.
  [[nodiscard]] double sent_alpha_rad() const noexcept { return sent_alpha_rad_; }
  [[nodiscard]] double sent_beta_rad() const noexcept { return sent_beta_rad_; }
  /// From the difference of the last two samples.
  [[nodiscard]] double alpha_rate_rad_s() const noexcept { return alpha_rate_rad_s_; }
  [[nodiscard]] double beta_rate_rad_s() const noexcept { return beta_rate_rad_s_; }
  /// Less the calibrated rate at rest (chassis only; the struts' is not calibrated).
  [[nodiscard]] double yaw_rate_rad_s() const noexcept { return yaw_rate_rad_s_; }
  [[nodiscard]] double sent_yaw_rate_rad_s() const noexcept { return sent_yaw_rate_rad_s_; }
  [[nodiscard]] double pitch_rate_rad_s() const noexcept { return pitch_rate_rad_s_; }
  [[nodiscard]] double roll_rate_rad_s() const noexcept { return roll_rate_rad_s_; }
  /// The three rates came in this step.
  [[nodiscard]] bool rates_now() const noexcept { return rates_counted_; }
  [[nodiscard]] bool has(std::uint8_t status_bit) const noexcept { return (status_ & status_bit) != 0; }
  /// Steps in a row that brought only the sample known already.
  [[nodiscard]] std::uint8_t repeated_frames() const noexcept { return repeated_frames_; }

  /// Of the last kLivelySamples samples, those in which an angle changed its course by more than rounding does; -1 until so many are known.
  [[nodiscard]] int lively_samples() const noexcept {
    return judged_samples_ < kLivelySamples ? -1 : std::popcount(lively_ & ((1U << kLivelySamples) - 1U));
  }
  /// Steps in a row whose message brought the very same turn rate, and pitch and roll rates within a digit.
  [[nodiscard]] std::uint8_t same_rates() const noexcept { return same_rates_; }
  static constexpr int kLivelySamples = 30;

 private:
  struct RawAngles {
    std::int32_t alpha = 0, beta = 0;
  };
  // The second difference of rounded values that lie on a smooth curve is two steps at most: half a step of rounding, weighted 1, 2, 1.
  static constexpr std::int32_t kRoundingSteps = 2;

  void judge_liveliness(RawAngles now, bool next_sample) noexcept {
    const RawAngles step{now.alpha - raw_.alpha, now.beta - raw_.beta};
    raw_ = now;
    // Only three samples in a row have a second difference; a lost frame says nothing.
    steps_in_row_ = !next_sample ? std::uint8_t{0} : static_cast<std::uint8_t>(steps_in_row_ < 2 ? steps_in_row_ + 1 : 2);
    const RawAngles bend{step.alpha - raw_step_.alpha, step.beta - raw_step_.beta};
    raw_step_ = step;
    if (steps_in_row_ < 2) return;
    const auto bends = [](std::int32_t by) { return by > kRoundingSteps || by < -kRoundingSteps; };
    lively_ = (lively_ << 1) | (bends(bend.alpha) || bends(bend.beta) ? 1U : 0U);
    if (judged_samples_ < kLivelySamples) ++judged_samples_;
  }

  static constexpr double kRadPerDeg = std::numbers::pi / 180.0;
  static constexpr double kSample_s = 0.01;          // 2103h
  static constexpr std::uint8_t kRateGapSteps = 20;  // over a longer gap a mean rate says nothing about now

  double alpha_rad_ = 0, beta_rad_ = 0;
  double sent_alpha_rad_ = 0, sent_beta_rad_ = 0;
  double alpha_rate_rad_s_ = 0, beta_rate_rad_s_ = 0;
  double sent_yaw_rate_rad_s_ = 0, yaw_rate_rad_s_ = 0, pitch_rate_rad_s_ = 0, roll_rate_rad_s_ = 0;
  Freshness fresh_, heard_, rates_fresh_;
  RawAngles raw_, raw_step_;
  std::array<std::int32_t, 3> raw_rates_{};
  std::uint32_t lively_ = 0;  // newest sample in bit 0
  std::uint8_t judged_samples_ = 0, steps_in_row_ = 0, same_rates_ = 0;
  std::uint8_t status_ = 0, counter_ = 0, repeated_frames_ = 0;
  bool known_ = false, repeat_counted_ = false, rates_counted_ = false;
};

}  // namespace hoist::core
