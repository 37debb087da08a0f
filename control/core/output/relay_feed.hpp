// The outputs of the input node, in one frame each 50 ms: alarm signals, synchronisation, and the feed of the motors' relay.
//
// Feeds the relay in the motors' supply (hazards H1, H23): an output of the input node that goes up and down as long as the core steps.
//
// The relay's own circuit takes the changes, not the level, so a core that hangs with the output on holds nothing. It opens about one second
// after the last change: later than the drives need to brake by themselves (0.045 s deadline, then 0.65 m/s at 1.0 m/s2), because a motor
// without supply does not brake evenly, and soon enough for a drive that did not. A runaway motor (output/runaway_watch.hpp) is not given
// that second: the feed ends, and a second output empties the circuit at once. The contract with the circuit: firmware/HARDWARE.md.
#pragma once
#include <cstdint>

#include "control/contract/alarms.hpp"
#include "control/contract/can_dictionary.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

class RelayFeed {
 public:
  /// A change each 50 ms: twenty a second. The node's own deadline (1400h:5, 120 ms) lies after the second next frame, so that one may be lost.
  static constexpr std::uint8_t kTicks = 5;

  /// Opens the relay and keeps it open until restore(). Should the second output not reach it, the missing feed opens it a second later.
  void cut() noexcept {
    cut_ = true;
    ticks_ = kTicks;  // told in this step
  }
  void restore() noexcept { cut_ = false; }
  [[nodiscard]] bool is_cut() const noexcept { return cut_; }

  /// What the outputs are to show in this step.
  struct Outputs {
    bool feeds = true;  // the relay may be closed
    bool sync = false;
    contract::AlarmCommand alarm;
  };

  /// Once per step, in every mode: what may move is decided elsewhere, this only says that the core decides. Without `feeds` the frames go on:
  /// they carry the alarm, and the node signals one by itself when they end.
  template <std::size_t N>
  void step(FixedVector<contract::CanFrame, N>& out, const Outputs& outputs) noexcept {
    if (ticks_ < kTicks) ++ticks_;
    if (ticks_ < kTicks) return;
    ticks_ = 0;
    if (!cut_ && outputs.feeds) level_ ^= contract::canopen::kRelayFeed;
    contract::CanFrame frame{contract::pdo_cob_id(contract::Pdo::io_rx1, contract::Node::io),
                             static_cast<std::uint8_t>(contract::pdo_bytes(contract::Pdo::io_rx1)),
                             0,
                             {}};
    sync_ = outputs.sync;
    frame.data[0] =
        static_cast<std::uint8_t>(level_ | (cut_ ? contract::canopen::kRelayRelease : 0U) | (sync_ ? contract::canopen::kSyncOutput : 0U));
    frame.data[1] = contract::alarm_byte(outputs.alarm);
    static_cast<void>(out.push_back(frame));
  }
  [[nodiscard]] std::uint8_t level() const noexcept { return level_; }
  /// Of the synchronisation output, as last sent.
  [[nodiscard]] std::uint8_t sync_level() const noexcept { return sync_ ? 1 : 0; }

 private:
  std::uint8_t ticks_ = 0, level_ = 0;
  bool cut_ = false, sync_ = false;
};

}  // namespace hoist::core
