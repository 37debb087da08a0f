// Memory map of an STM32F072CB: 128 KB of flash in pages of 2 KB, 16 KB of RAM. application.ld repeats these figures.
//
//   0x08000000  loader, 8 KB         0x08002000  application, 116 KB         0x0801F000, 0x0801F800  two copies of the parameters
//   0x20000000  vectors of the running program (SYSCFG maps RAM to address 0), 0x200000C0 variables and stack, 0x20003FF0 mailbox
//
// The mailbox may lie in RAM: a reset keeps its content, and with BOOT0 low no factory program runs before the loader (RM0091, 2.5).
#pragma once
#include <cstddef>
#include <cstdint>

#include "control/contract/firmware_image.hpp"

namespace hoist::firmware::stm32f072 {

inline constexpr contract::ImageChip kImageChip = contract::ImageChip::stm32f072;

inline constexpr std::uint32_t kFlashStart = 0x08000000, kFlashBytes = 0x20000;
inline constexpr std::uint32_t kPageBytes = 0x800;
inline constexpr std::uint32_t kApplicationStart = 0x08002000, kApplicationBytes = 0x1D000;
inline constexpr std::uint32_t kParametersStart = 0x0801F000;  // two pages

inline constexpr std::uint32_t kRamStart = 0x20000000, kRamBytes = 0x4000;
inline constexpr std::uint32_t kVectorBytes = 0xC0;
inline constexpr std::uint32_t kMailboxBytes = 16, kMailboxStart = kRamStart + kRamBytes - kMailboxBytes;

}  // namespace hoist::firmware::stm32f072
