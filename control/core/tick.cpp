#include "control/core/tick.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "control/contract/can_dictionary.hpp"
#include "control/core/events.hpp"
#include "control/core/modes/mode_list.hpp"
#include "control/core/output/bumper_room.hpp"
#include "control/core/output/sync_pulses.hpp"
#include "control/core/receive.hpp"
#include "control/core/record.hpp"
#include "control/core/serve/commands.hpp"
#include "control/core/serve/param_keeper.hpp"
#include "control/core/standstill.hpp"
#include "control/core/supervise/release.hpp"
#include "control/core/supervise/supervisor.hpp"

namespace hoist::core {

using contract::CanFrame;
using contract::Event;
using contract::EventKind;
using contract::Fault;
using contract::Node;
using contract::Pdo;

namespace {

/// After the bus came back, nodes get this long to be heard again before their silence is their own fault.
constexpr std::uint8_t kBusSettleTicks = 50;
/// Ten minutes: enough for every limit, and sums of it do not wrap.
constexpr std::uint64_t kSyncTicksMost = 60'000;

void tell_emergency(CoreState& state, const CanFrame& frame, const contract::FrameClass& what) noexcept {
  Event event;
  event.kind = EventKind::emergency;
  event.item = what.node;
  event.code = contract::read_le(&frame.data[0], 2);
  event.bits = frame.data[2];
  // Forty bits, which a double holds exactly.
  event.value = static_cast<double>(contract::read_le(&frame.data[3], 4)) + static_cast<double>(frame.data[7]) * 4294967296.0;
  emit(state, event);
}

void receive_frames(CoreState& state, const TickInputs& inputs, double dt_s) noexcept {
  state.sensed.next_tick(state.sync_ticks);
  state.master.next_tick();
  state.health.next_tick(inputs.time_ns, inputs.bus_up);
  for (const CanFrame& frame : inputs.frames) {
    ++state.bus_frames;
    const contract::FrameClass what = contract::classify(frame);
    if (state.health.take(frame, what)) tell_emergency(state, frame, what);
    if (!receive(frame, what, state.sensed, state.master, state.derived, dt_s)) ++state.bus_refused;
  }
  if (const IoSensor& io = state.sensed.io; io.fresh().now() && state.sync_edges.changes(io.sync_input())) {
    Event event;
    event.kind = EventKind::sync_input;
    event.code = io.sync_input() ? 1 : 0;
    emit(state, event);
  }
  if (!inputs.bus_up) {
    state.bus_settle_ticks = kBusSettleTicks;
  } else if (state.bus_settle_ticks > 0) {
    --state.bus_settle_ticks;
  }
  std::uint32_t heard = 0;
  for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n) heard |= state.sensed.heard(static_cast<Node>(n)).lost() ? 0U : 1U << n;
  if (heard == state.nodes_heard) return;
  for (std::size_t n = 0; n < contract::kRemoteNodeCount; ++n) {
    if ((((heard ^ state.nodes_heard) >> n) & 1U) == 0) continue;
    Event event;
    event.kind = EventKind::node_changed;
    event.item = static_cast<std::uint32_t>(n);
    event.code = (heard >> n) & 1U;
    emit(state, event);
  }
  state.nodes_heard = heard;
}

void watch(CoreState& state, const TickInputs& inputs, double dt_s) noexcept {
  if (!(inputs.wake_lateness_s <= kLate_s)) ++state.overruns;
  if (state.in_mode.remote_lost) {
    state.remote_lost_ticks = kRemoteLostShownTicks;
  } else if (state.remote_lost_ticks > 0) {
    --state.remote_lost_ticks;
  }
  state.acknowledgement.next_tick(state.sensed.io.bumpers());
  state.console.step(is_moving(state.mode));
  const MonitorView view{.sensed = state.sensed,
                         .health = state.health,
                         .params = state.params,
                         .mode = state.mode,
                         .moving = is_moving(state.mode),
                         .powered = state.in_mode.powered,
                         .latched = state.latched,
                         .left_command_m_s = state.left_command_m_s,
                         .right_command_m_s = state.right_command_m_s,
                         .left_control = state.left_control,
                         .right_control = state.right_control,
                         .bus_up = inputs.bus_up,
                         .bus_settled = state.bus_settle_ticks == 0,
                         .server_alive = state.server.alive(),
                         .server_seen = state.server.seen(),
                         .console_gone = state.console.gone(),
                         .remote_lost = state.remote_lost_ticks > 0,
                         .held_back = state.mode == contract::Mode::guided && state.guided.held_back(),
                         .relay_cut = state.relay.is_cut(),
                         .bumpers_acknowledged = state.acknowledgement.bumpers(),
                         .wake_lateness_s = inputs.wake_lateness_s,
                         .ticks = state.ticks_run,
                         .dt_s = dt_s};
  judge_faults(state, check_all(state.monitors, view));
}

/// H1: the wheels turn in spite of a stop. Cuts the motors' supply; the hoist is out of service until an engineer has
/// looked.
void watch_runaway(CoreState& state, double dt_s) noexcept {
  const bool runs_away = state.runaway.step(state.mode, is_moving(state.mode), state.sensed, state.left_command_m_s,
                                            state.right_command_m_s, state.params.track_width_m, dt_s);
  if (!runs_away || state.relay.is_cut() || !watches(Fault::overspeed)) return;
  state.relay.cut();
  raise_fault(state, Fault::overspeed);
  raise_fault(state, Fault::control_fault);
  state.stops_changed = true;  // kept before a hand at the main switch could end it
}

void take_requests(CoreState& state, const TickInputs& inputs) noexcept {
  watch_server(state, inputs.server_heartbeat, inputs.server_life);
  take_commands(state, inputs.commands);
  if (inputs.drive_fresh) take_drive_command(state, inputs.drive);
  serve_release(state);
}

GateView gate_view(const CoreState& state) noexcept {
  const auto unfit = [](const DriveSensor& drive) {
    using State = contract::canopen::drive::State;
    return drive.fresh().lost() || drive.state() == State::fault || drive.state() == State::fault_reaction;
  };
  const Estimate& sensed = state.sensed;
  return {state.mode,
          sensed.tilts_lost(),
          unfit(sensed.left_drive) || unfit(sensed.right_drive),
          state.remote.held() && state.remote.age_s(state.time_ns) < state.params.remote_stop_age_s,
          state.in_mode.service.on,
          sensed.io.bumpers()};
}

/// The mode's wish, through the limiter.
Wish decide(CoreState& state, double dt_s) noexcept {
  InMode& in_mode = state.in_mode;
  ++in_mode.ticks;
  // The status of a drive that was just released may be older than the release: it counts only while the drive is
  // commanded to run.
  if (state.sensed.left_drive.enabled() && state.sensed.right_drive.enabled() && state.left_control.goes_on() &&
      state.right_control.goes_on() && mode_row_of(state.mode).drives)
    in_mode.powered = true;
  Wish wish = mode_row_of(state.mode).step(state, dt_s);
  if (wish.done) finish_mode(state);
  const std::uint8_t bumpers = state.sensed.io.bumpers();
  if (bumpers != 0 && wish.braking == Braking::none) {
    const BumperRoom room(bumpers);
    wish.speed.within(room.backward_m_s, room.forward_m_s, contract::SpeedCause::bumper);
    wish.yaw_rate_rad_s = 0;
  }
  if (mode_row_of(state.mode).drives) {
    LimitedSpeed speed = wish.speed;
    // H9: the monitor only warns; this is what keeps the hoist slow on a slope.
    if ((state.latched & contract::fault_bit(Fault::base_tilt_high)) != 0)
      speed.within(state.params.base_tilt_speed_m_s_max, contract::SpeedCause::slope);
    state.limiter.step(state.params, wish.braking, speed, wish.yaw_rate_rad_s, gate_view(state).blind(), dt_s);
  } else {
    state.limiter.reset();
  }
  state.still.step(at_rest(state), kStillTicks);
  serve_breakdown(state);
  return wish;
}

/// The pause of the alarm's sound has ended by itself.
void tell_pause_end(CoreState& state) noexcept {
  Event event;
  event.kind = EventKind::alarm_paused;
  emit(state, event);
}

CanFrame drive_frame(Node node, std::uint16_t control, std::int32_t target) noexcept {
  CanFrame frame{contract::pdo_cob_id(Pdo::drive_rx1, node), static_cast<std::uint8_t>(contract::pdo_bytes(Pdo::drive_rx1)), 0, {}};
  contract::write_slot(frame, contract::pdo_slot(Pdo::drive_rx1, 0x6040), control);
  // A target means something only to a drive that runs; the others are told zero.
  contract::write_slot(frame, contract::pdo_slot(Pdo::drive_rx1, 0x60FF), control == contract::canopen::drive::kEnable ? target : 0);
  return frame;
}

double commanded_m_s(const CanFrame& frame, double motor_per_m) noexcept {
  return wheel_m_s(static_cast<std::int32_t>(contract::read_slot(frame, contract::pdo_slot(Pdo::drive_rx1, 0x60FF))), motor_per_m);
}

/// Both drives were lost during a stop, and one answers again: meanwhile they have braked by themselves, or rolled out. The ramp continues
/// from the measured wheel speeds; continued from its own last value it could start a hoist that already stands. A drive that is still silent
/// is assumed to turn like the other one.
void rejoin(CoreState& state) noexcept {
  const Estimate& sensed = state.sensed;
  const bool left_lost = sensed.left_drive.fresh().lost(), right_lost = sensed.right_drive.fresh().lost();
  const double left_m_s = left_lost ? sensed.odometry.wheel_right_m_s : sensed.odometry.wheel_left_m_s;
  const double right_m_s = right_lost ? sensed.odometry.wheel_left_m_s : sensed.odometry.wheel_right_m_s;
  const auto less = [](double ramp, double measured) {
    if (!(ramp * measured > 0)) return 0.0;
    return std::fabs(measured) < std::fabs(ramp) ? measured : ramp;
  };
  state.limiter.start_from(state.params, less(state.limiter.speed_m_s(), (left_m_s + right_m_s) / 2.0),
                           less(state.limiter.yaw_rate_rad_s(), (right_m_s - left_m_s) / state.params.track_width_m));
}

void send_frames(CoreState& state, const TickInputs& inputs, double dt_s, TickOutputs& out) noexcept {
  if (state.mode == contract::Mode::protective_stop &&
      state.in_mode.hold.step(state.limiter, state.sensed, (state.latched & fault_bit(Fault::tilt_sensor_fault)) == 0))
    raise_fault(state, Fault::overspeed);  // H1, H2: the wheels do not follow their command
  const bool cut = state.in_mode.hold.cut() || state.relay.is_cut();
  const Running wanted = !mode_row_of(state.mode).drives                     ? Running::off
                         : is_moving(state.mode) && !state.limiter.at_rest() ? Running::go_on
                                                                             : Running::begin;
  const std::uint16_t left_control = state.left_control.step(state.sensed.left_drive, wanted, cut);
  const std::uint16_t right_control = state.right_control.step(state.sensed.right_drive, wanted, cut);
  const bool joins = state.left_control.begins() || state.right_control.begins();
  if (state.mode == contract::Mode::protective_stop && joins && !state.left_control.goes_on() && !state.right_control.goes_on())
    rejoin(state);
  const WheelCommand wheels = mix_wheels(state.limiter.speed_m_s(), state.limiter.yaw_rate_rad_s(), state.derived);
  static_cast<void>(out.frames.push_back(drive_frame(Node::drive_left, left_control, wheels.left_raw)));
  static_cast<void>(out.frames.push_back(drive_frame(Node::drive_right, right_control, wheels.right_raw)));
  Service& service = state.in_mode.service;
  state.master.step(inputs.tick, state.sensed, state.live, service.on, out.frames);
  if (service.on && service.waiting) static_cast<void>(out.frames.push_back(service.frame));
  service.waiting = false;
  if (state.alarm.step(state.latched)) tell_pause_end(state);
  // H1: no supply before the drives can be watched.
  const bool feeds = state.mode != contract::Mode::init || !state.sensed.drives_lost();
  state.relay.step(out.frames, {.feeds = feeds, .sync = sync_pulse(inputs.tick), .alarm = state.alarm.command()});
  static_cast<void>(out.frames.push_back(contract::canopen::sync()));

  const GateView view = gate_view(state);
  // The first two are the drives' commands; of the others each one that may not simply does not leave.
  bool refused = !state.gate.judge_drives(out.frames[0], out.frames[1], view, state.params, state.derived, dt_s);
  if (refused) {
    const SafetyGate::Motion left_over = state.gate.brake(out.frames[0], out.frames[1], view, state.params, state.derived, dt_s);
    // The protective stop goes on from what the drives are told now.
    state.limiter.start_from(state.params, left_over.speed_m_s, left_over.yaw_rate_rad_s);
  }
  std::size_t kept = 2;
  for (std::size_t i = 2; i < out.frames.size(); ++i) {
    if (SafetyGate::judge(out.frames[i], view)) {
      out.frames[kept++] = out.frames[i];
    } else {
      refused = true;
    }
  }
  while (out.frames.size() > kept) out.frames.pop_back();
  if (refused) raise_fault(state, Fault::gate_refused);
  for (const CanFrame& frame : out.frames) state.health.sent(frame);
  state.left_command_m_s = commanded_m_s(out.frames[0], state.derived.left_motor_per_m);
  state.right_command_m_s = commanded_m_s(out.frames[1], state.derived.right_motor_per_m);
}

}  // namespace

