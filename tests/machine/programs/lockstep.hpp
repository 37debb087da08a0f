// The nodes' sources with a board of plain numbers in a deterministic world: compiled for this computer and for the Cortex-M0, results must
// be equal bit by bit in every tick. It needs no peripheral, so any Cortex-M0 can run it.
//
// Every output is folded into one digest: bridge and duty, and each frame sent.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contract/can_dictionary.hpp"
#include "firmware/lib/board.hpp"
#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/nodes/tilt/tilt_node.hpp"

namespace hoist::lockstep {

using contract::CanFrame;

class Digest {
 public:
  void fold(std::uint32_t word) {
    for (unsigned i = 0; i < 4; ++i) value_ = (value_ ^ ((word >> (8 * i)) & 0xFFU)) * 0x01000193U;  // FNV-1a, 32 bit
  }
  void fold_float(float value) { fold(std::bit_cast<std::uint32_t>(value)); }
  [[nodiscard]] std::uint32_t value() const { return value_; }

 private:
  std::uint32_t value_ = 0x811C9DC5U;
};

// Numerical Recipes' generator: enough for noise, the same everywhere.
class Noise {
 public:
  std::uint32_t bits() { return state_ = state_ * 1664525U + 1013904223U; }
  /// -1 to 1 in steps of 2^-15.
  float unit() { return static_cast<float>(static_cast<std::int32_t>(bits() >> 16) - 32768) * (1.0F / 32768.0F); }

 private:
  std::uint32_t state_ = 20261121U;
};

/// Flash that is never written, and a bus that accepts everything.
class NumberBoard {
 public:
  static constexpr std::size_t kPageBytes = 1024;
  struct Flash {
    static constexpr std::size_t kPageBytes = NumberBoard::kPageBytes;
    bool erase(int) { return true; }
    bool write(int, std::size_t, std::span<const std::byte>) { return false; }
    [[nodiscard]] std::span<const std::byte> read(int) const { return erased; }
    std::array<std::byte, kPageBytes> erased{};
  };
  NumberBoard() { flash_.erased.fill(std::byte{0xFF}); }
  bool send(const CanFrame& frame) {
    digest.fold(frame.id);
    for (std::size_t i = 0; i < frame.dlc; ++i) digest.fold(std::uint32_t{frame.data[i]});
    ++sent;
    return true;
  }
  [[nodiscard]] bool simulated() const { return false; }
  [[nodiscard]] bool sent_all() const { return true; }
  [[nodiscard]] firmware::CanHealth can_health() const { return {}; }
  void can_restart() {}
  Flash& flash() { return flash_; }
  [[nodiscard]] firmware::ResetCause reset_cause() const { return firmware::ResetCause::power; }
  void restart(bool) {}

  Digest digest;
  std::uint32_t sent = 0;

 private:
  Flash flash_{};
};

/// A motor in single precision, its encoder and its supply.
class MotorBoard : public NumberBoard {
 public:
  std::int32_t encoder_counts() { return counts_; }
  std::uint32_t edge_time_us() { return edge_us_; }
  std::uint32_t illegal_encoder_steps() { return 0; }
  float motor_current_a() { return current_a_ + 0.05F * noise_.unit(); }
  float supply_v() { return 24.5F + 0.05F * noise_.unit(); }
  bool driver_ok() { return true; }
  void set_bridge(bool enabled, float duty_norm) {
    enabled_ = enabled;
    duty_norm_ = duty_norm;
    digest.fold(enabled ? 1U : 0U);
    digest.fold_float(duty_norm);
  }
  [[nodiscard]] std::int32_t millirad_s() const { return static_cast<std::int32_t>(speed_rad_s_ * 1000.0F); }
  // One millisecond: winding, rotor, counts.
  void move(float load_n_m) {
    const float applied_v = enabled_ ? duty_norm_ * 24.5F : 0.0F;
    const float settled_a = enabled_ ? (applied_v - 0.115F * speed_rad_s_) * (1.0F / 1.2F) : 0.0F;
    current_a_ += 0.55F * (settled_a - current_a_);
    speed_rad_s_ += (0.115F * current_a_ - 0.0008F * speed_rad_s_ - load_n_m) * (0.001F / 0.0012F);
    angle_counts_ += speed_rad_s_ * 0.318309886F;  // 2000 counts a turn, 1 ms
    const auto whole = static_cast<std::int32_t>(angle_counts_);
    counts_ += whole;
    angle_counts_ -= static_cast<float>(whole);
    const float size = speed_rad_s_ < 0.0F ? -speed_rad_s_ : speed_rad_s_;
    edge_us_ = size > 1.0F ? static_cast<std::uint32_t>(3141.59265F / size) : firmware::kEdgeTimeUnknown_us;
  }

