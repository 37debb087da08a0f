// How hot the motor's winding is, from the current alone (I2t), and how much current that leaves: hazard H11. One thermal mass:
//   dT/dt = (i^2 R(T) R_th - (T - T_ambient)) / tau
// with R rising by 0.39 % per kelvin, as copper does. A winding that comes near its limit gets less current, before anything is switched
// off; the drive switches off only if it gets hotter all the same.
#pragma once
#include <cstdint>

namespace hoist::firmware {

struct WindingConfig {
  float resistance_ohm = 1.2F;  // at 25 degrees
  float ambient_c = 40;
  float limit_c = 120;
  float thermal_resistance_k_w = 1.3F;
  float time_constant_s = 60;
};

class Winding {
 public:
  static constexpr float kCopperPer_k = 0.0039F;
  static constexpr float kFoldBand_k = 15;   // below the limit: from here on the current is folded back
  static constexpr float kFoldShare = 0.3F;  // of the current limit, left at the limit itself: the motor still stops a patient
  static constexpr float kTripAbove_k = 5;   // above the limit: off
  static constexpr float kStartRise_k = 50;  // unknown after power-on: assumed warm, not cold
  static constexpr std::uint32_t kStep_ms = 10;

  /// After power-on. Not after a reset over the bus, which does not cool the winding.
  void start(const WindingConfig& config) {
    temperature_c_ = config.ambient_c + kStartRise_k;
    square_sum_a2_ = 0;
    samples_ = 0;
  }

  /// Each millisecond; the model itself moves every 10 ms.
  void step_1ms(const WindingConfig& config, float current_a) {
    square_sum_a2_ += current_a * current_a;
    if (++samples_ < kStep_ms) return;
    const float loss_w =
        square_sum_a2_ / static_cast<float>(kStep_ms) * config.resistance_ohm * (1.0F + kCopperPer_k * (temperature_c_ - 25.0F));
    constexpr float kStep_s = 0.001F * static_cast<float>(kStep_ms);
    temperature_c_ += kStep_s / config.time_constant_s * (loss_w * config.thermal_resistance_k_w - (temperature_c_ - config.ambient_c));
    if (!(temperature_c_ >= -50.0F)) temperature_c_ = -50.0F;  // settings changed in operation; also non-finite values
    if (temperature_c_ > 1000.0F) temperature_c_ = 1000.0F;
    square_sum_a2_ = 0;
    samples_ = 0;
  }

  [[nodiscard]] float temperature_c() const { return temperature_c_; }
  [[nodiscard]] bool too_hot(const WindingConfig& config) const { return temperature_c_ > config.limit_c + kTripAbove_k; }
  /// The share of the current limit that may flow now.
  [[nodiscard]] float current_share(const WindingConfig& config) const { return fold_share(temperature_c_, config.limit_c); }

  /// 1 up to the band below the limit, then down in a straight line to kFoldShare, which stays beyond it.
  [[nodiscard]] static constexpr float fold_share(float temperature_c, float limit_c) {
    const float into_band = (temperature_c - (limit_c - kFoldBand_k)) / kFoldBand_k;
    if (into_band <= 0.0F) return 1.0F;
    return into_band >= 1.0F ? kFoldShare : 1.0F - (1.0F - kFoldShare) * into_band;
  }

 private:
  float temperature_c_ = 25;
  float square_sum_a2_ = 0;
  std::uint32_t samples_ = 0;
};

}  // namespace hoist::firmware
