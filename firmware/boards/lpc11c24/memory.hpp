// Memory map of an LPC11C24: flash in sectors of 4 KB, 8 KB of RAM. The linker script (application.ld) repeats these figures.
//
//   0x0000 - 0x0FFF  loader (firmware/boot)
//   0x1000 - 0x6FFF  application: vectors, image header at +0xC0, program
//   0x7000 - 0x7FFF  stored parameters (parameter_pages.hpp)
//
//   0x10000000  vectors of the running program (the processor has no register for their place, SYSMEMREMAP maps RAM to address 0)
//   0x100000C0  variables, then the stack
//   0x10001FE0  32 bytes of the factory's flash routines
//
//   0x40038004  mailbox between application and loader: the general purpose registers GPREG0 to 3 of the PMU, which only power-on clears
//               (UM10398, chapter 4). Not RAM: the boot ROM runs after each reset with its stack under the last 32 bytes, up to 256 deep,
//               and its variables at 0x1000017C to 0x1000025B (UM10398, RAM used by the ISP command handler)
#pragma once
#include <cstddef>
#include <cstdint>

#include "control/contract/firmware_image.hpp"

namespace hoist::firmware::lpc11c24 {

inline constexpr contract::ImageChip kImageChip = contract::ImageChip::lpc11c24;

inline constexpr std::uint32_t kSectorBytes = 0x1000;
inline constexpr std::uint32_t kLoaderStart = 0x0000, kLoaderBytes = 0x1000;
inline constexpr std::uint32_t kApplicationStart = 0x1000, kApplicationBytes = 0x6000;
inline constexpr std::uint32_t kParametersStart = 0x7000;  // one sector
inline constexpr std::size_t kFlashWriteBytes = 256;       // the smallest piece that the factory's routine writes

inline constexpr std::uint32_t kRamStart = 0x10000000, kRamBytes = 0x2000;
inline constexpr std::uint32_t kVectorBytes = 0xC0;  // 16 of the processor and 32 interrupts
inline constexpr std::uint32_t kFlashRoutineBytes = 32;
inline constexpr std::uint32_t kStackTop = kRamStart + kRamBytes - kFlashRoutineBytes;
inline constexpr std::uint32_t kMailboxStart = 0x40038004, kMailboxBytes = 16;

}  // namespace hoist::firmware::lpc11c24
