// Two lead-acid batteries of 12 V, 18 Ah in series (paper III-A; in series: D30).
#pragma once

#include <optional>

namespace hoist::sim {

/// Open-circuit voltage and resistance: usual figures of small sealed lead-acid batteries (assumed).
struct BatteryParams {
  double capacity_c{18.0 * 3600.0};
  double full_v{12.8};
  double empty_v{11.4};
  double resistance_ohm{0.02};
  double difference_v{0.05};  ///< difference of the two: half of it up, half down
};

class Battery {
 public:
  explicit Battery(const BatteryParams& params = {}) : params_(params) {}

  void step(double current_a, double dt_s) {
    current_a_ = current_a;
    charge_norm_ -= current_a * dt_s / params_.capacity_c;
    charge_norm_ = charge_norm_ < 0.0 ? 0.0 : (charge_norm_ > 1.0 ? 1.0 : charge_norm_);
  }

  /// Voltage of battery 0 or 1 under load.
  [[nodiscard]] double one_v(int which) const {
    const double apart_v = params_.difference_v + weaker_v_;
    const double half_v = which == 0 ? apart_v / 2.0 : -apart_v / 2.0;
    if (forced_v_) return *forced_v_ / 2.0 + half_v;
    return params_.empty_v + (params_.full_v - params_.empty_v) * charge_norm_ - params_.resistance_ohm * current_a_ + half_v;
  }
  [[nodiscard]] double both_v() const { return one_v(0) + one_v(1); }
  [[nodiscard]] double charge_norm() const { return charge_norm_; }

  /// Fixes both together at this voltage independent of the load, or releases them.
  void force(std::optional<double> both_v) { forced_v_ = both_v; }
  /// One battery is worn out: battery 1 falls behind battery 0 by this much more than usual, with the same sum.
  void weaken(double by_v) { weaker_v_ = by_v; }

 private:
  BatteryParams params_;
  double charge_norm_{0.95};
  double current_a_{}, weaker_v_{};
  std::optional<double> forced_v_;
};

}  // namespace hoist::sim
