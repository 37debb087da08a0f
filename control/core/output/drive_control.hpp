// Leads one drive through the states of CiA 402 with its controlword: enabled only when the mode lets it be.
#pragma once
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/core/estimate/drive_sensor.hpp"

namespace hoist::core {

/// How long a drive may take to become enabled, and to leave its fault after a reset: three status reports are enough on a healthy bus.
inline constexpr std::uint8_t kEnableTicksMax = 50, kResetTicksMax = 50;
/// A drive that had been enabled and reports otherwise this often in a row has switched itself off.
inline constexpr std::uint8_t kDroppedTicksMax = 5;

/// What the mode wants of a drive. go_on: the hoist moves, so a drive that runs is told to run whatever its status says. On a line without a checksum
/// one word may be damaged; led by it, this wheel would brake alone. A status that stays is an alarm (refuses_to_run), and the stop leads the drive.
enum class Running : std::uint8_t { off, go_on, begin };

class DriveControl {
 public:
  /// `cut`: no voltage at all, whatever the drive does, because its own ramp is not trusted either.
  [[nodiscard]] std::uint16_t step(const DriveSensor& drive, Running wanted, bool cut) noexcept {
    watch(drive, wanted != Running::off && !cut);
    ran_ = runs_;
    const std::uint16_t control = lead(drive, wanted, cut);
    runs_ = control == contract::canopen::drive::kEnable;
    return control;
  }
  /// Commanded to run in this step but not in the previous one: the wheel starts from the present command. goes_on():
  /// in both.
  [[nodiscard]] bool begins() const noexcept { return runs_ && !ran_; }
  [[nodiscard]] bool goes_on() const noexcept { return runs_ && ran_; }

  /// Asks for a fault reset; called on acknowledgement only.
  void reset_fault() noexcept { reset_ticks_ = kResetTicksMax; }
  [[nodiscard]] bool resetting() const noexcept { return reset_ticks_ > 0; }

  /// Wanted and not enabled for too long, or dropped out by itself.
  [[nodiscard]] bool refuses_to_run(std::uint8_t start_ticks_max, std::uint8_t dropped_ticks_max) const noexcept {
    return missing_ticks_ >= start_ticks_max || (was_enabled_ && missing_ticks_ >= dropped_ticks_max);
  }

 private:
  [[nodiscard]] std::uint16_t lead(const DriveSensor& drive, Running wanted, bool cut) noexcept {
    namespace cia402 = contract::canopen::drive;
    const cia402::State state = drive.state();
    if (reset_ticks_ > 0) {
      --reset_ticks_;
      if (state != cia402::State::fault) reset_ticks_ = 0;
      // The drive acts on the rising edge; repeated, because the frame may be lost.
      return reset_ticks_ % 4 == 0 ? cia402::kDisableVoltage : cia402::kFaultReset;
    }
    if (cut) return cia402::kDisableVoltage;
    if (wanted == Running::go_on && state != cia402::State::fault && state != cia402::State::fault_reaction)
      return ran_ ? cia402::kEnable : cia402::kShutdown;
    switch (state) {
      case cia402::State::quick_stop_active:
        // The drive is executing its quick stop. Do not send "disable voltage": the wheel would coast.
        return cia402::kQuickStop;
      case cia402::State::fault:
      case cia402::State::fault_reaction:
        return cia402::kDisableVoltage;
      case cia402::State::not_ready:
      case cia402::State::switch_on_disabled:
        return cia402::kShutdown;
      case cia402::State::ready:
        return wanted == Running::begin ? cia402::kSwitchOn : cia402::kShutdown;
      case cia402::State::switched_on:
      case cia402::State::operation_enabled:
        return wanted == Running::begin ? cia402::kEnable : cia402::kShutdown;
    }
    return cia402::kDisableVoltage;
  }

  void watch(const DriveSensor& drive, bool wanted) noexcept {
    if (!wanted || drive.fresh().lost()) {
      // A silent drive is another fault; when it returns it starts from the beginning.
      was_enabled_ = false;
      missing_ticks_ = 0;
    } else if (drive.enabled()) {
      was_enabled_ = true;
      missing_ticks_ = 0;
    } else if (missing_ticks_ < kOldestTicks) {
      ++missing_ticks_;
    }
  }

  std::uint8_t missing_ticks_ = 0, reset_ticks_ = 0;
  bool was_enabled_ = false, runs_ = false, ran_ = false;
};

}  // namespace hoist::core
