#include "firmware/boards/cortex_m0/startup.hpp"

#include "firmware/boards/cortex_m0/registers.hpp"

// Defined beside the vector table: copies it into RAM and lets the processor take its vectors from there.
extern "C" void hoist_take_vectors();

extern "C" {

[[noreturn]] void reset_handler() {
  hoist_outputs_off();
  hoist_take_vectors();
  const std::uint32_t* from = hoist_data_load;
  for (std::uint32_t* to = hoist_data_start; to < hoist_data_end; ++to, ++from) *to = *from;
  for (std::uint32_t* to = hoist_bss_start; to < hoist_bss_end; ++to) *to = 0;
  // All below the frame of this very function, which calls nothing until then.
  std::uint32_t* here = nullptr;
  asm volatile("mov %0, sp" : "=r"(here));
  for (std::uint32_t* to = hoist_stack_low; to < here; ++to) *to = hoist::firmware::cortex_m0::kStackPaint;
  hoist_main();
}

// HardFault and every interrupt that nobody asked for: outputs off, then a reset. The cause is in the chip's reset register afterwards; a
// node that finds it there says so before anything moves.
[[noreturn]] void fault_handler() {
  hoist::firmware::cortex_m0::disable_interrupts();
  hoist_outputs_off();
  hoist::firmware::cortex_m0::reset_now();
}

// The compiler asks for this one when a pure virtual function could be called. There are none; without it the library would bring its own.
[[noreturn]] void __cxa_pure_virtual() { fault_handler(); }
}
