// Made by `deploy/dev gen` from control/contract/signals.def; do not edit.

export interface Words {
  en: string;
  de: string;
}

export type SignalName =
  | 'tick'
  | 'time_ns'
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
  | 'fault_bits'
  | 'blocked_bits'
  | 'lease_epoch'
  | 'lease_holder'
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
  | 'server_alive'
  | 'slip_state'
  | 'standing_still'
  | 'loop_priority'
  | 'loop_cpu'
  | 'memory_locked'
  | 'relay_feed'
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
  doc: string;
}

/** Every live value of one control step. */
export type TickRecord = Record<SignalName, number>;

export const tickRecordBytes = 424;

/** Reads the record that begins at byte `at`. */
export function readTickRecord(view: DataView, at: number): TickRecord {
  return {
    tick: Number(view.getBigUint64(at + 0, true)),
    time_ns: Number(view.getBigUint64(at + 8, true)),
    left_alpha_rad: view.getFloat32(at + 16, true),
    left_beta_rad: view.getFloat32(at + 20, true),
    right_alpha_rad: view.getFloat32(at + 24, true),
    right_beta_rad: view.getFloat32(at + 28, true),
    base_alpha_rad: view.getFloat32(at + 32, true),
    base_beta_rad: view.getFloat32(at + 36, true),
    base_yaw_rate_rad_s: view.getFloat32(at + 40, true),
    base_pitch_rate_rad_s: view.getFloat32(at + 44, true),
    base_roll_rate_rad_s: view.getFloat32(at + 48, true),
    dx_m: view.getFloat32(at + 52, true),
    dy_m: view.getFloat32(at + 56, true),
    dpsi_rad: view.getFloat32(at + 60, true),
    lean_norm: view.getFloat32(at + 64, true),
    turn_norm: view.getFloat32(at + 68, true),
    lean_filtered_units: view.getFloat32(at + 72, true),
    turn_filtered_units: view.getFloat32(at + 76, true),
    speed_wish_m_s: view.getFloat32(at + 80, true),
    yaw_rate_wish_rad_s: view.getFloat32(at + 84, true),
    speed_command_m_s: view.getFloat32(at + 88, true),
    yaw_rate_command_rad_s: view.getFloat32(at + 92, true),
    wheel_left_command_m_s: view.getFloat32(at + 96, true),
    wheel_right_command_m_s: view.getFloat32(at + 100, true),
    remote_age_s: view.getFloat32(at + 104, true),
    stop_distance_m: view.getFloat32(at + 108, true),
    speed_m_s: view.getFloat32(at + 112, true),
    yaw_rate_rad_s: view.getFloat32(at + 116, true),
    x_m: view.getFloat32(at + 120, true),
    y_m: view.getFloat32(at + 124, true),
    psi_rad: view.getFloat32(at + 128, true),
    distance_m: view.getFloat32(at + 132, true),
    wheel_left_m_s: view.getFloat32(at + 136, true),
    wheel_right_m_s: view.getFloat32(at + 140, true),
    left_counts: view.getInt32(at + 144, true),
    right_counts: view.getInt32(at + 148, true),
    fused_x_m: view.getFloat32(at + 152, true),
    fused_y_m: view.getFloat32(at + 156, true),
    fused_psi_rad: view.getFloat32(at + 160, true),
    fused_yaw_rate_rad_s: view.getFloat32(at + 164, true),
    gyro_bias_rad_s: view.getFloat32(at + 168, true),
    slip_rate_rad_s: view.getFloat32(at + 172, true),
    worst_stop_distance_m: view.getFloat32(at + 176, true),
    gait_lean_m: view.getFloat32(at + 180, true),
    gait_turn_rad: view.getFloat32(at + 184, true),
    gait_sway_m: view.getFloat32(at + 188, true),
    stride_hz: view.getFloat32(at + 192, true),
    left_current_a: view.getFloat32(at + 196, true),
    right_current_a: view.getFloat32(at + 200, true),
    left_supply_v: view.getFloat32(at + 204, true),
    right_supply_v: view.getFloat32(at + 208, true),
    battery_a_v: view.getFloat32(at + 212, true),
    battery_b_v: view.getFloat32(at + 216, true),
    wake_lateness_s: view.getFloat32(at + 220, true),
    tick_duration_s: view.getFloat32(at + 224, true),
    overruns: view.getUint32(at + 228, true),
    lateness_p50_s: view.getFloat32(at + 232, true),
    lateness_p99_s: view.getFloat32(at + 236, true),
    lateness_max_s: view.getFloat32(at + 240, true),
    missed_ticks: view.getUint32(at + 244, true),
    page_faults: view.getUint32(at + 248, true),
    allocations: view.getUint32(at + 252, true),
    calibration_value: view.getFloat32(at + 256, true),
    bus_frames: view.getUint32(at + 260, true),
    bus_refused: view.getUint32(at + 264, true),
    commands_refused: view.getUint32(at + 268, true),
    fault_bits: view.getUint32(at + 272, true),
    blocked_bits: view.getUint32(at + 276, true),
    lease_epoch: view.getUint32(at + 280, true),
    lease_holder: view.getUint32(at + 284, true),
    parameter_version: view.getUint32(at + 288, true),
    bus_load_norm: view.getFloat32(at + 292, true),
    bus_send_refused: view.getUint32(at + 296, true),
    bus_reopened: view.getUint32(at + 300, true),
    bus_overflows: view.getUint32(at + 304, true),
    bus_errors: view.getUint32(at + 308, true),
    syncs_lost: view.getUint32(at + 312, true),
    drive_left_lost_frames: view.getUint32(at + 316, true),
    drive_right_lost_frames: view.getUint32(at + 320, true),
    io_lost_frames: view.getUint32(at + 324, true),
    tilt_left_lost_frames: view.getUint32(at + 328, true),
    tilt_right_lost_frames: view.getUint32(at + 332, true),
    tilt_base_lost_frames: view.getUint32(at + 336, true),
    left_status_word: view.getUint16(at + 340, true),
    right_status_word: view.getUint16(at + 342, true),
    bus_frames_per_s: view.getUint16(at + 344, true),
    bus_tx_errors: view.getUint16(at + 346, true),
    bus_rx_errors: view.getUint16(at + 348, true),
    babbling_id: view.getUint16(at + 350, true),
    drive_left_emcy_code: view.getUint16(at + 352, true),
    drive_left_emcy_count: view.getUint16(at + 354, true),
    drive_right_emcy_code: view.getUint16(at + 356, true),
    drive_right_emcy_count: view.getUint16(at + 358, true),
    io_emcy_code: view.getUint16(at + 360, true),
    io_emcy_count: view.getUint16(at + 362, true),
    tilt_left_emcy_code: view.getUint16(at + 364, true),
    tilt_left_emcy_count: view.getUint16(at + 366, true),
    tilt_right_emcy_code: view.getUint16(at + 368, true),
    tilt_right_emcy_count: view.getUint16(at + 370, true),
    tilt_base_emcy_code: view.getUint16(at + 372, true),
    tilt_base_emcy_count: view.getUint16(at + 374, true),
    mode: view.getUint8(at + 376),
    stop_cause: view.getUint8(at + 377),
    bumpers: view.getUint8(at + 378),
    simulated: view.getUint8(at + 379),
    tilt_left_age_ticks: view.getUint8(at + 380),
    tilt_right_age_ticks: view.getUint8(at + 381),
    tilt_base_age_ticks: view.getUint8(at + 382),
    drive_left_age_ticks: view.getUint8(at + 383),
    drive_right_age_ticks: view.getUint8(at + 384),
    io_age_ticks: view.getUint8(at + 385),
    server_alive: view.getUint8(at + 386),
    slip_state: view.getUint8(at + 387),
    standing_still: view.getUint8(at + 388),
    loop_priority: view.getUint8(at + 389),
    loop_cpu: view.getUint8(at + 390),
    memory_locked: view.getUint8(at + 391),
    relay_feed: view.getUint8(at + 392),
    bus_state: view.getUint8(at + 393),
    bus_up: view.getUint8(at + 394),
    duplicate_id: view.getUint8(at + 395),
    calibration_step: view.getUint8(at + 396),
    calibration_phase: view.getUint8(at + 397),
    calibration_done_percent: view.getUint8(at + 398),
    calibration_reason: view.getUint8(at + 399),
    drive_left_nmt_state: view.getUint8(at + 400),
    drive_left_heartbeats_missed: view.getUint8(at + 401),
    drive_left_error_register: view.getUint8(at + 402),
    drive_left_lost_10s: view.getUint8(at + 403),
    drive_right_nmt_state: view.getUint8(at + 404),
    drive_right_heartbeats_missed: view.getUint8(at + 405),
    drive_right_error_register: view.getUint8(at + 406),
    drive_right_lost_10s: view.getUint8(at + 407),
    io_nmt_state: view.getUint8(at + 408),
    io_heartbeats_missed: view.getUint8(at + 409),
    io_error_register: view.getUint8(at + 410),
    io_lost_10s: view.getUint8(at + 411),
    tilt_left_nmt_state: view.getUint8(at + 412),
    tilt_left_heartbeats_missed: view.getUint8(at + 413),
    tilt_left_error_register: view.getUint8(at + 414),
    tilt_left_lost_10s: view.getUint8(at + 415),
    tilt_right_nmt_state: view.getUint8(at + 416),
    tilt_right_heartbeats_missed: view.getUint8(at + 417),
    tilt_right_error_register: view.getUint8(at + 418),
    tilt_right_lost_10s: view.getUint8(at + 419),
    tilt_base_nmt_state: view.getUint8(at + 420),
    tilt_base_heartbeats_missed: view.getUint8(at + 421),
    tilt_base_error_register: view.getUint8(at + 422),
    tilt_base_lost_10s: view.getUint8(at + 423),
  };
}

