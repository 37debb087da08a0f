// What the nodes told the core and what the drives were told: decoded here from the frames that crossed the border, by the dictionary.
#pragma once
#include <array>
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "tests/chaos/judge/seen.hpp"

namespace hoist::chaos {

class Ears {
 public:
  static constexpr int kNever = 100'000;

  struct Tilt {
    double forward_rad = 0, right_rad = 0;
    bool valid = false;
    int settled_steps = 0;  // since it has known its zero
  };
  struct Drive {
    std::uint16_t status = 0;
    double supply_v = 0;
    // What it was told: m/s at the rim, and whether to run.
    double target_m_s = 0, followed_m_s = 0;
    bool told_to_run = false;
  };

  void before_step(const Given& given);
  void sent(const contract::CanFrame& frame);
  /// After a crash of the core: it has heard nothing yet.
  void restart() { *this = Ears{}; }

  /// Steps since the node's cyclic data (TPDO1) came, counted in steps that the core ran.
  [[nodiscard]] int age(contract::Node node) const { return age_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] int battery_age() const { return battery_age_; }
  /// Steps since a tilt sensor last said, in a frame as the dictionary has it, that it knows nothing, is saturated or has failed.
  [[nodiscard]] int doubt_age() const { return doubt_age_; }
  [[nodiscard]] int rates_age() const { return rates_age_; }
  [[nodiscard]] int bus_age() const { return bus_age_; }  // since the port last said that the bus is down
  [[nodiscard]] bool bus_up() const { return bus_age_ > 0; }
  /// Steps in a row in which a node that answers SYNC answered twice or more.
  [[nodiscard]] int twice_run(std::size_t node) const { return twice_[node]; }
  /// Frames of ids that no node has, in the last half second.
  [[nodiscard]] int strangers() const { return strangers_; }
  [[nodiscard]] const Tilt& tilt(contract::Node node) const { return tilts_[static_cast<std::size_t>(node)]; }
  [[nodiscard]] const Drive& drive(std::size_t side) const { return drives_[side]; }
  [[nodiscard]] std::uint8_t bumpers() const { return bumpers_; }
  [[nodiscard]] double battery_v(std::size_t which) const { return battery_v_[which]; }
  /// Steps since the server's heartbeat last changed; whether one was ever seen.
  [[nodiscard]] int server_age() const { return server_age_; }
  [[nodiscard]] double lateness_s() const { return lateness_s_; }
  /// A second step later than 5 ms within a second, or one later than 30 ms: this step.
  [[nodiscard]] bool too_late() const { return too_late_; }
  [[nodiscard]] int steps() const { return steps_; }

 private:
  static constexpr std::size_t kWindow = 50;

  void take(const contract::CanFrame& frame);

  std::array<int, contract::kRemoteNodeCount> age_ = [] {
    std::array<int, contract::kRemoteNodeCount> never{};
    never.fill(kNever);
    return never;
  }();
  std::array<int, contract::kRemoteNodeCount> answers_{}, twice_{};
  std::array<Tilt, contract::kRemoteNodeCount> tilts_{};
  std::array<Drive, 2> drives_{};
  std::array<int, kWindow> stranger_counts_{};
  std::array<double, 2> battery_v_{};
  std::uint64_t heartbeat_ = 0;
  double lateness_s_ = 0;
  int strangers_ = 0, steps_ = 0, bus_age_ = 0, battery_age_ = kNever, rates_age_ = kNever, doubt_age_ = kNever, server_age_ = kNever,
      since_late_ = kNever;
  std::uint8_t bumpers_ = 0;
  bool too_late_ = false;
};

}  // namespace hoist::chaos
