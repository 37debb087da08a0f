#include "db/metrics/walk.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::db {

void ModeChanges::add(contract::Mode mode) {
  using contract::Mode;
  if (mode_ == mode) return;
  const bool from_moving = mode_ && contract::kModes[static_cast<std::size_t>(*mode_)].moving;
  if (mode_ == Mode::user) {
    if (mode == Mode::standby)
      perhaps_last_ = true;
    else
      ++interventions_;
  } else if (perhaps_last_ && contract::kModes[static_cast<std::size_t>(mode)].moving) {
    ++interventions_;
    perhaps_last_ = false;
  }
  if (from_moving && (mode == Mode::protective_stop || mode == Mode::fault || mode == Mode::emergency_stop)) ++protective_stops_;
  led_ = led_ || mode == Mode::user;
  mode_ = mode;
}

void Walk::add(const WalkSample& sample) {
  modes.add(sample.mode);
  if (!counts(sample)) return;
  ++samples;
  in_motion += sample.standing_still ? 0 : 1;
  in_motion_led += !sample.standing_still && sample.mode == contract::Mode::user ? 1 : 0;
  walked_m += std::fabs(sample.speed_m_s) * kSample_s;
  fastest_m_s = std::max(fastest_m_s, std::fabs(sample.speed_m_s));
}

std::optional<std::size_t> FastRun::add(const WalkSample& sample) {
  const bool goes_on = tick_ && sample.tick == *tick_ + 1;
  tick_ = sample.tick;
  if (!goes_on) next_ = 0;
  if (std::fabs(sample.speed_m_s) > kBout_m_s) return next_++;
  next_ = 0;
  return std::nullopt;
}

}  // namespace hoist::db
