// I2C1 as master at 400 kHz (RM0091, chapter 26) and SPI1 as master in mode 3 at 3 MHz (chapter 28), both polled. Each is a RegisterBus of
// firmware/lib/imu.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/boards/stm32f072/registers.hpp"

namespace hoist::firmware::stm32f072 {

class I2cBus {
 public:
  constexpr explicit I2cBus(std::uint8_t address) : address_(address) {}

  static void start() {
    free_lines();
    rcc::Configuration3::set(1U << 4);  // the 48 MHz, not the internal 8
    rcc::Apb1Clocks::set(rcc::kI2c1);
    set_pin<kI2cScl>(PinMode::alternate, PinPull::none, 1, true);
    set_pin<kI2cSda>(PinMode::alternate, PinPull::none, 1, true);
    Control1::write(0);
    Timing::write(0x50330309);  // fast mode at 48 MHz, RM0091 table 92
    Control1::write(1);
  }

  bool write(std::uint8_t reg, std::uint8_t value) {
    Control2::write(address(2) | kAutoEnd | kBegin);
    const bool good = put(reg) && put(value);
    return end(good) && good;
  }
  bool read(std::uint8_t reg, std::span<std::uint8_t> out) {
    if (out.empty() || out.size() > 255) return false;
    Control2::write(address(1) | kBegin);
    bool good = put(reg) && wait(kComplete);
    if (good) Control2::write(address(static_cast<std::uint32_t>(out.size())) | kRead | kAutoEnd | kBegin);
    for (std::size_t i = 0; good && i < out.size(); ++i) {
      good = wait(kReceived);
      if (good) out[i] = static_cast<std::uint8_t>(Received::read());
    }
    return end(good) && good;
  }

 private:
  using Control1 = Register<0x40005400>;
  using Control2 = Register<0x40005404>;
  using Timing = Register<0x40005410>;
  using Status = Register<0x40005418>;
  using Clear = Register<0x4000541C>;
  using Received = Register<0x40005424>;
  using ToSend = Register<0x40005428>;
  static constexpr std::uint32_t kRead = 1U << 10, kBegin = 1U << 13, kFinish = 1U << 14, kAutoEnd = 1U << 25;
  static constexpr std::uint32_t kSend = 1U << 1, kReceived = 1U << 2, kRefused = 1U << 4, kStopped = 1U << 5, kComplete = 1U << 6,
                                 kBusError = 1U << 8, kLostArbitration = 1U << 9;
  static constexpr std::uint32_t kLoopsMax = 2000;

  [[nodiscard]] std::uint32_t address(std::uint32_t bytes) const { return (static_cast<std::uint32_t>(address_) << 1) | (bytes << 16); }
  static bool wait(std::uint32_t bit) {
    for (std::uint32_t i = 0; i < kLoopsMax; ++i) {
      const std::uint32_t status = Status::read();
      if ((status & (kRefused | kBusError | kLostArbitration)) != 0) return false;
      if ((status & bit) != 0) return true;
    }
    return false;
  }
  static bool put(std::uint8_t byte) {
    if (!wait(kSend)) return false;
    ToSend::write(byte);
    return true;
  }
  // Waits for the stop. After an error the block is switched off and on, which resets it from every state.
  static bool end(bool good) {
    if (good)
      for (std::uint32_t i = 0; i < kLoopsMax; ++i)
        if ((Status::read() & kStopped) != 0) {
          Clear::write(kStopped | kRefused);
          return true;
        }
    Control2::set(kFinish);
    for (std::uint32_t i = 0; i < kLoopsMax && (Status::read() & kStopped) == 0; ++i) {
    }
    Clear::write(kStopped | kRefused | kBusError | kLostArbitration);
    Control1::write(0);
    (void)Control1::read();
    Control1::write(1);
    return false;
  }
  // A sensor that was reading out a byte when the processor was reset holds SDA low and waits for clocks: nine end any byte.
  static void free_lines() {
    set_pin<kI2cSda>(PinMode::input);
    write_pin<kI2cScl>(true);
    set_pin<kI2cScl>(PinMode::output, PinPull::none, 0, true);
    if (read_pin<kI2cSda>()) return;
    for (std::uint32_t i = 0; i < 18; ++i) {
      write_pin<kI2cScl>((i & 1U) != 0);
      for (std::uint32_t j = 0; j < 80; ++j) asm volatile("nop");
    }
  }

  std::uint8_t address_;
};

// Register number in the first byte, bit 7 set to read; the number increments automatically.
class SpiBus {
 public:
  static void start() {
    write_pin<kSpiSelect>(true);
    set_pin<kSpiSelect>(PinMode::output);
    // Clock and data change at 3 MHz; out of reset a pin is good for 2.
    set_pin_speed<kSpiSck>(PinSpeed::to_10_mhz);
    set_pin_speed<kSpiMosi>(PinSpeed::to_10_mhz);
    set_pin<kSpiSck>(PinMode::alternate, PinPull::none, 0);
    set_pin<kSpiMiso>(PinMode::alternate, PinPull::up, 0);
    set_pin<kSpiMosi>(PinMode::alternate, PinPull::none, 0);
    rcc::Apb2Clocks::set(rcc::kSpi1);
    Control2::write((7U << 8) | (1U << 12));  // 8 bit; the flag is set from one byte on
    // Mode 3, master, 48 MHz / 16, select by hand, on.
    Control1::write((1U << 0) | (1U << 1) | (1U << 2) | (3U << 3) | (1U << 8) | (1U << 9));
    Control1::set(1U << 6);
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
  using Control1 = Register<0x40013000>;
  using Control2 = Register<0x40013004>;
  using Status = Register<0x40013008>;
  static constexpr std::uint32_t kData = 0x4001300C;
  static constexpr std::uint32_t kLoopsMax = 500;

  static bool exchange(std::uint32_t out, std::uint8_t& in) {
    cortex_m0::write_byte(kData, static_cast<std::uint8_t>(out));  // as a word it would be two bytes
    for (std::uint32_t i = 0; i < kLoopsMax; ++i)
      if ((Status::read() & 1U) != 0) {
        in = cortex_m0::read_byte(kData);
        return true;
      }
    return false;
  }
};

}  // namespace hoist::firmware::stm32f072
