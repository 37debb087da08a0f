// The input board on the STM32F072.
#include "firmware/boards/cortex_m0/late.hpp"
#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/boards/stm32f072/board.hpp"
#include "firmware/boards/stm32f072/bridge.hpp"
#include "firmware/boot/image_header.hpp"
#include "firmware/nodes/io/io_node.hpp"

namespace hoist::firmware::stm32f072 {
namespace {

[[gnu::section(".image_header"), gnu::used]] constinit const ImageHeaderWords kImageHeader =
    image_header(contract::ImageKind::io, kImageChip);

// Pin by pin, lowest bit first.
template <Pin... kPins>
struct Group {
  static void make_inputs() { (set_pin<kPins>(PinMode::input, PinPull::up), ...); }
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
    (set_pin<kPins>(PinMode::output), ...);
  }
};
using Bumpers = Group<kBumperFront, kBumperRear, kBumperLeft, kBumperRight>;
using Switches = Group<kSwitch0, kSwitch1, kSwitch2, kSwitch3>;
using Outputs = Group<kOutput0, kOutput1, kOutput2, kOutput3, kOutput4, kOutput5, kOutput6, kOutput7>;

class IoBoard : public Board {
 public:
  void start() {
    Bumpers::make_inputs();
    Switches::make_inputs();
    set_pin<kBatteryA>(PinMode::analog);
    set_pin<kBatteryBoth>(PinMode::analog);
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
    rcc::AhbClocks::set(rcc::kPorts);
    Outputs::make_outputs();
  }

 private:
  Converter converter_{};
};

constinit cortex_m0::Late<IoBoard> board_place;
constinit cortex_m0::Late<IoNode<IoBoard>> node_place;

}  // namespace
}  // namespace hoist::firmware::stm32f072

extern "C" {
using hoist::firmware::stm32f072::board_place;

void can_interrupt() { board_place.object.on_can_interrupt(); }

void hoist_outputs_off() { hoist::firmware::stm32f072::IoBoard::outputs_off(); }

[[noreturn]] void hoist_main() {
  using namespace hoist;
  using namespace hoist::firmware;
  auto& the_board = board_place.make();
  if (!the_board.start_core()) cortex_m0::refuse_to_start(the_board);
  the_board.start();
  if (!the_board.start_can({false, contract::node_id(contract::Node::io)})) cortex_m0::refuse_to_start(the_board);
  auto& node = stm32f072::node_place.make(the_board, contract::Node::io);
  cortex_m0::run(node, the_board);
}
}
