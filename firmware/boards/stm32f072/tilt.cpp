// The tilt sensor on the STM32F072.
#include "firmware/boards/stm32f072/board.hpp"
#include "firmware/boards/stm32f072/serial_buses.hpp"

#include "firmware/boards/cortex_m0/tilt_image.hpp"
