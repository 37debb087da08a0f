// The gateway between serial line and bus, the same on every chip. Its source includes the chip's board.hpp and peripherals
// first and brings the interrupt of the serial line.
#pragma once
#include "firmware/boards/cortex_m0/late.hpp"
#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/lib/image_header.hpp"
#include "firmware/nodes/gateway/gateway_node.hpp"

namespace hoist::firmware::gateway_image {
using namespace chip;
namespace {

[[gnu::section(".image_header"), gnu::used]] constinit const ImageHeaderWords kImageHeader =
    image_header(contract::ImageKind::gateway, kImageChip);

class GatewayBoard : public cortex_m0::Board {
 public:
  void start() { uart_.start(); }
  std::size_t uart_read(std::span<char> in) { return uart_.read(in); }
  std::size_t uart_write(std::span<const char> out) { return uart_.write(out); }
  [[nodiscard]] std::uint32_t uart_lost() const { return uart_.lost(); }
  [[nodiscard]] bool has_work() const { return uart_.has_characters(); }

  void on_uart_interrupt() { uart_.on_interrupt(); }

 private:
  Uart uart_{};
};

constinit cortex_m0::Late<GatewayBoard> board_place;
constinit cortex_m0::Late<GatewayNode<GatewayBoard>> node_place;

}  // namespace
}  // namespace hoist::firmware::gateway_image

extern "C" {
using hoist::firmware::gateway_image::board_place;

void can_interrupt() { board_place.object.on_can_interrupt(); }

void hoist_outputs_off() {}

[[noreturn]] void hoist_main() {
  using namespace hoist::firmware;
  auto& the_board = board_place.make();
  if (!the_board.start_core()) cortex_m0::refuse_to_start(the_board);
  the_board.start();
  if (!the_board.start_can({})) cortex_m0::refuse_to_start(the_board);
  auto& node = gateway_image::node_place.make(the_board);
  cortex_m0::run(node, the_board);
}
}
