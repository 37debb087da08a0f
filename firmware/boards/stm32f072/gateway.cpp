// The gateway on the STM32F072.
#include "firmware/boards/stm32f072/board.hpp"
#include "firmware/boards/stm32f072/uart.hpp"

#include "firmware/boards/cortex_m0/gateway_image.hpp"

extern "C" void usart1_interrupt() { hoist::firmware::gateway_image::board_place.object.on_uart_interrupt(); }
