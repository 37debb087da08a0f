// The drive on the LPC11C24.
#include "firmware/boards/lpc11c24/board.hpp"
#include "firmware/boards/lpc11c24/bridge.hpp"
#include "firmware/boards/lpc11c24/encoder.hpp"

#include "firmware/boards/cortex_m0/drive_image.hpp"

// From RAM: up to 70 000 edges per second.
extern "C" [[gnu::section(".ramcode")]] void gpio2_interrupt() {
  hoist::firmware::drive_image::board_place.object.encoder().on_interrupt();
}
