// THE monitors: one row each. The fault's row in faults.def says hazard, reaction and words; the file says threshold and why.
#pragma once
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "control/core/monitor/base_tilt_high.hpp"
#include "control/core/monitor/base_tilted.hpp"
#include "control/core/monitor/battery.hpp"
#include "control/core/monitor/battery_uneven.hpp"
#include "control/core/monitor/bumper.hpp"
#include "control/core/monitor/bus_down.hpp"
#include "control/core/monitor/console_lost.hpp"
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
#include "control/core/monitor/supply_high.hpp"
#include "control/core/monitor/tilt_frozen.hpp"
#include "control/core/monitor/tilt_implausible.hpp"
#include "control/core/monitor/tilt_sensor_fault.hpp"
#include "control/core/monitor/wheel_slip.hpp"

namespace hoist::core {

namespace detail {
/// A NodeLost for every row of kNodeRows.
template <std::size_t... kRows>
std::tuple<NodeLost<kNodeRows[kRows].node>...> silences(std::index_sequence<kRows...>);
using Silences = decltype(silences(std::make_index_sequence<kNodeRows.size()>{}));

using Others =
    std::tuple<BusDown, NodeDuplicate, NodeBabbling, DriveFault<true>, DriveFault<false>, TiltImplausible, TiltFrozen, TiltSensorFault,
               BumperPressed, FallDetected, BatteryBelow<contract::Fault::battery_empty, &contract::Params::battery_empty_v>,
               BatteryBelow<contract::Fault::battery_low, &contract::Params::battery_low_v>, BatteryUneven, SupplyHigh, BaseTilted,
               BaseTiltHigh, PatientHanging, RemoteCommandLost, ServerLost, ConsoleLost, Overspeed, LoopOverrun, EmergencyStopOpen,
               WheelSlip>;
}  // namespace detail
using MonitorList = decltype(std::tuple_cat(detail::Silences{}, detail::Others{}));

/// Runs every monitor; one bit per fault whose condition holds now.
[[nodiscard]] inline contract::FaultBits check_all(MonitorList& monitors, const MonitorView& view) noexcept {
  return std::apply(
      [&view](auto&... monitor) {
        return ((watches(std::remove_reference_t<decltype(monitor)>::kFault) && monitor.check(view)
                     ? contract::fault_bit(std::remove_reference_t<decltype(monitor)>::kFault)
                     : contract::FaultBits{0}) |
                ...);
      },
      monitors);
}

/// The faults that no monitor watches: they are raised where they happen (gate_refused by the gate, stop_pressed by the STOP command,
/// parameters_corrupt and control_fault by the supervisor's own watch).
inline constexpr contract::FaultBits kRaisedDirectly =
    contract::fault_bit(contract::Fault::gate_refused) | contract::fault_bit(contract::Fault::stop_pressed) |
    contract::fault_bit(contract::Fault::parameters_corrupt) | contract::fault_bit(contract::Fault::control_fault);

namespace detail {
template <typename... Monitor>
consteval contract::FaultBits watched(const std::tuple<Monitor...>*) {
  return (contract::fault_bit(Monitor::kFault) | ...);
}
consteval contract::FaultBits every_fault() {
  contract::FaultBits bits = 0;
  for (const contract::FaultInfo& fault : contract::kFaults) bits |= contract::fault_bit(fault);
  return bits;
}
}  // namespace detail
static_assert((detail::watched(static_cast<const MonitorList*>(nullptr)) | kRaisedDirectly) == detail::every_fault(),
              "a fault of faults.def has no monitor");

}  // namespace hoist::core
