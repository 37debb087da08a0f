// The tilt sensor on the LPC11C24.
#include "firmware/boards/lpc11c24/board.hpp"
#include "firmware/boards/lpc11c24/serial_buses.hpp"

namespace hoist::firmware {
namespace chip = lpc11c24;
}

#include "firmware/boards/cortex_m0/tilt_image.hpp"
