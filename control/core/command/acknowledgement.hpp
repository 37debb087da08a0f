// The release of a stop: a person has seen why the hoist stopped and says so. It may have to wait for a drive to leave its fault.
#pragma once
#include <cstdint>

#include "control/contract/commands.hpp"
#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"

namespace hoist::core {

struct CoreState;

/// What goes with a press of the release.
struct Press {
  std::uint32_t request_id = 0, client = 0;
  contract::Role role = contract::Role::therapist;
  contract::FaultBits seen = 0;  // the faults it is about, 0 = all there are: one that came after them is no part of it
};

class Acknowledgement {
 public:
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

  /// Leaves PROTECTIVE_STOP, FAULT or EMERGENCY_STOP. Refusal bits; 0 = done, or under way while waits(): then serve() answers.
  [[nodiscard]] static std::uint32_t press(CoreState& state, const Press& press) noexcept;
  /// Once per step: a press that waits for a drive ends here, one way or the other.
  static void serve(CoreState& state) noexcept;

 private:
  struct Waiting {
    std::uint32_t request_id = 0, client = 0;
    std::uint32_t lease_epoch = 0;  // of the client that pressed
    std::uint8_t bumpers = 0;       // that touched at the press, and have touched ever since
    std::uint8_t ticks_left = 0;
    bool overtaken = false;
  };

  Waiting waits_;
  std::uint8_t bumpers_ = 0;
};

}  // namespace hoist::core
