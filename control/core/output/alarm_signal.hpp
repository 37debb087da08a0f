// Which priority sounds and which is lit (IEC 60601-1-8): the most urgent fault in force. Sound may be paused; the light never is.
//
// A pause is for the faults in force when it began: a new one, or one of them that comes back, sounds at once. The input node plays the
// patterns (alarms.def), and signals high by itself when the frames that carry this end.
#pragma once
#include <cstdint>

#include "control/contract/alarms.hpp"
#include "control/contract/faults.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

class AlarmSignal {
 public:
  static constexpr auto kPauseTicks = static_cast<std::uint32_t>(contract::kAudioPause_s / kTick_s);
  static_assert(kPauseTicks == 12'000, "nothing is lost by rounding");

  /// Pauses the sound of these faults, from now on for kAudioPause_s. False: there is nothing to pause.
  [[nodiscard]] bool pause(contract::FaultBits in_force) noexcept {
    if (in_force == 0) return false;
    paused_ = in_force;
    pause_ticks_ = kPauseTicks;
    return true;
  }
  /// Ends the pause. False: there is none.
  [[nodiscard]] bool resume() noexcept {
    const bool was_paused = pause_ticks_ > 0;
    pause_ticks_ = 0;
    return was_paused;
  }

  /// Once per step, with the faults in force. True: the pause has ended by itself.
  [[nodiscard]] bool step(contract::FaultBits in_force) noexcept {
    const bool was_paused = pause_ticks_ > 0;
    if (was_paused) --pause_ticks_;
    paused_ &= in_force;
    if (in_force != paused_ || in_force == 0) pause_ticks_ = 0;
    command_.light = contract::alarm_level(in_force);
    command_.sound = pause_ticks_ > 0 ? contract::AlarmLevel::none : command_.light;
    return was_paused && pause_ticks_ == 0;
  }

  [[nodiscard]] contract::AlarmCommand command() const noexcept { return command_; }
  /// Until it sounds again; 0 while it is not paused.
  [[nodiscard]] double pause_s() const noexcept { return pause_ticks_ * kTick_s; }

 private:
  contract::FaultBits paused_ = 0;
  std::uint32_t pause_ticks_ = 0;
  contract::AlarmCommand command_;
};

}  // namespace hoist::core
