// What makes a patient's walk uneven: no stride equals the one before, and none is a sine. Strides vary in time and size, motion inside a
// stride wanders, standing sways, and feet may freeze. Seeded: the same seed gives the same walk. Sources: PATIENTS.md.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "firmware/sim/model.hpp"
#include "firmware/sim/random.hpp"

namespace hoist::sim {

/// How uneven a patient's gait is. With zeros every stride is the same and a standing patient is still.
struct GaitVariation {
  double stride_time_norm{};  ///< coefficient of variation of the stride time, in a walk of a minute
  double lasting_norm{0.5};   ///< share of that variance that lasts over many strides
  double step_size_norm{};    ///< coefficient of variation of each step's sway: sideways, forward and turning, drawn apart
  double within_norm{};       ///< wandering inside a stride, RMS, as a share of the sway
  double stand_sway_m{};      ///< RMS forward and back of a standing patient without springs, which take about half; sideways 30 % of it
  double freezes_per_min{};   ///< how often the feet freeze while the hoist rolls
  double freeze_s{};          ///< mean length of a freeze
  double festination_s{};     ///< hastened small steps before a freeze
  double rests_per_min{};     ///< how often a leading patient stops to rest
  double rest_s{};            ///< mean length of a rest
  std::uint64_t seed{1};

  [[nodiscard]] constexpr bool any() const {
    return stride_time_norm > 0.0 || step_size_norm > 0.0 || within_norm > 0.0 || stand_sway_m > 0.0 || freezes_per_min > 0.0 ||
           rests_per_min > 0.0;
  }
};

/// What follows a goal with a critically damped lag of second order: no jump in value or rate.
struct SmoothValue {
  double value{}, rate{};
  void step_1ms(double goal, double corner_rad_s) {
    rate += (corner_rad_s * corner_rad_s * (goal - value) - 2.0 * corner_rad_s * rate) * 0.001;
    value += rate * 0.001;
  }
};

/// Coloured noise of RMS 1: white noise through SmoothValue, falling with the fourth power of the frequency above the corner.
class ColouredNoise {
 public:
  explicit ColouredNoise(double corner_rad_s) : corner_rad_s_(corner_rad_s), white_norm_(std::sqrt(4.0 / (corner_rad_s * kHeld_s))) {}
  void step_1ms(Random& random) {
    if (held_ms_ == 0) goal_ = white_norm_ * random.normal();
    held_ms_ = (held_ms_ + 1) % kHeld_ms;
    smooth_.step_1ms(goal_, corner_rad_s_);
  }
  [[nodiscard]] double value() const { return smooth_.value; }
  [[nodiscard]] double rate() const { return smooth_.rate; }

 private:
  static constexpr int kHeld_ms = 10;
  static constexpr double kHeld_s = 0.010;
  double corner_rad_s_, white_norm_;
  double goal_{};
  int held_ms_{};
  SmoothValue smooth_;
};

/// Stride after stride, mean 0, variance 1, from the first one on. The lasting share is a sum over 4, 16 and 64 strides, whose spectrum falls as
/// 1/f over two decades.
class StrideSeries {
 public:
  double next(Random& random, double lasting_norm) {
    constexpr std::array kMemories{4.0, 16.0, 64.0};
    if (!std::exchange(begun_, true))
      for (double& part : parts_) part = random.normal();
    double lasting = 0.0;
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      const double keep = std::exp(-1.0 / kMemories[i]);
      parts_[i] = keep * parts_[i] + std::sqrt(1.0 - keep * keep) * random.normal();
      lasting += parts_[i] / std::sqrt(3.0);
    }
    return std::sqrt(lasting_norm) * lasting + std::sqrt(1.0 - lasting_norm) * random.normal();
  }

 private:
  std::array<double, 3> parts_{};
  bool begun_{false};
};

/// The unevenness of one patient, step by step. Without variation every factor is exactly 1 and every offset exactly 0.
class UnevenGait {
 public:
  explicit UnevenGait(const GaitVariation& variation) : variation_(variation), random_(variation.seed ^ 0x556E6576656E0000ULL) {}

