// What every monitor may look at. A monitor answers one question each step: does its fault's condition hold now?
//
// A monitor is a small class with `static constexpr contract::Fault kFault` (the hazard and the reaction stand in that fault's row of
// faults.def) and `bool check(const MonitorView&) noexcept`. It is called in every step and in every mode, so that its memory is right
// when it matters; it decides itself in which modes its condition means anything. Each number that decides goes through threshold() or
// hold() (mutation.hpp), so that a test can be shown to fail when that number is wrong.
#pragma once
#include <cstdint>

#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/core/base/mutation.hpp"
#include "control/core/estimate/estimate.hpp"
#include "control/core/health/bus_health.hpp"
#include "control/core/output/drive_control.hpp"

namespace hoist::core {

struct MonitorView {
  const Estimate& sensed;
  const BusHealth& health;
  const contract::Params& params;
  contract::Mode mode;
  bool moving;                                       // a mode in which the wheels may turn
  bool powered;                                      // both drives have been enabled since the mode began and are meant to follow
  contract::FaultBits latched;                       // faults in force before this step
  double left_command_m_s, right_command_m_s;        // what the drives were last told
  const DriveControl &left_control, &right_control;  // know a drive that does not run although it should
  bool bus_up, bus_settled;                          // settled: long enough up that silence is the node's own
  bool server_alive, server_seen;
  bool console_gone;  // while the hoist was led, and nobody has taken control since
  bool remote_lost;
  bool held_back;                     // GUIDED goes slower than wished, because the patient lags
  bool relay_cut;                     // the core itself has taken the motors' supply away
  std::uint8_t bumpers_acknowledged;  // still pressed and acknowledged: the therapist may drive away (H13)
  float wake_lateness_s;
  std::uint64_t ticks;  // steps since the start of the core
  double dt_s;

  [[nodiscard]] bool has(contract::Fault fault) const noexcept { return (latched & contract::fault_bit(fault)) != 0; }
};

}  // namespace hoist::core
