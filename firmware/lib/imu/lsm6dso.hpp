// ST LSM6DSO on SPI (or I2C): +-2 g, +-250 deg/s, 833 Hz, low-pass 42 and about 49 Hz.
// Source: data sheet DS12140, self-test in application note AN5192 section 11 and limits in the data sheet's table 2.
#pragma once
#include "firmware/lib/imu/imu_chip.hpp"

namespace hoist::firmware {

struct Lsm6dsoChip {
  static constexpr std::uint8_t kWhoAmIRegister = 0x0F, kWhoAmI = 0x6C;

  // CTRL3_C: software reset, register address counts up.
  static constexpr std::array<RegisterValue, 1> kReset{{{0x12, 0x05}}};
  static constexpr std::uint16_t kReset_ms = 15;

  // CTRL3_C: bytes of one sample stay together. CTRL4_C: gyro low-pass 1 on. CTRL6_C: its narrower setting 5, about 49 Hz at 833 Hz.
  // CTRL8_XL: accelerometer low-pass at a twentieth of the rate. CTRL1_XL, CTRL2_G: 833 Hz, 2 g with low-pass 2, 250 deg/s.
  static constexpr std::array<RegisterValue, 7> kWork{
      {{0x12, 0x44}, {0x13, 0x02}, {0x14, 0x00}, {0x15, 0x05}, {0x17, 0x40}, {0x10, 0x72}, {0x11, 0x70}}};
  static constexpr std::uint16_t kWork_ms = 100;
  static constexpr float kAcceleration_m_s2 = 0.000061F * kStandardGravity_m_s2;
  static constexpr float kRate_rad_s = 0.00875F * kRadPerDegree;

  // STATUS_REG (bit 0 acceleration, bit 1 rate), one reserved, temperature, rate, acceleration.
  static constexpr std::uint8_t kBurstRegister = 0x1E, kReadyMask = 0x03;
  static constexpr std::size_t kBurstBytes = 16, kReadyAt = 0;
  static constexpr RawImu decode(const std::uint8_t* at) {
    return {little_endian(at + 10), little_endian(at + 12), little_endian(at + 14),
            little_endian(at + 4),  little_endian(at + 6),  little_endian(at + 8)};
  }

  // First the accelerometer alone at 52 Hz and +-4 g, then the gyro alone at 208 Hz and +-2000 deg/s.
  static constexpr std::array<RegisterValue, 8> kPrepareAcceleration{
      {{0x11, 0x00}, {0x12, 0x44}, {0x13, 0x00}, {0x14, 0x00}, {0x15, 0x00}, {0x16, 0x00}, {0x17, 0x00}, {0x10, 0x38}}};
  static constexpr std::array<RegisterValue, 2> kPrepareRate{{{0x10, 0x00}, {0x11, 0x5C}}};
  static constexpr std::array<RegisterValue, 1> kStimulateAcceleration{{{0x14, 0x01}}};
  static constexpr std::array<RegisterValue, 1> kStimulateRate{{{0x14, 0x04}}};
  static constexpr std::array<RegisterValue, 1> kRelax{{{0x14, 0x00}}};
  static constexpr std::array<SelfTestPass, 2> kPasses{{{kPrepareAcceleration, 100, kStimulateAcceleration, 100, kRelax, 5, 0x01},
                                                        {kPrepareRate, 150, kStimulateRate, 100, kRelax, 5, 0x02}}};

  template <class Bus>
  [[nodiscard]] static bool read_codes(Bus&, SelfTestCodes&) {
    return true;  // this chip has absolute limits
  }

  static constexpr float kAccelerationStep_mg = 0.122F, kRateStep_deg_s = 0.070F;  // in the self-test's ranges
  static constexpr bool passed(std::size_t pass, const SelfTestCodes&, const SelfTestResult& result) {
    for (std::size_t i = 0; i < 3; ++i) {
      const float moved = result.shift[3 * pass + i] * (pass == 0 ? kAccelerationStep_mg : kRateStep_deg_s);
      const float size = moved < 0 ? -moved : moved;
      if (pass == 0 ? !(size >= 50.0F && size <= 1700.0F) : !(size >= 150.0F && size <= 700.0F)) return false;
    }
    return true;
  }
};

template <RegisterBus Bus>
using Lsm6dso = ImuChip<Bus, Lsm6dsoChip>;

}  // namespace hoist::firmware