  /// Every millisecond: the gait's fullness (0 standing, 1 walking), the phase of the stride, 0 to 2 pi, and whether the legs carry.
  void step_1ms(double gait_norm, double phase_rad, bool carries) {
    if (!variation_.any()) return;
    const bool second_half = phase_rad >= kPi;
    if (second_half != second_half_) begin_half_stride(!second_half);
    second_half_ = second_half;
    const double hurry = festinating() ? kHurried_norm : 1.0;
    tempo_.step_1ms(hurry * tempo_goal_, kSettle_rad_s);
    for (std::size_t i = 0; i < kWays; ++i) {
      sizes_[i].step_1ms(size_goals_[i] * (festinating() ? kShortened_norm : 1.0), kSettle_rad_s);
      within_[i].step_1ms(random_);
    }
    for (ColouredNoise& noise : stand_) noise.step_1ms(random_);
    tremble_rad_ = std::fmod(tremble_rad_ + 2.0 * kPi * kTremble_hz * 0.001, 2.0 * kPi);
    tremble_.step_1ms(frozen() ? kTremble_m : 0.0, kSettle_rad_s);
    gait_norm_ = gait_norm;
    present_.step_1ms(carries ? 1.0 : 0.0, kFades_rad_s);
  }

  /// Every 10 ms: begins and ends freezes and rests. A freeze begins while the hoist rolls, a rest while the patient leads it.
  void decide_10ms(bool rolls, bool leads) {
    if (episode_ == Episode::none && variation_.freezes_per_min <= 0.0 && variation_.rests_per_min <= 0.0) return;
    episode_s_ -= kThought_s;
    if (episode_ == Episode::festination && episode_s_ <= 0.0) {
      begin(Episode::freeze, variation_.freeze_s);
    } else if (episode_ != Episode::none && episode_s_ <= 0.0) {
      begin(Episode::none, kAtLeastBetween_s);
    } else if (episode_ == Episode::none && episode_s_ <= 0.0 && rolls) {
      if (happens(variation_.freezes_per_min)) begin(Episode::festination, variation_.festination_s);
      if (leads && happens(variation_.rests_per_min)) begin(Episode::rest, variation_.rest_s);
    }
    if (episode_ == Episode::rest && !leads) begin(Episode::none, kAtLeastBetween_s);
  }

  /// A freeze that lasts this long begins now.
  void freeze(double seconds) {
    episode_ = Episode::freeze;
    episode_s_ = seconds;
  }

  [[nodiscard]] bool festinating() const { return episode_ == Episode::festination; }
  [[nodiscard]] bool frozen() const { return episode_ == Episode::freeze; }
  [[nodiscard]] bool resting() const { return episode_ == Episode::rest; }

  /// Factor of the stride frequency.
  [[nodiscard]] double tempo_norm() const { return tempo_.value; }
  /// Factors of the sway forward, sideways and in turning, with their rates.
  [[nodiscard]] const SmoothValue& forward() const { return sizes_[0]; }
  [[nodiscard]] const SmoothValue& aside() const { return sizes_[1]; }
  [[nodiscard]] const SmoothValue& twist() const { return sizes_[2]; }

  /// Added to the harness: wandering inside the stride, standing sway and trembling, given the sway of an even stride. It fades when the
  /// legs give way.
  void add_to(HarnessMotion& harness, double forward_m, double aside_m, double twist_rad) const {
    if (!variation_.any()) return;
    const double share = variation_.within_norm * gait_norm_;
    const double stand_m = variation_.stand_sway_m, stand_aside_m = kStandAside_norm * stand_m;
    const SmoothValue trembling{std::sin(tremble_rad_), 2.0 * kPi * kTremble_hz * std::cos(tremble_rad_)};
    const SmoothValue across{std::cos(tremble_rad_), -2.0 * kPi * kTremble_hz * std::sin(tremble_rad_)};
    const SmoothValue ahead =
        times(present_, sum(sum(scaled(within_[0], share * forward_m), stood(0, stand_m)), times(tremble_, trembling)));
    const SmoothValue aside =
        times(present_, sum(sum(scaled(within_[1], share * aside_m), stood(2, stand_aside_m)), times(tremble_, across)));
    const SmoothValue twist = times(present_, scaled(within_[2], share * twist_rad));
    harness.dx_m += ahead.value, harness.dx_rate_m_s += ahead.rate;
    harness.dy_m += aside.value, harness.dy_rate_m_s += aside.rate;
    harness.yaw_rad += twist.value, harness.yaw_rate_rad_s += twist.rate;
  }

