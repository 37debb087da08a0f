// The input board on the STM32F072.
#include "firmware/boards/stm32f072/board.hpp"
#include "firmware/boards/stm32f072/bridge.hpp"

#include "firmware/boards/cortex_m0/io_image.hpp"
