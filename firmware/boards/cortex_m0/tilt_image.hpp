// The tilt sensor's image, the same on every chip: one image for both struts and the base, distinguished by the straps, and for three
// inertial chips, distinguished by their identity. Its source includes the chip's board.hpp and peripherals first.
#pragma once
#include <array>

#include "firmware/boards/cortex_m0/late.hpp"
#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/lib/image_header.hpp"
#include "firmware/lib/imu/icm42688p.hpp"
#include "firmware/lib/imu/lsm6dso.hpp"
#include "firmware/lib/imu/mpu6050.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"

namespace hoist::firmware::tilt_image {
using namespace chip;
namespace {

[[gnu::section(".image_header"), gnu::used]] constinit const ImageHeaderWords kImageHeader =
    image_header(contract::ImageKind::tilt, kImageChip);

inline constexpr std::uint32_t kRetryIdentity_ms = 100;

class TiltBoard : public cortex_m0::Board {
 public:
  void start() {
    I2cBus::start();
    SpiBus::start();
  }

  void tick_1ms() {
    if (found_) return imu_.step_1ms();
    if (++since_request_ms_ == kRetryIdentity_ms) ask();
  }
  bool read_imu(ImuSample& sample) { return found_ && imu_.read(sample); }
  [[nodiscard]] ImuReport imu_report() const { return found_ ? imu_.report() : foreign_; }

 private:
  // Reads identities only; the chip's driver resets it and reads its identity again.
  void ask() {
    since_request_ms_ = 0;
    std::array<std::uint8_t, 1> answer{};
    if (spi_.read(Lsm6dsoChip::kWhoAmIRegister, answer) && answer[0] == Lsm6dsoChip::kWhoAmI) {
      use(ImuChip<SpiBus, Lsm6dsoChip>(spi_));
    } else if (spi_.read(Icm42688pChip::kWhoAmIRegister, answer) && answer[0] == Icm42688pChip::kWhoAmI) {
      use(ImuChip<SpiBus, Icm42688pChip>(spi_));
    } else if (i2c_.read(Mpu6050Chip::kWhoAmIRegister, answer)) {
      use(ImuChip<I2cBus, Mpu6050Chip>(i2c_));  // or another chip at its address: the driver checks
    } else if (answer[0] != 0x00 && answer[0] != 0xFF) {
      foreign_ = {false, true, false, answer[0]};  // another chip answers on SPI
    }
  }

  void use(const ImuEngine& chip) {
    imu_ = chip;
    found_ = true;
  }

  I2cBus i2c_{kMpu6050Address};
  SpiBus spi_{};
  bool found_ = false;
  ImuEngine imu_ = ImuChip<I2cBus, Mpu6050Chip>(i2c_);
  std::uint32_t since_request_ms_ = 0;
  ImuReport foreign_{};
};

constinit cortex_m0::Late<TiltBoard> board_place;
constinit cortex_m0::Late<TiltNode<TiltBoard>> node_place;

[[noreturn]] void run_as(TiltBoard& the_board, contract::Node place) {
  the_board.start();
  if (!the_board.start_can({false, contract::node_id(place)})) cortex_m0::refuse_to_start(the_board);
  auto& node = node_place.make(the_board, place);
  cortex_m0::run(node, the_board);
}

}  // namespace
}  // namespace hoist::firmware::tilt_image

extern "C" {
using hoist::firmware::tilt_image::board_place;

void can_interrupt() { board_place.object.on_can_interrupt(); }

void hoist_outputs_off() {}

[[noreturn]] void hoist_main() {
  using namespace hoist;
  auto& the_board = board_place.make();
  if (!the_board.start_core()) firmware::cortex_m0::refuse_to_start(the_board);
  const firmware::cortex_m0::Straps straps = firmware::cortex_m0::read_straps();
  if (!straps.strap0 && !straps.strap1) firmware::cortex_m0::refuse_to_start(the_board);
  firmware::tilt_image::run_as(the_board, straps.strap0 && straps.strap1 ? contract::Node::tilt_base
                                          : straps.strap0                ? contract::Node::tilt_left
                                                                         : contract::Node::tilt_right);
}
}
