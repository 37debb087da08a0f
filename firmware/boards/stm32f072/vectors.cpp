#include "firmware/boards/cortex_m0/vectors.hpp"
#include "firmware/boards/stm32f072/memory.hpp"
#include "firmware/boards/stm32f072/registers.hpp"

using namespace hoist::firmware;
using namespace hoist::firmware::stm32f072;

// An image defines the ones it uses.
extern "C" {
[[gnu::weak]] void can_interrupt() { fault_handler(); }
[[gnu::weak]] void usart1_interrupt() { fault_handler(); }
}

namespace {

[[gnu::section(".vectors"), gnu::used]] constinit const auto kVectorTable =
    cortex_m0::make_vectors<kVectorBytes>({{irq::kCan, can_interrupt}, {irq::kUsart1, usart1_interrupt}});

}  // namespace

extern "C" void hoist_take_vectors() {
  cortex_m0::copy_vectors(kVectorTable, kRamStart);
  rcc::Apb2Clocks::set(rcc::kSyscfg);
  MemoryMap::set(3);
}
