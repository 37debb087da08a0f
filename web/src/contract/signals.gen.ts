// Made by `deploy/dev gen` from control/contract/signals.def; do not edit.

export interface Words {
  en: string;
  de: string;
}

export type SignalName =
  | 'tick'
  | 'time_ns'
  | 'fault_bits'
  | 'left_alpha_rad'
  | 'left_beta_rad'
  | 'right_alpha_rad'
  | 'right_beta_rad'
  | 'base_alpha_rad'
  | 'base_beta_rad'
  | 'base_yaw_rate_rad_s'
  | 'base_pitch_rate_rad_s'
  | 'base_roll_rate_rad_s'
  | 'dx_m'
  | 'dy_m'
  | 'dpsi_rad'
  | 'lean_norm'
  | 'turn_norm'
  | 'lean_filtered_units'
  | 'turn_filtered_units'
  | 'speed_wish_m_s'
  | 'yaw_rate_wish_rad_s'
  | 'speed_command_m_s'
  | 'yaw_rate_command_rad_s'
  | 'wheel_left_command_m_s'
  | 'wheel_right_command_m_s'
  | 'remote_age_s'
  | 'stop_distance_m'
  | 'guided_progress_norm'
  | 'guided_cross_track_m'
  | 'guided_heading_error_rad'
  | 'guided_remaining_m'
  | 'speed_m_s'
  | 'yaw_rate_rad_s'
  | 'x_m'
  | 'y_m'
  | 'psi_rad'
  | 'distance_m'
  | 'wheel_left_m_s'
  | 'wheel_right_m_s'
  | 'left_counts'
  | 'right_counts'
  | 'fused_x_m'
  | 'fused_y_m'
  | 'fused_psi_rad'
  | 'fused_yaw_rate_rad_s'
  | 'gyro_bias_rad_s'
  | 'slip_rate_rad_s'
  | 'worst_stop_distance_m'
  | 'gait_lean_m'
  | 'gait_turn_rad'
  | 'gait_sway_m'
  | 'stride_hz'
  | 'left_current_a'
  | 'right_current_a'
  | 'left_supply_v'
  | 'right_supply_v'
  | 'battery_a_v'
  | 'battery_b_v'
  | 'settings_trial_s'
  | 'alarm_pause_s'
  | 'wake_lateness_s'
  | 'tick_duration_s'
  | 'overruns'
  | 'lateness_p50_s'
  | 'lateness_p99_s'
  | 'lateness_max_s'
  | 'missed_ticks'
  | 'page_faults'
  | 'allocations'
  | 'calibration_value'
  | 'bus_frames'
  | 'bus_refused'
  | 'commands_refused'
  | 'blocked_bits'
  | 'lease_epoch'
  | 'lease_holder'
  | 'start_mark'
  | 'parameter_version'
  | 'bus_load_norm'
  | 'bus_send_refused'
  | 'bus_reopened'
  | 'bus_overflows'
  | 'bus_errors'
  | 'syncs_lost'
  | 'drive_left_lost_frames'
  | 'drive_right_lost_frames'
  | 'io_lost_frames'
  | 'tilt_left_lost_frames'
  | 'tilt_right_lost_frames'
  | 'tilt_base_lost_frames'
  | 'left_status_word'
  | 'right_status_word'
  | 'bus_frames_per_s'
  | 'bus_tx_errors'
  | 'bus_rx_errors'
  | 'babbling_id'
  | 'drive_left_emcy_code'
  | 'drive_left_emcy_count'
  | 'drive_right_emcy_code'
  | 'drive_right_emcy_count'
  | 'io_emcy_code'
  | 'io_emcy_count'
  | 'tilt_left_emcy_code'
  | 'tilt_left_emcy_count'
  | 'tilt_right_emcy_code'
  | 'tilt_right_emcy_count'
  | 'tilt_base_emcy_code'
  | 'tilt_base_emcy_count'
  | 'drive_left_fault_code'
  | 'drive_right_fault_code'
  | 'tilt_implausible_code'
  | 'overspeed_code'
  | 'mode'
  | 'stop_cause'
  | 'bumpers'
  | 'simulated'
  | 'tilt_left_age_ticks'
  | 'tilt_right_age_ticks'
  | 'tilt_base_age_ticks'
  | 'drive_left_age_ticks'
  | 'drive_right_age_ticks'
  | 'io_age_ticks'
  | 'bumpers_acknowledged'
  | 'switches'
  | 'server_alive'
  | 'slip_state'
  | 'standing_still'
  | 'loop_priority'
  | 'loop_cpu'
  | 'memory_locked'
  | 'relay_feed'
  | 'sync_output'
  | 'alarm_sound'
  | 'alarm_light'
  | 'speed_cause'
  | 'guided_phase'
  | 'guided_end'
  | 'bus_state'
  | 'bus_up'
  | 'duplicate_id'
  | 'calibration_step'
  | 'calibration_phase'
  | 'calibration_done_percent'
  | 'calibration_reason'
  | 'drive_left_nmt_state'
  | 'drive_left_heartbeats_missed'
  | 'drive_left_error_register'
  | 'drive_left_lost_10s'
  | 'drive_right_nmt_state'
  | 'drive_right_heartbeats_missed'
  | 'drive_right_error_register'
  | 'drive_right_lost_10s'
  | 'io_nmt_state'
  | 'io_heartbeats_missed'
  | 'io_error_register'
  | 'io_lost_10s'
  | 'tilt_left_nmt_state'
  | 'tilt_left_heartbeats_missed'
  | 'tilt_left_error_register'
  | 'tilt_left_lost_10s'
  | 'tilt_right_nmt_state'
  | 'tilt_right_heartbeats_missed'
  | 'tilt_right_error_register'
  | 'tilt_right_lost_10s'
  | 'tilt_base_nmt_state'
  | 'tilt_base_heartbeats_missed'
  | 'tilt_base_error_register'
  | 'tilt_base_lost_10s';

