// Which frames may share the three mailboxes of the bxCAN. It sends the lowest identifier among them, but a mailbox once filled stays so: three
// frames of low priority would delay a fourth of a higher one.
#pragma once
#include <cstdint>
#include <span>

namespace hoist::firmware::stm32f072 {

// Orders of arbitration (cortex_m0/can_filter.hpp) from which process data and SDO begin.
inline constexpr std::uint32_t kProcessOrder = 0x180U << 19, kServiceOrder = 0x580U << 19;

// Whether a frame may take a free mailbox. NMT, SYNC and EMCY always; all others together two, so that one stays free; SDO and heartbeats
// one, so that PDOs find another. control/contract/bus_load.hpp computes with this rule.
constexpr bool may_take_mailbox(std::uint32_t order, std::span<const std::uint32_t> waiting) {
  std::uint32_t process = 0, service = 0;
  for (const std::uint32_t other : waiting) {
    process += other >= kProcessOrder ? 1U : 0U;
    service += other >= kServiceOrder ? 1U : 0U;
  }
  return (order < kProcessOrder || process < 2) && (order < kServiceOrder || service < 1);
}

}  // namespace hoist::firmware::stm32f072
