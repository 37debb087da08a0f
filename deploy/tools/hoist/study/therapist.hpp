// A therapist with a joystick who drives along a line on the floor: sees late, misjudges place and heading a little, and steers to a point
// ahead (pure pursuit). Assumed, as the patients are.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "control/contract/reference_path.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"
#include "firmware/sim/model.hpp"
#include "firmware/sim/random.hpp"

namespace hoist::tool::study {

class Therapist {
 public:
  Therapist(const Assumptions& assumed, const contract::ReferencePath& path, std::uint64_t seed)
      : assumed_(assumed), path_(path), random_(seed) {}

  struct Stick {
    double speed_m_s = 0, yaw_rate_rad_s = 0;
  };
  /// Every 10 ms: where the platform truly is.
  Stick look(const sim::PlatformMotion& now) {
    const double keep = std::exp(-kStep_s / kForgets_s), fresh = std::sqrt(1.0 - keep * keep);
    aside_m_ = keep * aside_m_ + fresh * assumed_.misjudgement_m * random_.normal();
    off_rad_ = keep * off_rad_ + fresh * assumed_.misjudgement_rad * random_.normal();
    seen_[at_] = now;
    const auto back = static_cast<std::size_t>(std::lround(assumed_.therapist_delay_s / kStep_s));
    const sim::PlatformMotion& then = seen_[(at_ + kRemembers - std::min(back, looks_)) % kRemembers];
    at_ = (at_ + 1) % kRemembers;
    looks_ = std::min(looks_ + 1, kRemembers - 1);
    return steer(then);
  }
  /// Arc length along the line that the hoist has come to, as the therapist sees it.
  [[nodiscard]] double progress_m() const { return progress_m_; }

 private:
  static constexpr double kStep_s = 0.01;
  static constexpr double kForgets_s = 3.0;  ///< how long a misjudgement lasts
  static constexpr double kLookAhead_m = 0.6;
  static constexpr std::size_t kRemembers = 64;  ///< longer than any delay of a protocol

  Stick steer(const sim::PlatformMotion& seen) {
    const double x_m = seen.x_m - aside_m_ * std::sin(seen.psi_rad), y_m = seen.y_m + aside_m_ * std::cos(seen.psi_rad);
    progress_m_ = path_.project(x_m, y_m, progress_m_);
    const contract::PathPose goal = path_.pose(progress_m_ + kLookAhead_m);
    const double bearing_rad = std::remainder(std::atan2(goal.y_m - y_m, goal.x_m - x_m) - seen.psi_rad - off_rad_, 2.0 * sim::kPi);
    const double distance_m = std::max(0.3, std::hypot(goal.x_m - x_m, goal.y_m - y_m));
    const double curve_per_m = 2.0 * std::sin(std::clamp(bearing_rad, -sim::kPi / 2.0, sim::kPi / 2.0)) / distance_m;
    return {assumed_.therapist_m_s, assumed_.therapist_m_s * curve_per_m};
  }

  Assumptions assumed_;
  contract::ReferencePath path_;
  sim::Random random_;
  std::array<sim::PlatformMotion, kRemembers> seen_{};
  std::size_t at_ = 0, looks_ = 0;
  double aside_m_ = 0, off_rad_ = 0, progress_m_ = 0;
};

}  // namespace hoist::tool::study