 private:
  enum class Episode : std::uint8_t { none, festination, freeze, rest };
  static constexpr std::size_t kWays = 3;
  static constexpr double kThought_s = 0.010;
  static constexpr double kSettle_rad_s = 10.0;  // a step's size and time settle within 0.4 s (assumed)
  // Settling takes a tenth of the variation, and a minute does not see all of the lasting share: over 60 s the row's value is left.
  static constexpr double kMinute_norm = 1.3;
  static constexpr double kWithin_rad_s = 2.0 * kPi * 1.5;
  // Slow wandering of the point a standing body is held at, and its faster swing about it (Kiemel 2006); of equal variance (assumed).
  static constexpr double kSlow_rad_s = 0.4, kFast_rad_s = 2.0 * kPi * 0.4, kStandAside_norm = 0.3;
  static constexpr double kHurried_norm = 1.8, kShortened_norm = 0.5;  // festination (assumed)
  // Trembling in place: 3 to 8 Hz (Moore 2008), size assumed.
  static constexpr double kTremble_hz = 5.0, kTremble_m = 0.003;
  static constexpr double kAtLeastBetween_s = 5.0, kFades_rad_s = 4.0;

  void begin_half_stride(bool stride) {
    if (stride) {
      const double factor = 1.0 + kMinute_norm * variation_.stride_time_norm * times_.next(random_, variation_.lasting_norm);
      tempo_goal_ = 1.0 / std::clamp(factor, 0.5, 2.0);
    }
    for (double& goal : size_goals_) goal = std::clamp(1.0 + variation_.step_size_norm * random_.normal(), 0.1, 2.5);
  }
  [[nodiscard]] bool happens(double per_min) { return random_.uniform(0.0, 1.0) < per_min / 60.0 * kThought_s; }
  void begin(Episode episode, double mean_s) {
    episode_ = episode;
    episode_s_ = mean_s * random_.uniform(0.5, 1.5);
  }
  static SmoothValue sum(const SmoothValue& a, const SmoothValue& b) { return {a.value + b.value, a.rate + b.rate}; }
  static SmoothValue times(const SmoothValue& a, const SmoothValue& b) { return {a.value * b.value, a.value * b.rate + a.rate * b.value}; }
  static SmoothValue scaled(const ColouredNoise& noise, double by) { return {by * noise.value(), by * noise.rate()}; }
  [[nodiscard]] SmoothValue stood(std::size_t first, double rms_m) const {
    const double each_m = std::sqrt(0.5) * rms_m;
    return sum(scaled(stand_[first], each_m), scaled(stand_[first + 1], each_m));
  }

  GaitVariation variation_;
  Random random_;
  StrideSeries times_;
  double tempo_goal_{1.0};
  std::array<double, kWays> size_goals_{1.0, 1.0, 1.0};
  SmoothValue tempo_{1.0, 0.0};
  std::array<SmoothValue, kWays> sizes_{SmoothValue{1.0, 0.0}, SmoothValue{1.0, 0.0}, SmoothValue{1.0, 0.0}};
  std::array<ColouredNoise, kWays> within_{ColouredNoise(kWithin_rad_s), ColouredNoise(kWithin_rad_s), ColouredNoise(kWithin_rad_s)};
  // Forward slow and fast, sideways slow and fast.
  std::array<ColouredNoise, 4> stand_{ColouredNoise(kSlow_rad_s), ColouredNoise(kFast_rad_s), ColouredNoise(kSlow_rad_s),
                                      ColouredNoise(kFast_rad_s)};
  SmoothValue tremble_, present_{1.0, 0.0};
  double tremble_rad_{};
  double gait_norm_{};
  double episode_s_{kAtLeastBetween_s};
  Episode episode_{Episode::none};
  bool second_half_{false};
};

}  // namespace hoist::sim
