// What a node needs from its hardware: one concept per node kind, no virtual calls, no heap. A board is a small class; the same node
// template runs on a Cortex-M0, in the simulator and in tests.
//
// The nodes have the same interface, and are powered on by construction:
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
#include <type_traits>

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

  friend constexpr bool operator==(const ImuSample&, const ImuSample&) = default;
};

// State of a CAN controller. The states are those of ISO 11898: warning from 96 errors on, passive from 128 on, bus_off above 255 transmit
// errors: it then neither sends nor receives until it is restarted.
struct CanHealth {
  enum class State : std::uint8_t { active, warning, passive, bus_off };
  State state = State::active;
  std::uint8_t tx_errors = 0, rx_errors = 0;
  std::uint32_t lost = 0;  // received frames lost by full buffers, since power-on
  friend constexpr bool operator==(const CanHealth&, const CanHealth&) = default;
};

// Every board. send() hands one frame to the controller: false when it is full; the frame is then not sent. simulated() is true for every board
// that is not the real machine; the node then sets bit 31 of its product code (1018h:2). can_restart() starts the recovery of a bus-off controller
// (128 times 11 recessive bits); in any other state it does nothing.
template <class B>
concept CanBoard = requires(B board, const B constant, const contract::CanFrame& frame) {
  { board.send(frame) } -> std::same_as<bool>;
  { constant.simulated() } -> std::same_as<bool>;
  { constant.can_health() } -> std::same_as<CanHealth>;
  { board.can_restart() } -> std::same_as<void>;
};

// Why the processor started. When the hardware shows several causes at once, the worst counts: watchdog, then software, pin, power.
enum class ResetCause : std::uint8_t { power, pin, watchdog, software };

// Two pages of flash that are erased one by one. Erased bytes read 0xFF. write() puts bytes into an erased place; false when the flash
// refused or the bytes do not read back. Offsets and lengths are multiples of the chip's write unit, which divides 256.
template <class F>
concept FlashPages = requires(F flash, const F constant, int page, std::size_t offset, std::span<const std::byte> bytes) {
  { F::kPageBytes } -> std::convertible_to<std::size_t>;
  { flash.erase(page) } -> std::same_as<bool>;
  { flash.write(page, offset, bytes) } -> std::same_as<bool>;
  { constant.read(page) } -> std::same_as<std::span<const std::byte>>;
};

// A board whose node keeps parameters. restart() does not return on a microcontroller; into_loader makes the next start stay in the loader.
template <class B>
concept StoringBoard = CanBoard<B> && requires(B board, const B constant, bool into_loader) {
  requires FlashPages<std::remove_cvref_t<decltype(board.flash())>>;
  { constant.reset_cause() } -> std::same_as<ResetCause>;
  { board.restart(into_loader) } -> std::same_as<void>;
};

// State of the inertial sensor. All false until the chip has answered.
struct ImuReport {
  bool found = false;             // the chip answered, with its own identity
  bool wrong_part = false;        // something answered with another identity: see who_am_i
  bool self_test_failed = false;  // the chip's own self-test was outside its data sheet's limits, or registers did not keep their values
  std::uint8_t who_am_i = 0;      // what the identity register said
  friend constexpr bool operator==(const ImuReport&, const ImuReport&) = default;
};

// read_imu() is false when the sensor gave no new reading.
template <class B>
concept TiltBoard = StoringBoard<B> && requires(B board, const B constant, ImuSample& sample) {
  { board.read_imu(sample) } -> std::same_as<bool>;
  { constant.imu_report() } -> std::same_as<ImuReport>;
};

// edge_time_us() of an encoder that has given fewer than two edges in one direction, or none for longer than the counter reaches.
inline constexpr std::uint32_t kEdgeTimeUnknown_us = 0xFFFFFFFF;

// The encoder counts up when the wheel drives forward and wraps at 32 bit. The current is positive when it drives forward. duty_norm is
// -1 to 1 of the supply; set_bridge(false, 0) switches all transistors off, so that the motor coasts.
//   edge_time_us()           microseconds between the last two edges, kEdgeTimeUnknown_us when unknown or after a change of direction
//   illegal_encoder_steps()  how often both lines changed at once, since power-on; wraps
//   driver_ok()              false while the bridge's driver reports a fault (nFAULT low)
template <class B>
concept DriveBoard = StoringBoard<B> && requires(B board, bool enabled, float duty_norm) {
  { board.encoder_counts() } -> std::same_as<std::int32_t>;
  { board.edge_time_us() } -> std::same_as<std::uint32_t>;
  { board.illegal_encoder_steps() } -> std::same_as<std::uint32_t>;
  { board.motor_current_a() } -> std::same_as<float>;
  { board.supply_v() } -> std::same_as<float>;
  { board.driver_ok() } -> std::same_as<bool>;
  { board.set_bridge(enabled, duty_norm) } -> std::same_as<void>;
};

// Bits of bumpers(): 0 front, 1 rear, 2 left, 3 right, set = pressed. battery_v(0) and (1) are the two 12 V batteries. set_outputs()
// switches the eight outputs, bit n = output n; all are off after power-on.
template <class B>
concept IoBoard = StoringBoard<B> && requires(B board, int battery, std::uint8_t outputs) {
  { board.bumpers() } -> std::same_as<std::uint8_t>;
  { board.switches() } -> std::same_as<std::uint8_t>;
  { board.battery_v(battery) } -> std::same_as<float>;
  { board.set_outputs(outputs) } -> std::same_as<void>;
};

// The serial line to the computer: both calls move as many bytes as are available or fit, and return how many. uart_lost() counts
// characters lost by full buffers or framing errors since power-on; wraps.
template <class B>
concept GatewayBoard = CanBoard<B> && requires(B board, const B constant, std::span<char> in, std::span<const char> out) {
  { board.uart_read(in) } -> std::same_as<std::size_t>;
  { board.uart_write(out) } -> std::same_as<std::size_t>;
  { constant.uart_lost() } -> std::same_as<std::uint32_t>;
};

}  // namespace hoist::firmware