export interface SignalInfo {
  id: number;
  name: SignalName;
  type: 'u64' | 'u32' | 'i32' | 'f32' | 'u16' | 'u8';
  unit: string;
  /** Value of one step of the stored integer in recordings. */
  lsb: number;
  /** Place of the value in a tick record, in bytes. */
  offset: number;
  title: Words;
}

/** Every live value of one control step. */
export type TickRecord = Record<SignalName, number>;

export const tickRecordBytes = 472;

/** Reads the record that begins at byte `at`. */
export function readTickRecord(view: DataView, at: number): TickRecord {
  return {
    tick: Number(view.getBigUint64(at + 0, true)),
    time_ns: Number(view.getBigUint64(at + 8, true)),
    fault_bits: Number(view.getBigUint64(at + 16, true)),
    left_alpha_rad: view.getFloat32(at + 24, true),
    left_beta_rad: view.getFloat32(at + 28, true),
    right_alpha_rad: view.getFloat32(at + 32, true),
    right_beta_rad: view.getFloat32(at + 36, true),
    base_alpha_rad: view.getFloat32(at + 40, true),
    base_beta_rad: view.getFloat32(at + 44, true),
    base_yaw_rate_rad_s: view.getFloat32(at + 48, true),
    base_pitch_rate_rad_s: view.getFloat32(at + 52, true),
    base_roll_rate_rad_s: view.getFloat32(at + 56, true),
    dx_m: view.getFloat32(at + 60, true),
    dy_m: view.getFloat32(at + 64, true),
    dpsi_rad: view.getFloat32(at + 68, true),
    lean_norm: view.getFloat32(at + 72, true),
    turn_norm: view.getFloat32(at + 76, true),
    lean_filtered_units: view.getFloat32(at + 80, true),
    turn_filtered_units: view.getFloat32(at + 84, true),
    speed_wish_m_s: view.getFloat32(at + 88, true),
    yaw_rate_wish_rad_s: view.getFloat32(at + 92, true),
    speed_command_m_s: view.getFloat32(at + 96, true),
    yaw_rate_command_rad_s: view.getFloat32(at + 100, true),
    wheel_left_command_m_s: view.getFloat32(at + 104, true),
    wheel_right_command_m_s: view.getFloat32(at + 108, true),
    remote_age_s: view.getFloat32(at + 112, true),
    stop_distance_m: view.getFloat32(at + 116, true),
    guided_progress_norm: view.getFloat32(at + 120, true),
    guided_cross_track_m: view.getFloat32(at + 124, true),
    guided_heading_error_rad: view.getFloat32(at + 128, true),
    guided_remaining_m: view.getFloat32(at + 132, true),
    speed_m_s: view.getFloat32(at + 136, true),
    yaw_rate_rad_s: view.getFloat32(at + 140, true),
    x_m: view.getFloat32(at + 144, true),
    y_m: view.getFloat32(at + 148, true),
    psi_rad: view.getFloat32(at + 152, true),
    distance_m: view.getFloat32(at + 156, true),
    wheel_left_m_s: view.getFloat32(at + 160, true),
    wheel_right_m_s: view.getFloat32(at + 164, true),
    left_counts: view.getInt32(at + 168, true),
    right_counts: view.getInt32(at + 172, true),
    fused_x_m: view.getFloat32(at + 176, true),
    fused_y_m: view.getFloat32(at + 180, true),
    fused_psi_rad: view.getFloat32(at + 184, true),
    fused_yaw_rate_rad_s: view.getFloat32(at + 188, true),
    gyro_bias_rad_s: view.getFloat32(at + 192, true),
    slip_rate_rad_s: view.getFloat32(at + 196, true),
    worst_stop_distance_m: view.getFloat32(at + 200, true),
    gait_lean_m: view.getFloat32(at + 204, true),
    gait_turn_rad: view.getFloat32(at + 208, true),
    gait_sway_m: view.getFloat32(at + 212, true),
    stride_hz: view.getFloat32(at + 216, true),
    left_current_a: view.getFloat32(at + 220, true),
    right_current_a: view.getFloat32(at + 224, true),
    left_supply_v: view.getFloat32(at + 228, true),
    right_supply_v: view.getFloat32(at + 232, true),
    battery_a_v: view.getFloat32(at + 236, true),
    battery_b_v: view.getFloat32(at + 240, true),
    settings_trial_s: view.getFloat32(at + 244, true),
    alarm_pause_s: view.getFloat32(at + 248, true),
    wake_lateness_s: view.getFloat32(at + 252, true),
    tick_duration_s: view.getFloat32(at + 256, true),
    overruns: view.getUint32(at + 260, true),
    lateness_p50_s: view.getFloat32(at + 264, true),
    lateness_p99_s: view.getFloat32(at + 268, true),
    lateness_max_s: view.getFloat32(at + 272, true),
    missed_ticks: view.getUint32(at + 276, true),
    page_faults: view.getUint32(at + 280, true),
    allocations: view.getUint32(at + 284, true),
    calibration_value: view.getFloat32(at + 288, true),
    bus_frames: view.getUint32(at + 292, true),
    bus_refused: view.getUint32(at + 296, true),
    commands_refused: view.getUint32(at + 300, true),
    blocked_bits: view.getUint32(at + 304, true),
    lease_epoch: view.getUint32(at + 308, true),
    lease_holder: view.getUint32(at + 312, true),
    start_mark: view.getUint32(at + 316, true),
    parameter_version: view.getUint32(at + 320, true),
    bus_load_norm: view.getFloat32(at + 324, true),
    bus_send_refused: view.getUint32(at + 328, true),
    bus_reopened: view.getUint32(at + 332, true),
    bus_overflows: view.getUint32(at + 336, true),
    bus_errors: view.getUint32(at + 340, true),
    syncs_lost: view.getUint32(at + 344, true),
    drive_left_lost_frames: view.getUint32(at + 348, true),
    drive_right_lost_frames: view.getUint32(at + 352, true),
    io_lost_frames: view.getUint32(at + 356, true),
    tilt_left_lost_frames: view.getUint32(at + 360, true),
    tilt_right_lost_frames: view.getUint32(at + 364, true),
    tilt_base_lost_frames: view.getUint32(at + 368, true),
    left_status_word: view.getUint16(at + 372, true),
    right_status_word: view.getUint16(at + 374, true),
    bus_frames_per_s: view.getUint16(at + 376, true),
    bus_tx_errors: view.getUint16(at + 378, true),
    bus_rx_errors: view.getUint16(at + 380, true),
    babbling_id: view.getUint16(at + 382, true),
    drive_left_emcy_code: view.getUint16(at + 384, true),
    drive_left_emcy_count: view.getUint16(at + 386, true),
    drive_right_emcy_code: view.getUint16(at + 388, true),
    drive_right_emcy_count: view.getUint16(at + 390, true),
    io_emcy_code: view.getUint16(at + 392, true),
    io_emcy_count: view.getUint16(at + 394, true),
    tilt_left_emcy_code: view.getUint16(at + 396, true),
    tilt_left_emcy_count: view.getUint16(at + 398, true),
    tilt_right_emcy_code: view.getUint16(at + 400, true),
    tilt_right_emcy_count: view.getUint16(at + 402, true),
    tilt_base_emcy_code: view.getUint16(at + 404, true),
    tilt_base_emcy_count: view.getUint16(at + 406, true),
    drive_left_fault_code: view.getUint16(at + 408, true),
    drive_right_fault_code: view.getUint16(at + 410, true),
    tilt_implausible_code: view.getUint16(at + 412, true),
    overspeed_code: view.getUint16(at + 414, true),
    mode: view.getUint8(at + 416),
    stop_cause: view.getUint8(at + 417),
    bumpers: view.getUint8(at + 418),
    simulated: view.getUint8(at + 419),
    tilt_left_age_ticks: view.getUint8(at + 420),
    tilt_right_age_ticks: view.getUint8(at + 421),
    tilt_base_age_ticks: view.getUint8(at + 422),
    drive_left_age_ticks: view.getUint8(at + 423),
    drive_right_age_ticks: view.getUint8(at + 424),
    io_age_ticks: view.getUint8(at + 425),
    bumpers_acknowledged: view.getUint8(at + 426),
    switches: view.getUint8(at + 427),
    server_alive: view.getUint8(at + 428),
    slip_state: view.getUint8(at + 429),
    standing_still: view.getUint8(at + 430),
    loop_priority: view.getUint8(at + 431),
    loop_cpu: view.getUint8(at + 432),
    memory_locked: view.getUint8(at + 433),
    relay_feed: view.getUint8(at + 434),
    sync_output: view.getUint8(at + 435),
    alarm_sound: view.getUint8(at + 436),
    alarm_light: view.getUint8(at + 437),
    speed_cause: view.getUint8(at + 438),
    guided_phase: view.getUint8(at + 439),
    guided_end: view.getUint8(at + 440),
    bus_state: view.getUint8(at + 441),
    bus_up: view.getUint8(at + 442),
    duplicate_id: view.getUint8(at + 443),
    calibration_step: view.getUint8(at + 444),
    calibration_phase: view.getUint8(at + 445),
    calibration_done_percent: view.getUint8(at + 446),
    calibration_reason: view.getUint8(at + 447),
    drive_left_nmt_state: view.getUint8(at + 448),
    drive_left_heartbeats_missed: view.getUint8(at + 449),
    drive_left_error_register: view.getUint8(at + 450),
    drive_left_lost_10s: view.getUint8(at + 451),
    drive_right_nmt_state: view.getUint8(at + 452),
    drive_right_heartbeats_missed: view.getUint8(at + 453),
    drive_right_error_register: view.getUint8(at + 454),
    drive_right_lost_10s: view.getUint8(at + 455),
    io_nmt_state: view.getUint8(at + 456),
    io_heartbeats_missed: view.getUint8(at + 457),
    io_error_register: view.getUint8(at + 458),
    io_lost_10s: view.getUint8(at + 459),
    tilt_left_nmt_state: view.getUint8(at + 460),
    tilt_left_heartbeats_missed: view.getUint8(at + 461),
    tilt_left_error_register: view.getUint8(at + 462),
    tilt_left_lost_10s: view.getUint8(at + 463),
    tilt_right_nmt_state: view.getUint8(at + 464),
    tilt_right_heartbeats_missed: view.getUint8(at + 465),
    tilt_right_error_register: view.getUint8(at + 466),
    tilt_right_lost_10s: view.getUint8(at + 467),
    tilt_base_nmt_state: view.getUint8(at + 468),
    tilt_base_heartbeats_missed: view.getUint8(at + 469),
    tilt_base_error_register: view.getUint8(at + 470),
    tilt_base_lost_10s: view.getUint8(at + 471),
  };
}

