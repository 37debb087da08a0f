// The drive, the same on every chip: one image for both wheels, distinguished by the straps. Its source includes the chip's board.hpp and
// peripherals first and brings the interrupt of the encoder where that needs one.
#pragma once
#include "firmware/boards/cortex_m0/late.hpp"
#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/lib/image_header.hpp"
#include "firmware/nodes/drive/drive_node.hpp"

namespace hoist::firmware::drive_image {
using namespace chip;
namespace {

[[gnu::section(".image_header"), gnu::used]] constinit const ImageHeaderWords kImageHeader =
    image_header(contract::ImageKind::drive, kImageChip);

class DriveBoard : public cortex_m0::Board {
 public:
  // Outputs stay off: only the node switches the bridge on.
  void start() {
    analog_pin<kMotorCurrent>();
    analog_pin<kBusVoltage>();
    encoder_.start();
    (void)converter_.start();  // one that does not work gives readings that are not numbers
    bridge_.start();
    converter_.follow_timer(kMotorCurrentChannel);
  }

  std::int32_t encoder_counts() { return encoder_.counts(); }
  std::uint32_t edge_time_us() { return encoder_.edge_time_us(); }
  std::uint32_t illegal_encoder_steps() { return encoder_.illegal_steps(); }
  float motor_current_a() { return (converter_.newest(kMotorCurrentChannel) - kAdcCounts / 2) * kCurrent_a_per_count; }
  float supply_v() {
    const float counts = converter_.convert(kBusVoltageChannel);
    converter_.follow_timer(kMotorCurrentChannel);
    return counts * kBus_v_per_count;
  }
  bool driver_ok() { return Bridge::fault_line_high(); }
  void set_bridge(bool enabled, float duty_norm) { bridge_.set(enabled, duty_norm); }

  [[gnu::always_inline]] Encoder& encoder() { return encoder_; }  // for the interrupt of the LPC11C24, in RAM

 private:
  Encoder encoder_{};
  Converter converter_{};
  Bridge bridge_{};
};

constinit cortex_m0::Late<DriveBoard> board_place;
constinit cortex_m0::Late<DriveNode<DriveBoard>> node_place;

}  // namespace
}  // namespace hoist::firmware::drive_image

extern "C" {
using hoist::firmware::drive_image::board_place;

void can_interrupt() { board_place.object.on_can_interrupt(); }

void hoist_outputs_off() { hoist::firmware::chip::Bridge::outputs_off(); }

[[noreturn]] void hoist_main() {
  using namespace hoist;
  using namespace hoist::firmware;
  auto& the_board = board_place.make();
  if (!the_board.start_core()) cortex_m0::refuse_to_start(the_board);
  const cortex_m0::Straps straps = cortex_m0::read_straps();
  if (straps.strap0 == straps.strap1) cortex_m0::refuse_to_start(the_board);
  const contract::Node place = straps.strap0 ? contract::Node::drive_left : contract::Node::drive_right;
  the_board.start();
  if (!the_board.start_can({false, contract::node_id(place)})) cortex_m0::refuse_to_start(the_board);
  auto& node = drive_image::node_place.make(the_board, place);
  cortex_m0::run(node, the_board);
}
}
