// From reset to main, the same for both chips: the chip's vector table names `reset_handler`, its linker script the symbols below.
#pragma once
#include <cstdint>

extern "C" {
extern std::uint32_t hoist_data_load[], hoist_data_start[], hoist_data_end[], hoist_bss_start[], hoist_bss_end[], hoist_stack_low[],
    hoist_stack_top[];

// Each image has these two. outputs_off() runs before memory is set up: it may touch registers only. The second starts clocks, builds
// board and node, and never returns.
void hoist_outputs_off();
[[noreturn]] void hoist_main();

[[noreturn]] void reset_handler();
[[noreturn]] void fault_handler();
}

namespace hoist::firmware::cortex_m0 {
// What unused stack looks like; how far down it has been used is read off by a debugger or the emulator bench.
inline constexpr std::uint32_t kStackPaint = 0x57AC57AC;
}  // namespace hoist::firmware::cortex_m0
