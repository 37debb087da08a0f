// The vector table: at the start of the image, and copied to the start of RAM, because this processor takes its vectors from address 0,
// where the loader's are.
#include <cstdint>

#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/boards/cortex_m0/startup.hpp"
#include "firmware/boards/lpc11c24/memory.hpp"
#include "firmware/boards/lpc11c24/registers.hpp"

extern "C" {
// Made by the linker script so that the first eight words add up to zero: otherwise the ROM does not start the program at address 0.
extern std::uint32_t hoist_vector_checksum[];

void systick_interrupt() { hoist::firmware::cortex_m0::on_systick(); }
// An image defines the ones it uses; any other interrupt is a fault.
[[gnu::weak]] void can_interrupt() { fault_handler(); }
[[gnu::weak]] void uart_interrupt() { fault_handler(); }
[[gnu::weak]] void gpio2_interrupt() { fault_handler(); }
}

namespace {

using namespace hoist::firmware;

union Vector {
  std::uint32_t* address;
  void (*handler)();
};
constexpr std::size_t kVectors = lpc11c24::kVectorBytes / 4;

struct Vectors {
  Vector at[kVectors];
};

consteval Vectors make_vectors() {
  Vectors v{};
  for (Vector& entry : v.at) entry = {.handler = fault_handler};
  v.at[0] = {.address = hoist_stack_top};
  v.at[1] = {.handler = reset_handler};
  for (std::size_t i = 4; i < 16; ++i) v.at[i] = {.address = nullptr};  // reserved
  v.at[7] = {.address = hoist_vector_checksum};
  v.at[11] = {.handler = fault_handler};  // SVC
  v.at[14] = {.handler = fault_handler};  // PendSV
  v.at[15] = {.handler = systick_interrupt};
  v.at[16 + lpc11c24::irq::kCan] = {.handler = can_interrupt};
  v.at[16 + lpc11c24::irq::kUart] = {.handler = uart_interrupt};
  v.at[16 + lpc11c24::irq::kGpio2] = {.handler = gpio2_interrupt};
  return v;
}

[[gnu::section(".vectors"), gnu::used]] constinit const Vectors kVectorTable = make_vectors();

}  // namespace

extern "C" void hoist_take_vectors() {
  const std::uint32_t from = reinterpret_cast<std::uintptr_t>(&kVectorTable);
  for (std::uint32_t i = 0; i < lpc11c24::kVectorBytes; i += 4)
    cortex_m0::write_word(lpc11c24::kRamStart + i, cortex_m0::read_word(from + i));
  lpc11c24::syscon::Remap::write(1);
}
