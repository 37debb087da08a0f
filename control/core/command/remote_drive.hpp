// The driving command of the lease holder: what is accepted, and how old it is (hazards H17 to H20).
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

#include "control/contract/commands.hpp"
#include "control/core/command/lease.hpp"

namespace hoist::core {

/// A stick this close to the middle is in the middle.
inline constexpr double kStickNeutral_norm = 0.02;
/// What is shown as age when there is no command (signals.def).
inline constexpr double kNoCommand_s = 9.999;

class RemoteDrive {
 public:
  /// False when the command is refused; nothing is changed then. Refused: not from the lease holder, a sequence that
  /// does not rise, a value that is NaN or beyond 1, an echo from the future or older than max_age_s. A release by the
  /// holder is always taken: it can only stop.
  [[nodiscard]] bool take(const contract::DriveCommand& command, const Lease& lease, std::uint64_t now_ns, double max_age_s) noexcept {
    if (!lease.held_by(command.client, command.lease_epoch) || command.sequence <= sequence_) return false;
    const bool held = command.held == 1;
    const bool fresh = contract::is_fresh_echo(command.echo_time_ns, now_ns, max_age_s);
    if (held) {
      // Written so that a NaN fails.
      const bool in_range = std::fabs(command.speed_norm) <= 1.0 && std::fabs(command.yaw_norm) <= 1.0;
      if (!fresh || !in_range) return false;
    }
    sequence_ = command.sequence;
    // The age never falls back: a later command with an older echo keeps the newer stamp.
    hand_ns_ = std::max(hand_ns_, std::min(command.echo_time_ns, now_ns));
    known_ = true;
    held_ = held;
    speed_norm_ = held ? command.speed_norm : 0.0;
    yaw_norm_ = held ? command.yaw_norm : 0.0;
    if (neutral() && fresh) awaits_neutral_ = false;
    return true;
  }

  /// A new driver, or none: forgets the commands of the former one.
  void reset() noexcept { *this = RemoteDrive{}; }

  /// A hold-to-run mode begins. A stick that was last seen pushed, or that was lost in the last one, may still be pushed: it must pass its
  /// middle first. A hold that is older than stop_age_s counts as released.
  void begin(std::uint64_t now_ns, double stop_age_s) noexcept {
    awaits_neutral_ = awaits_neutral_ || !neutral();
    if (age_s(now_ns) > stop_age_s) let_go();
  }
  /// Commands stopped coming while hold-to-run was held: the next motion needs a neutral stick first.
  void lose() noexcept {
    let_go();
    awaits_neutral_ = true;
  }

  [[nodiscard]] bool held() const noexcept { return held_; }
  [[nodiscard]] bool neutral() const noexcept {
    return !held_ || (std::fabs(speed_norm_) <= kStickNeutral_norm && std::fabs(yaw_norm_) <= kStickNeutral_norm);
  }
  [[nodiscard]] bool awaits_neutral() const noexcept { return awaits_neutral_; }
  [[nodiscard]] double speed_norm() const noexcept { return speed_norm_; }
  [[nodiscard]] double yaw_norm() const noexcept { return yaw_norm_; }
  /// The age of a command: since the telemetry stamp that its client had seen. It includes network delay, waiting in
  /// the server and silence since.
  [[nodiscard]] double age_s(std::uint64_t now_ns) const noexcept {
    if (!known_ || now_ns < hand_ns_) return kNoCommand_s;
    const double age = seconds(now_ns - hand_ns_);
    return age < kNoCommand_s ? age : kNoCommand_s;
  }

 private:
  [[nodiscard]] static double seconds(std::uint64_t ns) noexcept { return static_cast<double>(ns) * 1e-9; }
  void let_go() noexcept {
    held_ = false;
    speed_norm_ = 0;
    yaw_norm_ = 0;
  }

  std::uint64_t sequence_ = 0;
  std::uint64_t hand_ns_ = 0;  // the newest telemetry stamp that a command has echoed
  double speed_norm_ = 0, yaw_norm_ = 0;
  bool known_ = false, held_ = false, awaits_neutral_ = false;
};

}  // namespace hoist::core
