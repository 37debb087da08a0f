// All that is sensed, in one place.
#pragma once
#include "control/contract/can_dictionary.hpp"
#include "control/core/estimate/drive_sensor.hpp"
#include "control/core/estimate/freshness.hpp"
#include "control/core/estimate/fused_odometry.hpp"
#include "control/core/estimate/io_sensor.hpp"
#include "control/core/estimate/odometry.hpp"
#include "control/core/estimate/tilt_sensor.hpp"
#include "control/core/intent/pelvis.hpp"

namespace hoist::core {

struct Estimate {
  TiltSensor left_strut, right_strut, base;
  DriveSensor left_drive, right_drive;
  IoSensor io;
  Odometry odometry;
  FusedOdometry fused;

  /// Where the hoist is: the fused track, which slip does not lead astray. The encoders' own is odometry.pose.
  [[nodiscard]] const law::Pose<double>& pose() const noexcept { return fused.pose(); }
  /// Encoders and gyroscope disagree about the turn (H10): the distance of this moment is not to be trusted.
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
  [[nodiscard]] StrutAngles<double> relative() const noexcept {
    return {left_strut.alpha_rad() - base.alpha_rad(), right_strut.alpha_rad() - base.alpha_rad(), left_strut.beta_rad() - base.beta_rad(),
            right_strut.beta_rad() - base.beta_rad()};
  }

  [[nodiscard]] bool tilts_stale() const noexcept {
    return left_strut.fresh().stale() || right_strut.fresh().stale() || base.fresh().stale();
  }
  [[nodiscard]] bool tilts_lost() const noexcept { return left_strut.fresh().lost() || right_strut.fresh().lost() || base.fresh().lost(); }
  [[nodiscard]] bool drives_lost() const noexcept { return left_drive.fresh().lost() || right_drive.fresh().lost(); }

  /// The age of the node's periodic data, whatever they say: whether it lives at all.
  [[nodiscard]] const Freshness& heard(contract::Node node) const noexcept {
    using contract::Node;
    switch (node) {
      case Node::drive_left:
        return left_drive.fresh();
      case Node::drive_right:
        return right_drive.fresh();
      case Node::tilt_left:
        return left_strut.heard();
      case Node::tilt_right:
        return right_strut.heard();
      case Node::tilt_base:
        return base.heard();
      case Node::io:
      case Node::core:
        break;
    }
    return io.fresh();
  }

  void restart(contract::Node node) noexcept {
    using contract::Node;
    switch (node) {
      case Node::drive_left:
        left_drive.restart();
        break;
      case Node::drive_right:
        right_drive.restart();
        break;
      case Node::tilt_left:
        left_strut.restart();
        break;
      case Node::tilt_right:
        right_strut.restart();
        break;
      case Node::tilt_base:
        base.restart();
        break;
      case Node::io:
        io.restart();
        break;
      case Node::core:
        break;
    }
  }
};

}  // namespace hoist::core
