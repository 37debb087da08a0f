// A brushed DC motor with inertia, friction and an encoder, for the simulator and the servo's tests.
//
// Physics only: it does not include the control laws, so that a shared error cannot cancel out. Equations:
//   L di/dt = V - R i - K w      J dw/dt = K i - B w - friction - load
// Coulomb friction holds the shaft at rest as long as nothing exceeds it.
#pragma once

#include <cmath>
#include <cstdint>

namespace hoist::sim {

/// Defaults: the motor the servo's properties are stated for (24 V, 100 W class; assumed, the paper gives no data sheet).
struct MotorConfig {
  double resistance_ohm{1.2};
  double inductance_h{0.0015};
  double constant_v_s_rad{0.115};  ///< back-EMF, V s/rad, and torque, N m/A
  double inertia_kg_m2{0.00043};   ///< rotor plus the load on the shaft
  double viscous_n_m_s{0.0001};
  double coulomb_n_m{0.02};
  double counts_per_turn{2000.0};
};

/// Longest integration step: a fifteenth of the winding's 1.25 ms time constant.
inline constexpr double kMotorSubStep_s = 100e-6;
/// Longest time per call; the rest is not simulated.
inline constexpr int kMotorSubStepLimit = 100'000;

class Motor {
 public:
  explicit Motor(const MotorConfig& config = {}) : config_(config) {}

  /// Moves dt_s ahead with a constant terminal voltage and a constant load torque (positive load resists forward motion and drives
  /// backward motion). Inputs that are not finite are taken as zero.
  void step(double voltage_v, double load_n_m, double dt_s) {
    if (!(dt_s > 0.0) || !std::isfinite(dt_s)) return;
    const double terminal_v = std::isfinite(voltage_v) ? voltage_v : 0.0;
    const double load = std::isfinite(load_n_m) ? load_n_m : 0.0;
    double steps_wanted = std::ceil(dt_s / kMotorSubStep_s - 1e-9);
    if (steps_wanted < 1.0) steps_wanted = 1.0;
    const int steps = steps_wanted < kMotorSubStepLimit ? static_cast<int>(steps_wanted) : kMotorSubStepLimit;
    const double h_s = steps_wanted < kMotorSubStepLimit ? dt_s / steps : kMotorSubStep_s;
    // The winding is solved exactly over a sub-step with the speed held: stable for any inductance.
    const double keep = config_.inductance_h > 0.0 ? std::exp(-h_s * config_.resistance_ohm / config_.inductance_h) : 0.0;
    for (int i = 0; i < steps; ++i) {
      const double settled_a = (terminal_v - config_.constant_v_s_rad * speed_rad_s_) / config_.resistance_ohm;
      current_a_ = settled_a + keep * (current_a_ - settled_a);
      const double before_rad_s = speed_rad_s_;
      advance_speed(config_.constant_v_s_rad * current_a_ - load, h_s);
      angle_rad_ += 0.5 * (before_rad_s + speed_rad_s_) * h_s;
    }
  }

  /// Blocks the shaft (a wheel against a door sill), or releases it.
  void lock(bool locked) {
    locked_ = locked;
    if (locked) speed_rad_s_ = 0.0;
  }

  /// Like step, for a shaft whose speed is given (a rigid platform turning both wheels): only winding and angle move. Returns the mean
  /// electrical torque over the step, N m; inertia and friction are then the other model's.
  double step_imposed(double voltage_v, double speed_rad_s, double dt_s) {
    if (!(dt_s > 0.0) || !std::isfinite(dt_s) || !std::isfinite(voltage_v) || !std::isfinite(speed_rad_s)) return 0.0;
    const double settled_a = (voltage_v - config_.constant_v_s_rad * speed_rad_s) / config_.resistance_ohm;
    const double tau_s = config_.inductance_h / config_.resistance_ohm;
    const double keep = tau_s > 0.0 ? std::exp(-dt_s / tau_s) : 0.0;
    const double before_a = current_a_;
    current_a_ = settled_a + keep * (before_a - settled_a);
    const double mean_a = settled_a + (tau_s > 0.0 ? (before_a - settled_a) * (1.0 - keep) * tau_s / dt_s : 0.0);
    angle_rad_ += 0.5 * (speed_rad_s_ + speed_rad_s) * dt_s;
    speed_rad_s_ = speed_rad_s;
    return config_.constant_v_s_rad * mean_a;
  }

  [[nodiscard]] double current_a() const { return current_a_; }
  [[nodiscard]] double speed_rad_s() const { return speed_rad_s_; }
  [[nodiscard]] double angle_rad() const { return angle_rad_; }
  [[nodiscard]] const MotorConfig& config() const { return config_; }

  /// Free-running 32-bit quadrature count, wrapping like the counter of the drive.
  [[nodiscard]] std::int32_t encoder_counts() const {
    constexpr double kTurn_rad = 6.283185307179586;
    const double counts = std::floor(angle_rad_ / kTurn_rad * config_.counts_per_turn);
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(static_cast<std::int64_t>(counts)));
  }

 private:
  void advance_speed(double drive_n_m, double h_s) {
    if (locked_) {
      speed_rad_s_ = 0.0;
      return;
    }
    const double coulomb = config_.coulomb_n_m;
    if (speed_rad_s_ == 0.0 && std::fabs(drive_n_m) <= coulomb) return;
    const double sense = speed_rad_s_ != 0.0 ? std::copysign(1.0, speed_rad_s_) : std::copysign(1.0, drive_n_m);
    // Viscous friction implicitly, so that no step size makes it unstable.
    const double next_rad_s = (speed_rad_s_ + h_s / config_.inertia_kg_m2 * (drive_n_m - sense * coulomb)) /
                              (1.0 + h_s * config_.viscous_n_m_s / config_.inertia_kg_m2);
    // Friction stops a shaft but never reverses it; the next sub-step continues from rest.
    speed_rad_s_ = (speed_rad_s_ != 0.0 && next_rad_s * speed_rad_s_ < 0.0) ? 0.0 : next_rad_s;
  }

  MotorConfig config_;
  double current_a_{};
  double speed_rad_s_{};
  double angle_rad_{};
  bool locked_{false};
};

}  // namespace hoist::sim
