// Records, in simulated time, when one drive stops obeying after its last command and when its wheel stands. For tests only; nothing
// depends on it.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>

namespace hoist::sim {

class StopWitness {
 public:
  /// A wheel has come to rest at the first and rolls on above the second. Between: the sprung patient rocks the hoist back for 0.1 s after a quick
  /// stop, by up to 0.028 m/s at the wheel in 342 stops of 400 walks; a witness asked only then would never have seen the rest.
  static constexpr double kAtRest_m_s = 0.01, kRollsOn_m_s = 0.05;

  /// A command has reached the drive.
  void command(std::uint64_t now_ns) {
    command_ns_ = now_ns;
    gave_up_ns_.reset();
    at_rest_ns_.reset();
    rolled_m_ = 0.0;
    fresh_ = true;
  }
  /// Once a millisecond: whether the drive obeys (operation is enabled), and its wheel.
  void look(std::uint64_t now_ns, bool obeys, double wheel_m_s) {
    if (!command_ns_) return;
    if (!obeys && !gave_up_ns_) gave_up_ns_ = now_ns;
    if (std::fabs(wheel_m_s) > kRollsOn_m_s) {
      at_rest_ns_.reset();
    } else if (!at_rest_ns_ && std::fabs(wheel_m_s) <= kAtRest_m_s) {
      at_rest_ns_ = now_ns;
    }
    if (fresh_) speed_m_s_ = wheel_m_s;
    fresh_ = false;
    rolled_m_ += wheel_m_s * 0.001;
  }

  /// Time of the latest command; empty before the first.
  [[nodiscard]] std::optional<std::uint64_t> command_ns() const { return command_ns_; }
  /// Since that command: the drive no longer obeys; the wheel has come to rest and does not roll on. Empty while that is not so.
  [[nodiscard]] std::optional<std::uint64_t> gave_up_ns() const { return gave_up_ns_; }
  [[nodiscard]] std::optional<std::uint64_t> at_rest_ns() const { return at_rest_ns_; }
  [[nodiscard]] double speed_at_command_m_s() const { return speed_m_s_; }
  [[nodiscard]] double rolled_m() const { return rolled_m_; }

 private:
  std::optional<std::uint64_t> command_ns_, gave_up_ns_, at_rest_ns_;
  double speed_m_s_{}, rolled_m_{};
  bool fresh_{false};
};

}  // namespace hoist::sim
