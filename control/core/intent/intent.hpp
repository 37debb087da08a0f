// What the patient asks for, step by step: equations (1)-(3), neutral and range, and the memory that "Set neutral" needs.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>

#include "control/core/base/derived.hpp"
#include "control/core/base/lasting.hpp"
#include "control/core/estimate/estimate.hpp"
#include "control/core/law/gait_cancel.hpp"
#include "control/core/law/pelvis.hpp"

namespace hoist::core {

/// One second of steps: how long neutral must last before a start, and what "Set neutral" averages.
inline constexpr std::size_t kNeutralTicks = 100;

class PatientIntent {
 public:
  /// `calm_norm`: the share of the gait's sway that is taken out of lean and turn; 0 = none, as the paper has it. Guards look at the
  /// sensors, never at what is left over here.
  void update(const Estimate& sensed, const Derived& derived, double tolerance_norm, double calm_norm, double dt_s) noexcept {
    pelvis_ = law::pelvis_exact(sensed.relative(), derived.geometry);
    take_gait(sensed.tilts_stale() ? 0.0 : calm_norm, dt_s);
    const law::Pelvis<double> calm{pelvis_.dx_m - gait_.lean_m, pelvis_.dy_m, pelvis_.dpsi_rad - gait_.turn_rad};
    // A stale tilt means no intent. Keeping the last one would drive on without knowing the patient's posture (H4).
    const law::Intent<double> wish = sensed.tilts_stale() ? law::Intent<double>{} : law::normalise(calm, derived.range, derived.neutral);
    lean_norm_ = wish.u_norm;
    turn_norm_ = wish.u_psi_norm;
    if (!wish.valid) {
      held_ = 0;
      neutral_ = {};
      return;
    }
    dx_m_[next_] = pelvis_.dx_m;
    dpsi_rad_[next_] = pelvis_.dpsi_rad;
    next_ = next_ + 1 == kNeutralTicks ? 0 : next_ + 1;
    if (held_ < kNeutralTicks) ++held_;
    neutral_.step(std::fabs(lean_norm_) <= tolerance_norm && std::fabs(turn_norm_) <= tolerance_norm, kNeutralTicks);
  }

  /// Discards the history: the meaning of lean and turn has changed, or they were not read for a while.
  void restart() noexcept {
    held_ = 0;
    neutral_ = {};
  }

  [[nodiscard]] const law::Pelvis<double>& pelvis() const noexcept { return pelvis_; }
  /// What was taken out as gait in this step; zeros while that is off.
  [[nodiscard]] const law::GaitPart<double>& gait() const noexcept { return gait_; }
  /// u and u_psi, -1 to 1; 0 while any tilt is stale.
  [[nodiscard]] double lean_norm() const noexcept { return lean_norm_; }
  [[nodiscard]] double turn_norm() const noexcept { return turn_norm_; }
  /// Upright and straight for a whole second.
  [[nodiscard]] bool neutral() const noexcept { return neutral_.reached(kNeutralTicks); }

  struct Posture {
    bool complete = false;  // a whole second without a gap
    double dx_m = 0, dpsi_rad = 0;
    double dx_spread_m = 0;  // largest minus smallest: while the patient moves there is no neutral
  };
  [[nodiscard]] Posture last_second() const noexcept {
    Posture posture;
    if (held_ < kNeutralTicks) return posture;
    double low_m = dx_m_[0], high_m = dx_m_[0];
    for (std::size_t i = 0; i < kNeutralTicks; ++i) {
      posture.dx_m += dx_m_[i] / static_cast<double>(kNeutralTicks);
      posture.dpsi_rad += dpsi_rad_[i] / static_cast<double>(kNeutralTicks);
      low_m = dx_m_[i] < low_m ? dx_m_[i] : low_m;
      high_m = dx_m_[i] > high_m ? dx_m_[i] : high_m;
    }
    posture.dx_spread_m = high_m - low_m;
    posture.complete = true;
    return posture;
  }

 private:
  void take_gait(double calm_norm, double dt_s) noexcept {
    gait_ = {};
    if (!(calm_norm > 0.0)) {
      gait_state_ = {};
      return;
    }
    gait_ = law::gait_cancel_step(law::GaitCancelConfig<double>{}, gait_state_, pelvis_.dx_m, pelvis_.dy_m, pelvis_.dpsi_rad, dt_s);
    gait_.lean_m *= calm_norm;
    gait_.turn_rad *= calm_norm;
  }

  law::Pelvis<double> pelvis_;
  law::GaitCancelState<double> gait_state_;
  law::GaitPart<double> gait_;
  double lean_norm_ = 0, turn_norm_ = 0;
  std::array<double, kNeutralTicks> dx_m_{}, dpsi_rad_{};
  std::size_t next_ = 0, held_ = 0;
  Lasting neutral_;
};

}  // namespace hoist::core
