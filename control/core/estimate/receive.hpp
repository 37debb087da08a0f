// Where each received frame goes. What no node of the dictionary sends, or not in this length, is refused.
#pragma once
#include <array>
#include <cstdint>

#include "control/contract/can_dictionary.hpp"
#include "control/core/derived.hpp"
#include "control/core/estimate/estimate.hpp"
#include "control/core/output/bus_master.hpp"

namespace hoist::core {

namespace detail {
// Node of each of the 128 node ids, kNodes.size() = none. The core itself is none: nobody else may speak for it.
inline constexpr auto kNodeOfId = [] {
  std::array<std::uint8_t, 128> table{};
  table.fill(static_cast<std::uint8_t>(contract::kNodes.size()));
  for (std::size_t i = 0; i < contract::kRemoteNodeCount; ++i) table[contract::kNodes[i].id] = static_cast<std::uint8_t>(i);
  return table;
}();
}  // namespace detail

/// True when the frame was one of ours and its content plausible.
[[nodiscard]] inline bool receive(const contract::CanFrame& frame, Estimate& sensed, BusMaster& master, const Derived& derived,
                                  double dt_s) noexcept {
  using contract::Node;
  using contract::Pdo;
  namespace canopen = contract::canopen;
  if (frame.flags != 0 || frame.id > 0x7FF) return false;
  const std::uint8_t index = detail::kNodeOfId[frame.id & 0x7F];
  if (index >= contract::kRemoteNodeCount) return false;
  const auto node = static_cast<Node>(index);
  const contract::NodeKind kind = contract::kNodes[index].kind;
  const auto fits = [&frame](Pdo pdo) { return frame.dlc == contract::pdo_bytes(pdo); };
  TiltSensor& tilt = node == Node::tilt_left ? sensed.left_strut : (node == Node::tilt_right ? sensed.right_strut : sensed.base);
  const bool left = node == Node::drive_left;
  DriveSensor& drive = left ? sensed.left_drive : sensed.right_drive;
  switch (frame.id & 0x780) {
    case 0x180:  // first process data
      switch (kind) {
        case contract::NodeKind::tilt:
          if (!fits(Pdo::tilt_tx1)) return false;
          tilt.take_angles(
              frame, node == Node::tilt_left ? derived.left_zero : (node == Node::tilt_right ? derived.right_zero : derived.base_zero));
          return true;
        case contract::NodeKind::drive:
          return fits(Pdo::drive_tx1) &&
                 drive.take_state(frame, (left ? derived.left_counts_per_s_max : derived.right_counts_per_s_max) * dt_s);
        case contract::NodeKind::io:
          if (!fits(Pdo::io_tx1)) return false;
          sensed.io.take_inputs(frame);
          return true;
        case contract::NodeKind::host:
          return false;
      }
      return false;
    case 0x280:  // second process data
      switch (kind) {
        case contract::NodeKind::tilt:
          if (!fits(Pdo::tilt_tx2)) return false;
          tilt.take_rates(frame, node == Node::tilt_base ? derived.base_yaw_bias_rad_s : 0.0);
          return true;
        case contract::NodeKind::drive:
          if (!fits(Pdo::drive_tx2)) return false;
          drive.take_supply(frame);
          return true;
        case contract::NodeKind::io:
          if (!fits(Pdo::io_tx2)) return false;
          sensed.io.take_batteries(frame);
          return true;
        case contract::NodeKind::host:
          return false;
      }
      return false;
    case canopen::kEmcyBase:
      return frame.dlc == 8;  // recorded with the bus; what it tells is also in the process data
    case canopen::kSdoReplyBase:
      return frame.dlc == 8 && master.take_sdo_reply(node, frame);
    case canopen::kHeartbeatBase: {
      const auto state = frame.data[0];
      const bool known = state == static_cast<std::uint8_t>(canopen::NmtState::boot_up) ||
                         state == static_cast<std::uint8_t>(canopen::NmtState::stopped) ||
                         state == static_cast<std::uint8_t>(canopen::NmtState::operational) ||
                         state == static_cast<std::uint8_t>(canopen::NmtState::pre_operational);
      if (frame.dlc != 1 || !known) return false;
      if (master.take_heartbeat(node, state)) sensed.restart(node);
      return true;
    }
    default:
      return false;
  }
}

}  // namespace hoist::core
