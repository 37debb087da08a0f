// What one drive reports: TPDO1 with statusword, position and current, TPDO2 with speed, error code and supply.
#pragma once
#include <algorithm>
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/core/estimate/freshness.hpp"
#include "control/core/law/odometry.hpp"

namespace hoist::core {

class DriveSensor {
 public:
  /// `sync_ticks`: time between the SYNC that this step's frames answer and the one before it; more than 1 after steps that were left out.
  void next_tick(std::uint32_t sync_ticks = 1) noexcept {
    fresh_.next_tick();
    supply_fresh_.next_tick();
    moved_counts_ = 0;
    moved_ticks_ = 0;
    sync_ticks_ = sync_ticks;
    since_counts_ticks_ = std::min(since_counts_ticks_ + sync_ticks, kLongestTicks);
  }

  /// False when the position jumped further than a wheel can turn: the frame's other values count, the jump does not.
  [[nodiscard]] bool take_state(const contract::CanFrame& frame, double counts_per_tick_max) noexcept {
    using contract::Pdo;
    constexpr auto kStatus = contract::pdo_slot(Pdo::drive_tx1, 0x6041), kPosition = contract::pdo_slot(Pdo::drive_tx1, 0x6064),
                   kCurrent = contract::pdo_slot(Pdo::drive_tx1, 0x6078);
    fresh_.renew();
    status_word_ = static_cast<std::uint16_t>(contract::read_slot(frame, kStatus));
    current_a_ = static_cast<double>(contract::read_slot(frame, kCurrent)) * kAmpsPerStep;
    const auto counts = static_cast<std::int32_t>(contract::read_slot(frame, kPosition));
    // Two frames may arrive in one step when the loop woke late, or when a late one was overtaken: they add up, and are judged by their sum.
    const std::int64_t moved = std::int64_t{moved_counts_} + law::delta32(counts, counts_);
    const std::uint32_t ticks = moved_ticks_ + since_counts_ticks_;
    const double most = counts_per_tick_max * std::max(ticks, 1U);
    const bool plausible = !known_ || (static_cast<double>(moved) < most && static_cast<double>(moved) > -most);
    if (known_ && plausible) {
      moved_counts_ = static_cast<std::int32_t>(moved);
      moved_ticks_ = ticks;
    }
    counts_ = counts;
    known_ = true;
    since_counts_ticks_ = 0;
    return plausible;
  }

  void take_supply(const contract::CanFrame& frame) noexcept {
    using contract::Pdo;
    constexpr auto kError = contract::pdo_slot(Pdo::drive_tx2, 0x603F), kSupply = contract::pdo_slot(Pdo::drive_tx2, 0x2211);
    supply_fresh_.renew();
    error_code_ = static_cast<std::uint16_t>(contract::read_slot(frame, kError));
    supply_v_ = static_cast<double>(contract::read_slot(frame, kSupply)) * kSupply.scale;
  }

  void restart() noexcept { *this = DriveSensor{}; }

  [[nodiscard]] const Freshness& fresh() const noexcept { return fresh_; }
  [[nodiscard]] contract::canopen::drive::State state() const noexcept { return contract::canopen::drive::state(status_word_); }
  [[nodiscard]] bool enabled() const noexcept { return !fresh_.lost() && state() == contract::canopen::drive::State::operation_enabled; }
  /// Its bridge works: it follows commands, or stops by itself on a ramp.
  [[nodiscard]] bool works() const noexcept {
    using State = contract::canopen::drive::State;
    return enabled() || state() == State::quick_stop_active || state() == State::fault_reaction;
  }
  [[nodiscard]] std::uint16_t status_word() const noexcept { return status_word_; }
  [[nodiscard]] std::uint16_t error_code() const noexcept { return error_code_; }
  [[nodiscard]] std::int32_t counts() const noexcept { return counts_; }
  /// How far the wheel turned since its last report, and the time between both in ticks, left-out steps included (0 = nothing new).
  [[nodiscard]] std::int32_t moved_counts() const noexcept { return moved_counts_; }
  [[nodiscard]] std::uint32_t moved_ticks() const noexcept { return moved_ticks_; }
  [[nodiscard]] std::uint32_t sync_ticks() const noexcept { return sync_ticks_; }
  /// A position has come since the drive started: from here on every movement is counted.
  [[nodiscard]] bool position_known() const noexcept { return known_; }
  [[nodiscard]] double current_a() const noexcept { return current_a_; }
  [[nodiscard]] double supply_v() const noexcept { return supply_v_; }
  /// Received since the drive started, within its last ten reports.
  [[nodiscard]] bool supply_known() const noexcept { return supply_fresh_.age_ticks() < kSupplyTicksMax; }

 private:
  // 6078h counts in thousandths of 6075h, whose default is the rated current of the motor.
  static constexpr double kAmpsPerStep = contract::find_object(contract::NodeKind::drive, 0x6075, 0)->default_value / 1000.0 / 1000.0;

  // Ten minutes: the sum must not wrap.
  static constexpr std::uint32_t kLongestTicks = 60'000;
  static constexpr std::uint8_t kSupplyTicksMax = 10 * contract::pdo_info(contract::Pdo::drive_tx2).period_ms / 10;

  double current_a_ = 0, supply_v_ = 0;
  std::int32_t counts_ = 0, moved_counts_ = 0;
  std::uint32_t moved_ticks_ = 0, since_counts_ticks_ = 0, sync_ticks_ = 1;
  std::uint16_t status_word_ = 0, error_code_ = 0;
  Freshness fresh_, supply_fresh_;
  bool known_ = false;
};

}  // namespace hoist::core
