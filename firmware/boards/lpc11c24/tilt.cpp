// The tilt sensor on the LPC11C24.
#include "firmware/boards/lpc11c24/board.hpp"
#include "firmware/boards/lpc11c24/serial_buses.hpp"

#include "firmware/boards/cortex_m0/tilt_image.hpp"
