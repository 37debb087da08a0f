// I2C as master at 400 kHz (UM10398, chapter 15) and SSP0 as SPI master in mode 3 at 4 MHz (chapter 14), both polled: a reading of an
// inertial sensor takes 0.4 ms and 35 us, and the main loop has no other work then. Both are a RegisterBus of firmware/lib/imu.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/boards/lpc11c24/registers.hpp"

namespace hoist::firmware::lpc11c24 {

class I2cBus {
 public:
  constexpr explicit I2cBus(std::uint8_t address) : address_(address) {}

  static void start() {
    free_lines();
    syscon::AhbClocks::set(syscon::kI2c);
    syscon::PeripheralReset::set(syscon::kI2cRuns);
    set_pin<kI2cScl>(1, kPinOpenDrainI2c);
    set_pin<kI2cSda>(1, kPinOpenDrainI2c);
    // 48 MHz / 120; low for 1.46 us, fast mode demands 1.3.
    HighTime::write(50);
    LowTime::write(70);
    ControlClear::write(kAcknowledge | kInterrupt | kBegin | kEnable);
    ControlSet::write(kEnable);
  }

  bool write(std::uint8_t reg, std::uint8_t value) {
    const bool good = begin(false) && put(reg) && put(value);
    return end() && good;
  }
  bool read(std::uint8_t reg, std::span<std::uint8_t> out) {
    bool good = !out.empty() && begin(false) && put(reg) && begin(true);
    for (std::size_t i = 0; good && i < out.size(); ++i) {
      const bool last = i + 1 == out.size();
      if (last)
        ControlClear::write(kAcknowledge);
      else
        ControlSet::write(kAcknowledge);
      ControlClear::write(kInterrupt);
      good = wait() && State::read() == (last ? kReceivedLast : kReceived);
      out[i] = static_cast<std::uint8_t>(Data::read());
    }
    return end() && good;
  }

 private:
  using ControlSet = Register<0x40000000>;
  using State = Register<0x40000004>;
  using Data = Register<0x40000008>;
  using HighTime = Register<0x40000010>;
  using LowTime = Register<0x40000014>;
  using ControlClear = Register<0x40000018>;
  static constexpr std::uint32_t kAcknowledge = 1U << 2, kInterrupt = 1U << 3, kFinish = 1U << 4, kBegin = 1U << 5, kEnable = 1U << 6;
  static constexpr std::uint32_t kBegun = 0x08, kBegunAgain = 0x10, kAddressWriteTaken = 0x18, kDataTaken = 0x28, kAddressReadTaken = 0x40,
                                 kReceived = 0x50, kReceivedLast = 0x58;
  static constexpr std::uint32_t kLoopsMax = 1000;  // of at least 8 cycles: 160 us; a byte takes 23 us, the sensor stretches no clock

  static bool wait() {
    for (std::uint32_t i = 0; i < kLoopsMax; ++i)
      if ((ControlSet::read() & kInterrupt) != 0) return true;
    return false;
  }
  bool begin(bool reading) {
    ControlSet::write(kBegin);
    ControlClear::write(kInterrupt);
    if (!wait()) return false;
    const std::uint32_t state = State::read();
    if (state != kBegun && state != kBegunAgain) return false;
    Data::write((static_cast<std::uint32_t>(address_) << 1) | (reading ? 1U : 0U));
    ControlClear::write(kBegin | kInterrupt);
    return wait() && State::read() == (reading ? kAddressReadTaken : kAddressWriteTaken);
  }
  static bool put(std::uint8_t byte) {
    Data::write(byte);
    ControlClear::write(kInterrupt);
    return wait() && State::read() == kDataTaken;
  }
  // Sends a stop, also after an error. The hardware clears the bit when the stop is on the bus.
  static bool end() {
    ControlSet::write(kFinish);
    ControlClear::write(kInterrupt | kBegin);
    for (std::uint32_t i = 0; i < kLoopsMax; ++i)
      if ((ControlSet::read() & kFinish) == 0) return true;
    return false;
  }
  // A sensor that was reading out a byte when the processor was reset holds SDA low and waits for clocks: nine end any byte.
  static void free_lines() {
    set_pin<kI2cScl>(0, kPinOpenDrainI2c);
    set_pin<kI2cSda>(0, kPinOpenDrainI2c);
    write_pin<kI2cScl>(true);
    if (read_pin<kI2cSda>()) return;
    make_output<kI2cScl>();
    for (std::uint32_t i = 0; i < 18; ++i) {
      write_pin<kI2cScl>((i & 1U) != 0);
      for (std::uint32_t j = 0; j < 80; ++j) asm volatile("nop");
    }
    Register<gpio_base(kI2cScl.port) + 0x8000>::clear(1U << kI2cScl.bit);
  }

  std::uint8_t address_;
};

// Register number in the first byte, bit 7 set to read; the number increments automatically. So for LSM6DSO and ICM-42688-P.
class SpiBus {
 public:
  static void start() {
    write_pin<kSpiSelect>(true);
    set_pin<kSpiSelect>(0, kPinFloating);
    make_output<kSpiSelect>();
    SckLocation::write(2);
    set_pin<kSpiSck>(2, kPinFloating);
    set_pin<kSpiMiso>(1, kPinPullUp);  // no chip there: all ones
    set_pin<kSpiMosi>(1, kPinFloating);
    syscon::AhbClocks::set(syscon::kSsp0);
    syscon::Ssp0Divider::write(1);
    syscon::PeripheralReset::set(syscon::kSsp0Runs);
    Prescale::write(2);
    Control0::write(7U | (1U << 6) | (1U << 7) | (5U << 8));  // 8 bit, mode 3, 48 MHz / 2 / 6
    Control1::write(2);
  }

  bool write(std::uint8_t reg, std::uint8_t value) {
    write_pin<kSpiSelect>(false);
    std::uint8_t unused = 0;
    const bool good = exchange(reg & 0x7FU, unused) && exchange(value, unused);
    write_pin<kSpiSelect>(true);
    return good;
  }
  bool read(std::uint8_t reg, std::span<std::uint8_t> out) {
    write_pin<kSpiSelect>(false);
    std::uint8_t unused = 0;
    bool good = exchange(reg | 0x80U, unused);
    for (std::size_t i = 0; good && i < out.size(); ++i) good = exchange(0, out[i]);
    write_pin<kSpiSelect>(true);
    return good;
  }

 private:
  using Control0 = Register<0x40040000>;
  using Control1 = Register<0x40040004>;
  using Data = Register<0x40040008>;
  using Status = Register<0x4004000C>;
  using Prescale = Register<0x40040010>;
  static constexpr std::uint32_t kReceived = 1U << 2;
  static constexpr std::uint32_t kLoopsMax = 200;  // a byte takes 2 us

  static bool exchange(std::uint32_t out, std::uint8_t& in) {
    Data::write(out);
    for (std::uint32_t i = 0; i < kLoopsMax; ++i)
      if ((Status::read() & kReceived) != 0) {
        in = static_cast<std::uint8_t>(Data::read());
        return true;
      }
    return false;
  }
};

}  // namespace hoist::firmware::lpc11c24
