// Quadrature encoder by edge interrupts: the chip has no quadrature counter. About 65 cycles an edge, so 370 000 edges/s would take half of
// the processor; the fastest motor gives 72 000.
//
// Time between edges comes from CT32B0, which counts microseconds and never stops.
#pragma once
#include <array>
#include <cstdint>

#include "firmware/boards/lpc11c24/clock.hpp"
#include "firmware/boards/lpc11c24/registers.hpp"

namespace hoist::firmware::lpc11c24 {

namespace microseconds {
using Control = Register<0x40014004>;
using Count = Register<0x40014008>;
using Prescale = Register<0x4001400C>;
inline void start() {
  syscon::AhbClocks::set(syscon::kTimer32_0);
  Control::write(2);
  Prescale::write(kClock_hz / 1'000'000 - 1);
  Control::write(1);
}
}  // namespace microseconds

class Encoder {
 public:
  void start() {
    static_assert(kEncoderA.port == 2 && kEncoderB.port == 2 && kEncoderB.bit == kEncoderA.bit + 1);
    microseconds::start();
    set_pin<kEncoderA>(0, kPinPullUp | kPinHysteresis);
    set_pin<kEncoderB>(0, kPinPullUp | kPinHysteresis);
    lines_ = lines();
    Gpio<2>::Sense::clear(kBits);
    Gpio<2>::BothEdges::set(kBits);
    Gpio<2>::Clear::write(kBits);
    Gpio<2>::Enable::set(kBits);
    cortex_m0::enable_interrupt(irq::kGpio2, kPriorityEncoder);
  }

  // The interrupt. An edge that comes after the clearing and before the reading gives a second interrupt without a step: harmless.
  [[gnu::always_inline]] void on_interrupt() {
    Gpio<2>::Clear::write(kBits);
    const std::uint32_t now = lines();
    const std::uint32_t step = (lines_ << 2) | now;
    lines_ = now;
    const std::int32_t moved = kSteps[step];
    if (moved == 0) return;
    if (moved == kIllegal) {
      illegal_ = illegal_ + 1;
      direction_ = 0;
      return;
    }
    const std::uint32_t now_us = microseconds::Count::read();
    counts_ = static_cast<std::int32_t>(static_cast<std::uint32_t>(counts_) + static_cast<std::uint32_t>(moved));
    between_us_ = moved == direction_ ? now_us - edge_us_ : kEdgeTimeUnknown_us;
    edge_us_ = now_us;
    direction_ = moved;
  }

  [[nodiscard]] std::int32_t counts() const { return counts_; }
  [[nodiscard]] std::uint32_t illegal_steps() const { return illegal_; }
  // Called every millisecond: notices that the counter will wrap around since the last edge, after half an hour of standing.
  [[nodiscard]] std::uint32_t edge_time_us() {
    const cortex_m0::InterruptsOff off;
    if (microseconds::Count::read() - edge_us_ > kTooLong_us) {
      direction_ = 0;
      between_us_ = kEdgeTimeUnknown_us;
    }
    return between_us_;
  }

 private:
  static constexpr std::uint32_t kBits = 3U << kEncoderA.bit;
  static constexpr std::uint32_t kTooLong_us = 0x7FFFFFFF;
  static constexpr std::int8_t kIllegal = 2;
  // By (before << 2 | now), each as B << 1 | A. Forward is A leading: 0, 1, 3, 2.
  static constexpr std::array<std::int8_t, 16> kSteps = {0, 1, -1, kIllegal, -1, 0, kIllegal, 1, 1, kIllegal, 0, -1, kIllegal, -1, 1, 0};

  [[gnu::always_inline]] static std::uint32_t lines() { return Register<gpio_base(2) + (kBits << 2)>::read() >> kEncoderA.bit; }

  std::uint32_t lines_ = 0;
  volatile std::int32_t counts_ = 0;
  volatile std::uint32_t illegal_ = 0;
  volatile std::uint32_t edge_us_ = 0, between_us_ = kEdgeTimeUnknown_us;
  volatile std::int32_t direction_ = 0;  // of the previous edge; 0 when unknown
};

}  // namespace hoist::firmware::lpc11c24
