// Flash through the factory's routines in ROM (UM10398, chapter 26: IAP). They need the last 32 bytes of RAM, and nothing may run from
// flash while they work: interrupts are off for up to 100 ms, so this is only for a node at standstill.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/boards/lpc11c24/clock.hpp"
#include "firmware/boards/lpc11c24/memory.hpp"
#include "firmware/boards/lpc11c24/parameter_pages.hpp"
#include "firmware/lib/serial_number.hpp"

namespace hoist::firmware::lpc11c24 {

namespace iap {
enum class Command : std::uint32_t { prepare = 50, copy = 51, erase = 52, compare = 56, read_unique_id = 58 };
inline constexpr std::uint32_t kEntry = 0x1FFF1FF1;

using Result = std::array<std::uint32_t, 5>;  // status, then results
inline Result ask(Command command, std::uint32_t a = 0, std::uint32_t b = 0, std::uint32_t c = 0, std::uint32_t d = 0) {
  std::array<std::uint32_t, 5> in{static_cast<std::uint32_t>(command), a, b, c, d};
  Result out{0xFFFFFFFF};  // not a status code, so a routine that did nothing counts as failed
  reinterpret_cast<void (*)(std::uint32_t*, std::uint32_t*)>(kEntry)(in.data(), out.data());
  return out;
}
// True when the routine returns CMD_SUCCESS.
inline bool call(Command command, std::uint32_t a, std::uint32_t b, std::uint32_t c = 0, std::uint32_t d = 0) {
  return ask(command, a, b, c, d)[0] == 0;
}

// 1018h:4. 0 when the routine refuses.
inline std::uint32_t serial_number() {
  const cortex_m0::InterruptsOff off;
  const Result id = ask(Command::read_unique_id);
  return id[0] == 0 ? serial_of(std::span(id).subspan<1>()) : 0;
}

// Both work on one sector. The watchdog, when it runs, must have been given time by the caller.
inline bool erase_sector(std::uint32_t sector) {
  const cortex_m0::InterruptsOff off;
  return call(Command::prepare, sector, sector) && call(Command::erase, sector, sector, kClock_hz / 1000);
}
// `words` are 256 bytes at a word's address in RAM.
inline bool write_page(std::uint32_t to, const std::uint32_t* words) {
  const cortex_m0::InterruptsOff off;
  const std::uint32_t sector = to / kSectorBytes;
  const std::uint32_t from = reinterpret_cast<std::uintptr_t>(words);
  return call(Command::prepare, sector, sector) && call(Command::copy, to, from, kFlashWriteBytes, kClock_hz / 1000) &&
         call(Command::compare, to, from, kFlashWriteBytes);
}
}  // namespace iap

// The sector of the parameters. The watchdog gets more time while a routine holds the processor.
class ParameterSector {
 public:
  static constexpr std::size_t kBytes = kSectorBytes;

  bool erase() {
    watchdog::set_timeout(watchdog::kFlashTimeout_ms);
    const bool good = iap::erase_sector(kParametersStart / kSectorBytes);
    watchdog::set_timeout(watchdog::kTimeout_ms);
    return good;
  }
  bool write(std::size_t offset, const std::array<std::uint32_t, kSlotWriteBytes / 4>& words) {
    watchdog::set_timeout(watchdog::kFlashTimeout_ms);
    const bool good = iap::write_page(static_cast<std::uint32_t>(kParametersStart + offset), words.data());
    watchdog::set_timeout(watchdog::kTimeout_ms);
    return good;
  }
  [[nodiscard]] std::span<const std::byte> bytes() const { return {reinterpret_cast<const std::byte*>(kParametersStart), kBytes}; }
};
using ParameterFlash = ParameterPages<ParameterSector>;

}  // namespace hoist::firmware::lpc11c24
