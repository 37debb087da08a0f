#include "firmware/boards/cortex_m0/startup.hpp"

#include "firmware/boards/cortex_m0/registers.hpp"

// Defined beside the vector table: copies it into RAM and maps the processor's vectors there.
extern "C" void hoist_take_vectors();

extern "C" {

[[noreturn]] void reset_handler() {
  hoist_outputs_off();
  hoist_take_vectors();
  const std::uint32_t* from = hoist_data_load;
  for (std::uint32_t* to = hoist_data_start; to < hoist_data_end; ++to, ++from) *to = *from;
  for (std::uint32_t* to = hoist_bss_start; to < hoist_bss_end; ++to) *to = 0;
  // Everything below the frame of this function, which has called nothing yet.
  std::uint32_t* here = nullptr;
  asm volatile("mov %0, sp" : "=r"(here));
  for (std::uint32_t* to = hoist_stack_low; to < here; ++to) *to = hoist::firmware::cortex_m0::kStackPaint;
  hoist_main();
}

// HardFault and every unexpected interrupt: outputs off, then the watchdog's reset, whose cause a drive keeps as a fault (6010h) until it is
// reset. A reset by software looks like an update and would be forgotten; it is what ends a program that fails before its watchdog runs.
[[noreturn]] void fault_handler() {
  hoist::firmware::cortex_m0::disable_interrupts();
  hoist_outputs_off();
  hoist::firmware::cortex_m0::outwait_watchdog();
  hoist::firmware::cortex_m0::reset_now();
}

// The compiler references this for pure virtual calls. There are none; without it the library's version would be linked.
[[noreturn]] void __cxa_pure_virtual() { fault_handler(); }
}
