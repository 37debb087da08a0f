// The gateway on the LPC11C24.
#include "firmware/boards/lpc11c24/board.hpp"
#include "firmware/boards/lpc11c24/uart.hpp"

#include "firmware/boards/cortex_m0/gateway_image.hpp"

extern "C" void uart_interrupt() { hoist::firmware::gateway_image::board_place.object.on_uart_interrupt(); }
