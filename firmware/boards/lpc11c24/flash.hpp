// Flash through the factory's routines in ROM (UM10398, chapter 26: IAP). They need the last 32 bytes of RAM, and nothing may run from
// flash while they work: interrupts are off for up to 100 ms, so this is only for a node that moves nothing.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "firmware/boards/lpc11c24/clock.hpp"
#include "firmware/boards/lpc11c24/memory.hpp"

namespace hoist::firmware::lpc11c24 {

namespace iap {
enum class Command : std::uint32_t { prepare = 50, copy = 51, erase = 52, compare = 56 };
inline constexpr std::uint32_t kEntry = 0x1FFF1FF1;

// True when the routine says CMD_SUCCESS.
inline bool call(Command command, std::uint32_t a, std::uint32_t b, std::uint32_t c = 0, std::uint32_t d = 0) {
  std::array<std::uint32_t, 5> in{static_cast<std::uint32_t>(command), a, b, c, d};
  std::array<std::uint32_t, 5> out{0xFFFFFFFF};  // not a status: a routine that did nothing has not succeeded
  reinterpret_cast<void (*)(std::uint32_t*, std::uint32_t*)>(kEntry)(in.data(), out.data());
  return out[0] == 0;
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

// The two copies of the parameters: FlashPages of firmware/lib/board.hpp.
class ParameterFlash {
 public:
  static constexpr std::size_t kPageBytes = kSectorBytes;

  bool erase(int page) {
    if (page != 0 && page != 1) return false;
    watchdog::set_timeout(watchdog::kFlashTimeout_ms);
    const bool good = iap::erase_sector(start(page) / kSectorBytes);
    watchdog::set_timeout(watchdog::kTimeout_ms);
    return good;
  }
  bool write(int page, std::size_t offset, std::span<const std::byte> bytes) {
    if ((page != 0 && page != 1) || offset % kFlashWriteBytes != 0 || bytes.size() % kFlashWriteBytes != 0 || offset > kPageBytes ||
        bytes.size() > kPageBytes - offset)
      return false;
    bool good = true;
    std::array<std::uint32_t, kFlashWriteBytes / 4> piece{};  // the routine takes whole words from RAM only
    for (std::size_t at = 0; good && at < bytes.size(); at += kFlashWriteBytes) {
      std::memcpy(piece.data(), bytes.data() + at, kFlashWriteBytes);
      watchdog::set_timeout(watchdog::kFlashTimeout_ms);
      good = iap::write_page(static_cast<std::uint32_t>(start(page) + offset + at), piece.data());
      watchdog::set_timeout(watchdog::kTimeout_ms);
    }
    return good;
  }
  [[nodiscard]] std::span<const std::byte> read(int page) const {
    if (page != 0 && page != 1) return {};
    return {reinterpret_cast<const std::byte*>(start(page)), kPageBytes};
  }

 private:
  static constexpr std::uint32_t start(int page) { return kParametersStart + (page == 0 ? 0U : kSectorBytes); }
};

}  // namespace hoist::firmware::lpc11c24
