// What a node needs from the hardware under it: one concept per node kind, no virtual calls, no heap. A board is a small class; the same
// node template runs on a Cortex-M0, in the simulator and in tests.
//
// The nodes, all driven the same way, and all switched on by being constructed:
//   TiltNode<Board>(Board&, contract::Node)    firmware/nodes/tilt/tilt_node.hpp
//   DriveNode<Board>(Board&, contract::Node)   firmware/nodes/drive/drive_node.hpp
//   IoNode<Board>(Board&, contract::Node)      firmware/nodes/io/io_node.hpp
//   GatewayNode<Board>(Board&)                 firmware/nodes/gateway/gateway_node.hpp
//   void on_frame(const contract::CanFrame&)   each frame received from the bus, in order, when it arrives
//   void tick_1ms()                            exactly once per millisecond
//   void power_on()                            as if its supply had been switched off and on
#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contract/can_frame.hpp"

namespace hoist::firmware {

// One reading of an inertial sensor, already turned into the frame of the hoist (x forward, y left, z up).
struct ImuSample {
  float ax_m_s2 = 0;  // specific force: at rest and upright (0, 0, +9.81)
  float ay_m_s2 = 0;
  float az_m_s2 = 0;
  float alpha_rate_rad_s = 0;  // > 0 while leaning further forward
  float beta_rate_rad_s = 0;   // > 0 while leaning further right
  float yaw_rate_rad_s = 0;    // > 0 while turning left
};

// Every board. send() hands one frame to the controller: false when it has no room, the frame is then not sent.
// simulated() is true for every board that is not the real machine; the node then says so in its product code (1018h:2, bit 31).
template <class B>
concept CanBoard = requires(B board, const B constant, const contract::CanFrame& frame) {
  { board.send(frame) } -> std::same_as<bool>;
  { constant.simulated() } -> std::same_as<bool>;
};

// read_imu() is false when the sensor gave no new reading.
template <class B>
concept TiltBoard = CanBoard<B> && requires(B board, ImuSample& sample) {
  { board.read_imu(sample) } -> std::same_as<bool>;
};

// The encoder counts up when the wheel drives forward and wraps at 32 bit. The current is positive when it drives forward. duty_norm is
// -1 to 1 of the supply; set_bridge(false, 0) switches all transistors off, so that the motor coasts.
template <class B>
concept DriveBoard = CanBoard<B> && requires(B board, bool enabled, float duty_norm) {
  { board.encoder_counts() } -> std::same_as<std::int32_t>;
  { board.motor_current_a() } -> std::same_as<float>;
  { board.supply_v() } -> std::same_as<float>;
  { board.set_bridge(enabled, duty_norm) } -> std::same_as<void>;
};

// Bits of bumpers(): 0 front, 1 rear, 2 left, 3 right, set = pressed. battery_v(0) and (1) are the two 12 V batteries.
template <class B>
concept IoBoard = CanBoard<B> && requires(B board, int battery) {
  { board.bumpers() } -> std::same_as<std::uint8_t>;
  { board.switches() } -> std::same_as<std::uint8_t>;
  { board.battery_v(battery) } -> std::same_as<float>;
};

// The serial line to the computer: both calls move as many bytes as are there or fit, and return how many.
template <class B>
concept GatewayBoard = CanBoard<B> && requires(B board, std::span<char> in, std::span<const char> out) {
  { board.uart_read(in) } -> std::same_as<std::size_t>;
  { board.uart_write(out) } -> std::same_as<std::size_t>;
};

}  // namespace hoist::firmware