export const signals: readonly SignalInfo[] = [
  { id: 1, name: 'tick', type: 'u64', unit: '', lsb: 1, offset: 0, title: { en: 'Tick', de: 'Takt' }, doc: 'Number of the control step since the core started.' },
  { id: 2, name: 'time_ns', type: 'u64', unit: 'ns', lsb: 1, offset: 8, title: { en: 'Time', de: 'Zeit' }, doc: 'Steady clock of the core at the start of the step.' },
  { id: 10, name: 'left_alpha_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 16, title: { en: 'Left strut, forward', de: 'Linke Strebe, vor' }, doc: 'Forward tilt of the left strut against gravity.' },
  { id: 11, name: 'left_beta_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 20, title: { en: 'Left strut, sideways', de: 'Linke Strebe, seitlich' }, doc: 'Rightward tilt of the left strut against gravity.' },
  { id: 12, name: 'right_alpha_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 24, title: { en: 'Right strut, forward', de: 'Rechte Strebe, vor' }, doc: 'Forward tilt of the right strut against gravity.' },
  { id: 13, name: 'right_beta_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 28, title: { en: 'Right strut, sideways', de: 'Rechte Strebe, seitlich' }, doc: 'Rightward tilt of the right strut against gravity.' },
  { id: 14, name: 'base_alpha_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 32, title: { en: 'Chassis, forward', de: 'Fahrgestell, vor' }, doc: 'Forward tilt of the chassis against gravity.' },
  { id: 15, name: 'base_beta_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 36, title: { en: 'Chassis, sideways', de: 'Fahrgestell, seitlich' }, doc: 'Rightward tilt of the chassis against gravity.' },
  { id: 16, name: 'base_yaw_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 40, title: { en: 'Chassis turn rate', de: 'Fahrgestell-Drehrate' }, doc: 'Turn rate of the chassis from its gyroscope, left positive.' },
  { id: 17, name: 'base_pitch_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 44, title: { en: 'Chassis pitch rate', de: 'Fahrgestell-Nickrate' }, doc: 'Pitch rate of the chassis, forward positive.' },
  { id: 18, name: 'base_roll_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 48, title: { en: 'Chassis roll rate', de: 'Fahrgestell-Wankrate' }, doc: 'Roll rate of the chassis, to the right positive.' },
  { id: 20, name: 'dx_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 52, title: { en: 'Lean of the harness', de: 'Neigung des Gurts' }, doc: 'Forward displacement of the support bar, eq (1).' },
  { id: 21, name: 'dy_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 56, title: { en: 'Sway of the harness', de: 'Seitliches Pendeln' }, doc: 'Leftward displacement of the support bar, eq (2): gait quality, not used for control.' },
  { id: 22, name: 'dpsi_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 60, title: { en: 'Turn of the harness', de: 'Drehung des Gurts' }, doc: 'Turn of the support bar as printed in eq (3), left positive.' },
  { id: 23, name: 'lean_norm', type: 'f32', unit: '', lsb: 1e-04, offset: 64, title: { en: 'Intent to move', de: 'Absicht zu gehen' }, doc: 'Normalised lean u, -1 to 1.' },
  { id: 24, name: 'turn_norm', type: 'f32', unit: '', lsb: 1e-04, offset: 68, title: { en: 'Intent to turn', de: 'Absicht zu drehen' }, doc: 'Normalised turn u_psi, -1 to 1.' },
  { id: 25, name: 'lean_filtered_units', type: 'f32', unit: 'units', lsb: 1e-04, offset: 72, title: { en: 'Built-up speed', de: 'Aufgebautes Tempo' }, doc: 'v_f of Algorithm 1.' },
  { id: 26, name: 'turn_filtered_units', type: 'f32', unit: 'units', lsb: 1e-04, offset: 76, title: { en: 'Built-up turn', de: 'Aufgebaute Drehung' }, doc: 'omega_f of Algorithm 2.' },
  { id: 30, name: 'speed_wish_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 80, title: { en: 'Asked speed', de: 'Verlangtes Tempo' }, doc: 'Speed asked by the mode in charge, before limits.' },
  { id: 31, name: 'yaw_rate_wish_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-05, offset: 84, title: { en: 'Asked turn rate', de: 'Verlangte Drehrate' }, doc: 'Turn rate asked by the mode in charge, before limits.' },
  { id: 32, name: 'speed_command_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 88, title: { en: 'Commanded speed', de: 'Befohlenes Tempo' }, doc: 'Speed after limiter and safety gate.' },
  { id: 33, name: 'yaw_rate_command_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-05, offset: 92, title: { en: 'Commanded turn rate', de: 'Befohlene Drehrate' }, doc: 'Turn rate after limiter and safety gate.' },
  { id: 34, name: 'wheel_left_command_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 96, title: { en: 'Left wheel command', de: 'Befehl linkes Rad' }, doc: 'Ground speed commanded to the left wheel.' },
  { id: 35, name: 'wheel_right_command_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 100, title: { en: 'Right wheel command', de: 'Befehl rechtes Rad' }, doc: 'Ground speed commanded to the right wheel.' },
  { id: 36, name: 'remote_age_s', type: 'f32', unit: 's', lsb: 0.001, offset: 104, title: { en: 'Age of driving command', de: 'Alter des Fahrbefehls' }, doc: 'Time since the newest accepted driving command; 9.999 when there is none.' },
  { id: 37, name: 'stop_distance_m', type: 'f32', unit: 'm', lsb: 1e-04, offset: 108, title: { en: 'Stopping distance', de: 'Anhalteweg' }, doc: 'Distance the hoist would roll if the link to its driver died now; while the patient leads, if STOP were pressed.' },
  { id: 40, name: 'speed_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 112, title: { en: 'Speed', de: 'Tempo' }, doc: 'Forward speed from the encoders.' },
  { id: 41, name: 'yaw_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-05, offset: 116, title: { en: 'Turn rate', de: 'Drehrate' }, doc: 'Turn rate from the encoders, left positive.' },
  { id: 42, name: 'x_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 120, title: { en: 'Position x', de: 'Position x' }, doc: 'Odometry, metres from the start mark.' },
  { id: 43, name: 'y_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 124, title: { en: 'Position y', de: 'Position y' }, doc: 'Odometry, metres from the start mark.' },
  { id: 44, name: 'psi_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 128, title: { en: 'Heading', de: 'Richtung' }, doc: 'Odometry heading, not wrapped, left positive.' },
  { id: 45, name: 'distance_m', type: 'f32', unit: 'm', lsb: 1e-04, offset: 132, title: { en: 'Distance', de: 'Strecke' }, doc: 'Path length since the pose was last set.' },
  { id: 46, name: 'wheel_left_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 136, title: { en: 'Left wheel speed', de: 'Tempo linkes Rad' }, doc: 'Ground speed of the left wheel from its encoder.' },
  { id: 47, name: 'wheel_right_m_s', type: 'f32', unit: 'm/s', lsb: 1e-05, offset: 140, title: { en: 'Right wheel speed', de: 'Tempo rechtes Rad' }, doc: 'Ground speed of the right wheel from its encoder.' },
  { id: 48, name: 'left_counts', type: 'i32', unit: 'counts', lsb: 1, offset: 144, title: { en: 'Left encoder', de: 'Geber links' }, doc: 'Position counter of the left drive.' },
  { id: 49, name: 'right_counts', type: 'i32', unit: 'counts', lsb: 1, offset: 148, title: { en: 'Right encoder', de: 'Geber rechts' }, doc: 'Position counter of the right drive.' },
  { id: 170, name: 'fused_x_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 152, title: { en: 'Position x, slip repaired', de: 'Position x, Schlupf berichtigt' }, doc: 'Track of encoders and gyroscope together, metres from the start mark.' },
  { id: 171, name: 'fused_y_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 156, title: { en: 'Position y, slip repaired', de: 'Position y, Schlupf berichtigt' }, doc: 'Track of encoders and gyroscope together, metres from the start mark.' },
  { id: 172, name: 'fused_psi_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 160, title: { en: 'Heading, slip repaired', de: 'Richtung, Schlupf berichtigt' }, doc: 'Heading of encoders and gyroscope together, not wrapped, left positive.' },
  { id: 173, name: 'fused_yaw_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 164, title: { en: 'Turn rate, slip repaired', de: 'Drehrate, Schlupf berichtigt' }, doc: 'Of the encoders while they grip, of the gyroscope while they do not.' },
  { id: 174, name: 'gyro_bias_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-06, offset: 168, title: { en: 'Chassis turn rate at rest', de: 'Fahrgestell-Drehrate in Ruhe' }, doc: 'Bias of the chassis gyroscope, learnt at standstill and on straight ways.' },
  { id: 175, name: 'slip_rate_rad_s', type: 'f32', unit: 'rad/s', lsb: 1e-04, offset: 172, title: { en: 'Slip', de: 'Schlupf' }, doc: 'How much faster the encoders turn than the gyroscope, smoothed over 50 ms.' },
  { id: 176, name: 'worst_stop_distance_m', type: 'f32', unit: 'm', lsb: 1e-04, offset: 176, title: { en: 'Stopping distance without computer', de: 'Anhalteweg ohne Rechner' }, doc: 'Distance the hoist would roll if the control computer died now and the drives stopped by themselves.' },
  { id: 177, name: 'gait_lean_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 180, title: { en: 'Sway taken from the lean', de: 'Aus der Neigung genommenes Pendeln' }, doc: 'Part of the lean that was taken for gait and removed; 0 while that is off.' },
  { id: 178, name: 'gait_turn_rad', type: 'f32', unit: 'rad', lsb: 1e-05, offset: 184, title: { en: 'Sway taken from the turn', de: 'Aus der Drehung genommenes Pendeln' }, doc: 'Part of the turn that was taken for gait and removed; 0 while that is off.' },
  { id: 179, name: 'gait_sway_m', type: 'f32', unit: 'm', lsb: 1e-05, offset: 188, title: { en: 'Sway of the stride', de: 'Pendeln des Doppelschritts' }, doc: 'Sideways sway at stride frequency as the oscillator follows it; 0 while that is off.' },
  { id: 180, name: 'stride_hz', type: 'f32', unit: 'Hz', lsb: 1e-04, offset: 192, title: { en: 'Stride frequency', de: 'Doppelschritte je Sekunde' }, doc: 'Of the oscillator that follows the gait; 0 while that is off or nobody walks.' },
  { id: 50, name: 'left_current_a', type: 'f32', unit: 'A', lsb: 0.001, offset: 196, title: { en: 'Left motor current', de: 'Motorstrom links' }, doc: 'Motor current of the left drive.' },
  { id: 51, name: 'right_current_a', type: 'f32', unit: 'A', lsb: 0.001, offset: 200, title: { en: 'Right motor current', de: 'Motorstrom rechts' }, doc: 'Motor current of the right drive.' },
  { id: 52, name: 'left_supply_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 204, title: { en: 'Left drive supply', de: 'Versorgung links' }, doc: 'Supply voltage at the left drive.' },
  { id: 53, name: 'right_supply_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 208, title: { en: 'Right drive supply', de: 'Versorgung rechts' }, doc: 'Supply voltage at the right drive.' },
  { id: 54, name: 'battery_a_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 212, title: { en: 'Battery A', de: 'Batterie A' }, doc: 'Voltage of the first battery.' },
  { id: 55, name: 'battery_b_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 216, title: { en: 'Battery B', de: 'Batterie B' }, doc: 'Voltage of the second battery.' },
  { id: 60, name: 'wake_lateness_s', type: 'f32', unit: 's', lsb: 1e-06, offset: 220, title: { en: 'Wake-up lateness', de: 'Verspätung' }, doc: 'How late this step began.' },
  { id: 61, name: 'tick_duration_s', type: 'f32', unit: 's', lsb: 1e-07, offset: 224, title: { en: 'Step duration', de: 'Schrittdauer' }, doc: 'How long the previous step took, bus reading and writing included.' },
  { id: 62, name: 'overruns', type: 'u32', unit: '', lsb: 1, offset: 228, title: { en: 'Late steps', de: 'Verspätete Schritte' }, doc: 'Steps that began more than 2 ms late, since the start of the core.' },
  { id: 205, name: 'lateness_p50_s', type: 'f32', unit: 's', lsb: 1e-06, offset: 232, title: { en: 'Lateness, half of the steps', de: 'Verspätung, Hälfte der Schritte' }, doc: 'Half of the steps of the last ten seconds began no later than this; at most a quarter too high.' },
  { id: 206, name: 'lateness_p99_s', type: 'f32', unit: 's', lsb: 1e-06, offset: 236, title: { en: 'Lateness, 99 of 100 steps', de: 'Verspätung, 99 von 100 Schritten' }, doc: '99 of 100 steps of the last ten seconds began no later than this; at most a quarter too high.' },
  { id: 207, name: 'lateness_max_s', type: 'f32', unit: 's', lsb: 1e-06, offset: 240, title: { en: 'Lateness, latest step', de: 'Verspätung, spätester Schritt' }, doc: 'The latest beginning of a step in the last ten seconds.' },
  { id: 208, name: 'missed_ticks', type: 'u32', unit: '', lsb: 1, offset: 244, title: { en: 'Steps left out', de: 'Ausgelassene Schritte' }, doc: 'Steps that did not take place because one before them began or ended too late, since the start of the core.' },
  { id: 209, name: 'page_faults', type: 'u32', unit: '', lsb: 1, offset: 248, title: { en: 'Page faults', de: 'Seitenfehler' }, doc: 'Times the control thread had to wait for memory since it settled: 0 on a computer that is set up well.' },
  { id: 210, name: 'allocations', type: 'u32', unit: '', lsb: 1, offset: 252, title: { en: 'Memory requests', de: 'Speicheranforderungen' }, doc: 'Times the control thread asked for memory since its first step: always 0.' },
  { id: 190, name: 'calibration_value', type: 'f32', unit: '', lsb: 1e-05, offset: 256, title: { en: 'Calibration: now', de: 'Kalibrierung: jetzt' }, doc: 'What the step under way watches: the movement in rad, the way in m or the turn in rad.' },
  { id: 63, name: 'bus_frames', type: 'u32', unit: '', lsb: 1, offset: 260, title: { en: 'Bus frames', de: 'Busnachrichten' }, doc: 'Frames received since the start of the core.' },
  { id: 64, name: 'bus_refused', type: 'u32', unit: '', lsb: 1, offset: 264, title: { en: 'Refused frames', de: 'Abgelehnte Nachrichten' }, doc: 'Frames refused since the start: unknown id, wrong length, implausible value, broken line.' },
  { id: 65, name: 'commands_refused', type: 'u32', unit: '', lsb: 1, offset: 268, title: { en: 'Refused commands', de: 'Abgelehnte Befehle' }, doc: 'Commands from the server refused since the start.' },
  { id: 66, name: 'fault_bits', type: 'u32', unit: '', lsb: 1, offset: 272, title: { en: 'Active faults', de: 'Aktive Störungen' }, doc: 'One bit per row of the fault table.' },
  { id: 67, name: 'blocked_bits', type: 'u32', unit: '', lsb: 1, offset: 276, title: { en: 'Start blocked by', de: 'Start gesperrt durch' }, doc: 'One bit per row of the refusal table: why motion may not start now.' },
  { id: 68, name: 'lease_epoch', type: 'u32', unit: '', lsb: 1, offset: 280, title: { en: 'Lease number', de: 'Steuerungsnummer' }, doc: 'Rises with every new driver.' },
  { id: 69, name: 'lease_holder', type: 'u32', unit: '', lsb: 1, offset: 284, title: { en: 'Lease holder', de: 'Steuernder' }, doc: 'Client number of the driver, 0 for nobody.' },
  { id: 70, name: 'parameter_version', type: 'u32', unit: '', lsb: 1, offset: 288, title: { en: 'Parameter version', de: 'Parameterstand' }, doc: 'Rises with every accepted parameter change.' },
  { id: 85, name: 'bus_load_norm', type: 'f32', unit: '', lsb: 0.001, offset: 292, title: { en: 'Bus load', de: 'Buslast' }, doc: 'Share of the last second in which the bus was busy, counted with the most stuff bits: at most 18 % of itself too high.' },
  { id: 86, name: 'bus_send_refused', type: 'u32', unit: '', lsb: 1, offset: 296, title: { en: 'Frames not sent', de: 'Nicht gesendete Nachrichten' }, doc: 'Frames of the core that the bus connection did not take, since the start.' },
  { id: 87, name: 'bus_reopened', type: 'u32', unit: '', lsb: 1, offset: 300, title: { en: 'Bus reopened', de: 'Bus neu geöffnet' }, doc: 'Times the bus connection had to be opened again, since the start.' },
  { id: 88, name: 'bus_overflows', type: 'u32', unit: '', lsb: 1, offset: 304, title: { en: 'Frames overrun', de: 'Übergelaufene Nachrichten' }, doc: 'Frames that adapter or kernel lost for want of room, since the start.' },
  { id: 89, name: 'bus_errors', type: 'u32', unit: '', lsb: 1, offset: 308, title: { en: 'Bus errors', de: 'Busfehler' }, doc: 'Error reports of our bus controller, since the start; 0 where it does not tell.' },
  { id: 90, name: 'syncs_lost', type: 'u32', unit: '', lsb: 1, offset: 312, title: { en: 'Lost SYNC messages', de: 'Verlorene SYNC-Nachrichten' }, doc: 'SYNC messages that no node answered, since the start.' },
  { id: 100, name: 'drive_left_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 316, title: { en: 'Left drive: lost frames', de: 'Antrieb links: verlorene Nachrichten' }, doc: 'Frames of this node that should have come and did not, since the start.' },
  { id: 110, name: 'drive_right_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 320, title: { en: 'Right drive: lost frames', de: 'Antrieb rechts: verlorene Nachrichten' }, doc: 'Frames of this node that should have come and did not, since the start.' },
  { id: 120, name: 'io_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 324, title: { en: 'Input node: lost frames', de: 'Eingangsknoten: verlorene Nachrichten' }, doc: 'Frames of this node that should have come and did not, since the start.' },
  { id: 130, name: 'tilt_left_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 328, title: { en: 'Left strut sensor: lost frames', de: 'Sensor links: verlorene Nachrichten' }, doc: 'Frames of this node that should have come and did not, since the start.' },
  { id: 140, name: 'tilt_right_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 332, title: { en: 'Right strut sensor: lost frames', de: 'Sensor rechts: verlorene Nachrichten' }, doc: 'Frames of this node that should have come and did not, since the start.' },
  { id: 150, name: 'tilt_base_lost_frames', type: 'u32', unit: '', lsb: 1, offset: 336, title: { en: 'Chassis sensor: lost frames', de: 'Sensor Fahrgestell: verlorene Nachrichten' }, doc: 'Frames of this node that should have come and did not, since the start.' },
  { id: 71, name: 'left_status_word', type: 'u16', unit: '', lsb: 1, offset: 340, title: { en: 'Left drive status', de: 'Status Antrieb links' }, doc: 'Status word of the left drive, CiA 402 6041h.' },
  { id: 72, name: 'right_status_word', type: 'u16', unit: '', lsb: 1, offset: 342, title: { en: 'Right drive status', de: 'Status Antrieb rechts' }, doc: 'Status word of the right drive, CiA 402 6041h.' },
  { id: 91, name: 'bus_frames_per_s', type: 'u16', unit: '1/s', lsb: 1, offset: 344, title: { en: 'Frames per second', de: 'Nachrichten je Sekunde' }, doc: 'Frames on the bus in the last second, received and sent.' },
  { id: 92, name: 'bus_tx_errors', type: 'u16', unit: '', lsb: 1, offset: 346, title: { en: 'Send error counter', de: 'Sendefehlerzähler' }, doc: 'Error counter of our bus controller for sending, as last told.' },
  { id: 93, name: 'bus_rx_errors', type: 'u16', unit: '', lsb: 1, offset: 348, title: { en: 'Receive error counter', de: 'Empfangsfehlerzähler' }, doc: 'Error counter of our bus controller for receiving, as last told.' },
  { id: 94, name: 'babbling_id', type: 'u16', unit: '', lsb: 1, offset: 350, title: { en: 'Flooding id', de: 'Flutende Kennung' }, doc: 'CAN id that comes far more often than planned; 65535 for none.' },
  { id: 101, name: 'drive_left_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 352, title: { en: 'Left drive: emergency', de: 'Antrieb links: Notmeldung' }, doc: 'Code of the latest emergency message (table of emergencies); 0 for none since the start.' },
  { id: 102, name: 'drive_left_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 354, title: { en: 'Left drive: emergencies', de: 'Antrieb links: Notmeldungen' }, doc: 'Emergency messages since the start, without those that say that an error has ended.' },
  { id: 111, name: 'drive_right_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 356, title: { en: 'Right drive: emergency', de: 'Antrieb rechts: Notmeldung' }, doc: 'Code of the latest emergency message (table of emergencies); 0 for none since the start.' },
  { id: 112, name: 'drive_right_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 358, title: { en: 'Right drive: emergencies', de: 'Antrieb rechts: Notmeldungen' }, doc: 'Emergency messages since the start, without those that say that an error has ended.' },
  { id: 121, name: 'io_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 360, title: { en: 'Input node: emergency', de: 'Eingangsknoten: Notmeldung' }, doc: 'Code of the latest emergency message (table of emergencies); 0 for none since the start.' },
  { id: 122, name: 'io_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 362, title: { en: 'Input node: emergencies', de: 'Eingangsknoten: Notmeldungen' }, doc: 'Emergency messages since the start, without those that say that an error has ended.' },
  { id: 131, name: 'tilt_left_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 364, title: { en: 'Left strut sensor: emergency', de: 'Sensor links: Notmeldung' }, doc: 'Code of the latest emergency message (table of emergencies); 0 for none since the start.' },
  { id: 132, name: 'tilt_left_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 366, title: { en: 'Left strut sensor: emergencies', de: 'Sensor links: Notmeldungen' }, doc: 'Emergency messages since the start, without those that say that an error has ended.' },
  { id: 141, name: 'tilt_right_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 368, title: { en: 'Right strut sensor: emergency', de: 'Sensor rechts: Notmeldung' }, doc: 'Code of the latest emergency message (table of emergencies); 0 for none since the start.' },
  { id: 142, name: 'tilt_right_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 370, title: { en: 'Right strut sensor: emergencies', de: 'Sensor rechts: Notmeldungen' }, doc: 'Emergency messages since the start, without those that say that an error has ended.' },
  { id: 151, name: 'tilt_base_emcy_code', type: 'u16', unit: '', lsb: 1, offset: 372, title: { en: 'Chassis sensor: emergency', de: 'Sensor Fahrgestell: Notmeldung' }, doc: 'Code of the latest emergency message (table of emergencies); 0 for none since the start.' },
  { id: 152, name: 'tilt_base_emcy_count', type: 'u16', unit: '', lsb: 1, offset: 374, title: { en: 'Chassis sensor: emergencies', de: 'Sensor Fahrgestell: Notmeldungen' }, doc: 'Emergency messages since the start, without those that say that an error has ended.' },
  { id: 73, name: 'mode', type: 'u8', unit: '', lsb: 1, offset: 376, title: { en: 'Mode', de: 'Betriebsart' }, doc: 'Row of the mode table.' },
  { id: 74, name: 'stop_cause', type: 'u8', unit: '', lsb: 1, offset: 377, title: { en: 'Stop cause', de: 'Haltegrund' }, doc: 'Fault that caused the latest protective stop, plus one; 0 for none.' },
  { id: 75, name: 'bumpers', type: 'u8', unit: '', lsb: 1, offset: 378, title: { en: 'Bumpers', de: 'Stoßfänger' }, doc: 'Bit 0 front, 1 rear, 2 left, 3 right: pressed.' },
  { id: 76, name: 'simulated', type: 'u8', unit: '', lsb: 1, offset: 379, title: { en: 'Simulated', de: 'Simuliert' }, doc: '1 when any node says that it is a simulated build.' },
  { id: 77, name: 'tilt_left_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 380, title: { en: 'Left strut sensor age', de: 'Alter Sensor links' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 78, name: 'tilt_right_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 381, title: { en: 'Right strut sensor age', de: 'Alter Sensor rechts' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 79, name: 'tilt_base_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 382, title: { en: 'Chassis sensor age', de: 'Alter Sensor Fahrgestell' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 80, name: 'drive_left_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 383, title: { en: 'Left drive age', de: 'Alter Antrieb links' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 81, name: 'drive_right_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 384, title: { en: 'Right drive age', de: 'Alter Antrieb rechts' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 82, name: 'io_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 385, title: { en: 'Input node age', de: 'Alter Eingangsknoten' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 83, name: 'server_alive', type: 'u8', unit: '', lsb: 1, offset: 386, title: { en: 'Console server', de: 'Konsolenserver' }, doc: '1 while the server\'s heartbeat is younger than 250 ms.' },
  { id: 181, name: 'slip_state', type: 'u8', unit: '', lsb: 1, offset: 387, title: { en: 'Slip state', de: 'Schlupfzustand' }, doc: 'Bit 0: the wheels slip; bit 1: the track is the encoders\' alone, without the gyroscope.' },
  { id: 84, name: 'standing_still', type: 'u8', unit: '', lsb: 1, offset: 388, title: { en: 'Standing still', de: 'Steht still' }, doc: '1 while both wheels turn slower than 0.02 m/s.' },
  { id: 211, name: 'loop_priority', type: 'u8', unit: '', lsb: 1, offset: 389, title: { en: 'Real-time priority', de: 'Echtzeitpriorität' }, doc: 'Priority of the control thread under SCHED_FIFO; 0 when the computer did not grant it.' },
  { id: 212, name: 'loop_cpu', type: 'u8', unit: '', lsb: 1, offset: 390, title: { en: 'Own processor core', de: 'Eigener Prozessorkern' }, doc: 'Processor core that the control thread is bound to; 255 for none.' },
  { id: 213, name: 'memory_locked', type: 'u8', unit: '', lsb: 1, offset: 391, title: { en: 'Memory locked', de: 'Speicher verriegelt' }, doc: '1 when the memory of the core cannot be taken away from it.' },
  { id: 214, name: 'relay_feed', type: 'u8', unit: '', lsb: 1, offset: 392, title: { en: 'Relay feed', de: 'Relais-Speisung' }, doc: 'Level of the output that keeps the motors\' relay closed, as sent last; the relay opens when it no longer changes.' },
  { id: 95, name: 'bus_state', type: 'u8', unit: '', lsb: 1, offset: 393, title: { en: 'Bus controller', de: 'Buscontroller' }, doc: 'What our bus controller says of itself: 0 active, 1 warning, 2 passive, 3 off.' },
  { id: 96, name: 'bus_up', type: 'u8', unit: '', lsb: 1, offset: 394, title: { en: 'Bus connected', de: 'Bus verbunden' }, doc: '1 while frames can pass.' },
  { id: 97, name: 'duplicate_id', type: 'u8', unit: '', lsb: 1, offset: 395, title: { en: 'Doubled node number', de: 'Doppelte Knotennummer' }, doc: 'Node id under which two devices answer, 127 when a second control computer is on the bus; 0 for none.' },
  { id: 191, name: 'calibration_step', type: 'u8', unit: '', lsb: 1, offset: 396, title: { en: 'Calibration step', de: 'Kalibrierschritt' }, doc: 'Row of the table of calibration steps; 0 for none.' },
  { id: 192, name: 'calibration_phase', type: 'u8', unit: '', lsb: 1, offset: 397, title: { en: 'Calibration phase', de: 'Kalibrierphase' }, doc: '0 none, 1 waits for rest, 2 measures, 3 waits for the operator, 4 has a result, 5 refused.' },
  { id: 193, name: 'calibration_done_percent', type: 'u8', unit: '%', lsb: 1, offset: 398, title: { en: 'Calibration progress', de: 'Kalibrierfortschritt' }, doc: 'How far the measurement under way is.' },
  { id: 194, name: 'calibration_reason', type: 'u8', unit: '', lsb: 1, offset: 399, title: { en: 'Calibration reason', de: 'Kalibriergrund' }, doc: 'Row of the table of reasons: why the last measurement was refused; 0 for none.' },
  { id: 103, name: 'drive_left_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 400, title: { en: 'Left drive: state', de: 'Antrieb links: Zustand' }, doc: 'State in its latest heartbeat: 0 starting, 4 stopped, 5 working, 127 waiting; 255 before the first one.' },
  { id: 104, name: 'drive_left_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 401, title: { en: 'Left drive: heartbeats missed', de: 'Antrieb links: fehlende Lebenszeichen' }, doc: 'Heartbeats in a row that should have come by now, 25 at most.' },
  { id: 105, name: 'drive_left_error_register', type: 'u8', unit: '', lsb: 1, offset: 402, title: { en: 'Left drive: error register', de: 'Antrieb links: Fehlerregister' }, doc: 'Object 1001h as its latest emergency message told it; 0 while no error is active.' },
  { id: 106, name: 'drive_left_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 403, title: { en: 'Left drive: lost lately', de: 'Antrieb links: zuletzt verloren' }, doc: 'Lost frames in the last ten seconds, 255 at most.' },
  { id: 113, name: 'drive_right_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 404, title: { en: 'Right drive: state', de: 'Antrieb rechts: Zustand' }, doc: 'State in its latest heartbeat: 0 starting, 4 stopped, 5 working, 127 waiting; 255 before the first one.' },
  { id: 114, name: 'drive_right_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 405, title: { en: 'Right drive: heartbeats missed', de: 'Antrieb rechts: fehlende Lebenszeichen' }, doc: 'Heartbeats in a row that should have come by now, 25 at most.' },
  { id: 115, name: 'drive_right_error_register', type: 'u8', unit: '', lsb: 1, offset: 406, title: { en: 'Right drive: error register', de: 'Antrieb rechts: Fehlerregister' }, doc: 'Object 1001h as its latest emergency message told it; 0 while no error is active.' },
  { id: 116, name: 'drive_right_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 407, title: { en: 'Right drive: lost lately', de: 'Antrieb rechts: zuletzt verloren' }, doc: 'Lost frames in the last ten seconds, 255 at most.' },
  { id: 123, name: 'io_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 408, title: { en: 'Input node: state', de: 'Eingangsknoten: Zustand' }, doc: 'State in its latest heartbeat: 0 starting, 4 stopped, 5 working, 127 waiting; 255 before the first one.' },
  { id: 124, name: 'io_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 409, title: { en: 'Input node: heartbeats missed', de: 'Eingangsknoten: fehlende Lebenszeichen' }, doc: 'Heartbeats in a row that should have come by now, 25 at most.' },
  { id: 125, name: 'io_error_register', type: 'u8', unit: '', lsb: 1, offset: 410, title: { en: 'Input node: error register', de: 'Eingangsknoten: Fehlerregister' }, doc: 'Object 1001h as its latest emergency message told it; 0 while no error is active.' },
  { id: 126, name: 'io_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 411, title: { en: 'Input node: lost lately', de: 'Eingangsknoten: zuletzt verloren' }, doc: 'Lost frames in the last ten seconds, 255 at most.' },
  { id: 133, name: 'tilt_left_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 412, title: { en: 'Left strut sensor: state', de: 'Sensor links: Zustand' }, doc: 'State in its latest heartbeat: 0 starting, 4 stopped, 5 working, 127 waiting; 255 before the first one.' },
  { id: 134, name: 'tilt_left_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 413, title: { en: 'Left strut sensor: heartbeats missed', de: 'Sensor links: fehlende Lebenszeichen' }, doc: 'Heartbeats in a row that should have come by now, 25 at most.' },
  { id: 135, name: 'tilt_left_error_register', type: 'u8', unit: '', lsb: 1, offset: 414, title: { en: 'Left strut sensor: error register', de: 'Sensor links: Fehlerregister' }, doc: 'Object 1001h as its latest emergency message told it; 0 while no error is active.' },
  { id: 136, name: 'tilt_left_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 415, title: { en: 'Left strut sensor: lost lately', de: 'Sensor links: zuletzt verloren' }, doc: 'Lost frames in the last ten seconds, 255 at most.' },
  { id: 143, name: 'tilt_right_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 416, title: { en: 'Right strut sensor: state', de: 'Sensor rechts: Zustand' }, doc: 'State in its latest heartbeat: 0 starting, 4 stopped, 5 working, 127 waiting; 255 before the first one.' },
  { id: 144, name: 'tilt_right_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 417, title: { en: 'Right strut sensor: heartbeats missed', de: 'Sensor rechts: fehlende Lebenszeichen' }, doc: 'Heartbeats in a row that should have come by now, 25 at most.' },
  { id: 145, name: 'tilt_right_error_register', type: 'u8', unit: '', lsb: 1, offset: 418, title: { en: 'Right strut sensor: error register', de: 'Sensor rechts: Fehlerregister' }, doc: 'Object 1001h as its latest emergency message told it; 0 while no error is active.' },
  { id: 146, name: 'tilt_right_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 419, title: { en: 'Right strut sensor: lost lately', de: 'Sensor rechts: zuletzt verloren' }, doc: 'Lost frames in the last ten seconds, 255 at most.' },
  { id: 153, name: 'tilt_base_nmt_state', type: 'u8', unit: '', lsb: 1, offset: 420, title: { en: 'Chassis sensor: state', de: 'Sensor Fahrgestell: Zustand' }, doc: 'State in its latest heartbeat: 0 starting, 4 stopped, 5 working, 127 waiting; 255 before the first one.' },
  { id: 154, name: 'tilt_base_heartbeats_missed', type: 'u8', unit: '', lsb: 1, offset: 421, title: { en: 'Chassis sensor: heartbeats missed', de: 'Sensor Fahrgestell: fehlende Lebenszeichen' }, doc: 'Heartbeats in a row that should have come by now, 25 at most.' },
  { id: 155, name: 'tilt_base_error_register', type: 'u8', unit: '', lsb: 1, offset: 422, title: { en: 'Chassis sensor: error register', de: 'Sensor Fahrgestell: Fehlerregister' }, doc: 'Object 1001h as its latest emergency message told it; 0 while no error is active.' },
  { id: 156, name: 'tilt_base_lost_10s', type: 'u8', unit: '', lsb: 1, offset: 423, title: { en: 'Chassis sensor: lost lately', de: 'Sensor Fahrgestell: zuletzt verloren' }, doc: 'Lost frames in the last ten seconds, 255 at most.' },
];
