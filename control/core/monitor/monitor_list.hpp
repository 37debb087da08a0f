// THE monitors: one row each. The fault's row in faults.def says hazard, reaction and words; the file says threshold and why.
#pragma once
#include <cstdint>
#include <tuple>

#include "control/core/monitor/base_tilt_high.hpp"
#include "control/core/monitor/base_tilted.hpp"
#include "control/core/monitor/battery.hpp"
#include "control/core/monitor/battery_uneven.hpp"
#include "control/core/monitor/bumper.hpp"
#include "control/core/monitor/bus_down.hpp"
#include "control/core/monitor/drive_fault.hpp"
#include "control/core/monitor/emergency_stop.hpp"
#include "control/core/monitor/fall.hpp"
#include "control/core/monitor/loop_overrun.hpp"
#include "control/core/monitor/monitor.hpp"
#include "control/core/monitor/node_babbling.hpp"
#include "control/core/monitor/node_duplicate.hpp"
#include "control/core/monitor/node_lost.hpp"
#include "control/core/monitor/overspeed.hpp"
#include "control/core/monitor/patient_hanging.hpp"
#include "control/core/monitor/remote_lost.hpp"
#include "control/core/monitor/server_lost.hpp"
#include "control/core/monitor/tilt_frozen.hpp"
#include "control/core/monitor/tilt_implausible.hpp"
#include "control/core/monitor/tilt_sensor_fault.hpp"
#include "control/core/monitor/wheel_slip.hpp"

namespace hoist::core {

using MonitorList =
    std::tuple<NodeLost<contract::Node::tilt_left, contract::Fault::tilt_left_lost>,
               NodeLost<contract::Node::tilt_right, contract::Fault::tilt_right_lost>,
               NodeLost<contract::Node::tilt_base, contract::Fault::tilt_base_lost>,
               NodeLost<contract::Node::drive_left, contract::Fault::drive_left_lost>,
               NodeLost<contract::Node::drive_right, contract::Fault::drive_right_lost>,
               NodeLost<contract::Node::io, contract::Fault::io_lost>, BusDown, NodeDuplicate, NodeBabbling, DriveFault<true>,
               DriveFault<false>, TiltImplausible, TiltFrozen, TiltSensorFault, BumperPressed, FallDetected,
               BatteryBelow<contract::Fault::battery_empty, &contract::Params::battery_empty_v>,
               BatteryBelow<contract::Fault::battery_low, &contract::Params::battery_low_v>, BatteryUneven, BaseTilted, BaseTiltHigh,
               PatientHanging, RemoteCommandLost, ServerLost, Overspeed, LoopOverrun, EmergencyStopOpen, WheelSlip>;

/// Runs every monitor; one bit per fault whose condition holds now.
[[nodiscard]] inline std::uint32_t check_all(MonitorList& monitors, const MonitorView& view) noexcept {
  return std::apply(
      [&view](auto&... monitor) {
        return ((watches(std::remove_reference_t<decltype(monitor)>::kFault) && monitor.check(view)
                     ? contract::fault_bit(std::remove_reference_t<decltype(monitor)>::kFault)
                     : 0U) |
                ...);
      },
      monitors);
}

/// The faults that no monitor watches: they are raised where they happen (gate_refused by the gate, stop_pressed by the STOP command,
/// parameters_corrupt and control_fault by the supervisor's own watch).
inline constexpr std::uint32_t kRaisedDirectly =
    contract::fault_bit(contract::Fault::gate_refused) | contract::fault_bit(contract::Fault::stop_pressed) |
    contract::fault_bit(contract::Fault::parameters_corrupt) | contract::fault_bit(contract::Fault::control_fault);

namespace detail {
template <typename... Monitor>
consteval std::uint32_t watched(const std::tuple<Monitor...>*) {
  return (contract::fault_bit(Monitor::kFault) | ...);
}
consteval std::uint32_t every_fault() {
  std::uint32_t bits = 0;
  for (const contract::FaultInfo& fault : contract::kFaults) bits |= 1U << fault.bit;
  return bits;
}
}  // namespace detail
static_assert((detail::watched(static_cast<const MonitorList*>(nullptr)) | kRaisedDirectly) == detail::every_fault(),
              "a fault of faults.def has no monitor");

}  // namespace hoist::core
