// H2, H11: a drive reports a fault, or does not run although it is told to.
//
// Its statusword says fault; dropped out for kDroppedTicksMax, or not enabled kEnableTicksMax after a start. R2 within 100 ms of the cause;
// the drive itself has stopped by then (R3), and the other one brakes matched to it (output/drive_control.hpp).
#pragma once
#include "control/core/base/mutation.hpp"
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

template <bool kLeft>
struct DriveFault {
  static constexpr contract::Fault kFault = kLeft ? contract::Fault::drive_left_fault : contract::Fault::drive_right_fault;

  bool check(const MonitorView& view) noexcept {
    using State = contract::canopen::drive::State;
    const DriveSensor& drive = kLeft ? view.sensed.left_drive : view.sensed.right_drive;
    const DriveControl& control = kLeft ? view.left_control : view.right_control;
    if (view.mode == contract::Mode::init || drive.fresh().lost()) return false;
    return drive.state() == State::fault || drive.state() == State::fault_reaction ||
           control.refuses_to_run(hold<kFault, "start">(kEnableTicksMax), hold<kFault, "dropped">(kDroppedTicksMax));
  }
};

}  // namespace hoist::core
