// TDK InvenSense ICM-42688-P on SPI (or I2C): +-2 g, +-250 deg/s, 1 kHz, low-pass about 50 Hz.
// Source: data sheet DS-000347; self-test equation and limits as in the vendor's public driver for the family (ICM-426xx).
#pragma once
#include "firmware/lib/imu/imu_chip.hpp"

namespace hoist::firmware {

struct Icm42688pChip {
  static constexpr std::uint8_t kWhoAmIRegister = 0x75, kWhoAmI = 0x47;
  static constexpr std::uint8_t kBankSelect = 0x76;

  // DEVICE_CONFIG: software reset, done after 1 ms.
  static constexpr std::array<RegisterValue, 2> kReset{{{kBankSelect, 0x00}, {0x11, 0x01}}};
  static constexpr std::uint16_t kReset_ms = 5;

  // GYRO_CONFIG0 and ACCEL_CONFIG0: 250 deg/s, 2 g, 1 kHz. GYRO_ACCEL_CONFIG0: a twentieth of the rate. PWR_MGMT0 last: both low noise;
  // the chip takes no other write for 200 us after it.
  static constexpr std::array<RegisterValue, 4> kWork{{{0x4F, 0x66}, {0x50, 0x66}, {0x52, 0x66}, {0x4E, 0x0F}}};
  static constexpr std::uint16_t kWork_ms = 60;
  static constexpr float kAcceleration_m_s2 = kStandardGravity_m_s2 / 16384.0F;
  static constexpr float kRate_rad_s = kRadPerDegree / 131.0F;

  // Temperature, acceleration, rate, two of no use, INT_STATUS (bit 3: new data).
  static constexpr std::uint8_t kBurstRegister = 0x1D, kReadyMask = 0x08;
  static constexpr std::size_t kBurstBytes = 17, kReadyAt = 16;
  static constexpr RawImu decode(const std::uint8_t* at) {
    return {big_endian(at + 2), big_endian(at + 4), big_endian(at + 6), big_endian(at + 8), big_endian(at + 10), big_endian(at + 12)};
  }

  static constexpr std::array<RegisterValue, 4> kPrepare{{{0x4F, 0x66}, {0x50, 0x66}, {0x52, 0x44}, {0x4E, 0x0F}}};
  static constexpr std::array<RegisterValue, 1> kStimulateRate{{{0x70, 0x07}}};
  static constexpr std::array<RegisterValue, 1> kStimulateAcceleration{{{0x70, 0x78}}};
  static constexpr std::array<RegisterValue, 1> kRelax{{{0x70, 0x00}}};
  static constexpr std::array<SelfTestPass, 2> kPasses{{{kPrepare, 100, kStimulateAcceleration, 50, kRelax, 100, kReadyMask},
                                                        {kPrepare, 100, kStimulateRate, 200, kRelax, 100, kReadyMask}}};

  // Acceleration in bank 2, rate in bank 1.
  template <class Bus>
  [[nodiscard]] static bool read_codes(Bus& bus, SelfTestCodes& codes) {
    const std::span<std::uint8_t> all(codes);
    return bus.write(kBankSelect, 2) && bus.read(0x3B, all.first(3)) && bus.write(kBankSelect, 1) && bus.read(0x5F, all.last(3)) &&
           bus.write(kBankSelect, 0);
  }

  static constexpr float kStepsPer_mg = 16.384F, kStepsPer_deg_s = 131.0F;
  static constexpr float kOffsetMax_deg_s = 20.0F;
  static constexpr bool passed(std::size_t pass, const SelfTestCodes& codes, const SelfTestResult& result) {
    for (std::size_t i = 3 * pass; i < 3 * pass + 3; ++i) {
      const float size = result.shift[i] < 0 ? -result.shift[i] : result.shift[i];
      const float offset = result.rest[i] < 0 ? -result.rest[i] : result.rest[i];
      const float expected = 2620.0F * self_test_power(1.01F, codes[i]);
      // Half to one and a half of the factory's response; without a code absolute limits: 50 to 1200 mg, 60 deg/s and more.
      const bool good = expected != 0.0F ? size > 0.5F * expected && size < 1.5F * expected
                        : pass == 0      ? size >= 50.0F * kStepsPer_mg && size <= 1200.0F * kStepsPer_mg
                                         : size >= 60.0F * kStepsPer_deg_s;
      if (!good || (pass == 1 && offset > kOffsetMax_deg_s * kStepsPer_deg_s)) return false;
    }
    return true;
  }
};

template <RegisterBus Bus>
using Icm42688p = ImuChip<Bus, Icm42688pChip>;

}  // namespace hoist::firmware
