// An inertial sensor chip behind a register bus: reset, identity, self-test, configuration, readings. One engine, with a description per
// chip (mpu6050.hpp, lsm6dso.hpp, icm42688p.hpp).
//
// It never waits: step_1ms() is called once per millisecond and does at most a few transfers. read() gives nothing until the self-test has
// passed, and after any error.
//
//   start -> reset -> identity -> for each pass of the self-test: prepare, samples at rest, stimulus on, samples, stimulus off, evaluate
//         -> configure -> running, where one register after the other is read back
//   wrong identity            stays out of service, retries each second
//   self-test not passed      repeated kSelfTestTries times (the strut may have been moved), then failed until power-off
//   a register has changed    failed until power-off: the chip has restarted or is broken
//   bus does not answer       restarts at reset
#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/lib/board.hpp"

namespace hoist::firmware {

// Registers of one chip, over I2C or SPI. read() fills `out` from `reg` on in one burst; the bus adds its protocol's address or read bit.
// false: no acknowledge, or the transfer did not end in time.
template <class B>
concept RegisterBus = requires(B bus, std::uint8_t reg, std::uint8_t value, std::span<std::uint8_t> out) {
  { bus.write(reg, value) } -> std::same_as<bool>;
  { bus.read(reg, out) } -> std::same_as<bool>;
};

inline constexpr float kStandardGravity_m_s2 = 9.80665F;
inline constexpr float kRadPerDegree = 0.017453292F;

inline constexpr std::uint16_t kImuPowerUp_ms = 50;  // longest power-up of the three: MPU-6050, 30 ms, and a margin
inline constexpr std::uint16_t kImuRetry_ms = 1000;  // between two checks of a missing or unknown chip
inline constexpr std::uint16_t kImuCheck_ms = 100;   // between two registers read back
// A check waits for the middle between two samples, which come every 10 ms: a sample over I2C leaves no time for it in the same millisecond.
inline constexpr std::uint16_t kImuSample_ms = 10, kImuCheckBehindSample_ms = 4;
inline constexpr std::uint8_t kSelfTestTries = 5;        // each takes under a second
inline constexpr std::uint16_t kSelfTestSample_ms = 60;  // longest wait for one sample; the slowest rate in use is 52 Hz
inline constexpr std::uint8_t kImuBusFailuresMax = 5;    // transfers in a row
inline constexpr std::uint8_t kImuFrozenReadings = 20;   // equal in all six words: noise makes that impossible, hazard H6
inline constexpr std::size_t kImuBurstMax = 20;          // bytes

struct RegisterValue {
  std::uint8_t reg = 0, value = 0;
};

// Acceleration x, y, z, then rate x, y, z, in the chip's steps and axes.
using RawImu = std::array<std::int16_t, 6>;

struct SelfTestPass {
  std::span<const RegisterValue> prepare{};
  std::uint16_t prepare_ms = 0;
  std::span<const RegisterValue> stimulate{};
  std::uint16_t stimulate_ms = 0;
  std::span<const RegisterValue> relax{};
  std::uint8_t samples = 0;     // averaged before and after; one more is thrown away first
  std::uint8_t ready_mask = 0;  // which bits of the ready byte must be set
};
// What a pass measured, in steps: the mean at rest, and how far the stimulus moved it.
struct SelfTestResult {
  std::array<float, 6> rest{}, shift{};
};
// Factory codes of the self-test: acceleration x, y, z, rate x, y, z.
using SelfTestCodes = std::array<std::uint8_t, 6>;

constexpr std::int16_t big_endian(const std::uint8_t* at) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>((static_cast<unsigned>(at[0]) << 8) | at[1]));
}
constexpr std::int16_t little_endian(const std::uint8_t* at) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>((static_cast<unsigned>(at[1]) << 8) | at[0]));
}
// base^(code - 1) by repeated multiplication: the same bits on every machine. 0 for code 0: the factory wrote none.
constexpr float self_test_power(float base, std::uint8_t code) {
  if (code == 0) return 0.0F;
  float power = 1.0F;
  for (std::uint8_t i = 1; i < code; ++i) power *= base;
  return power;
}

// Any RegisterBus, its kind forgotten. The bus must outlive it.
class RegisterBusRef {
 public:
  // Not for itself: a copy must refer to the same bus, not to what it was copied from.
  template <RegisterBus Bus>
  requires(!std::same_as<Bus, RegisterBusRef>) constexpr explicit RegisterBusRef(Bus& bus)
      : bus_(&bus),
        write_([](void* b, std::uint8_t reg, std::uint8_t value) { return static_cast<Bus*>(b)->write(reg, value); }),
        read_([](void* b, std::uint8_t reg, std::span<std::uint8_t> out) { return static_cast<Bus*>(b)->read(reg, out); }) {}
  bool write(std::uint8_t reg, std::uint8_t value) { return write_(bus_, reg, value); }
  bool read(std::uint8_t reg, std::span<std::uint8_t> out) { return read_(bus_, reg, out); }

