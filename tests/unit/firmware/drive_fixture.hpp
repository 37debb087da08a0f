// A drive on a motor, commanded over its own frames. Times are milliseconds of virtual time.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <vector>

#include "firmware/nodes/drive/drive_node.hpp"
#include "firmware/sim/motor.hpp"
#include "tests/unit/firmware/test_board.hpp"

namespace hoist::firmware {

using DriveState = canopen::drive::State;
inline constexpr int kShutdown = 0x06, kSwitchOn = 0x07, kEnable = 0x0F, kQuickStop = 0x02, kOff = 0x00, kReset = 0x80, kHalt = 0x10F;

inline std::uint32_t bits_of(float value) { return std::bit_cast<std::uint32_t>(value); }

inline sim::MotorConfig loaded_motor() {
  sim::MotorConfig config;
  config.inertia_kg_m2 = 1.0e-3;  // rotor plus its half of 100 kg through gear 30
  return config;
}

class DriveFixture : public ::testing::Test {
 protected:
  using Node = DriveNode<TestBoard>;
  using State = DriveState;
  void SetUp() override { begin(); }
  // Operational, and through the self-test.
  void begin() {
    if (!readings_by_hand_) board_.current_a = 0;
    make_operational(node_, board_);
    tick(node_, static_cast<int>(kSelfTest_ms));
    board_.sent.clear();
  }

  CanFrame rpdo(int word, double target_rad_s) const {
    CanFrame frame{0x201, 6, 0, {}};
    contract::write_le(&frame.data[0], 2, static_cast<std::uint32_t>(word));
    contract::write_le(&frame.data[2], 4, static_cast<std::uint32_t>(std::lround(1000 * target_rad_s)));
    return frame;
  }
  void one_ms() {
    board_.counts = encoder_dead_ ? board_.counts : (encoder_reversed_ ? -motor_.encoder_counts() : motor_.encoder_counts());
    if (!readings_by_hand_) board_.current_a = static_cast<float>(motor_.current_a());
    node_.tick_1ms();
    ++now_ms_;
    peak_current_a_ = std::max(peak_current_a_, std::fabs(motor_.current_a()));
    ASSERT_TRUE(std::isfinite(board_.duty_norm) && std::fabs(board_.duty_norm) <= 1.0F);
    if (board_.bridge_on) {
      motor_.step(board_.duty_norm * board_.supply_voltage_v, load_n_m_, 0.001);
    } else {
      motor_.step(motor_.config().constant_v_s_rad * motor_.speed_rad_s(), load_n_m_, 0.001);  // open: no current
    }
  }
  // The computer as it should be: RPDO every 10 ms, heartbeat every 100 ms.
  void run(int milliseconds, int word, double target_rad_s) {
    for (int i = 0; i < milliseconds; ++i) {
      if (now_ms_ % 10 == 0) node_.on_frame(rpdo(word, target_rad_s));
      if (now_ms_ % 100 == 0 && heartbeats_) node_.on_frame(canopen::heartbeat(0x7F, canopen::NmtState::operational));
      one_ms();
    }
  }
  // Another machine, just powered on: no speed, no faults, and an encoder that starts at this motor's position.
  void start_anew(const sim::MotorConfig& config) {
    motor_ = sim::Motor(config);
    board_.counts = motor_.encoder_counts();
    load_n_m_ = peak_current_a_ = 0;
    encoder_dead_ = false;
    node_.power_on();
    begin();
  }
  void silence(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) one_ms();
  }
  void enable() {
    run(10, kShutdown, 0);
    run(10, kSwitchOn, 0);
    run(10, kEnable, 0);
    ASSERT_EQ(node_.state(), State::operation_enabled);
  }
  void drive_at(double target_rad_s) {
    enable();
    run(1000, kEnable, target_rad_s);
    ASSERT_NEAR(motor_.speed_rad_s(), target_rad_s, 2.0);
    board_.sent.clear();
  }
  std::uint16_t status() const { return node_.stack().values().get<0x6041>(); }
  std::uint16_t error_code() const { return node_.stack().values().get<0x603F>(); }
  std::vector<int> emergencies() const {
    std::vector<int> codes;
    for (const CanFrame& f : board_.with_id(0x081)) codes.push_back(static_cast<int>(contract::read_le(&f.data[0], 2)));
    return codes;
  }
  // Milliseconds from now until `condition`, driven by `step`; -1 after `limit`.
  template <class Condition, class Step>
  int until(int limit, Condition condition, Step step) {
    for (int i = 0; i <= limit; ++i) {
      if (condition()) return i;
      step();
    }
    return -1;
  }

  TestBoard board_;
  Node node_{board_, contract::Node::drive_left};
  sim::Motor motor_{loaded_motor()};
  double load_n_m_ = 0, peak_current_a_ = 0;
  bool encoder_dead_ = false, encoder_reversed_ = false, heartbeats_ = true, readings_by_hand_ = false;
  int now_ms_ = 0;
};

}  // namespace hoist::firmware