void tick(CoreState& state, const TickInputs& inputs, double dt_s, TickOutputs& out) noexcept {
  out.frames.clear();
  out.events.clear();
  state.events.begin(out.events);
  // Also the few bytes behind the last value: equal steps are equal byte for byte, in memory and in a replay.
  std::memset(static_cast<void*>(&out.record), 0, sizeof out.record);
  const std::uint64_t missed = state.started && inputs.tick > state.tick + 1 ? inputs.tick - state.tick - 1 : 0;
  state.missed_ticks += static_cast<std::uint32_t>(missed);
  state.tick = inputs.tick;
  state.time_ns = inputs.time_ns;
  if (!state.started) {
    state.started = true;
    Event event;
    event.kind = EventKind::core_started;
    emit(state, event);
  }
  ++state.ticks_run;
  // Before anything uses a parameter: a damaged one decides nothing.
  serve_params(state, dt_s);
  receive_frames(state, inputs, dt_s);
  // The nodes answer this step's SYNC in the next one.
  state.sync_ticks = static_cast<std::uint32_t>(std::min(missed + 1, kSyncTicksMost));
  // A drive that restarted has not counted what its wheel did meanwhile: the pose no longer refers to the start mark.
  if (!state.sensed.left_drive.position_known() || !state.sensed.right_drive.position_known()) state.start.exercise = 0;
  state.sensed.odometry.update(state.sensed.left_drive, state.sensed.right_drive, state.derived, dt_s);
  state.sensed.fused.update(state.sensed.odometry, state.sensed.left_drive, state.sensed.right_drive, state.sensed.base, state.derived,
                            dt_s);
  state.intent.update(state.sensed, state.derived, state.params.neutral_start_tolerance_norm, state.params.cadence_cancel_norm, dt_s);
  // H22, I6: after a delayed loop all remembered data are old, and so is a start that was requested meanwhile.
  if (!(static_cast<double>(inputs.wake_lateness_s) <= state.params.loop_late_s_max) ||
      static_cast<double>(missed) * dt_s > state.params.loop_late_s_max)
    state.intent.restart();
  watch(state, inputs, dt_s);
  watch_runaway(state, dt_s);
  take_requests(state, inputs);
  const Wish wish = decide(state, dt_s);
  send_frames(state, inputs, dt_s, out);
  fill_record(state, inputs, wish, out.record);
  state.events.end();
  out.params_changed = state.params_changed;
  state.params_changed = false;
  out.stops_changed = state.stops_changed;
  state.stops_changed = false;
}

bool load_params(CoreState& state, const contract::Params& params) noexcept {
  if (state.started || contract::check_param_set(params) != nullptr) return false;
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    if (contract::check_param(i, contract::get_param(params, i)) != contract::ParamCheck::ok) return false;
  install_params(state, params);
  return true;
}

}  // namespace hoist::core
