// The loader on the STM32F072, one image per node kind (HOIST_LOADER_KIND). There is room for 8 KB, so it uses the board's own drivers and
// the main loop of all images; for the rest see lpc11c24/main.cpp.
#include <cstdint>
#include <span>

#include "control/contract/firmware_image.hpp"
#include "firmware/boards/cortex_m0/late.hpp"
#include "firmware/boards/cortex_m0/run.hpp"
#include "firmware/boards/stm32f072/board.hpp"
#include "firmware/boards/stm32f072/bridge.hpp"
#include "firmware/boot/loader.hpp"

namespace hoist::firmware::stm32f072 {
namespace {

using contract::ImageKind;
constexpr ImageKind kKind = ImageKind::HOIST_LOADER_KIND;
constexpr contract::ImageChipInfo kChip = *contract::find_image_chip(static_cast<std::uint8_t>(kImageChip));
static_assert(kChip.application_at == kApplicationStart && kChip.application_max == kApplicationBytes);
static_assert(kChip.ram_at == kRamStart && kChip.ram_bytes == kRamBytes);

constexpr std::uint8_t kGatewayLoader = 0x7E;  // as on the LPC11C24

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

class BootBoard : public Board {
 public:
  static constexpr std::size_t kWritePage = 256;
  static constexpr std::size_t kEraseUnit = kPageBytes;

  [[nodiscard]] std::span<const std::uint8_t> application() const {
    return {reinterpret_cast<const std::uint8_t*>(kApplicationStart), kApplicationBytes};
  }
  bool erase(std::size_t unit) { return ProgramFlash::erase(static_cast<std::uint32_t>(kApplicationStart + unit * kEraseUnit)); }
  // The CRC of the whole program, computed from flash, verifies each page.
  bool write(std::size_t offset, std::span<const std::uint8_t> bytes) {
    return ProgramFlash::write(static_cast<std::uint32_t>(kApplicationStart + offset), bytes);
  }
  [[nodiscard]] bool sent_all() const { return all_sent(); }
  [[nodiscard]] static constexpr ImageKind kind() { return kKind; }
  [[nodiscard]] static constexpr const contract::ImageChipInfo& chip() { return kChip; }
  Mailbox& mailbox() { return stm32f072::mailbox(); }
  void restart() { cortex_m0::reset_now(); }
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

bool service_pin_low() {
  set_pin<kService>(PinMode::input, PinPull::up);
  for (std::uint32_t i = 0; i < 100; ++i) asm volatile("nop");  // as for the straps
  return !read_pin<kService>();
}

// 0: no valid strap. Such a board stays off the bus: two nodes with one id would be worse than none.
std::uint8_t node_id() {
  if constexpr (kKind == ImageKind::io) return contract::node_id(contract::Node::io);
  if constexpr (kKind == ImageKind::gateway) return kGatewayLoader;
  const Straps straps = read_straps();
  if constexpr (kKind == ImageKind::drive) {
    if (straps.strap0 == straps.strap1) return 0;
    return straps.strap0 ? contract::node_id(contract::Node::drive_left) : contract::node_id(contract::Node::drive_right);
  } else {
    constexpr std::array kIds{std::uint8_t{0}, contract::node_id(contract::Node::tilt_left), contract::node_id(contract::Node::tilt_right),
                              contract::node_id(contract::Node::tilt_base)};
    return kIds[(straps.strap0 ? 1U : 0U) | (straps.strap1 ? 2U : 0U)];
  }
}

[[noreturn]] void start_application() {
  const std::uint32_t stack = cortex_m0::read_word(kApplicationStart), entry = cortex_m0::read_word(kApplicationStart + 4);
  asm volatile("msr msp, %0\n\tbx %1" ::"r"(stack), "r"(entry));
  __builtin_unreachable();
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
  const std::uint8_t id = node_id();
  if (id == 0 || !the_board.start_can({false, id})) cortex_m0::refuse_to_start(the_board);
  cortex_m0::run(loader_place.make(the_board, id, reason), the_board);
}
}
