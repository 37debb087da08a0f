// InvenSense MPU-6050 on I2C (address 68h or 69h): +-2 g, +-250 deg/s, low-pass 44 and 42 Hz, 1 kHz.
// Source: register map RM-MPU-6000A-00 revision 4.2, self-test in its sections 4.1 and 4.2; data sheet PS-MPU-6000A-00.
#pragma once
#include "firmware/lib/imu/imu_chip.hpp"

namespace hoist::firmware {

struct Mpu6050Chip {
  static constexpr std::uint8_t kWhoAmIRegister = 0x75, kWhoAmI = 0x68;

  // PWR_MGMT_1: device reset; 100 ms until everything reads its default.
  static constexpr std::array<RegisterValue, 1> kReset{{{0x6B, 0x80}}};
  static constexpr std::uint16_t kReset_ms = 100;

  // PWR_MGMT_1: awake, clock from the x gyro. SMPLRT_DIV 0 with a low-pass: 1 kHz. CONFIG 3: 44 Hz and 42 Hz, 4.9 ms late; below half
  // of the 100 Hz at which the node samples.
  static constexpr std::array<RegisterValue, 5> kWork{{{0x6B, 0x01}, {0x19, 0x00}, {0x1A, 0x03}, {0x1B, 0x00}, {0x1C, 0x00}}};
  static constexpr std::uint16_t kWork_ms = 50;
  static constexpr float kAcceleration_m_s2 = kStandardGravity_m_s2 / 16384.0F;
  static constexpr float kRate_rad_s = kRadPerDegree / 131.0F;

  // INT_STATUS (bit 0: new data), acceleration, temperature, rate: one burst, which the chip keeps consistent.
  static constexpr std::uint8_t kBurstRegister = 0x3A, kReadyMask = 0x01;
  static constexpr std::size_t kBurstBytes = 15, kReadyAt = 0;
  static constexpr RawImu decode(const std::uint8_t* at) {
    return {big_endian(at + 1), big_endian(at + 3), big_endian(at + 5), big_endian(at + 9), big_endian(at + 11), big_endian(at + 13)};
  }

  // The factory's codes hold for +-8 g and +-250 deg/s.
  static constexpr std::array<RegisterValue, 5> kPrepare{{{0x6B, 0x01}, {0x19, 0x00}, {0x1A, 0x02}, {0x1B, 0x00}, {0x1C, 0x10}}};
  static constexpr std::array<RegisterValue, 2> kStimulate{{{0x1B, 0xE0}, {0x1C, 0xF0}}};
  static constexpr std::array<RegisterValue, 2> kRelax{{{0x1B, 0x00}, {0x1C, 0x10}}};
  static constexpr std::array<SelfTestPass, 1> kPasses{{{kPrepare, 100, kStimulate, 100, kRelax, 32, kReadyMask}}};

  // SELF_TEST_X, Y, Z: acceleration's upper three bits, rate's five. SELF_TEST_A: acceleration's lower two of x, y, z.
  template <class Bus>
  [[nodiscard]] static bool read_codes(Bus& bus, SelfTestCodes& codes) {
    std::array<std::uint8_t, 4> bytes{};
    if (!bus.read(0x0D, bytes)) return false;
    for (std::size_t i = 0; i < 3; ++i) {
      const unsigned low = (static_cast<unsigned>(bytes[3]) >> (4 - 2 * i)) & 3U;
      codes[i] = static_cast<std::uint8_t>(((static_cast<unsigned>(bytes[i]) >> 3) & 0x1CU) | low);
      codes[3 + i] = bytes[i] & 0x1FU;
    }
    return true;
  }

  // Data sheet: the change may differ from the factory's by 14 %. A chip without codes counts as failed.
  static constexpr float kDeviationMax = 0.14F;
  static constexpr bool passed(std::size_t, const SelfTestCodes& codes, const SelfTestResult& result) {
    for (std::size_t i = 0; i < 6; ++i) {
      // 4096 x 0.34 x (0.92 / 0.34)^((code - 1) / 30); 25 x 131 x 1.046^(code - 1), negative for y.
      const float expected =
          i < 3 ? 1392.64F * self_test_power(1.0337376F, codes[i]) : (i == 4 ? -3275.0F : 3275.0F) * self_test_power(1.046F, codes[i]);
      if (expected == 0.0F) return false;
      const float ratio = result.shift[i] / expected;
      if (!(ratio >= 1.0F - kDeviationMax && ratio <= 1.0F + kDeviationMax)) return false;
    }
    return true;
  }
};

template <RegisterBus Bus>
using Mpu6050 = ImuChip<Bus, Mpu6050Chip>;

}  // namespace hoist::firmware