 private:
  void* bus_;
  bool (*write_)(void*, std::uint8_t, std::uint8_t);
  bool (*read_)(void*, std::uint8_t, std::span<std::uint8_t>);
};

// What differs between chips, as data: a board that may carry one of three has the engine once in its flash, not three times.
struct ImuDescription {
  std::uint8_t who_am_i_register, who_am_i;
  std::span<const RegisterValue> reset;
  std::uint16_t reset_ms;
  std::span<const RegisterValue> work;
  std::uint16_t work_ms;
  float acceleration_m_s2, rate_rad_s;  // one step
  std::uint8_t burst_register, burst_bytes, ready_at, ready_mask;
  std::span<const SelfTestPass> passes;
  RawImu (*decode)(const std::uint8_t*);
  bool (*read_codes)(RegisterBusRef&, SelfTestCodes&);
  bool (*passed)(std::size_t, const SelfTestCodes&, const SelfTestResult&);
};
template <class Chip>
inline constexpr ImuDescription kImuDescription{Chip::kWhoAmIRegister,
                                                Chip::kWhoAmI,
                                                Chip::kReset,
                                                Chip::kReset_ms,
                                                Chip::kWork,
                                                Chip::kWork_ms,
                                                Chip::kAcceleration_m_s2,
                                                Chip::kRate_rad_s,
                                                Chip::kBurstRegister,
                                                Chip::kBurstBytes,
                                                Chip::kReadyAt,
                                                Chip::kReadyMask,
                                                Chip::kPasses,
                                                Chip::decode,
                                                Chip::template read_codes<RegisterBusRef>,
                                                Chip::passed};

class ImuEngine {
 public:
  constexpr ImuEngine(RegisterBusRef bus, const ImuDescription& chip) : bus_(bus), chip_(&chip) {}

  /// As after power-on.
  void restart() {
    phase_ = Phase::reset;
    wait_ms_ = kImuPowerUp_ms;
    report_ = {};
    tries_ = bus_failures_ = same_ = 0;
    has_last_ = false;
  }

  void step_1ms() {
    if (wait_ms_ > 0) {
      --wait_ms_;
      return;
    }
    switch (phase_) {
      case Phase::reset:
        if (!write_all(chip_->reset)) return lose_bus();
        return go(Phase::identify, chip_->reset_ms);
      case Phase::identify:
        return identify();
      case Phase::prepare:
        if (!write_all(pass().prepare)) return lose_bus();
        begin_sums();
        return go(Phase::rest, pass().prepare_ms);
      case Phase::rest:
        if (!sum_up(rest_)) return;
        if (!write_all(pass().stimulate)) return lose_bus();
        begin_sums();
        return go(Phase::stimulus, pass().stimulate_ms);
      case Phase::stimulus:
        if (!sum_up(moved_)) return;
        if (!write_all(pass().relax)) return lose_bus();
        return evaluate();
      case Phase::configure:
        if (!write_all(chip_->work)) return lose_bus();
        check_at_ = 0;
        return go(Phase::verify, chip_->work_ms);
      case Phase::verify:  // every register once, then one now and then
        if (!check_register()) return;
        if (check_at_ != 0) return;
        return go(Phase::running, kImuCheck_ms);
      case Phase::running:
        if (check_register()) wait_ms_ = kImuCheck_ms;
        return;
      case Phase::failed:
        return;
    }
  }

  /// The newest reading, in the chip's own axes (x, y, z on its package are forward, left, up); false without a new one, and while the chip
  /// is out of service.
  [[nodiscard]] bool read(ImuSample& sample) {
    if (phase_ != Phase::running) return false;
    if (wait_ms_ < kImuSample_ms + kImuCheckBehindSample_ms) wait_ms_ = kImuCheckBehindSample_ms;
    RawImu raw{};
    if (!read_raw(raw, chip_->ready_mask)) return false;
    if (has_last_ && raw == last_) {
      if (same_ < kImuFrozenReadings) ++same_;
    } else {
      same_ = 0;
    }
    last_ = raw;
    has_last_ = true;
    if (same_ >= kImuFrozenReadings) return false;
    const auto acceleration_m_s2 = [&raw, this](std::size_t axis) { return chip_->acceleration_m_s2 * static_cast<float>(raw[axis]); };
    const auto rate_rad_s = [&raw, this](std::size_t axis) { return chip_->rate_rad_s * static_cast<float>(raw[3 + axis]); };
    // Right-handed with x forward and z up: turning about y leans forward, about x leans right.
    sample = {acceleration_m_s2(0), acceleration_m_s2(1), acceleration_m_s2(2), rate_rad_s(1), rate_rad_s(0), rate_rad_s(2)};
    return true;
  }

  [[nodiscard]] const ImuReport& report() const { return report_; }
  [[nodiscard]] bool running() const { return phase_ == Phase::running; }

