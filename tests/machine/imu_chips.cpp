#include "tests/machine/imu_chips.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace hoist::machine {
namespace {

constexpr double kGravity_m_s2 = 9.80665;
constexpr double kDegree_rad = 3.14159265358979323846 / 180.0;

std::uint8_t high(std::int16_t value) { return static_cast<std::uint8_t>(static_cast<std::uint16_t>(value) >> 8); }
std::uint8_t low(std::int16_t value) { return static_cast<std::uint8_t>(static_cast<std::uint16_t>(value) & 0xFFU); }

}  // namespace

std::int16_t ImuChip::saturate(double counts) { return static_cast<std::int16_t>(std::lround(std::clamp(counts, -32768.0, 32767.0))); }

bool ImuChip::i2c_write(std::uint8_t byte, Time now) {
  if (!pointer_set_) {
    pointer_ = byte & 0x7FU;
    pointer_set_ = true;
    return true;
  }
  write_register(pointer_, byte, now);
  pointer_ = (pointer_ + 1) & 0x7FU;
  return true;
}
std::uint8_t ImuChip::next_byte(Time now) {
  const std::uint8_t value = read_register(pointer_, now);
  pointer_ = (pointer_ + 1) & 0x7FU;
  return value;
}
void ImuChip::spi_select(bool selected, Time) {
  selected_ = selected;
  first_ = true;
}
std::uint8_t ImuChip::spi_exchange(std::uint8_t byte, bool cpol, bool cpha, std::uint64_t clock_hz, Time now) {
  if (!selected_ || removed_ || !speaks_spi()) return 0xFF;
  if (cpol != cpha) complain_("inertial sensor: SPI mode 1 or 2, it speaks 0 and 3");
  if (clock_hz > spi_max_hz()) complain_("inertial sensor: SPI clock of " + std::to_string(clock_hz) + " Hz is too fast");
  if (first_) {
    first_ = false;
    reading_ = (byte & 0x80U) != 0;
    pointer_ = byte & 0x7FU;
    return 0xFF;
  }
  if (reading_) return next_byte(now);
  write_register(pointer_, byte, now);
  pointer_ = (pointer_ + 1) & 0x7FU;
  return 0xFF;
}

// ---------------------------------------------------------------- MPU-6050

namespace {
constexpr std::array<std::uint8_t, 3> kMpuGyroTrim{15, 17, 14}, kMpuForceTrim{12, 15, 18};
}

Mpu6050::Mpu6050(MotionSource motion, Complain complain) : ImuChip(std::move(motion), std::move(complain)) {
  identity_ = 0x68;
  defaults();
}
void Mpu6050::defaults() {
  auto& regs = bank_[0];
  regs.fill(0);
  regs[0x6B] = 0x40;
  // Factory trims: five bits for each axis, the accelerometer's split over two registers.
  for (std::size_t i = 0; i < 3; ++i) {
    regs[0x0D + i] = static_cast<std::uint8_t>(((kMpuForceTrim[i] >> 2) << 5) | kMpuGyroTrim[i]);
    regs[0x10] = static_cast<std::uint8_t>(regs[0x10] | ((kMpuForceTrim[i] & 3U) << (4 - 2 * i)));
  }
  force_ = {};
  rate_ = {};
}
bool Mpu6050::i2c_address(std::uint8_t address, bool read, Time now) {
  if (address != 0x68 || removed_) return false;
  if (!read) pointer_set_ = false;
  (void)now;
  return true;
}
void Mpu6050::sample(Time now) {
  if (frozen_ || (bank_[0][0x6B] & 0x40U) != 0 || slot(now) <= data_slot_) return;
  data_slot_ = slot(now);
  ++samples_;
  const ChipMotion at = motion_(now);
  const unsigned force_range = (bank_[0][0x1C] >> 3) & 3U, rate_range = (bank_[0][0x1B] >> 3) & 3U;
  for (std::size_t i = 0; i < 3; ++i) {
    double force = at.force_m_s2[i] / kGravity_m_s2 * (16384 >> force_range);
    double rate = at.rate_rad_s[i] / kDegree_rad * (131.0 / (1 << rate_range));
    if ((bank_[0][0x1B] & (0x80U >> i)) != 0) {
      const double sense = i == 1 ? -1.0 : 1.0;
      rate += self_test_share_ * sense * 25.0 * 131.0 * std::pow(1.046, kMpuGyroTrim[i] - 1.0) / (1 << rate_range);
    }
    if ((bank_[0][0x1C] & (0x80U >> i)) != 0)
      force += self_test_share_ * 4096.0 * 0.34 * std::pow(0.92 / 0.34, (kMpuForceTrim[i] - 1.0) / 30.0) * 4.0 / (1 << force_range);
    force_[i] = saturate(force);
    rate_[i] = saturate(rate);
  }
}
std::uint8_t Mpu6050::read_register(std::uint8_t address, Time now) {
  if (address == 0x75) return identity_;
  if (address == 0x3B) sample(now);
  if (address >= 0x3B && address <= 0x40) {
    const std::int16_t value = force_[(address - 0x3BU) / 2];
    return (address & 1U) != 0 ? high(value) : low(value);
  }
  if (address == 0x41) return 0xF0;  // 25 degrees C: (value / 340) + 36.53
  if (address == 0x42) return 0xB0;
  if (address >= 0x43 && address <= 0x48) {
    const std::int16_t value = rate_[(address - 0x43U) / 2];
    return (address & 1U) != 0 ? high(value) : low(value);
  }
  if (address == 0x3A) return (bank_[0][0x6B] & 0x40U) == 0 && tell_ready(now) ? 1 : 0;
  return bank_[0][address];
}
void Mpu6050::write_register(std::uint8_t address, std::uint8_t value, Time now) {
  if (address == 0x6B && (value & 0x80U) != 0) {
    defaults();
    wake(now + 100 * kMillisecond);
    return;
  }
  if (now < awake_from_) complain_("MPU-6050: written less than 100 ms after its reset");
  if (address == 0x75 || (address >= 0x3B && address <= 0x60)) complain_("MPU-6050: read-only register written");
  bank_[0][address] = value;
}

