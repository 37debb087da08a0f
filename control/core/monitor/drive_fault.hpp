// H2: a drive reports a fault, or does not run although it is told to.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

template <bool kLeft>
struct DriveFault {
  static constexpr contract::Fault kFault = kLeft ? contract::Fault::drive_left_fault : contract::Fault::drive_right_fault;

  bool check(const MonitorView& view) noexcept {
    using State = contract::canopen::drive::State;
    const DriveSensor& drive = kLeft ? view.sensed.left_drive : view.sensed.right_drive;
    if (view.mode == contract::Mode::init || drive.fresh().lost()) return false;
    return drive.state() == State::fault || drive.state() == State::fault_reaction || (kLeft ? view.left_refuses : view.right_refuses);
  }
};

}  // namespace hoist::core
