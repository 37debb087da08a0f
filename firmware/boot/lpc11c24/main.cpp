// The loader on the LPC11C24.
//
// It must fit into one sector of 4 KB, so it has no interrupts and no queue: the controller's filters pass only requests to this node, one
// at a time, and SysTick is polled. It runs on the chip's 12 MHz and leaves reset causes and peripherals as after a reset.
#include <array>
#include <cstring>
#include <span>

#include "control/contract/firmware_image.hpp"
#include "firmware/boards/cortex_m0/late.hpp"
#include "firmware/boards/cortex_m0/startup.hpp"
#include "firmware/boards/lpc11c24/board.hpp"
#include "firmware/boards/lpc11c24/bridge.hpp"
#include "firmware/boot/cortex_m0.hpp"

extern "C" {
// Made by the linker script so that the first eight words add up to zero: otherwise the ROM does not start the program at address 0.
extern std::uint32_t hoist_vector_checksum[];
}

namespace hoist::firmware::lpc11c24 {
namespace {

using namespace cortex_m0;
using contract::ImageKind;

// Reset and faults. No interrupt is enabled and no SVC executed, so the table ends here.
union Vector {
  std::uint32_t* address;
  void (*handler)();
};
struct Vectors {
  Vector at[8];
};
consteval Vectors make_vectors() {
  Vectors v{};
  for (Vector& entry : v.at) entry = {.address = nullptr};
  v.at[0] = {.address = hoist_stack_top};
  v.at[1] = {.handler = reset_handler};
  v.at[2] = v.at[3] = {.handler = fault_handler};
  v.at[7] = {.address = hoist_vector_checksum};
  return v;
}
[[gnu::section(".vectors"), gnu::used]] constinit const Vectors kVectorTable = make_vectors();

// Message object 1 sends; 2 receives requests to this node, 3 network management.
class BootBoard : public LoaderBoard {
 public:
  static constexpr std::size_t kWritePage = kFlashWriteBytes;
  static constexpr std::size_t kEraseUnit = kSectorBytes;
  using Window = c_can::Loop;

  // False without an exact clock or a controller: such a board cannot be on the bus.
  [[nodiscard]] bool start(std::uint8_t node_id) {
    if (!start_clock()) return false;
    start_brown_out();  // a sinking supply must not get into the middle of a flash write
    cortex_m0::SysTickReload::write(kClock_hz / 1000 - 1);
    cortex_m0::SysTickValue::write(0);
    cortex_m0::SysTickControl::write(5);  // counts processor clocks, no interrupt
    syscon::AhbClocks::set(syscon::kCan);
    syscon::PeripheralReset::set(syscon::kCanRuns);
    c_can::Control::write(c_can::kInit | c_can::kChangeTiming);
    c_can::ClockDivider::write(0);
    c_can::BitTiming::write(kBitTiming_250k);
    c_can::PrescalerExtension::write(0);
    // The message memory holds anything after power-on.
    for (std::uint32_t object = 1; object <= kCanObjects; ++object)
      if (!set_up(object, object == kRequests ? (contract::canopen::kSdoRequestBase + node_id) << 2 : 0,
                  object == kRequests || object == kManagement))
        return false;
    (void)c_can::Status::read();
    c_can::Control::write(0);
    return true;
  }
  [[nodiscard]] bool receive(contract::CanFrame& frame) {
    const std::uint32_t news = c_can::NewData1::read();
    const std::uint32_t object = (news & (1U << (kRequests - 1))) != 0     ? kRequests
                                 : (news & (1U << (kManagement - 1))) != 0 ? kManagement
                                                                           : 0;
    if (object == 0) return false;
    Window::Command::write(c_can::kArbitration | c_can::kControl | c_can::kClearPending | c_can::kNewDataOrRequest | c_can::kDataA |
                           c_can::kDataB);
    if (!Window::move(object)) return false;
    frame.id = (Window::Id2::read() & 0x1FFFU) >> 2;
    const std::uint32_t dlc = Window::Message::read() & 0xFU;
    frame.dlc = static_cast<std::uint8_t>(dlc > 8 ? 8 : dlc);
    for (std::uint32_t i = 0; i < 4; ++i) {
      const std::uint32_t pair = cortex_m0::read_word(Window::kData + 4 * i);
      frame.data[2 * i] = static_cast<std::uint8_t>(pair);
      frame.data[2 * i + 1] = static_cast<std::uint8_t>(pair >> 8);
    }
    return true;
  }
  [[nodiscard]] bool millisecond() const { return (cortex_m0::SysTickControl::read() & (1U << 16)) != 0; }
  // After bus-off the loader must recover by itself: nothing else could reach it.
  void mend_bus() {
    if ((c_can::Status::read() & c_can::kBusOff) != 0 && (c_can::Control::read() & c_can::kInit) != 0) c_can::Control::write(0);
  }

