// The loader on the STM32F072. There is room for 8 KB, so it uses the board's own drivers and
// the main loop of all images; for the rest see lpc11c24/main.cpp.
#include <cstdint>
#include <span>

#include "control/contract/firmware_image.hpp"
#include "firmware/boards/cortex_m0/late.hpp"
#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/boards/stm32f072/board.hpp"
#include "firmware/boards/stm32f072/bridge.hpp"
#include "firmware/boot/cortex_m0.hpp"

namespace hoist::firmware::stm32f072 {
namespace {

using namespace cortex_m0;
using contract::ImageKind;

// Flash of the application (RM0091, section 3.2): pages of 2 KB, half-words. The processor waits while the flash is busy.
class ProgramFlash {
 public:
  static bool erase(std::uint32_t address) {
    const Change change;
    Control::write(kErasePage);
    Address::write(address);
    Control::write(kErasePage | kStart);
    return wait();
  }
  static bool write(std::uint32_t address, std::span<const std::uint8_t> bytes) {
    const Change change;
    Control::write(kProgram);
    bool good = true;
    for (std::size_t at = 0; good && at + 1 < bytes.size(); at += 2) {
      const auto half = static_cast<std::uint16_t>(bytes[at] | (bytes[at + 1] << 8));
      cortex_m0::write_half(address + static_cast<std::uint32_t>(at), half);
      good = wait();
    }
    return good;
  }

 private:
  using Key = Register<0x40022004>;
  using Status = Register<0x4002200C>;
  using Control = Register<0x40022010>;
  using Address = Register<0x40022014>;
  static constexpr std::uint32_t kProgram = 1U << 0, kErasePage = 1U << 1, kStart = 1U << 6, kLock = 1U << 7;
  static constexpr std::uint32_t kBusy = 1U << 0, kWrong = (1U << 2) | (1U << 4), kEnd = 1U << 5;
  static constexpr std::uint32_t kBusy_loops = 2'000'000;  // far more than the 40 ms of an erase

  // Flash is unlocked and the watchdog timeout long during this object's lifetime.
  class Change {
   public:
    Change() {
      watchdog::set_timeout(watchdog::kFlashTimeout_ms);
      if ((Control::read() & kLock) == 0) return;
      Key::write(0x45670123);
      Key::write(0xCDEF89AB);
    }
    ~Change() {
      Control::write(kLock);
      watchdog::set_timeout(watchdog::kTimeout_ms);
    }
    Change(const Change&) = delete;
    Change& operator=(const Change&) = delete;
  };
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

class BootBoard : public Board, public LoaderBoard {
 public:
  using LoaderBoard::restart;
  static constexpr std::size_t kWritePage = 256;
  static constexpr std::size_t kEraseUnit = kPageBytes;

  bool erase(std::size_t unit) { return ProgramFlash::erase(static_cast<std::uint32_t>(kApplicationStart + unit * kEraseUnit)); }
  // The CRC of the whole program, computed from flash, verifies each page.
  bool write(std::size_t offset, std::span<const std::uint8_t> bytes) {
    return ProgramFlash::write(static_cast<std::uint32_t>(kApplicationStart + offset), bytes);
  }
  [[nodiscard]] bool sent_all() const { return all_sent(); }
  void started_well() {}  // that is said of applications
  // After bus-off the loader must recover by itself: nothing else could reach it.
  void tick_1ms() { can_restart(); }
};

constinit cortex_m0::Late<BootBoard> board_place;
constinit cortex_m0::Late<Loader<BootBoard>> loader_place;

// Read without clearing: the application reads it too. The pin's bit is set with every other one.
LoaderReset reset_kind() {
  const std::uint32_t status = rcc::Status::read();
  if ((status & ((1U << 29) | (1U << 30))) != 0) return LoaderReset::watchdog;
  return (status & (1U << 28)) != 0 ? LoaderReset::software : LoaderReset::power_or_pin;
}

template <Pin... kPins>
void pull_low() {
  (write_pin<kPins>(false), ...);
  (set_pin<kPins>(PinMode::output), ...);
}

}  // namespace
}  // namespace hoist::firmware::stm32f072

extern "C" {
using hoist::firmware::stm32f072::board_place;

void can_interrupt() { board_place.object.on_can_interrupt(); }

void hoist_outputs_off() {
  using namespace hoist::firmware::stm32f072;
  rcc::AhbClocks::set(rcc::kPorts);
  if constexpr (kKind == ImageKind::drive) Bridge::outputs_off();
  if constexpr (kKind == ImageKind::io) pull_low<kOutput0, kOutput1, kOutput2, kOutput3, kOutput4, kOutput5, kOutput6, kOutput7>();
}

[[noreturn]] void hoist_main() {
  using namespace hoist::firmware;
  using namespace hoist::firmware::stm32f072;
  BootBoard& the_board = board_place.make();
  const StartReason reason = decide_start(the_board, reset_kind(), service_pin_low());
  if (reason == StartReason::application) start_application();
  if (!the_board.start_core()) cortex_m0::refuse_to_start(the_board);
  const std::uint8_t id = loader_id();
  if (id == 0 || !the_board.start_can({false, id})) cortex_m0::refuse_to_start(the_board);
  cortex_m0::run(loader_place.make(the_board, id, reason), the_board);
}
}