 private:
  Noise noise_;
  bool enabled_ = false;
  float duty_norm_ = 0, current_a_ = 0, speed_rad_s_ = 0, angle_counts_ = 0;
  std::int32_t counts_ = 0;
  std::uint32_t edge_us_ = firmware::kEdgeTimeUnknown_us;
};

class SwayBoard : public NumberBoard {
 public:
  bool read_imu(firmware::ImuSample& sample) {
    sample = sample_;
    return true;
  }
  [[nodiscard]] firmware::ImuReport imu_report() const { return {true, false, false, 0x68}; }
  // Still for three seconds, then swaying forward and sideways like a patient, with noise.
  void move(std::uint32_t tick) {
    const std::uint32_t phase = tick % 1700U;
    const float ramp = tick < 3000U ? 0.0F : (static_cast<float>(phase) - 850.0F) * (1.0F / 850.0F);
    const float alpha = 0.2F * ramp * ramp * ramp, beta = -0.1F * ramp;
    sample_.ax_m_s2 = -9.8F * alpha + (tick < 3000U ? 0.005F : 0.05F) * noise_.unit();
    sample_.ay_m_s2 = 9.8F * beta + (tick < 3000U ? 0.005F : 0.05F) * noise_.unit();
    sample_.az_m_s2 = 9.8F + (tick < 3000U ? 0.005F : 0.05F) * noise_.unit();
    sample_.alpha_rate_rad_s = 0.6F * ramp * ramp * (tick < 3000U ? 0.0F : 1.0F) + 0.002F * noise_.unit() + 0.011F;
    sample_.beta_rate_rad_s = 0.002F * noise_.unit() - 0.007F;
    sample_.yaw_rate_rad_s = 0.002F * noise_.unit();
  }

 private:
  Noise noise_;
  firmware::ImuSample sample_{};
};

inline CanFrame frame(std::uint32_t id, std::span<const std::uint8_t> data) {
  CanFrame out;
  out.id = id;
  out.dlc = static_cast<std::uint8_t>(data.size());
  for (std::size_t i = 0; i < data.size(); ++i) out.data[i] = data[i];
  return out;
}

// Frames of the computer in this millisecond: NMT start, heartbeat, SYNC and, for a drive, commands that enable it and then set changing
// speeds, forward and backward, slow and fast. Calls on_frame for each.
template <class OnFrame>
void computer(std::uint32_t tick, std::uint32_t id, bool drive, OnFrame&& on_frame) {
  if (tick == 200) on_frame(frame(0x000, std::array<std::uint8_t, 2>{1, 0}));
  if (tick % 100 == 0) on_frame(frame(0x77F, std::array<std::uint8_t, 1>{5}));
  if (tick % 10 != 0 || tick < 210) return;
  on_frame(frame(0x080, {}));
  if (!drive) return;
  const std::uint32_t step = tick / 10;
  const std::uint8_t word = tick < 300 ? 0x06 : (tick < 400 ? 0x07 : 0x0F);
  constexpr std::array<std::int32_t, 8> kTargets{0, 90'000, 2'500, -60'000, 3'000, 180'000, -2'000, 20'000};  // mrad/s
  const std::int32_t target = tick < 500 ? 0 : kTargets[(step / 120) % kTargets.size()];
  const auto bits = static_cast<std::uint32_t>(target);
  on_frame(frame(0x200 + id, std::array<std::uint8_t, 6>{word, 0, static_cast<std::uint8_t>(bits), static_cast<std::uint8_t>(bits >> 8),
                                                         static_cast<std::uint8_t>(bits >> 16), static_cast<std::uint8_t>(bits >> 24)}));
}

/// Mark is called around the node's own work: mark(true) before its tick, mark(false) behind it.
class DriveRun {
 public:
  DriveRun() : node_(board_, contract::Node::drive_left) {}
  template <class Mark>
  void step(Mark&& mark) {
    computer(tick_, 1, true, [this](const CanFrame& f) { node_.on_frame(f); });
    mark(true);
    node_.tick_1ms();
    mark(false);
    board_.move((tick_ / 400) % 3 == 0 ? 0.05F : -0.02F);
    ++tick_;
  }
  [[nodiscard]] std::uint32_t digest() const { return board_.digest.value(); }
  [[nodiscard]] std::uint32_t sent() const { return board_.sent; }
  [[nodiscard]] std::int32_t millirad_s() const { return board_.millirad_s(); }

 private:
  MotorBoard board_;
  firmware::DriveNode<MotorBoard> node_;
  std::uint32_t tick_ = 0;
};

class TiltRun {
 public:
  TiltRun() : node_(board_, contract::Node::tilt_left) {}
  template <class Mark>
  void step(Mark&& mark) {
    board_.move(tick_);
    mark(true);
    // Its work is done when a SYNC comes.
    computer(tick_, 0x11, false, [this](const CanFrame& f) { node_.on_frame(f); });
    node_.tick_1ms();
    mark(false);
    ++tick_;
  }
  [[nodiscard]] std::uint32_t digest() const { return board_.digest.value(); }
  [[nodiscard]] std::uint32_t sent() const { return board_.sent; }

 private:
  SwayBoard board_;
  firmware::TiltNode<SwayBoard> node_;
  std::uint32_t tick_ = 0;
};

}  // namespace hoist::lockstep