  // For the loader.
  bool send(const contract::CanFrame& frame) {
    if (!sent_all()) return false;
    Window::Command::write(c_can::kWrite | c_can::kArbitration | c_can::kControl | c_can::kDataA | c_can::kDataB);
    Window::Id1::write(0);
    Window::Id2::write((frame.id << 2) | c_can::kValid | c_can::kTransmit);
    for (std::uint32_t i = 0; i < 4; ++i)
      cortex_m0::write_word(Window::kData + 4 * i,
                            static_cast<std::uint32_t>(frame.data[2 * i]) | (static_cast<std::uint32_t>(frame.data[2 * i + 1]) << 8));
    Window::Message::write(frame.dlc | c_can::kEndOfChain | c_can::kRequest);
    return Window::move(kSends);
  }
  [[nodiscard]] bool sent_all() const { return (c_can::TransmitRequest1::read() & (1U << (kSends - 1))) == 0; }
  [[nodiscard]] bool simulated() const { return false; }
  bool erase(std::size_t unit) {
    const auto sector = static_cast<std::uint32_t>(kApplicationStart / kSectorBytes + unit);
    return change(sector, iap::Command::erase, sector, sector, kClock_hz / 1000);
  }
  // The CRC of the whole program, computed from flash, verifies the page.
  bool write(std::size_t offset, std::span<const std::uint8_t> bytes) {
    const auto to = static_cast<std::uint32_t>(kApplicationStart + offset);
    return change(to / kSectorBytes, iap::Command::copy, to, reinterpret_cast<std::uintptr_t>(bytes.data()), kFlashWriteBytes);
  }

 private:
  // The factory's routines need each sector prepared before each change. No interrupt can intervene: none is enabled.
  static bool change(std::uint32_t sector, iap::Command command, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return iap::call(iap::Command::prepare, sector, sector) && iap::call(command, a, b, c, kClock_hz / 1000);
  }

  static constexpr std::uint32_t kSends = 1, kRequests = 2, kManagement = 3;

  [[nodiscard]] static bool set_up(std::uint32_t object, std::uint32_t id2, bool receives) {
    Window::Command::write(c_can::kWrite | c_can::kMask | c_can::kArbitration | c_can::kControl);
    Window::Mask1::write(0xFFFF);
    Window::Mask2::write(0xFFFF);  // every bit of the identifier decides, and that it is a standard data frame
    Window::Id1::write(0);
    Window::Id2::write(receives ? id2 | c_can::kValid : 0);
    Window::Message::write(c_can::kUseMask | c_can::kEndOfChain);
    return Window::move(object);
  }
};

constinit cortex_m0::Late<BootBoard> board_place;
constinit cortex_m0::Late<Loader<BootBoard>> loader_place;

// Read without clearing: the application reads it too.
LoaderReset reset_kind() {
  const std::uint32_t status = syscon::ResetStatus::read();
  if ((status & syscon::kResetWatchdog) != 0) return LoaderReset::watchdog;
  return (status & syscon::kResetSoftware) != 0 ? LoaderReset::software : LoaderReset::power_or_pin;
}

// All of them on one port: one write switches them off before one write makes them outputs.
template <Pin kFirst, Pin... kPins>
void pull_low() {
  static_assert(((kPins.port == kFirst.port) && ...));
  constexpr std::uint32_t kMask = (1U << kFirst.bit) | ((1U << kPins.bit) | ...);
  Register<gpio_base(kFirst.port) + (kMask << 2)>::write(0);
  set_pin<kFirst>(0, kPinFloating);
  (set_pin<kPins>(kPins.port == 1 && kPins.bit == 2 ? 1 : 0, kPinFloating), ...);  // PIO1_2 has its GPIO as function 1
  Register<gpio_base(kFirst.port) + 0x8000>::write(kMask);
}

}  // namespace
}  // namespace hoist::firmware::lpc11c24

extern "C" {
// The loader's vectors lie where the processor looks for them after a reset.
void hoist_take_vectors() {}

void hoist_outputs_off() {
  using namespace hoist::firmware::lpc11c24;
  syscon::AhbClocks::set(syscon::kGpio | syscon::kIocon);
  if constexpr (kKind == ImageKind::drive) Bridge::outputs_off();
  if constexpr (kKind == ImageKind::io) pull_low<kOutput0, kOutput1, kOutput2, kOutput3, kOutput4, kOutput5, kOutput6, kOutput7>();
}

[[noreturn]] void hoist_main() {
  using namespace hoist::firmware;
  using namespace hoist::firmware::lpc11c24;
  BootBoard& the_board = board_place.make();
  const StartReason reason = decide_start(the_board, reset_kind(), service_pin_low());
  if (reason == StartReason::application) start_application();
  syscon::ResetStatus::write(syscon::ResetStatus::read());
  const std::uint8_t id = loader_id();
  while (id == 0 || !the_board.start(id)) {
  }
  Loader<BootBoard>& loader = loader_place.make(the_board, id, reason);
  for (;;) {
    hoist::contract::CanFrame frame;
    if (the_board.receive(frame)) loader.on_frame(frame);
    if (!the_board.millisecond()) continue;
    the_board.mend_bus();
    loader.tick_1ms();
  }
}
}
