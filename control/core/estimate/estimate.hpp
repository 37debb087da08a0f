// All that is sensed, in one place, and which node fills what.
#pragma once
#include <array>
#include <cstddef>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/faults.hpp"
#include "control/core/base/derived.hpp"
#include "control/core/estimate/drive_sensor.hpp"
#include "control/core/estimate/freshness.hpp"
#include "control/core/estimate/fused_odometry.hpp"
#include "control/core/estimate/io_sensor.hpp"
#include "control/core/estimate/odometry.hpp"
#include "control/core/estimate/tilt_sensor.hpp"
#include "control/core/law/pelvis.hpp"

namespace hoist::core {

struct Estimate {
  TiltSensor left_strut, right_strut, base;
  DriveSensor left_drive, right_drive;
  IoSensor io;
  Odometry odometry;
  FusedOdometry fused;

  /// Where the hoist is: the fused track, which slip does not lead astray. The encoders' own is odometry.pose.
  [[nodiscard]] const law::Pose<double>& pose() const noexcept { return fused.pose(); }
  /// Encoders and gyroscope disagree about the turn (H10): the distance is unreliable now.
  [[nodiscard]] bool slipping() const noexcept { return fused.slipping(); }

  /// `ticks`: time since the SYNC before the one that this step's frames answer.
  void next_tick(std::uint32_t ticks = 1) noexcept {
    left_strut.next_tick();
    right_strut.next_tick();
    base.next_tick();
    left_drive.next_tick(ticks);
    right_drive.next_tick(ticks);
    io.next_tick();
  }

  /// The struts against the chassis: a push of the chassis tilts all three alike and cancels here (D4).
  [[nodiscard]] law::StrutAngles<double> relative() const noexcept {
    return {left_strut.alpha_rad() - base.alpha_rad(), right_strut.alpha_rad() - base.alpha_rad(), left_strut.beta_rad() - base.beta_rad(),
            right_strut.beta_rad() - base.beta_rad()};
  }

  [[nodiscard]] bool tilts_stale() const noexcept {
    return left_strut.fresh().stale() || right_strut.fresh().stale() || base.fresh().stale();
  }
  [[nodiscard]] bool tilts_lost() const noexcept { return left_strut.fresh().lost() || right_strut.fresh().lost() || base.fresh().lost(); }
  [[nodiscard]] bool drives_lost() const noexcept { return left_drive.fresh().lost() || right_drive.fresh().lost(); }

  /// The age of the node's periodic data, valid or not: whether the node lives. The core itself counts as never heard.
  [[nodiscard]] const Freshness& heard(contract::Node node) const noexcept;
  /// The node reported a restart.
  void restart(contract::Node node) noexcept;
};

/// What the core keeps of a node. Of `tilt`, `drive` and `io` one is set: the sensor that the node's kind fills.
struct NodeRow {
  contract::Node node;
  contract::Fault lost;  // what its silence is (monitor/node_lost.hpp)
  TiltSensor Estimate::*tilt = nullptr;
  TiltZero Derived::*zero = nullptr;          // of a tilt sensor: taken off its angles
  double Derived::*yaw_bias_rad_s = nullptr;  // of the tilt sensor whose rates are used: its turn rate at rest
  DriveSensor Estimate::*drive = nullptr;
  double Derived::*counts_per_s_max = nullptr;  // of a drive: a position that moves faster has jumped
  IoSensor Estimate::*io = nullptr;
};

/// THE nodes of the core: one row each, in the order of can_dictionary.def.
inline constexpr std::array kNodeRows{
    NodeRow{.node = contract::Node::drive_left,
            .lost = contract::Fault::drive_left_lost,
            .drive = &Estimate::left_drive,
            .counts_per_s_max = &Derived::left_counts_per_s_max},
    NodeRow{.node = contract::Node::drive_right,
            .lost = contract::Fault::drive_right_lost,
            .drive = &Estimate::right_drive,
            .counts_per_s_max = &Derived::right_counts_per_s_max},
    NodeRow{.node = contract::Node::io, .lost = contract::Fault::io_lost, .io = &Estimate::io},
    NodeRow{.node = contract::Node::tilt_left,
            .lost = contract::Fault::tilt_left_lost,
            .tilt = &Estimate::left_strut,
            .zero = &Derived::left_zero},
    NodeRow{.node = contract::Node::tilt_right,
            .lost = contract::Fault::tilt_right_lost,
            .tilt = &Estimate::right_strut,
            .zero = &Derived::right_zero},
    NodeRow{.node = contract::Node::tilt_base,
            .lost = contract::Fault::tilt_base_lost,
            .tilt = &Estimate::base,
            .zero = &Derived::base_zero,
            .yaw_bias_rad_s = &Derived::base_yaw_bias_rad_s},
};

/// Every node of the dictionary has its row, with the sensor of its kind and what belongs to it, and no two share anything.
template <std::size_t N>
[[nodiscard]] consteval bool rows_are_sound(const std::array<NodeRow, N>& rows) {
  if (N != contract::kRemoteNodeCount) return false;
  for (std::size_t i = 0; i < N; ++i) {
    const NodeRow& row = rows[i];
    if (row.node != static_cast<contract::Node>(i)) return false;
    const contract::NodeKind kind = contract::kNodes[i].kind;
    if ((row.tilt != nullptr) != (kind == contract::NodeKind::tilt) || (row.zero != nullptr) != (row.tilt != nullptr)) return false;
    if ((row.drive != nullptr) != (kind == contract::NodeKind::drive) || (row.counts_per_s_max != nullptr) != (row.drive != nullptr))
      return false;
    if ((row.io != nullptr) != (kind == contract::NodeKind::io)) return false;
    if (row.yaw_bias_rad_s != nullptr && row.tilt == nullptr) return false;
    for (std::size_t k = 0; k < i; ++k) {
      const NodeRow& other = rows[k];
      if (row.lost == other.lost || (row.tilt != nullptr && (row.tilt == other.tilt || row.zero == other.zero)) ||
          (row.drive != nullptr && row.drive == other.drive) || (row.io != nullptr && row.io == other.io))
        return false;
    }
  }
  return true;
}
static_assert(rows_are_sound(kNodeRows), "kNodeRows: a node of can_dictionary.def has no row of its own, or not the sensor of its kind");

inline const Freshness& Estimate::heard(contract::Node node) const noexcept {
  static constexpr Freshness kNever;
  const auto index = static_cast<std::size_t>(node);
  if (index >= kNodeRows.size()) return kNever;
  const NodeRow& row = kNodeRows[index];
  if (row.tilt != nullptr) return (this->*row.tilt).heard();
  return row.drive != nullptr ? (this->*row.drive).fresh() : (this->*row.io).fresh();
}

inline void Estimate::restart(contract::Node node) noexcept {
  const auto index = static_cast<std::size_t>(node);
  if (index >= kNodeRows.size()) return;
  const NodeRow& row = kNodeRows[index];
  if (row.tilt != nullptr) (this->*row.tilt).restart();
  if (row.drive != nullptr) (this->*row.drive).restart();
  if (row.io != nullptr) (this->*row.io).restart();
}

}  // namespace hoist::core
