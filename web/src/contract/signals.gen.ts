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
  | 'left_current_a'
  | 'right_current_a'
  | 'left_supply_v'
  | 'right_supply_v'
  | 'battery_a_v'
  | 'battery_b_v'
  | 'wake_lateness_s'
  | 'tick_duration_s'
  | 'overruns'
  | 'bus_frames'
  | 'bus_refused'
  | 'commands_refused'
  | 'fault_bits'
  | 'blocked_bits'
  | 'lease_epoch'
  | 'lease_holder'
  | 'parameter_version'
  | 'left_status_word'
  | 'right_status_word'
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
  | 'standing_still';

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

export const tickRecordBytes = 240;

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
    left_current_a: view.getFloat32(at + 152, true),
    right_current_a: view.getFloat32(at + 156, true),
    left_supply_v: view.getFloat32(at + 160, true),
    right_supply_v: view.getFloat32(at + 164, true),
    battery_a_v: view.getFloat32(at + 168, true),
    battery_b_v: view.getFloat32(at + 172, true),
    wake_lateness_s: view.getFloat32(at + 176, true),
    tick_duration_s: view.getFloat32(at + 180, true),
    overruns: view.getUint32(at + 184, true),
    bus_frames: view.getUint32(at + 188, true),
    bus_refused: view.getUint32(at + 192, true),
    commands_refused: view.getUint32(at + 196, true),
    fault_bits: view.getUint32(at + 200, true),
    blocked_bits: view.getUint32(at + 204, true),
    lease_epoch: view.getUint32(at + 208, true),
    lease_holder: view.getUint32(at + 212, true),
    parameter_version: view.getUint32(at + 216, true),
    left_status_word: view.getUint16(at + 220, true),
    right_status_word: view.getUint16(at + 222, true),
    mode: view.getUint8(at + 224),
    stop_cause: view.getUint8(at + 225),
    bumpers: view.getUint8(at + 226),
    simulated: view.getUint8(at + 227),
    tilt_left_age_ticks: view.getUint8(at + 228),
    tilt_right_age_ticks: view.getUint8(at + 229),
    tilt_base_age_ticks: view.getUint8(at + 230),
    drive_left_age_ticks: view.getUint8(at + 231),
    drive_right_age_ticks: view.getUint8(at + 232),
    io_age_ticks: view.getUint8(at + 233),
    server_alive: view.getUint8(at + 234),
    standing_still: view.getUint8(at + 235),
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
  { id: 37, name: 'stop_distance_m', type: 'f32', unit: 'm', lsb: 1e-04, offset: 108, title: { en: 'Stopping distance', de: 'Anhalteweg' }, doc: 'Distance the hoist would roll if everything were let go now.' },
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
  { id: 50, name: 'left_current_a', type: 'f32', unit: 'A', lsb: 0.001, offset: 152, title: { en: 'Left motor current', de: 'Motorstrom links' }, doc: 'Motor current of the left drive.' },
  { id: 51, name: 'right_current_a', type: 'f32', unit: 'A', lsb: 0.001, offset: 156, title: { en: 'Right motor current', de: 'Motorstrom rechts' }, doc: 'Motor current of the right drive.' },
  { id: 52, name: 'left_supply_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 160, title: { en: 'Left drive supply', de: 'Versorgung links' }, doc: 'Supply voltage at the left drive.' },
  { id: 53, name: 'right_supply_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 164, title: { en: 'Right drive supply', de: 'Versorgung rechts' }, doc: 'Supply voltage at the right drive.' },
  { id: 54, name: 'battery_a_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 168, title: { en: 'Battery A', de: 'Batterie A' }, doc: 'Voltage of the first battery.' },
  { id: 55, name: 'battery_b_v', type: 'f32', unit: 'V', lsb: 0.01, offset: 172, title: { en: 'Battery B', de: 'Batterie B' }, doc: 'Voltage of the second battery.' },
  { id: 60, name: 'wake_lateness_s', type: 'f32', unit: 's', lsb: 1e-06, offset: 176, title: { en: 'Wake-up lateness', de: 'Verspätung' }, doc: 'How late this step began.' },
  { id: 61, name: 'tick_duration_s', type: 'f32', unit: 's', lsb: 1e-07, offset: 180, title: { en: 'Step duration', de: 'Schrittdauer' }, doc: 'How long the previous step took, bus reading and writing included.' },
  { id: 62, name: 'overruns', type: 'u32', unit: '', lsb: 1, offset: 184, title: { en: 'Late steps', de: 'Verspätete Schritte' }, doc: 'Steps that began more than 5 ms late, since the start of the core.' },
  { id: 63, name: 'bus_frames', type: 'u32', unit: '', lsb: 1, offset: 188, title: { en: 'Bus frames', de: 'Busnachrichten' }, doc: 'Frames received since the start of the core.' },
  { id: 64, name: 'bus_refused', type: 'u32', unit: '', lsb: 1, offset: 192, title: { en: 'Refused frames', de: 'Abgelehnte Nachrichten' }, doc: 'Frames refused since the start: unknown id, wrong length, implausible value, broken line.' },
  { id: 65, name: 'commands_refused', type: 'u32', unit: '', lsb: 1, offset: 196, title: { en: 'Refused commands', de: 'Abgelehnte Befehle' }, doc: 'Commands from the server refused since the start.' },
  { id: 66, name: 'fault_bits', type: 'u32', unit: '', lsb: 1, offset: 200, title: { en: 'Active faults', de: 'Aktive Störungen' }, doc: 'One bit per row of the fault table.' },
  { id: 67, name: 'blocked_bits', type: 'u32', unit: '', lsb: 1, offset: 204, title: { en: 'Start blocked by', de: 'Start gesperrt durch' }, doc: 'One bit per row of the refusal table: why motion may not start now.' },
  { id: 68, name: 'lease_epoch', type: 'u32', unit: '', lsb: 1, offset: 208, title: { en: 'Lease number', de: 'Steuerungsnummer' }, doc: 'Rises with every new driver.' },
  { id: 69, name: 'lease_holder', type: 'u32', unit: '', lsb: 1, offset: 212, title: { en: 'Lease holder', de: 'Steuernder' }, doc: 'Client number of the driver, 0 for nobody.' },
  { id: 70, name: 'parameter_version', type: 'u32', unit: '', lsb: 1, offset: 216, title: { en: 'Parameter version', de: 'Parameterstand' }, doc: 'Rises with every accepted parameter change.' },
  { id: 71, name: 'left_status_word', type: 'u16', unit: '', lsb: 1, offset: 220, title: { en: 'Left drive status', de: 'Status Antrieb links' }, doc: 'Status word of the left drive, CiA 402 6041h.' },
  { id: 72, name: 'right_status_word', type: 'u16', unit: '', lsb: 1, offset: 222, title: { en: 'Right drive status', de: 'Status Antrieb rechts' }, doc: 'Status word of the right drive, CiA 402 6041h.' },
  { id: 73, name: 'mode', type: 'u8', unit: '', lsb: 1, offset: 224, title: { en: 'Mode', de: 'Betriebsart' }, doc: 'Row of the mode table.' },
  { id: 74, name: 'stop_cause', type: 'u8', unit: '', lsb: 1, offset: 225, title: { en: 'Stop cause', de: 'Haltegrund' }, doc: 'Fault that caused the latest protective stop, plus one; 0 for none.' },
  { id: 75, name: 'bumpers', type: 'u8', unit: '', lsb: 1, offset: 226, title: { en: 'Bumpers', de: 'Stoßfänger' }, doc: 'Bit 0 front, 1 rear, 2 left, 3 right: pressed.' },
  { id: 76, name: 'simulated', type: 'u8', unit: '', lsb: 1, offset: 227, title: { en: 'Simulated', de: 'Simuliert' }, doc: '1 when any node says that it is a simulated build.' },
  { id: 77, name: 'tilt_left_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 228, title: { en: 'Left strut sensor age', de: 'Alter Sensor links' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 78, name: 'tilt_right_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 229, title: { en: 'Right strut sensor age', de: 'Alter Sensor rechts' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 79, name: 'tilt_base_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 230, title: { en: 'Chassis sensor age', de: 'Alter Sensor Fahrgestell' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 80, name: 'drive_left_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 231, title: { en: 'Left drive age', de: 'Alter Antrieb links' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 81, name: 'drive_right_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 232, title: { en: 'Right drive age', de: 'Alter Antrieb rechts' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 82, name: 'io_age_ticks', type: 'u8', unit: 'ticks', lsb: 1, offset: 233, title: { en: 'Input node age', de: 'Alter Eingangsknoten' }, doc: 'Steps since the last fresh frame, 255 at most.' },
  { id: 83, name: 'server_alive', type: 'u8', unit: '', lsb: 1, offset: 234, title: { en: 'Console server', de: 'Konsolenserver' }, doc: '1 while the server\'s heartbeat is younger than 250 ms.' },
  { id: 84, name: 'standing_still', type: 'u8', unit: '', lsb: 1, offset: 235, title: { en: 'Standing still', de: 'Steht still' }, doc: '1 while both wheels turn slower than 0.02 m/s.' },
];