 private:
  enum class Phase : std::uint8_t { reset, identify, prepare, rest, stimulus, configure, verify, running, failed };

  [[nodiscard]] const SelfTestPass& pass() const { return chip_->passes[pass_]; }

  void go(Phase to, std::uint16_t wait_ms) {
    phase_ = to;
    wait_ms_ = wait_ms;
  }
  void lose_bus() {
    report_.found = false;
    same_ = bus_failures_ = 0;
    has_last_ = false;
    go(Phase::reset, kImuRetry_ms);
  }
  [[nodiscard]] bool write_all(std::span<const RegisterValue> writes) {
    for (const RegisterValue& w : writes)
      if (!bus_.write(w.reg, w.value)) return false;
    return true;
  }

  void identify() {
    std::array<std::uint8_t, 1> identity{};
    if (!bus_.read(chip_->who_am_i_register, identity)) return lose_bus();
    report_.who_am_i = identity[0];
    report_.wrong_part = identity[0] != chip_->who_am_i;
    if (report_.wrong_part) return lose_bus();
    report_.found = true;
    if (!chip_->read_codes(bus_, codes_)) return lose_bus();
    pass_ = 0;
    go(Phase::prepare, 0);
  }

  // One burst holds the ready bits and the newest sample.
  [[nodiscard]] bool read_raw(RawImu& raw, std::uint8_t ready_mask) {
    std::array<std::uint8_t, kImuBurstMax> bytes{};
    if (!bus_.read(chip_->burst_register, std::span(bytes).first(chip_->burst_bytes))) {
      if (++bus_failures_ >= kImuBusFailuresMax) lose_bus();
      return false;
    }
    bus_failures_ = 0;
    if ((bytes[chip_->ready_at] & ready_mask) != ready_mask) return false;
    raw = chip_->decode(bytes.data());
    return true;
  }

  void begin_sums() {
    sums_ = {};
    taken_ = 0;
    sample_age_ms_ = 0;
  }
  // True when the mean is complete and in `mean`.
  [[nodiscard]] bool sum_up(std::array<float, 6>& mean) {
    RawImu raw{};
    const Phase before = phase_;
    if (!read_raw(raw, pass().ready_mask)) {
      if (phase_ == before && ++sample_age_ms_ > kSelfTestSample_ms) try_again();
      return false;
    }
    sample_age_ms_ = 0;
    if (++taken_ == 1) return false;  // may be older than the change before it
    for (std::size_t i = 0; i < raw.size(); ++i) sums_[i] += raw[i];
    if (taken_ <= pass().samples) return false;
    for (std::size_t i = 0; i < raw.size(); ++i) mean[i] = static_cast<float>(sums_[i]) / static_cast<float>(pass().samples);
    return true;
  }

  void evaluate() {
    SelfTestResult result{rest_, {}};
    for (std::size_t i = 0; i < rest_.size(); ++i) result.shift[i] = moved_[i] - rest_[i];
    if (!chip_->passed(pass_, codes_, result)) return try_again();
    if (++pass_ < chip_->passes.size()) return go(Phase::prepare, 0);
    go(Phase::configure, 0);
  }
  void try_again() {
    if (!write_all(pass().relax)) return lose_bus();
    pass_ = 0;
    if (++tries_ < kSelfTestTries) return go(Phase::prepare, 0);
    report_.self_test_failed = true;
    go(Phase::failed, 0);
  }

  // Reads one configuration register back; true when it is unchanged.
  [[nodiscard]] bool check_register() {
    const RegisterValue& expected = chip_->work[check_at_];
    std::array<std::uint8_t, 1> value{};
    if (!bus_.read(expected.reg, value)) {
      if (++bus_failures_ >= kImuBusFailuresMax) lose_bus();
      return false;
    }
    bus_failures_ = 0;
    if (value[0] != expected.value) {
      report_.self_test_failed = true;
      go(Phase::failed, 0);
      return false;
    }
    check_at_ = static_cast<std::uint8_t>((check_at_ + 1U) % chip_->work.size());
    return true;
  }

  RegisterBusRef bus_;
  const ImuDescription* chip_;
  Phase phase_ = Phase::reset;
  std::uint16_t wait_ms_ = kImuPowerUp_ms, sample_age_ms_ = 0;
  ImuReport report_{};
  SelfTestCodes codes_{};
  std::uint8_t pass_ = 0, tries_ = 0, taken_ = 0, bus_failures_ = 0, same_ = 0, check_at_ = 0;
  bool has_last_ = false;
  std::array<std::int32_t, 6> sums_{};
  std::array<float, 6> rest_{}, moved_{};
  RawImu last_{};
};

template <RegisterBus Bus, class Chip>
class ImuChip : public ImuEngine {
 public:
  static_assert(Chip::kBurstBytes <= kImuBurstMax);
  constexpr explicit ImuChip(Bus& bus) : ImuEngine(RegisterBusRef(bus), kImuDescription<Chip>) {}
};

}  // namespace hoist::firmware
