// Everything the core remembers from one step to the next. Plain bytes: copying it copies the whole controller.
#pragma once
#include <array>
#include <cstdint>

#include "control/contract/faults.hpp"
#include "control/contract/params.hpp"
#include "control/core/base/derived.hpp"
#include "control/core/base/event_sink.hpp"
#include "control/core/base/lasting.hpp"
#include "control/core/calibrate/calibration.hpp"
#include "control/core/command/acknowledgement.hpp"
#include "control/core/command/console_watch.hpp"
#include "control/core/command/guided.hpp"
#include "control/core/command/lease.hpp"
#include "control/core/command/param_copies.hpp"
#include "control/core/command/remote_drive.hpp"
#include "control/core/command/server_watch.hpp"
#include "control/core/command/staging.hpp"
#include "control/core/estimate/estimate.hpp"
#include "control/core/estimate/sync_edges.hpp"
#include "control/core/health/bus_health.hpp"
#include "control/core/intent/intent.hpp"
#include "control/core/law/pfp.hpp"
#include "control/core/law/pfp_turn.hpp"
#include "control/core/monitor/monitor_list.hpp"
#include "control/core/output/alarm_signal.hpp"
#include "control/core/output/bus_master.hpp"
#include "control/core/output/drive_control.hpp"
#include "control/core/output/hold_watch.hpp"
#include "control/core/output/limiter.hpp"
#include "control/core/output/relay_feed.hpp"
#include "control/core/output/repeat_watch.hpp"
#include "control/core/output/runaway_watch.hpp"
#include "control/core/output/safety_gate.hpp"
#include "control/core/output/wheel_mixing.hpp"

namespace hoist::core {

/// INIT while nodes get new programs: frames of the engineer's tool pass, one a step, and the core itself asks no node anything.
struct Service {
  bool on = false;
  bool waiting = false;          // `frame` leaves in this step
  std::uint8_t quiet_ticks = 0;  // since the last word of the engineer's tool
  contract::CanFrame frame;
};

/// State of the present mode; cleared with every change of mode.
struct InMode {
  Braking braking = Braking::none;
  bool leaving = false;            // braking to a stop, then STANDBY
  bool powered = false;            // both drives have been enabled since the mode began
  bool remote_lost = false;        // REMOTE: commands stopped while hold-to-run was held
  contract::FaultBits causes = 0;  // PROTECTIVE_STOP: faults of the step in which it began
  Lasting silent;                  // PROTECTIVE_STOP: a node is silent; up to kGoneTicks
  std::uint32_t epoch = 0;         // lease with which the mode began
  std::uint64_t ticks = 0;         // steps since the mode began
  HoldWatch hold;                  // PROTECTIVE_STOP: whether it does hold
  Service service;                 // INIT only
  Calibration calibration;         // CALIBRATE only
};

/// Where the odometry's origin lies and what for. A start with the exercise of the mark goes on from where the hoist is; anything else sets
/// a new mark.
struct StartMark {
  std::uint32_t number = 0;    // counts up with every pose that is set
  std::uint32_t exercise = 0;  // key that the server gave the exercise, 0 = none: the next start sets a new mark
};

struct CoreState {
  CoreState() : CoreState(contract::Params{}) {}
  /// The parameters are taken as they are; load_params checks.
  explicit CoreState(const contract::Params& initial)
      : params(initial),
        live(initial),
        sent_to_nodes(initial),
        seal{initial, derive(initial), params_crc(initial)},
        derived(derive(initial)) {}

  contract::Params params;         // in force: what was last set, and what the limits are
  contract::Params live;           // the same, but for gains that are still on their way there
  contract::Params sent_to_nodes;  // what the master was told to write
  ParamSeal seal;
  bool slewing = false;
  bool defaults_after_damage = false;  // in force because both copies were damaged, until a parameter is set
  Trial trial;
  Derived derived;
  std::uint64_t parameter_version = 1;  // control/run begins each run at another one
  bool started = false;
  std::uint64_t tick = 0, time_ns = 0, ticks_run = 0;
  std::uint32_t sync_ticks = 1;  // between the newest SYNC and the one before it

  Estimate sensed;
  BusHealth health;
  PatientIntent intent;

  Lease lease;
  RemoteDrive remote;
  ServerWatch server;
  ConsoleWatch console;
  Staging staging;
  std::uint64_t next_sequence = 0;  // of the commands; 0 = whatever comes first
  Acknowledgement acknowledgement;

  contract::Mode mode = contract::Mode::init;
  InMode in_mode;
  Lasting still;  // commanded and measured standstill; up to kStillTicks
  Lasting clear;  // INIT: everything there; up to kClearTicks
  law::PfpState<double> lean;
  law::PfpTurnState<double> turn;
  GuidedRun guided;
  StartMark start;

  MonitorList monitors;
  contract::FaultBits conditions = 0;                               // what holds now
  contract::FaultBits latched = 0;                                  // what is in force: protective faults stay until acknowledged
  std::uint8_t stop_cause = 0;                                      // fault that came first of the latest stop, plus one
  std::array<std::uint16_t, contract::kFaultPlaces> fault_codes{};  // by bit: what a fault in force is about (HOIST_DETAIL)
  RepeatWatch repeats;
  bool stops_changed = false;  // what `repeats` counts, or whether the hoist is out of service for it
  std::uint8_t bus_settle_ticks = 0;
  std::uint8_t remote_lost_ticks = 0;  // how long the lost driver is still shown
  std::uint32_t nodes_heard = 0;       // bit per node: answering
  SyncEdges sync_edges;

  Limiter limiter;
  DriveControl left_control, right_control;
  SafetyGate gate;
  BusMaster master;
  RelayFeed relay;
  AlarmSignal alarm;
  RunawayWatch runaway;
  double left_command_m_s = 0, right_command_m_s = 0;  // as sent

  EventSink events;
  bool params_changed = false;
  std::uint32_t bus_frames = 0, bus_refused = 0, commands_refused = 0, overruns = 0, missed_ticks = 0;
};

}  // namespace hoist::core
