// The three inertial sensors of the tilt boards, as their data sheets say a program sees them: registers, reset, sleep, ranges, self-test.
// Motion comes from outside in the chip's own axes; noise and bias are its business.
#pragma once

#include <array>
#include <cstdint>
#include <functional>

#include "tests/machine/serial_blocks.hpp"
#include "tests/machine/time.hpp"

namespace hoist::machine {

/// Specific force in m/s2 and rates in rad/s, x y z of the chip.
struct ChipMotion {
  std::array<double, 3> force_m_s2{0.0, 0.0, 9.80665};
  std::array<double, 3> rate_rad_s{};
};
using MotionSource = std::function<ChipMotion(Time now)>;

/// Common to all three: 128 registers of 8 bit behind an auto-incrementing pointer, and a sample taken when its first byte is read.
class ImuChip : public I2cDevice, public SpiDevice {
 public:
  ImuChip(MotionSource motion, Complain complain) : motion_(std::move(motion)), complain_(std::move(complain)) {}
  /// The self-test gives this share of what the maker says; 1: a sound chip.
  void set_self_test_share(double share) { self_test_share_ = share; }
  /// Another identity than its own, as a wrong part would give.
  void set_identity(std::uint8_t id) { identity_ = id; }
  /// The data registers no longer change.
  void freeze(bool frozen) { frozen_ = frozen; }
  /// Does not answer any more.
  void remove(bool removed) { removed_ = removed; }
  [[nodiscard]] std::uint64_t samples() const { return samples_; }
  [[nodiscard]] std::uint8_t reg(std::uint8_t address) const { return bank_[0][address & 0x7FU]; }

  [[nodiscard]] bool i2c_address(std::uint8_t, bool, Time) override { return false; }
  [[nodiscard]] bool i2c_write(std::uint8_t byte, Time now) override;
  [[nodiscard]] std::uint8_t i2c_read(bool, Time now) override { return next_byte(now); }
  void i2c_stop(Time) override {}
  void spi_select(bool selected, Time now) override;
  [[nodiscard]] std::uint8_t spi_exchange(std::uint8_t byte, bool cpol, bool cpha, std::uint64_t clock_hz, Time now) override;

 protected:
  [[nodiscard]] virtual std::uint8_t read_register(std::uint8_t address, Time now) = 0;
  virtual void write_register(std::uint8_t address, std::uint8_t value, Time now) = 0;
  [[nodiscard]] virtual std::uint64_t spi_max_hz() const { return 10'000'000; }
  [[nodiscard]] virtual bool speaks_spi() const { return true; }
  [[nodiscard]] static std::int16_t saturate(double counts);

  MotionSource motion_;
  Complain complain_;
  double self_test_share_{1.0};
  std::uint8_t identity_{};
  bool frozen_{}, removed_{};
  std::array<std::array<std::uint8_t, 128>, 5> bank_{};
  std::array<std::int16_t, 3> force_{}, rate_{};
  /// The chip samples by its own clock, from when it was last woken or reset.
  [[nodiscard]] std::uint64_t slot(Time now) const { return now > awake_from_ ? (now - awake_from_) / kMillisecond : 0; }
  void wake(Time from) {
    awake_from_ = from;
    told_slot_ = data_slot_ = 0;
  }
  /// True once for each new sample.
  [[nodiscard]] bool tell_ready(Time now) {
    const bool fresh = slot(now) > told_slot_;
    told_slot_ = slot(now);
    return fresh;
  }
  Time awake_from_{};
  std::uint64_t told_slot_{}, data_slot_{};
  std::uint64_t samples_{};
  std::uint8_t pointer_{};
  bool pointer_set_{};  // I2C: the first byte written is the address
  bool selected_{}, first_{}, reading_{};

 private:
  [[nodiscard]] std::uint8_t next_byte(Time now);
};

/// InvenSense MPU-6050 on I2C (register map revision 4.2).
class Mpu6050 : public ImuChip {
 public:
  Mpu6050(MotionSource motion, Complain complain);
  [[nodiscard]] bool i2c_address(std::uint8_t address, bool read, Time now) override;

 protected:
  [[nodiscard]] std::uint8_t read_register(std::uint8_t address, Time now) override;
  void write_register(std::uint8_t address, std::uint8_t value, Time now) override;
  [[nodiscard]] bool speaks_spi() const override { return false; }

 private:
  void defaults();
  void sample(Time now);
};

/// ST LSM6DSO on SPI (data sheet DS12140).
class Lsm6dso : public ImuChip {
 public:
  Lsm6dso(MotionSource motion, Complain complain);

 protected:
  [[nodiscard]] std::uint8_t read_register(std::uint8_t address, Time now) override;
  void write_register(std::uint8_t address, std::uint8_t value, Time now) override;

 private:
  void defaults();
  void sample(Time now);
};

/// TDK ICM-42688-P on SPI (data sheet DS-000347).
class Icm42688p : public ImuChip {
 public:
  Icm42688p(MotionSource motion, Complain complain);

 protected:
  [[nodiscard]] std::uint8_t read_register(std::uint8_t address, Time now) override;
  void write_register(std::uint8_t address, std::uint8_t value, Time now) override;
  [[nodiscard]] std::uint64_t spi_max_hz() const override { return 24'000'000; }

 private:
  void defaults();
  void sample(Time now);
};

}  // namespace hoist::machine
