// Stands in for the input node (id 08h) when bumpers, switches and batteries come from a PoKeys: boot-up, heartbeat, NMT, identity by SDO,
// and its two PDOs, equal to the CAN node's frames. So core, monitors and recordings need no change.
//
// Fail-safe: without a fresh answer of the device all four bumpers read as pressed and, a little later, the batteries as 0 V. After a
// longer silence the stand-in stops too, so that the core reports the lost node.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/bus/pokeys/device.hpp"
#include "control/contract/can_dictionary.hpp"

namespace hoist::bus::pokeys {

class IoStandIn {
 public:
  static constexpr contract::Node kNode = contract::Node::io;
  static constexpr std::uint64_t kStaleNs = 100'000'000;         // an older answer counts as "pressed"
  static constexpr std::uint64_t kBatteryStaleNs = 500'000'000;  // five polls
  static constexpr std::uint64_t kGoneNs = 1'000'000'000;        // from here on the node sends nothing
  static constexpr std::uint64_t kHeartbeatNs = 100'000'000;
  static constexpr std::uint8_t kAllPressed = 0x0F;
  static constexpr std::size_t kRepliesMax = 4;
  static constexpr std::size_t kFramesMax = kRepliesMax + 3;  // in one step: answers, heartbeat, two process data

  // Whether a frame belongs to the input node, from or to it.
  [[nodiscard]] static bool is_from_node(const contract::CanFrame& frame);
  // A frame the core has sent. Answers leave with the next step().
  void on_frame(const contract::CanFrame& frame);
  // Writes the frames that are due at `now_ns`; how many. `pressed` = bumpers touched since the last call, even if they are free again.
  std::size_t step(const Readings& readings, std::uint8_t pressed, std::uint64_t now_ns, std::span<contract::CanFrame> out);

 private:
  void answer_sdo(const contract::CanFrame& request);
  void boot(std::uint64_t now_ns);

  contract::canopen::NmtState state_ = contract::canopen::NmtState::boot_up;
  bool silent_ = true;
  std::uint64_t heartbeat_at_ns_ = 0, inputs_at_ns_ = 0, batteries_at_ns_ = 0;
  std::uint8_t shown_bumpers_ = 0, shown_switches_ = 0;
  std::array<contract::CanFrame, kRepliesMax> replies_{};
  std::size_t reply_count_ = 0;
};

}  // namespace hoist::bus::pokeys
