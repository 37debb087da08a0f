// What the core remembers of an acknowledgement: a press that waits for a drive, and the bumpers it was for (supervise/release.hpp).
#pragma once
#include <cstdint>

#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"

namespace hoist::core {

/// What goes with a press of the release.
struct Press {
  std::uint32_t request_id = 0, client = 0;
  contract::Role role = contract::Role::therapist;
  contract::FaultBits seen = 0;  // the faults it is about, 0 = all there are: one that came after them is no part of it
};

class Acknowledgement {
 public:
  struct Waiting {
    std::uint32_t request_id = 0, client = 0;
    std::uint32_t lease_epoch = 0;  // of the client that pressed
    std::uint8_t bumpers = 0;       // that touched at the press, and have touched ever since
    std::uint8_t ticks_left = 0;
    bool overtaken = false;
  };

  /// An earlier press waits for a drive.
  [[nodiscard]] bool waits() const noexcept { return waits_.ticks_left > 0; }
  /// Bumpers that touch still and were acknowledged so: the therapist may drive off them (H13).
  [[nodiscard]] std::uint8_t bumpers() const noexcept { return bumpers_; }

  /// Once per step, before the monitors: what was let go counts anew when it touches again.
  void next_tick(std::uint8_t touching) noexcept {
    bumpers_ &= touching;
    waits_.bumpers &= touching;
  }
  /// A new cause has stopped the hoist since the press; the press does not acknowledge it.
  void overtake() noexcept { waits_.overtaken = true; }
  /// Nothing is waited for any more: answered, or without power, or out of service.
  void drop() noexcept { waits_ = {}; }

  /// A press from now on waits for a drive to leave its fault.
  void wait(const Waiting& press) noexcept { waits_ = press; }
  /// One step of waiting.
  void count_down() noexcept { --waits_.ticks_left; }
  [[nodiscard]] const Waiting& pressed() const noexcept { return waits_; }
  /// These bumpers are acknowledged while they touch.
  void accept(std::uint8_t bumpers) noexcept { bumpers_ = bumpers; }

 private:
  Waiting waits_;
  std::uint8_t bumpers_ = 0;
};

}  // namespace hoist::core
