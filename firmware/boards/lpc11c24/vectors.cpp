#include "firmware/boards/cortex_m0/vectors.hpp"
#include "firmware/boards/lpc11c24/memory.hpp"
#include "firmware/boards/lpc11c24/registers.hpp"

using namespace hoist::firmware;
using namespace hoist::firmware::lpc11c24;

// An image defines the ones it uses.
extern "C" {
[[gnu::weak]] void can_interrupt() { fault_handler(); }
[[gnu::weak]] void uart_interrupt() { fault_handler(); }
[[gnu::weak]] void gpio2_interrupt() { fault_handler(); }
}

namespace {

[[gnu::section(".vectors"), gnu::used]] constinit const auto kVectorTable =
    cortex_m0::make_vectors<kVectorBytes>({{irq::kCan, can_interrupt}, {irq::kUart, uart_interrupt}, {irq::kGpio2, gpio2_interrupt}});

}  // namespace

extern "C" void hoist_take_vectors() {
  cortex_m0::copy_vectors(kVectorTable, kRamStart);
  syscon::Remap::write(1);
}