// ---------------------------------------------------------------- LSM6DSO

Lsm6dso::Lsm6dso(MotionSource motion, Complain complain) : ImuChip(std::move(motion), std::move(complain)) {
  identity_ = 0x6C;
  defaults();
}
void Lsm6dso::defaults() {
  bank_[0].fill(0);
  bank_[0][0x12] = 0x04;
  force_ = {};
  rate_ = {};
}
void Lsm6dso::sample(Time now) {
  if (frozen_ || slot(now) <= data_slot_) return;
  data_slot_ = slot(now);
  ++samples_;
  const ChipMotion at = motion_(now);
  constexpr std::array<double, 4> kForce_mg{0.061, 0.488, 0.122, 0.244};
  constexpr std::array<double, 4> kRate_mdeg_s{8.75, 17.5, 35.0, 70.0};
  const double force_mg = kForce_mg[(bank_[0][0x10] >> 2) & 3U];
  const double rate_mdeg = (bank_[0][0x11] & 2U) != 0 ? 4.375 : kRate_mdeg_s[(bank_[0][0x11] >> 2) & 3U];
  const bool force_on = (bank_[0][0x10] >> 4) != 0, rate_on = (bank_[0][0x11] >> 4) != 0;
  const unsigned force_test = bank_[0][0x14] & 3U, rate_test = (bank_[0][0x14] >> 2) & 3U;
  for (std::size_t i = 0; i < 3; ++i) {
    // Data sheet, table 2: self-test moves the output by 50 to 1700 mg and by 150 to 700 deg/s.
    double force = at.force_m_s2[i] / kGravity_m_s2 * 1000.0;
    double rate = at.rate_rad_s[i] / kDegree_rad * 1000.0;
    if (force_test == 1 || force_test == 2) force += self_test_share_ * (force_test == 1 ? 400.0 : -400.0);
    if (rate_test == 1 || rate_test == 3) rate += self_test_share_ * (rate_test == 1 ? 300'000.0 : -300'000.0);
    if (force_on) force_[i] = saturate(force / force_mg);
    if (rate_on) rate_[i] = saturate(rate / rate_mdeg);
  }
}
std::uint8_t Lsm6dso::read_register(std::uint8_t address, Time now) {
  if (address == 0x0F) return identity_;
  if (address == 0x1E) {
    if (slot(now) <= data_slot_) return 0;
    return static_cast<std::uint8_t>(((bank_[0][0x10] >> 4) != 0 ? 1U : 0U) | ((bank_[0][0x11] >> 4) != 0 ? 2U : 0U) | 4U);
  }
  if (address == 0x22) sample(now);
  if (address == 0x20 || address == 0x21) return 0;  // 25 degrees C
  if (address >= 0x22 && address <= 0x27) {
    const std::int16_t value = rate_[(address - 0x22U) / 2];
    return (address & 1U) != 0 ? high(value) : low(value);
  }
  if (address >= 0x28 && address <= 0x2D) {
    const std::int16_t value = force_[(address - 0x28U) / 2];
    return (address & 1U) != 0 ? high(value) : low(value);
  }
  return bank_[0][address];
}
void Lsm6dso::write_register(std::uint8_t address, std::uint8_t value, Time now) {
  if (address == 0x12 && (value & 1U) != 0) {
    defaults();
    wake(now + 50 * kMicrosecond);
    return;
  }
  if (address == 0x0F || (address >= 0x1A && address <= 0x2F)) complain_("LSM6DSO: read-only register written");
  bank_[0][address] = value;
}

