#include "control/core/record.hpp"

#include <cmath>

#include "control/core/modes/calibration_run.hpp"
#include "control/core/stop_distance.hpp"
#include "control/core/supervise/supervisor.hpp"

namespace hoist::core {

namespace {

std::uint16_t to_u16(std::uint32_t value) noexcept { return static_cast<std::uint16_t>(value < 0xFFFF ? value : 0xFFFF); }

void fill_health(const CoreState& state, const TickInputs& inputs, contract::TickRecord& record) noexcept {
  using contract::Node;
  const BusHealth& health = state.health;
  record.bus_load_norm = static_cast<float>(health.load().load_norm());
  record.bus_frames_per_s = to_u16(health.load().frames_per_s());
  record.bus_send_refused = inputs.bus.send_refused;
  record.bus_reopened = inputs.bus.reopened;
  record.bus_overflows = inputs.bus.overflows;
  record.bus_errors = inputs.bus.errors;
  record.bus_tx_errors = inputs.bus.tx_errors;
  record.bus_rx_errors = inputs.bus.rx_errors;
  record.bus_state = inputs.bus.state;
  record.bus_up = inputs.bus_up ? 1 : 0;
  record.syncs_lost = health.syncs_lost();
  record.babbling_id = health.babbling_id();
  record.duplicate_id = health.duplicate_id();
#define HOIST_FILL_NODE(name)                                            \
  record.name##_lost_frames = health.node(Node::name).lost_frames;       \
  record.name##_lost_10s = health.node(Node::name).lost_10s;             \
  record.name##_emcy_code = health.node(Node::name).emcy_code;           \
  record.name##_emcy_count = health.node(Node::name).emcy_count;         \
  record.name##_error_register = health.node(Node::name).error_register; \
  record.name##_nmt_state = state.master.nmt_state(Node::name);          \
  record.name##_heartbeats_missed = state.master.heartbeats_missed(Node::name);
  HOIST_FILL_NODE(drive_left)
  HOIST_FILL_NODE(drive_right)
  HOIST_FILL_NODE(io)
  HOIST_FILL_NODE(tilt_left)
  HOIST_FILL_NODE(tilt_right)
  HOIST_FILL_NODE(tilt_base)
#undef HOIST_FILL_NODE
}

float f32(double value) noexcept { return static_cast<float>(value); }
float finite(float value) noexcept { return std::isfinite(value) ? value : 0.0F; }

void fill_tilts(const Estimate& sensed, contract::TickRecord& record) noexcept {
  record.left_alpha_rad = f32(sensed.left_strut.alpha_rad());
  record.left_beta_rad = f32(sensed.left_strut.beta_rad());
  record.right_alpha_rad = f32(sensed.right_strut.alpha_rad());
  record.right_beta_rad = f32(sensed.right_strut.beta_rad());
  record.base_alpha_rad = f32(sensed.base.alpha_rad());
  record.base_beta_rad = f32(sensed.base.beta_rad());
  record.base_yaw_rate_rad_s = f32(sensed.base.yaw_rate_rad_s());
  record.base_pitch_rate_rad_s = f32(sensed.base.pitch_rate_rad_s());
  record.base_roll_rate_rad_s = f32(sensed.base.roll_rate_rad_s());
}

void fill_intent(const CoreState& state, const Wish& wish, contract::TickRecord& record) noexcept {
  record.dx_m = f32(state.intent.pelvis().dx_m);
  record.dy_m = f32(state.intent.pelvis().dy_m);
  record.dpsi_rad = f32(state.intent.pelvis().dpsi_rad);
  record.gait_lean_m = f32(state.intent.gait().lean_m);
  record.gait_turn_rad = f32(state.intent.gait().turn_rad);
  record.gait_sway_m = f32(state.intent.gait().sway_m);
  record.stride_hz = f32(state.intent.gait().stride_hz);
  record.lean_norm = f32(state.intent.lean_norm());
  record.turn_norm = f32(state.intent.turn_norm());
  record.lean_filtered_units = f32(state.lean.v_f_units);
  record.turn_filtered_units = f32(state.turn.omega_f_units);
  record.speed_wish_m_s = f32(wish.speed.m_s());
  record.yaw_rate_wish_rad_s = f32(wish.yaw_rate_rad_s);
}

void fill_commands(const CoreState& state, contract::TickRecord& record) noexcept {
  record.speed_command_m_s = f32((state.left_command_m_s + state.right_command_m_s) / 2.0);
  record.yaw_rate_command_rad_s = f32((state.right_command_m_s - state.left_command_m_s) / state.params.track_width_m);
  record.wheel_left_command_m_s = f32(state.left_command_m_s);
  record.wheel_right_command_m_s = f32(state.right_command_m_s);
  record.remote_age_s = f32(state.remote.age_s(state.time_ns));
  const StopDistance stop = stop_distance(state);
  record.stop_distance_m = f32(stop.link_m);
  record.worst_stop_distance_m = f32(stop.computer_m);
  record.speed_cause = static_cast<std::uint8_t>(state.limiter.cause());
}

void fill_guided(const GuidedRun& guided, contract::TickRecord& record) noexcept {
  record.guided_progress_norm = f32(guided.progress_norm());
  record.guided_cross_track_m = f32(guided.cross_m());
  record.guided_heading_error_rad = f32(guided.heading_error_rad());
  record.guided_remaining_m = f32(guided.left_m());
  record.guided_phase = static_cast<std::uint8_t>(guided.told_phase());
  record.guided_end = static_cast<std::uint8_t>(guided.ended());
}

void fill_motion(const Estimate& sensed, contract::TickRecord& record) noexcept {
  const Odometry& odometry = sensed.odometry;
  record.speed_m_s = f32(odometry.speed_m_s);
  record.yaw_rate_rad_s = f32(odometry.yaw_rate_rad_s);
  record.x_m = f32(odometry.pose.x_m);
  record.y_m = f32(odometry.pose.y_m);
  record.psi_rad = f32(odometry.pose.psi_rad);
  record.distance_m = f32(odometry.distance_m);
  const FusedOdometry& fused = sensed.fused;
  record.fused_x_m = f32(fused.pose().x_m);
  record.fused_y_m = f32(fused.pose().y_m);
  record.fused_psi_rad = f32(fused.pose().psi_rad);
  record.fused_yaw_rate_rad_s = f32(fused.yaw_rate_rad_s());
  record.gyro_bias_rad_s = f32(fused.gyro_bias_rad_s());
  record.slip_rate_rad_s = f32(fused.slip_rate_rad_s());
  record.slip_state = static_cast<std::uint8_t>((fused.slipping() ? 1U : 0U) | (fused.gyro_used() ? 0U : 2U));
  record.standing_still = odometry.standing_still ? 1 : 0;
  record.wheel_left_m_s = f32(odometry.wheel_left_m_s);
  record.wheel_right_m_s = f32(odometry.wheel_right_m_s);
  record.left_counts = sensed.left_drive.counts();
  record.right_counts = sensed.right_drive.counts();
  record.left_current_a = f32(sensed.left_drive.current_a());
  record.right_current_a = f32(sensed.right_drive.current_a());
  record.left_supply_v = f32(sensed.left_drive.supply_v());
  record.right_supply_v = f32(sensed.right_drive.supply_v());
  record.battery_a_v = f32(sensed.io.battery_a_v());
  record.battery_b_v = f32(sensed.io.battery_b_v());
}

void fill_loop(const CoreState& state, const TickInputs& inputs, contract::TickRecord& record) noexcept {
  record.wake_lateness_s = finite(inputs.wake_lateness_s);
  record.tick_duration_s = finite(inputs.previous_duration_s);
  record.overruns = state.overruns;
  record.lateness_p50_s = finite(inputs.loop.lateness_p50_s);
  record.lateness_p99_s = finite(inputs.loop.lateness_p99_s);
  record.lateness_max_s = finite(inputs.loop.lateness_max_s);
  record.missed_ticks = state.missed_ticks;
  record.page_faults = inputs.loop.page_faults;
  record.allocations = inputs.loop.allocations;
  record.loop_priority = inputs.loop.priority;
  record.loop_cpu = inputs.loop.cpu;
  record.memory_locked = inputs.loop.memory_locked ? 1 : 0;
}

void fill_state(const CoreState& state, const TickInputs& inputs, contract::TickRecord& record) noexcept {
  record.relay_feed = state.relay.level();
  record.sync_output = state.relay.sync_level();
  record.alarm_sound = static_cast<std::uint8_t>(state.alarm.command().sound);
  record.alarm_light = static_cast<std::uint8_t>(state.alarm.command().light);
  record.alarm_pause_s = f32(state.alarm.pause_s());
  record.bus_frames = state.bus_frames;
  record.bus_refused = inputs.bus.refused + state.bus_refused;
  record.commands_refused = state.commands_refused;
  record.fault_bits = state.latched;
  record.blocked_bits = start_refusals(state);
  record.lease_epoch = state.lease.epoch;
  record.lease_holder = state.lease.holder;
  record.start_mark = state.start.number;
  record.parameter_version = static_cast<std::uint32_t>(state.parameter_version);
  record.left_status_word = state.sensed.left_drive.status_word();
  record.right_status_word = state.sensed.right_drive.status_word();
  record.mode = static_cast<std::uint8_t>(state.mode);
  record.stop_cause = state.stop_cause;
  const auto code = [&state](contract::Fault fault) { return state.fault_codes[static_cast<std::size_t>(fault)]; };
  record.drive_left_fault_code = code(contract::Fault::drive_left_fault);
  record.drive_right_fault_code = code(contract::Fault::drive_right_fault);
  record.tilt_implausible_code = code(contract::Fault::tilt_implausible);
  record.overspeed_code = code(contract::Fault::overspeed);
  record.bumpers = state.sensed.io.bumpers();
  record.bumpers_acknowledged = state.acknowledgement.bumpers();
  record.switches = state.sensed.io.switches();
  record.settings_trial_s = f32(state.trial.left_s);
  record.server_alive = state.server.alive() ? 1 : 0;
  record.simulated = state.master.simulated() ? 1 : 0;
}

void fill_ages(const Estimate& sensed, contract::TickRecord& record) noexcept {
  record.tilt_left_age_ticks = sensed.left_strut.fresh().age_ticks();
  record.tilt_right_age_ticks = sensed.right_strut.fresh().age_ticks();
  record.tilt_base_age_ticks = sensed.base.fresh().age_ticks();
  record.drive_left_age_ticks = sensed.left_drive.fresh().age_ticks();
  record.drive_right_age_ticks = sensed.right_drive.fresh().age_ticks();
  record.io_age_ticks = sensed.io.fresh().age_ticks();
}

void fill_calibration(const Calibration& calibration, contract::TickRecord& record) noexcept {
  record.calibration_value = calibration.value;
  record.calibration_step = static_cast<std::uint8_t>(calibration.step);
  record.calibration_phase = static_cast<std::uint8_t>(calibration.phase);
  record.calibration_done_percent = calibration.done_percent;
  record.calibration_reason = static_cast<std::uint8_t>(calibration.reason);
}

}  // namespace

void fill_record(const CoreState& state, const TickInputs& inputs, const Wish& wish, contract::TickRecord& record) noexcept {
  record.tick = inputs.tick;
  record.time_ns = inputs.time_ns;
  fill_tilts(state.sensed, record);
  fill_intent(state, wish, record);
  fill_commands(state, record);
  fill_guided(state.guided, record);
  fill_motion(state.sensed, record);
  fill_loop(state, inputs, record);
  fill_state(state, inputs, record);
  fill_ages(state.sensed, record);
  fill_calibration(state.in_mode.calibration, record);
  fill_health(state, inputs, record);
}

}  // namespace hoist::core
