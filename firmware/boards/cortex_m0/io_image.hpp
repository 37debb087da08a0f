// The input board, the same on every chip. Its source includes the chip's board.hpp and peripherals first.
#pragma once
#include "firmware/boards/cortex_m0/late.hpp"
#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/lib/image_header.hpp"
#include "firmware/nodes/io/io_node.hpp"

namespace hoist::firmware::io_image {
using namespace chip;
namespace {

[[gnu::section(".image_header"), gnu::used]] constinit const ImageHeaderWords kImageHeader =
    image_header(contract::ImageKind::io, kImageChip);

// Pin by pin, lowest bit first.
template <Pin... kPins>
struct Group {
  static void make_inputs() { (input_pin<kPins>(), ...); }
  // Bit set = pin high.
  static std::uint8_t read() {
    std::uint32_t bits = 0, bit = 0;
    ((bits |= (read_pin<kPins>() ? 1U : 0U) << bit++), ...);
    return static_cast<std::uint8_t>(bits);
  }
  static void write(std::uint8_t bits) {
    std::uint32_t bit = 0;
    (write_pin<kPins>(((static_cast<std::uint32_t>(bits) >> bit++) & 1U) != 0), ...);
  }
  // Low before they drive.
  static void make_outputs() {
    write(0);
    (output_pin<kPins>(), ...);
  }
};
using Bumpers = Group<kBumperFront, kBumperRear, kBumperLeft, kBumperRight>;
using Switches = Group<kSwitch0, kSwitch1, kSwitch2, kSwitch3>;
using Outputs = Group<kOutput0, kOutput1, kOutput2, kOutput3, kOutput4, kOutput5, kOutput6, kOutput7>;

class IoBoard : public cortex_m0::Board {
 public:
  void start() {
    Bumpers::make_inputs();
    Switches::make_inputs();
    analog_pin<kBatteryA>();
    analog_pin<kBatteryBoth>();
    (void)converter_.start();  // one that does not work gives readings that are not numbers
  }
  // The contacts open when pressed.
  std::uint8_t bumpers() { return Bumpers::read(); }
  // Bit 0 is the emergency stop chain: its contact opens, so that a cut wire reads as pressed. The others are closed to ground = 1.
  std::uint8_t switches() { return Switches::read() ^ 0x0EU; }
  float battery_v(int battery) {
    constexpr float kVolt = kAdcReference_v / kAdcCounts;
    const float lower_v = converter_.convert(kBatteryAChannel) * (kVolt * kBatteryADivider);
    if (battery == 0) return lower_v;
    return converter_.convert(kBatteryBothChannel) * (kVolt * kBatteryBothDivider) - lower_v;
  }
  void set_outputs(std::uint8_t outputs) { Outputs::write(outputs); }
  static void outputs_off() {
    start_ports();
    Outputs::make_outputs();
  }

 private:
  Converter converter_{};
};

constinit cortex_m0::Late<IoBoard> board_place;
constinit cortex_m0::Late<IoNode<IoBoard>> node_place;

}  // namespace
}  // namespace hoist::firmware::io_image

extern "C" {
using hoist::firmware::io_image::board_place;

void can_interrupt() { board_place.object.on_can_interrupt(); }

void hoist_outputs_off() { hoist::firmware::io_image::IoBoard::outputs_off(); }

[[noreturn]] void hoist_main() {
  using namespace hoist;
  using namespace hoist::firmware;
  auto& the_board = board_place.make();
  if (!the_board.start_core()) cortex_m0::refuse_to_start(the_board);
  the_board.start();
  if (!the_board.start_can({false, contract::node_id(contract::Node::io)})) cortex_m0::refuse_to_start(the_board);
  auto& node = io_image::node_place.make(the_board, contract::Node::io);
  cortex_m0::run(node, the_board);
}
}