// ---------------------------------------------------------------- ICM-42688-P

Icm42688p::Icm42688p(MotionSource motion, Complain complain) : ImuChip(std::move(motion), std::move(complain)) {
  identity_ = 0x47;
  defaults();
}
void Icm42688p::defaults() {
  for (auto& bank : bank_) bank.fill(0);
  bank_[0][0x4F] = 0x06;
  bank_[0][0x50] = 0x06;
  // Factory self-test data; 0 would say that the part was never trimmed.
  for (std::size_t i = 0; i < 3; ++i) {
    bank_[1][0x5F + i] = 100;
    bank_[2][0x3B + i] = 100;
  }
  force_ = {};
  rate_ = {};
}
void Icm42688p::sample(Time now) {
  if (frozen_ || slot(now) <= data_slot_) return;
  data_slot_ = slot(now);
  ++samples_;
  const ChipMotion at = motion_(now);
  const bool rate_on = (bank_[0][0x4E] & 0x0CU) == 0x0CU, force_on = (bank_[0][0x4E] & 3U) == 3U;
  const unsigned force_range = (bank_[0][0x50] >> 5) & 7U, rate_range = (bank_[0][0x4F] >> 5) & 7U;
  const unsigned test = bank_[0][0x70];
  for (std::size_t i = 0; i < 3; ++i) {
    double force = at.force_m_s2[i] / kGravity_m_s2 * (2048 << std::min(force_range, 3U));
    double rate = at.rate_rad_s[i] / kDegree_rad * (16.4 * (1 << std::min(rate_range, 7U)));
    // The response at the factory for a code n: 2620 * 1.01^(n - 1) counts at the self-test's own ranges (2 g, 250 deg/s).
    const double response = 2620.0 * std::pow(1.01, 99.0);
    if ((test & (1U << i)) != 0) rate += self_test_share_ * response * (1 << std::min(rate_range, 7U)) / 8.0;
    if ((test & (8U << i)) != 0 && (test & 0x40U) != 0) force += self_test_share_ * response * (1 << std::min(force_range, 3U)) / 8.0;
    force_[i] = force_on ? saturate(force) : std::int16_t{-32768};
    rate_[i] = rate_on ? saturate(rate) : std::int16_t{-32768};
  }
}
std::uint8_t Icm42688p::read_register(std::uint8_t address, Time now) {
  const unsigned bank = std::min<unsigned>(bank_[0][0x76] & 7U, 4);
  if (address == 0x76) return bank_[0][0x76];
  if (bank != 0) return bank_[bank][address];
  if (address == 0x75) return identity_;
  if (address == 0x2D) return tell_ready(now) ? 0x08 : 0;
  if (address == 0x1D || address == 0x1E) return 0;  // 25 degrees C
  if (address == 0x1F) sample(now);
  if (address >= 0x1F && address <= 0x24) {
    const std::int16_t value = force_[(address - 0x1FU) / 2];
    return (address & 1U) != 0 ? high(value) : low(value);
  }
  if (address >= 0x25 && address <= 0x2A) {
    const std::int16_t value = rate_[(address - 0x25U) / 2];
    return (address & 1U) != 0 ? high(value) : low(value);
  }
  return bank_[0][address];
}
void Icm42688p::write_register(std::uint8_t address, std::uint8_t value, Time now) {
  if (address == 0x76) {
    bank_[0][0x76] = value & 7U;
    return;
  }
  const unsigned bank = std::min<unsigned>(bank_[0][0x76] & 7U, 4);
  if (bank == 0 && address == 0x11 && (value & 1U) != 0) {
    defaults();
    wake(now + kMillisecond);
    return;
  }
  if (bank == 0 && (address == 0x75 || (address >= 0x1D && address <= 0x2D))) complain_("ICM-42688-P: read-only register written");
  bank_[bank][address] = value;
}

}  // namespace hoist::machine
