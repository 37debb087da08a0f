// The input node: TPDO1 with bumpers and switches, TPDO2 with the two battery voltages.
#pragma once
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/core/estimate/freshness.hpp"

namespace hoist::core {

class IoSensor {
 public:
  void next_tick() noexcept {
    fresh_.next_tick();
    battery_fresh_.next_tick();
  }

  void take_inputs(const contract::CanFrame& frame) noexcept {
    using contract::Pdo;
    constexpr auto kInputs = contract::pdo_slot(Pdo::io_tx1, 0x6000, 1), kSwitches = contract::pdo_slot(Pdo::io_tx1, 0x6000, 2);
    fresh_.renew();
    bumpers_ = static_cast<std::uint8_t>(contract::read_slot(frame, kInputs));
    switches_ = static_cast<std::uint8_t>(contract::read_slot(frame, kSwitches));
  }

  void take_batteries(const contract::CanFrame& frame) noexcept {
    using contract::Pdo;
    constexpr auto kA = contract::pdo_slot(Pdo::io_tx2, 0x6401, 1), kB = contract::pdo_slot(Pdo::io_tx2, 0x6401, 2);
    battery_fresh_.renew();
    battery_known_ = true;
    battery_a_v_ = static_cast<double>(contract::read_slot(frame, kA)) * kA.scale;
    battery_b_v_ = static_cast<double>(contract::read_slot(frame, kB)) * kB.scale;
  }

  void restart() noexcept { *this = IoSensor{}; }

  [[nodiscard]] const Freshness& fresh() const noexcept { return fresh_; }
  [[nodiscard]] bool battery_known() const noexcept { return battery_known_; }
  /// The voltages have stopped arriving: the held values are no readings.
  [[nodiscard]] bool battery_silent(int ticks) const noexcept { return battery_known_ && battery_fresh_.age_ticks() >= ticks; }
  [[nodiscard]] bool battery_now() const noexcept { return battery_fresh_.now(); }
  /// Bit set = pressed: 0 front, 1 rear, 2 left, 3 right.
  [[nodiscard]] std::uint8_t bumpers() const noexcept { return bumpers_ & kBumperBits; }
  [[nodiscard]] std::uint8_t switches() const noexcept { return switches_; }
  /// Bit 0 of the switches: the chain that feeds the motors' relay is open, or its wire is torn.
  [[nodiscard]] bool emergency_stop_open() const noexcept { return (switches_ & 1U) != 0; }
  [[nodiscard]] bool sync_input() const noexcept { return (switches_ & contract::canopen::kSyncInput) != 0; }
  [[nodiscard]] double battery_a_v() const noexcept { return battery_a_v_; }
  [[nodiscard]] double battery_b_v() const noexcept { return battery_b_v_; }

 private:
  static constexpr std::uint8_t kBumperBits = 0x0F;

  double battery_a_v_ = 0, battery_b_v_ = 0;
  Freshness fresh_, battery_fresh_;
  std::uint8_t bumpers_ = 0, switches_ = 0;
  bool battery_known_ = false;
};

}  // namespace hoist::core
