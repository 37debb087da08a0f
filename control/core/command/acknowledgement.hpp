// What the core remembers of an acknowledgement: a press that waits for a drive, and the bumpers it was for (supervise/release.hpp).
#pragma once
#include <cstdint>

#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"

namespace hoist::core {

/// One request to acknowledge.
struct Press {
  std::uint32_t request_id = 0, client = 0;
  contract::Role role = contract::Role::therapist;
  contract::FaultBits seen = 0;  // faults that the client was shown, 0 = all; later ones are not acknowledged
};

class Acknowledgement {
 public:
  struct Waiting {
    std::uint32_t request_id = 0, client = 0;
    std::uint32_t lease_epoch = 0;  // of the client that pressed
    std::uint8_t bumpers = 0;       // pressed at the acknowledgement and without a break since
    std::uint8_t ticks_left = 0;
    bool overtaken = false;
  };

  /// An earlier press waits for a drive.
  [[nodiscard]] bool waits() const noexcept { return waits_.ticks_left > 0; }
  /// Acknowledged bumpers that are still pressed: the therapist may drive away from them (H13).
  [[nodiscard]] std::uint8_t bumpers() const noexcept { return bumpers_; }

  /// Once per step, before the monitors: a released bumper counts as new when it is pressed again.
  void next_tick(std::uint8_t touching) noexcept {
    bumpers_ &= touching;
    waits_.bumpers &= touching;
  }
  /// A new cause has stopped the hoist since the request, which does not acknowledge it.
  void overtake() noexcept { waits_.overtaken = true; }
  /// Ends the wait: answered, without power, or out of service.
  void drop() noexcept { waits_ = {}; }

  /// From now on the request waits for a drive to leave its fault.
  void wait(const Waiting& press) noexcept { waits_ = press; }
  /// One step of waiting.
  void count_down() noexcept { --waits_.ticks_left; }
  [[nodiscard]] const Waiting& pressed() const noexcept { return waits_; }
  /// These bumpers are acknowledged while they stay pressed.
  void accept(std::uint8_t bumpers) noexcept { bumpers_ = bumpers; }

 private:
  Waiting waits_;
  std::uint8_t bumpers_ = 0;
};

}  // namespace hoist::core
