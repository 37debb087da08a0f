// H21: the console in control vanished while the hoist was led. The server says so when it gives up the connection; a holder who gives control
// back by hand is not missed.
#pragma once
#include <cstdint>

#include "control/core/base/mutation.hpp"

namespace hoist::core {

class ConsoleWatch {
 public:
  /// The holder's connection ended. At rest nobody needs to come.
  void left(bool moving) noexcept { gone_ = moving; }
  /// Somebody is in control again.
  void taken() noexcept { gone_ = false; }

  /// Once per step. A hoist that was led is missed for another minute after its motion: the patient still hangs in it.
  void step(bool moving) noexcept {
    rest_ticks_ = moving ? 0 : rest_ticks_ + 1;
    if (rest_ticks_ >= hold<contract::Fault::console_lost, "rest">(kConsoleLostTicks)) gone_ = false;
  }
  [[nodiscard]] bool gone() const noexcept { return gone_; }

 private:
  static constexpr std::uint32_t kConsoleLostTicks = 6000;  // 60 s

  std::uint32_t rest_ticks_ = 0;
  bool gone_ = false;
};

}  // namespace hoist::core
