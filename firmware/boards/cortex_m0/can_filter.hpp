// Which frames a node reads, and in which order frames leave. The same for every controller.
#pragma once
#include <cstdint>

#include "control/contract/can_frame.hpp"

namespace hoist::firmware::cortex_m0 {

// The rest is dropped in the interrupt. The gateway takes all.
struct CanFilter {
  bool all = true;
  std::uint8_t node_id = 0;
  [[nodiscard]] bool wants(std::uint32_t id, bool extended) const {
    if (all) return true;
    if (extended) return false;
    const std::uint32_t node = id & 0x7FU;
    // NMT and SYNC, all heartbeats, and its own identifiers, also those that it sends: they reveal a second node with
    // this id.
    return node == 0 || node == node_id || (id >> 7) == 0xE;
  }
};

// Identifiers in the order of arbitration: a standard frame goes before an extended one with the same first 11 bits.
inline std::uint32_t arbitration_order(const contract::CanFrame& frame) {
  return (frame.flags & contract::CanFrame::kExtended) != 0 ? (frame.id << 1) | 1U : frame.id << 19;
}

}  // namespace hoist::firmware::cortex_m0
