// The input board on the LPC11C24.
#include "firmware/boards/lpc11c24/board.hpp"
#include "firmware/boards/lpc11c24/bridge.hpp"

#include "firmware/boards/cortex_m0/io_image.hpp"
