// Where each received frame goes. Frames that no node of the dictionary sends, or not with this length, are refused.
#pragma once
#include <cstdint>

#include "control/contract/classify.hpp"
#include "control/core/base/derived.hpp"
#include "control/core/estimate/estimate.hpp"
#include "control/core/output/bus_master.hpp"

namespace hoist::core {

namespace detail {
[[nodiscard]] inline bool take_first_data(const contract::CanFrame& frame, const NodeRow& row, Estimate& sensed, const Derived& derived,
                                          double dt_s) noexcept {
  if (row.drive != nullptr) return (sensed.*row.drive).take_state(frame, derived.*row.counts_per_s_max * dt_s);
  if (row.tilt != nullptr) (sensed.*row.tilt).take_angles(frame, derived.*row.zero);
  if (row.io != nullptr) (sensed.*row.io).take_inputs(frame);
  return true;
}

inline void take_second_data(const contract::CanFrame& frame, const NodeRow& row, Estimate& sensed, const Derived& derived) noexcept {
  if (row.drive != nullptr) (sensed.*row.drive).take_supply(frame);
  if (row.tilt != nullptr) (sensed.*row.tilt).take_rates(frame, row.yaw_bias_rad_s != nullptr ? derived.*row.yaw_bias_rad_s : 0.0);
  if (row.io != nullptr) (sensed.*row.io).take_batteries(frame);
}
}  // namespace detail

/// True when the frame was one of ours and its content plausible. `what` = classify(frame).
[[nodiscard]] inline bool receive(const contract::CanFrame& frame, const contract::FrameClass& what, Estimate& sensed, BusMaster& master,
                                  const Derived& derived, double dt_s) noexcept {
  using contract::CobKind;
  using contract::canopen::NmtState;
  // No node may use the core's identifiers; the core's row comes after these.
  if (what.node >= kNodeRows.size() || !what.fits) return false;
  const NodeRow& row = kNodeRows[what.node];
  switch (what.kind) {
    case CobKind::tpdo1:
      return detail::take_first_data(frame, row, sensed, derived, dt_s);
    case CobKind::tpdo2:
      detail::take_second_data(frame, row, sensed, derived);
      return true;
    case CobKind::emergency:
      return true;  // recorded with the bus; what it tells is also in the process data
    case CobKind::sdo_reply:
      return master.take_sdo_reply(row.node, frame);
    case CobKind::heartbeat: {
      const auto state = static_cast<NmtState>(frame.data[0]);
      if (state != NmtState::boot_up && state != NmtState::stopped && state != NmtState::operational && state != NmtState::pre_operational)
        return false;
      if (master.take_heartbeat(row.node, frame.data[0])) sensed.restart(row.node);
      return true;
    }
    default:
      return false;
  }
}

}  // namespace hoist::core
