// Where what lies in an LPC11C24: flash in sectors of 4 KB, 8 KB of RAM. The linker script (application.ld) repeats these figures.
//
//   0x0000 - 0x0FFF  loader (firmware/boot)
//   0x1000 - 0x6FFF  application: vectors, image header at +0xC0, program
//   0x7000 - 0x7FFF  stored parameters (parameter_pages.hpp)
//
//   0x10000000  vectors of the running program (the processor has no register for their place, SYSMEMREMAP maps RAM to address 0)
//   0x100000C0  variables, then the stack
//   0x10001FD0  mailbox between application and loader, 16 bytes
//   0x10001FE0  32 bytes of the factory's flash routines
#pragma once
#include <cstddef>
#include <cstdint>

namespace hoist::firmware::lpc11c24 {

inline constexpr std::uint32_t kSectorBytes = 0x1000;
inline constexpr std::uint32_t kLoaderStart = 0x0000, kLoaderBytes = 0x1000;
inline constexpr std::uint32_t kApplicationStart = 0x1000, kApplicationBytes = 0x6000;
inline constexpr std::uint32_t kParametersStart = 0x7000;  // one sector
inline constexpr std::size_t kFlashWriteBytes = 256;       // the smallest piece that the factory's routine writes

inline constexpr std::uint32_t kRamStart = 0x10000000, kRamBytes = 0x2000;
inline constexpr std::uint32_t kVectorBytes = 0xC0;  // 16 of the processor and 32 interrupts
inline constexpr std::uint32_t kMailboxStart = kRamStart + kRamBytes - 48, kMailboxBytes = 16;
inline constexpr std::uint32_t kStackTop = kMailboxStart;

}  // namespace hoist::firmware::lpc11c24
