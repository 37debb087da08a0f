// The vector table: at the start of the image, and copied to the start of RAM, because this processor takes its vectors from address 0,
// where the loader's are.
#include <cstdint>

#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/boards/cortex_m0/startup.hpp"
#include "firmware/boards/stm32f072/memory.hpp"
#include "firmware/boards/stm32f072/registers.hpp"

extern "C" {
// Made by the linker script; this chip does not need it, a tool may check it.
extern std::uint32_t hoist_vector_checksum[];

void systick_interrupt() { hoist::firmware::cortex_m0::on_systick(); }
// An image defines the ones it uses; any other interrupt is a fault.
[[gnu::weak]] void can_interrupt() { fault_handler(); }
[[gnu::weak]] void usart1_interrupt() { fault_handler(); }
}

namespace {

using namespace hoist::firmware;

union Vector {
  std::uint32_t* address;
  void (*handler)();
};
constexpr std::size_t kVectors = stm32f072::kVectorBytes / 4;

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
  v.at[16 + stm32f072::irq::kCan] = {.handler = can_interrupt};
  v.at[16 + stm32f072::irq::kUsart1] = {.handler = usart1_interrupt};
  return v;
}

[[gnu::section(".vectors"), gnu::used]] constinit const Vectors kVectorTable = make_vectors();

}  // namespace

extern "C" void hoist_take_vectors() {
  const std::uint32_t from = reinterpret_cast<std::uintptr_t>(&kVectorTable);
  for (std::uint32_t i = 0; i < stm32f072::kVectorBytes; i += 4)
    cortex_m0::write_word(stm32f072::kRamStart + i, cortex_m0::read_word(from + i));
  stm32f072::rcc::Apb2Clocks::set(stm32f072::rcc::kSyscfg);
  stm32f072::MemoryMap::set(3);
}
