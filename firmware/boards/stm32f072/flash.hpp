// Flash of the STM32F072 (RM0091, chapter 3): pages of 2 KB, written by half-words. The processor waits while the flash is busy.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/boards/stm32f072/clock.hpp"
#include "firmware/boards/stm32f072/memory.hpp"

namespace hoist::firmware::stm32f072 {

// The two copies of the parameters, each in its own page: FlashPages of firmware/lib/board.hpp.
class ParameterFlash {
 public:
  static constexpr std::size_t kPageBytes = stm32f072::kPageBytes;

  bool erase(int page) {
    if (page != 0 && page != 1) return false;
    watchdog::set_timeout(watchdog::kFlashTimeout_ms);
    unlock();
    Control::write(kErasePage);
    Address::write(start(page));
    Control::write(kErasePage | kStart);
    const bool good = wait();
    Control::write(kLock);
    watchdog::set_timeout(watchdog::kTimeout_ms);
    if (!good) return false;
    for (const std::byte b : read(page))
      if (b != std::byte{0xFF}) return false;
    return true;
  }
  bool write(int page, std::size_t offset, std::span<const std::byte> bytes) {
    if ((page != 0 && page != 1) || offset % 2 != 0 || bytes.size() % 2 != 0 || offset > kPageBytes || bytes.size() > kPageBytes - offset)
      return false;
    watchdog::set_timeout(watchdog::kFlashTimeout_ms);
    unlock();
    bool good = true;
    for (std::size_t at = 0; good && at < bytes.size(); at += 2) {
      const std::uint32_t half = std::to_integer<std::uint32_t>(bytes[at]) | (std::to_integer<std::uint32_t>(bytes[at + 1]) << 8);
      Control::write(kProgram);
      cortex_m0::write_half(static_cast<std::uint32_t>(start(page) + offset + at), static_cast<std::uint16_t>(half));
      good = wait();
    }
    Control::write(kLock);
    watchdog::set_timeout(watchdog::kTimeout_ms);
    for (std::size_t at = 0; good && at < bytes.size(); ++at) good = read(page)[offset + at] == bytes[at];
    return good;
  }
  [[nodiscard]] std::span<const std::byte> read(int page) const {
    if (page != 0 && page != 1) return {};
    return {reinterpret_cast<const std::byte*>(start(page)), kPageBytes};
  }

 private:
  using Key = Register<0x40022004>;
  using Status = Register<0x4002200C>;
  using Control = Register<0x40022010>;
  using Address = Register<0x40022014>;
  static constexpr std::uint32_t kProgram = 1U << 0, kErasePage = 1U << 1, kStart = 1U << 6, kLock = 1U << 7;
  static constexpr std::uint32_t kBusy = 1U << 0, kWrong = (1U << 2) | (1U << 4), kEnd = 1U << 5;
  static constexpr std::uint32_t kBusy_loops = 2'000'000;  // far more than 40 ms

  static constexpr std::uint32_t start(int page) { return kParametersStart + static_cast<std::uint32_t>(page) * stm32f072::kPageBytes; }
  static void unlock() {
    if ((Control::read() & kLock) == 0) return;
    Key::write(0x45670123);
    Key::write(0xCDEF89AB);
  }
  static bool wait() {
    for (std::uint32_t i = 0; i < kBusy_loops; ++i) {
      const std::uint32_t status = Status::read();
      if ((status & kBusy) != 0) continue;
      Status::write(kWrong | kEnd);
      return (status & kWrong) == 0;
    }
    return false;
  }
};

}  // namespace hoist::firmware::stm32f072