export const signals: readonly SignalInfo[] = [
  { id: 1, name: 'tick', type: 'u64', unit: '', lsb: 1, offset: 0, title: { en: 'Tick', de: 'Takt' } },
  { id: 2, name: 'time_ns', type: 'u64', unit: 'ns', lsb: 1, offset: 8, title: { en: 'Time', de: 'Zeit' } },
  { id: 66, name: 'fault_bits', type: 'u64', unit: '', lsb: 1, offset: 16, title: { en: 'Active faults', de: 'Aktive Störungen' } },
  { id: 10, name: 'left_alpha_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 24, title: { en: 'Left strut, forward', de: 'Linke Strebe, vor' } },
  { id: 11, name: 'left_beta_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 28, title: { en: 'Left strut, sideways', de: 'Linke Strebe, seitlich' } },
  { id: 12, name: 'right_alpha_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 32, title: { en: 'Right strut, forward', de: 'Rechte Strebe, vor' } },
  { id: 13, name: 'right_beta_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 36, title: { en: 'Right strut, sideways', de: 'Rechte Strebe, seitlich' } },
  { id: 14, name: 'base_alpha_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 40, title: { en: 'Chassis, forward', de: 'Fahrgestell, vor' } },
  { id: 15, name: 'base_beta_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 44, title: { en: 'Chassis, sideways', de: 'Fahrgestell, seitlich' } },
  { id: 16, name: 'base_yaw_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 48, title: { en: 'Chassis turn rate', de: 'Fahrgestell-Drehrate' } },
  { id: 17, name: 'base_pitch_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 52, title: { en: 'Chassis pitch rate', de: 'Fahrgestell-Nickrate' } },
  { id: 18, name: 'base_roll_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 56, title: { en: 'Chassis roll rate', de: 'Fahrgestell-Wankrate' } },
  { id: 20, name: 'dx_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 60, title: { en: 'Lean of the harness', de: 'Neigung des Gurts' } },
  { id: 21, name: 'dy_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 64, title: { en: 'Sway of the harness', de: 'Seitliches Pendeln' } },
  { id: 22, name: 'dpsi_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 68, title: { en: 'Turn of the harness', de: 'Drehung des Gurts' } },
  { id: 23, name: 'lean_norm', type: 'f32', unit: '', lsb: 1e-04, offset: 72, title: { en: 'Intent to move', de: 'Absicht zu gehen' } },
  { id: 24, name: 'turn_norm', type: 'f32', unit: '', lsb: 1e-04, offset: 76, title: { en: 'Intent to turn', de: 'Absicht zu drehen' } },
  { id: 25, name: 'lean_filtered_units', type: 'f32', unit: 'units', lsb: 1e-04, offset: 80, title: { en: 'Built-up speed', de: 'Aufgebautes Tempo' } },
  { id: 26, name: 'turn_filtered_units', type: 'f32', unit: 'units', lsb: 1e-04, offset: 84, title: { en: 'Built-up turn', de: 'Aufgebaute Drehung' } },
  { id: 30, name: 'speed_wish_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 88, title: { en: 'Requested speed', de: 'Verlangtes Tempo' } },
  { id: 31, name: 'yaw_rate_wish_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-05, offset: 92, title: { en: 'Requested turn rate', de: 'Verlangte Drehrate' } },
  { id: 32, name: 'speed_command_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 96, title: { en: 'Commanded speed', de: 'Befohlenes Tempo' } },
  { id: 33, name: 'yaw_rate_command_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-05, offset: 100, title: { en: 'Commanded turn rate', de: 'Befohlene Drehrate' } },
  { id: 34, name: 'wheel_left_command_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 104, title: { en: 'Left wheel command', de: 'Befehl linkes Rad' } },
  { id: 35, name: 'wheel_right_command_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 108, title: { en: 'Right wheel command', de: 'Befehl rechtes Rad' } },
  { id: 36, name: 'remote_age_s', type: 'f32', unit: 's', lsb: 0.001, offset: 112, title: { en: 'Age of driving command', de: 'Alter des Fahrbefehls' } },
  { id: 37, name: 'stop_distance_m', type: 'f32', unit: 'm', lsb: 1e-04, offset: 116, title: { en: 'Stopping distance', de: 'Anhalteweg' } },
  { id: 195, name: 'guided_progress_norm', type: 'f32', unit: '', lsb: 1e-04, offset: 120, title: { en: 'Exercise done', de: 'Übung geschafft' } },
  { id: 196, name: 'guided_cross_track_m', type: 'f32', unit: 'm', lsb: 1e-04, offset: 124, title: { en: 'Distance from the line', de: 'Abstand von der Linie' } },
  { id: 197, name: 'guided_heading_error_rad', type: 'f32', unit: 'rad', lsb: 1e-04, offset: 128, title: { en: 'Heading error', de: 'Richtungsfehler' } },
  { id: 198, name: 'guided_remaining_m', type: 'f32', unit: 'm', lsb: 0.001, offset: 132, title: { en: 'Remaining exercise', de: 'Verbleibende Übung' } },
  { id: 40, name: 'speed_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 136, title: { en: 'Speed', de: 'Tempo' } },
  { id: 41, name: 'yaw_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-05, offset: 140, title: { en: 'Turn rate', de: 'Drehrate' } },
  { id: 42, name: 'x_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 144, title: { en: 'Position x', de: 'Position x' } },
  { id: 43, name: 'y_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 148, title: { en: 'Position y', de: 'Position y' } },
  { id: 44, name: 'psi_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 152, title: { en: 'Heading', de: 'Richtung' } },
  { id: 45, name: 'distance_m', type: 'f32', unit: 'm', lsb: 1e-04, offset: 156, title: { en: 'Distance', de: 'Strecke' } },
  { id: 46, name: 'wheel_left_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 160, title: { en: 'Left wheel speed', de: 'Tempo linkes Rad' } },
  { id: 47, name: 'wheel_right_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 164, title: { en: 'Right wheel speed', de: 'Tempo rechtes Rad' } },
  { id: 48, name: 'left_counts', type: 'i32', unit: 'counts', lsb: 1, offset: 168, title: { en: 'Left encoder', de: 'Geber links' } },
  { id: 49, name: 'right_counts', type: 'i32', unit: 'counts', lsb: 1, offset: 172, title: { en: 'Right encoder', de: 'Geber rechts' } },
  { id: 170, name: 'fused_x_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 176, title: { en: 'Position x, slip corrected', de: 'Position x, Schlupf korrigiert' } },
  { id: 171, name: 'fused_y_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 180, title: { en: 'Position y, slip corrected', de: 'Position y, Schlupf korrigiert' } },
  { id: 172, name: 'fused_psi_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 184, title: { en: 'Heading, slip corrected', de: 'Richtung, Schlupf korrigiert' } },
  { id: 173, name: 'fused_yaw_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 188, title: { en: 'Turn rate, slip corrected', de: 'Drehrate, Schlupf korrigiert' } },
  { id: 174, name: 'gyro_bias_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-06, offset: 192, title: { en: 'Chassis turn rate at rest', de: 'Fahrgestell-Drehrate in Ruhe' } },
  { id: 175, name: 'slip_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 196, title: { en: 'Slip', de: 'Schlupf' } },
  { id: 176, name: 'worst_stop_distance_m', type: 'f32', unit: 'm', lsb: 1e-04, offset: 200, title: { en: 'Stopping distance without computer', de: 'Anhalteweg ohne Rechner' } },
  { id: 177, name: 'gait_lean_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 204, title: { en: 'Gait removed from the lean', de: 'Aus der Neigung entferntes Pendeln' } },
  { id: 178, name: 'gait_turn_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 208, title: { en: 'Gait removed from the turn', de: 'Aus der Drehung entferntes Pendeln' } },
  { id: 179, name: 'gait_sway_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 212, title: { en: 'Sway of the stride', de: 'Pendeln des Doppelschritts' } },
  { id: 180, name: 'stride_hz', type: 'f32', unit: 'Hz', lsb: 1e-04, offset: 216, title: { en: 'Stride frequency', de: 'Doppelschritte je Sekunde' } },
  { id: 50, name: 'left_current_a', type: 'f32', unit: 'A', lsb: 0.001, offset: 220, title: { en: 'Left motor current', de: 'Motorstrom links' } },
  { id: 51, name: 'right_current_a', type: 'f32', unit: 'A', lsb: 0.001, offset: 224, title: { en: 'Right motor current', de: 'Motorstrom rechts' } },
  { id: 52, name: 'left_supply_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 228, title: { en: 'Left drive supply', de: 'Versorgung links' } },
  { id: 53, name: 'right_supply_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 232, title: { en: 'Right drive supply', de: 'Versorgung rechts' } },
  { id: 54, name: 'battery_a_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 236, title: { en: 'Battery A', de: 'Batterie A' } },
  { id: 55, name: 'battery_b_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 240, title: { en: 'Battery B', de: 'Batterie B' } },
  { id: 160, name: 'settings_trial_s', type: 'f32', unit: 's', lsb: 0.01, offset: 244, title: { en: 'Settings on trial', de: 'Einstellungen auf Probe' } },
  { id: 239, name: 'alarm_pause_s', type: 'f32', unit: 's', lsb: 0.01, offset: 248, title: { en: 'Sound paused', de: 'Ton pausiert' } },
  { id: 60, name: 'wake_lateness_s', type: 'f32', unit: 's', lsb: 1e-06, offset: 252, title: { en: 'Wake-up lateness', de: 'Verspätung' } },
  { id: 61, name: 'tick_duration_s', type: 'f32', unit: 's', lsb: 1e-07, offset: 256, title: { en: 'Step duration', de: 'Schrittdauer' } },
  { id: 62, name: 'overruns', type: 'u32', unit: '', lsb: 1, offset: 260, title: { en: 'Late steps', de: 'Verspätete Schritte' } },
  { id: 205, name: 'lateness_p50_s', type: 'f32', unit: 's', lsb: 1e-06, offset: 264, title: { en: 'Lateness, half of the steps', de: 'Verspätung, Hälfte der Schritte' } },
  { id: 206, name: 'lateness_p99_s', type: 'f32', unit: 's', lsb: 1e-06, offset: 268, title: { en: 'Lateness, 99 of 100 steps', de: 'Verspätung, 99 von 100 Schritten' } },
  { id: 207, name: 'lateness_max_s', type: 'f32', unit: 's', lsb: 1e-06, offset: 272, title: { en: 'Lateness, latest step', de: 'Verspätung, spätester Schritt' } },
  { id: 208, name: 'missed_ticks', type: 'u32', unit: '', lsb: 1, offset: 276, title: { en: 'Steps left out', de: 'Ausgelassene Schritte' } },
  { id: 209, name: 'page_faults', type: 'u32', unit: '', lsb: 1, offset: 280, title: { en: 'Page faults', de: 'Seitenfehler' } },
  { id: 210, name: 'allocations', type: 'u32', unit: '', lsb: 1, offset: 284, title: { en: 'Memory requests', de: 'Speicheranforderungen' } },
  { id: 190, name: 'calibration_value', type: 'f32', unit: '', lsb: 1e-05, offset: 288, title: { en: 'Calibration: now', de: 'Kalibrierung: jetzt' } },
  { id: 63, name: 'bus_frames', type: 'u32', unit: '', lsb: 1, offset: 292, title: { en: 'Bus frames', de: 'Busnachrichten' } },
  { id: 64, name: 'bus_refused', type: 'u32', unit: '', lsb: 1, offset: 296, title: { en: 'Refused frames', de: 'Abgelehnte Nachrichten' } },
  { id: 65, name: 'commands_refused', type: 'u32', unit: '', lsb: 1, offset: 300, title: { en: 'Refused commands', de: 'Abgelehnte Befehle' } },
  { id: 67, name: 'blocked_bits', type: 'u32', unit: '', lsb: 1, offset: 304, title: { en: 'Start blocked by', de: 'Start gesperrt durch' } },
  { id: 68, name: 'lease_epoch', type: 'u32', unit: '', lsb: 1, offset: 308, title: { en: 'Lease number', de: 'Steuerungsnummer' } },
  { id: 69, name: 'lease_holder', type: 'u32', unit: '', lsb: 1, offset: 312, title: { en: 'Lease holder', de: 'Steuernder' } },
  { id: 235, name: 'start_mark', type: 'u32', unit: '', lsb: 1, offset: 316, title: { en: 'Start mark', de: 'Startmarke' } },
  { id: 70, name: 'parameter_version', type: 'u32', unit: '', lsb: 1, offset: 320, title: { en: 'Parameter version', de: 'Parameterstand' } },
  { id: 85, name: 'bus_load_norm', type: 'f32', unit: '', lsb: 0.001, offset: 324, title: { en: 'Bus load', de: 'Buslast' } },
  { id: 86, name: 'bus_send_refused', type: 'u32', unit: '', lsb: 1, offset: 328, title: { en: 'Frames not sent', de: 'Nicht gesendete Nachrichten' } },
  { id: 87, name: 'bus_reopened', type: 'u32', unit: '', lsb: 1, offset: 332, title: { en: 'Bus reopened', de: 'Bus neu geöffnet' } },
  { id: 88, name: 'bus_overflows', type: 'u32', unit: '', lsb: 1, offset: 336, title: { en: 'Frame overflows', de: 'Übergelaufene Nachrichten' } },
  { id: 89, name: 'bus_errors', type: 'u32', unit: '', lsb: 1, offset: 340, title: { en: 'Bus errors', de: 'Busfehler' } },
  { id: 90, name: 'syncs_lost', type: 'u32', unit: '', lsb: 1, offset: 344, title: { en: 'Lost SYNC messages', de: 'Verlorene SYNC-Nachrichten' } },
  { id: 100, name: 'drive_left_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 348, title: { en: 'Left drive: lost frames', de: 'Antrieb links: verlorene Nachrichten' } },
  { id: 110, name: 'drive_right_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 352, title: { en: 'Right drive: lost frames', de: 'Antrieb rechts: verlorene Nachrichten' } },
  { id: 120, name: 'io_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 356, title: { en: 'Input node: lost frames', de: 'Eingangsknoten: verlorene Nachrichten' } },
  { id: 130, name: 'tilt_left_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 360, title: { en: 'Left strut sensor: lost frames', de: 'Sensor links: verlorene Nachrichten' } },
  { id: 140, name: 'tilt_right_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 364, title: { en: 'Right strut sensor: lost frames', de: 'Sensor rechts: verlorene Nachrichten' } },
  { id: 150, name: 'tilt_base_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 368, title: { en: 'Chassis sensor: lost frames', de: 'Sensor Fahrgestell: verlorene Nachrichten' } },
  { id: 71, name: 'left_status_word', type: 'u16', unit: '', lsb: 1, offset: 372, title: { en: 'Left drive status', de: 'Status Antrieb links' } },
  { id: 72, name: 'right_status_word', type: 'u16', unit: '', lsb: 1, offset: 374, title: { en: 'Right drive status', de: 'Status Antrieb rechts' } },
  { id: 91, name: 'bus_frames_per_s', type: 'u16', unit: '1/s', lsb: 1, offset: 376, title: { en: 'Frames per second', de: 'Nachrichten je Sekunde' } },
  { id: 92, name: 'bus_tx_errors', type: 'u16', unit: '', lsb: 1, offset: 378, title: { en: 'Send error counter', de: 'Sendefehlerzähler' } },
  { id: 93, name: 'bus_rx_errors', type: 'u16', unit: '', lsb: 1, offset: 380, title: { en: 'Receive error counter', de: 'Empfangsfehlerzähler' } },
  { id: 94, name: 'babbling_id', type: 'u16', unit: '', lsb: 1, offset: 382, title: { en: 'Flooding id', de: 'Flutende Kennung' } },
  { id: 101, name: 'drive_left_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 384, title: { en: 'Left drive: emergency', de: 'Antrieb links: Notmeldung' } },
  { id: 102, name: 'drive_left_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 386, title: { en: 'Left drive: emergencies', de: 'Antrieb links: Notmeldungen' } },
  { id: 111, name: 'drive_right_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 388, title: { en: 'Right drive: emergency', de: 'Antrieb rechts: Notmeldung' } },
  { id: 112, name: 'drive_right_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 390, title: { en: 'Right drive: emergencies', de: 'Antrieb rechts: Notmeldungen' } },
  { id: 121, name: 'io_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 392, title: { en: 'Input node: emergency', de: 'Eingangsknoten: Notmeldung' } },
  { id: 122, name: 'io_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 394, title: { en: 'Input node: emergencies', de: 'Eingangsknoten: Notmeldungen' } },
  { id: 131, name: 'tilt_left_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 396, title: { en: 'Left strut sensor: emergency', de: 'Sensor links: Notmeldung' } },
  { id: 132, name: 'tilt_left_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 398, title: { en: 'Left strut sensor: emergencies', de: 'Sensor links: Notmeldungen' } },
  { id: 141, name: 'tilt_right_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 400, title: { en: 'Right strut sensor: emergency', de: 'Sensor rechts: Notmeldung' } },
  { id: 142, name: 'tilt_right_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 402, title: { en: 'Right strut sensor: emergencies', de: 'Sensor rechts: Notmeldungen' } },
  { id: 151, name: 'tilt_base_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 404, title: { en: 'Chassis sensor: emergency', de: 'Sensor Fahrgestell: Notmeldung' } },
  { id: 152, name: 'tilt_base_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 406, title: { en: 'Chassis sensor: emergencies', de: 'Sensor Fahrgestell: Notmeldungen' } },
  { id: 225, name: 'drive_left_fault_code', type: 'u16', unit: '', lsb: 1, offset: 408, title: { en: 'Left drive: fault code', de: 'Antrieb links: Störungscode' } },
  { id: 226, name: 'drive_right_fault_code', type: 'u16', unit: '', lsb: 1, offset: 410, title: { en: 'Right drive: fault code', de: 'Antrieb rechts: Störungscode' } },
  { id: 227, name: 'tilt_implausible_code', type: 'u16', unit: '', lsb: 1, offset: 412, title: { en: 'Impossible tilt: cause', de: 'Unmögliche Neigung: Ursache' } },
  { id: 228, name: 'overspeed_code', type: 'u16', unit: '', lsb: 1, offset: 414, title: { en: 'Moves differently: cause', de: 'Andere Bewegung: Ursache' } },
  { id: 73, name: 'mode', type: 'u8', unit: '', lsb: 1, offset: 416, title: { en: 'Mode', de: 'Betriebsart' } },
  { id: 74, name: 'stop_cause', type: 'u8', unit: '', lsb: 1, offset: 417, title: { en: 'Stop cause', de: 'Haltegrund' } },
  { id: 75, name: 'bumpers', type: 'u8', unit: '', lsb: 1, offset: 418, title: { en: 'Bumpers', de: 'Stoßfänger' } },
  { id: 76, name: 'simulated', type: 'u8', unit: '', lsb: 1, offset: 419, title: { en: 'Simulated', de: 'Simuliert' } },
  { id: 77, name: 'tilt_left_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 420, title: { en: 'Left strut sensor age', de: 'Alter Sensor links' } },
  { id: 78, name: 'tilt_right_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 421, title: { en: 'Right strut sensor age', de: 'Alter Sensor rechts' } },
  { id: 79, name: 'tilt_base_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 422, title: { en: 'Chassis sensor age', de: 'Alter Sensor Fahrgestell' } },
  { id: 80, name: 'drive_left_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 423, title: { en: 'Left drive age', de: 'Alter Antrieb links' } },
  { id: 81, name: 'drive_right_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 424, title: { en: 'Right drive age', de: 'Alter Antrieb rechts' } },
  { id: 82, name: 'io_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 425, title: { en: 'Input node age', de: 'Alter Eingangsknoten' } },
  { id: 161, name: 'bumpers_acknowledged', type: 'u8', unit: '', lsb: 1, offset: 426, title: { en: 'Bumpers acknowledged', de: 'Quittierte Stoßfänger' } },
  { id: 237, name: 'switches', type: 'u8', unit: '', lsb: 1, offset: 427, title: { en: 'Switches', de: 'Schalter' } },
  { id: 83, name: 'server_alive', type: 'u8', unit: '', lsb: 1, offset: 428, title: { en: 'Console server', de: 'Konsolenserver' } },
  { id: 181, name: 'slip_state', type: 'u8', unit: '', lsb: 1, offset: 429, title: { en: 'Slip state', de: 'Schlupfzustand' } },
  { id: 84, name: 'standing_still', type: 'u8', unit: '', lsb: 1, offset: 430, title: { en: 'Standing still', de: 'Steht still' } },
  { id: 211, name: 'loop_priority', type: 'u8', unit: '', lsb: 1, offset: 431, title: { en: 'Real-time priority', de: 'Echtzeitpriorität' } },
  { id: 212, name: 'loop_cpu', type: 'u8', unit: '', lsb: 1, offset: 432, title: { en: 'Own processor core', de: 'Eigener Prozessorkern' } },
  { id: 213, name: 'memory_locked', type: 'u8', unit: '', lsb: 1, offset: 433, title: { en: 'Memory locked', de: 'Speicher verriegelt' } },
  { id: 214, name: 'relay_feed', type: 'u8', unit: '', lsb: 1, offset: 434, title: { en: 'Relay feed', de: 'Relais-Speisung' } },
  { id: 238, name: 'sync_output', type: 'u8', unit: '', lsb: 1, offset: 435, title: { en: 'Synchronisation output', de: 'Synchronausgang' } },
  { id: 240, name: 'alarm_sound', type: 'u8', unit: '', lsb: 1, offset: 436, title: { en: 'Alarm sound', de: 'Alarmton' } },
  { id: 241, name: 'alarm_light', type: 'u8', unit: '', lsb: 1, offset: 437, title: { en: 'Alarm light', de: 'Alarmlicht' } },
  { id: 236, name: 'speed_cause', type: 'u8', unit: '', lsb: 1, offset: 438, title: { en: 'Slower because', de: 'Langsamer wegen' } },
  { id: 199, name: 'guided_phase', type: 'u8', unit: '', lsb: 1, offset: 439, title: { en: 'Exercise phase', de: 'Übungsphase' } },
  { id: 200, name: 'guided_end', type: 'u8', unit: '', lsb: 1, offset: 440, title: { en: 'Exercise ended by', de: 'Übung beendet durch' } },
  { id: 95, name: 'bus_state', type: 'u8', unit: '', lsb: 1, offset: 441, title: { en: 'Bus controller', de: 'Buscontroller' } },
  { id: 96, name: 'bus_up', type: 'u8', unit: '', lsb: 1, offset: 442, title: { en: 'Bus connected', de: 'Bus verbunden' } },
  { id: 97, name: 'duplicate_id', type: 'u8', unit: '', lsb: 1, offset: 443, title: { en: 'Duplicate node number', de: 'Doppelte Knotennummer' } },
  { id: 191, name: 'calibration_step', type: 'u8', unit: '', lsb: 1, offset: 444, title: { en: 'Calibration step', de: 'Kalibrierschritt' } },
  { id: 192, name: 'calibration_phase', type: 'u8', unit: '', lsb: 1, offset: 445, title: { en: 'Calibration phase', de: 'Kalibrierphase' } },
  { id: 193, name: 'calibration_done_percent', type: 'u8', unit: '%', lsb: 1, offset: 446, title: { en: 'Calibration progress', de: 'Kalibrierfortschritt' } },
  { id: 194, name: 'calibration_reason', type: 'u8', unit: '', lsb: 1, offset: 447, title: { en: 'Calibration reason', de: 'Kalibriergrund' } },
  { id: 103, name: 'drive_left_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 448, title: { en: 'Left drive: state', de: 'Antrieb links: Zustand' } },
  { id: 104, name: 'drive_left_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 449, title: { en: 'Left drive: heartbeats missed', de: 'Antrieb links: fehlende Lebenszeichen' } },
  { id: 105, name: 'drive_left_error_register', type: 'u8', unit: '', lsb: 1, offset: 450, title: { en: 'Left drive: error register', de: 'Antrieb links: Fehlerregister' } },
  { id: 106, name: 'drive_left_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 451, title: { en: 'Left drive: lost recently', de: 'Antrieb links: zuletzt verloren' } },
  { id: 113, name: 'drive_right_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 452, title: { en: 'Right drive: state', de: 'Antrieb rechts: Zustand' } },
  { id: 114, name: 'drive_right_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 453, title: { en: 'Right drive: heartbeats missed', de: 'Antrieb rechts: fehlende Lebenszeichen' } },
  { id: 115, name: 'drive_right_error_register', type: 'u8', unit: '', lsb: 1, offset: 454, title: { en: 'Right drive: error register', de: 'Antrieb rechts: Fehlerregister' } },
  { id: 116, name: 'drive_right_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 455, title: { en: 'Right drive: lost recently', de: 'Antrieb rechts: zuletzt verloren' } },
  { id: 123, name: 'io_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 456, title: { en: 'Input node: state', de: 'Eingangsknoten: Zustand' } },
  { id: 124, name: 'io_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 457, title: { en: 'Input node: heartbeats missed', de: 'Eingangsknoten: fehlende Lebenszeichen' } },
  { id: 125, name: 'io_error_register', type: 'u8', unit: '', lsb: 1, offset: 458, title: { en: 'Input node: error register', de: 'Eingangsknoten: Fehlerregister' } },
  { id: 126, name: 'io_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 459, title: { en: 'Input node: lost recently', de: 'Eingangsknoten: zuletzt verloren' } },
  { id: 133, name: 'tilt_left_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 460, title: { en: 'Left strut sensor: state', de: 'Sensor links: Zustand' } },
  { id: 134, name: 'tilt_left_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 461, title: { en: 'Left strut sensor: heartbeats missed', de: 'Sensor links: fehlende Lebenszeichen' } },
  { id: 135, name: 'tilt_left_error_register', type: 'u8', unit: '', lsb: 1, offset: 462, title: { en: 'Left strut sensor: error register', de: 'Sensor links: Fehlerregister' } },
  { id: 136, name: 'tilt_left_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 463, title: { en: 'Left strut sensor: lost recently', de: 'Sensor links: zuletzt verloren' } },
  { id: 143, name: 'tilt_right_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 464, title: { en: 'Right strut sensor: state', de: 'Sensor rechts: Zustand' } },
  { id: 144, name: 'tilt_right_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 465, title: { en: 'Right strut sensor: heartbeats missed', de: 'Sensor rechts: fehlende Lebenszeichen' } },
  { id: 145, name: 'tilt_right_error_register', type: 'u8', unit: '', lsb: 1, offset: 466, title: { en: 'Right strut sensor: error register', de: 'Sensor rechts: Fehlerregister' } },
  { id: 146, name: 'tilt_right_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 467, title: { en: 'Right strut sensor: lost recently', de: 'Sensor rechts: zuletzt verloren' } },
  { id: 153, name: 'tilt_base_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 468, title: { en: 'Chassis sensor: state', de: 'Sensor Fahrgestell: Zustand' } },
  { id: 154, name: 'tilt_base_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 469, title: { en: 'Chassis sensor: heartbeats missed', de: 'Sensor Fahrgestell: fehlende Lebenszeichen' } },
  { id: 155, name: 'tilt_base_error_register', type: 'u8', unit: '', lsb: 1, offset: 470, title: { en: 'Chassis sensor: error register', de: 'Sensor Fahrgestell: Fehlerregister' } },
  { id: 156, name: 'tilt_base_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 471, title: { en: 'Chassis sensor: lost recently', de: 'Sensor Fahrgestell: zuletzt verloren' } },
];
