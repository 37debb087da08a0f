// Common to the loaders of every chip. One image per node kind, because the kind decides which straps mean which node and whose programs it
// takes; HOIST_LOADER_KIND is its name. The loader's source includes its chip's board.hpp first.
#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "control/contract/firmware_image.hpp"
#include "firmware/boards/cortex_m0/board.hpp"
#include "firmware/boot/loader.hpp"

namespace hoist::firmware::cortex_m0 {
namespace {

constexpr contract::ImageKind kKind = contract::ImageKind::HOIST_LOADER_KIND;
constexpr contract::ImageChipInfo kChip = *contract::find_image_chip(static_cast<std::uint8_t>(kImageChip));
static_assert(kChip.application_at == kApplicationStart && kChip.application_max == kApplicationBytes);
static_assert(kChip.ram_at == kRamStart && kChip.ram_bytes == kRamBytes);

// A gateway has no place among the nodes: its loader uses the number below the computer's.
constexpr std::uint8_t kGatewayLoader = 0x7E;

class LoaderBoard {
 public:
  [[nodiscard]] static constexpr contract::ImageKind kind() { return kKind; }
  [[nodiscard]] static constexpr const contract::ImageChipInfo& chip() { return kChip; }
  [[nodiscard]] std::span<const std::uint8_t> application() const {
    return {reinterpret_cast<const std::uint8_t*>(kApplicationStart), kApplicationBytes};
  }
  Mailbox& mailbox() { return cortex_m0::mailbox(); }
  void restart() { reset_now(); }
};

bool service_pin_low() {
  input_pin<kService>();
  wait_for_pull_ups();
  return !read_pin<kService>();
}

// 0: no valid strap. Such a board stays off the bus: two nodes with one id would be worse than none.
std::uint8_t loader_id() {
  if constexpr (kKind == contract::ImageKind::io) return contract::node_id(contract::Node::io);
  if constexpr (kKind == contract::ImageKind::gateway) return kGatewayLoader;
  const Straps straps = read_straps();
  if constexpr (kKind == contract::ImageKind::drive) {
    if (straps.strap0 == straps.strap1) return 0;
    return straps.strap0 ? contract::node_id(contract::Node::drive_left) : contract::node_id(contract::Node::drive_right);
  } else {
    constexpr std::array kIds{std::uint8_t{0}, contract::node_id(contract::Node::tilt_left), contract::node_id(contract::Node::tilt_right),
                              contract::node_id(contract::Node::tilt_base)};
    return kIds[(straps.strap0 ? 1U : 0U) | (straps.strap1 ? 2U : 0U)];
  }
}

[[noreturn]] void start_application() {
  const std::uint32_t stack = read_word(kApplicationStart), entry = read_word(kApplicationStart + 4);
  asm volatile("msr msp, %0\n\tbx %1" ::"r"(stack), "r"(entry));
  __builtin_unreachable();
}

}  // namespace
}  // namespace hoist::firmware::cortex_m0
