// Made by `deploy/dev gen` from control/contract/params.def; do not edit.

export interface Words {
  en: string;
  de: string;
}

export type ParamName =
  | 'strut_length_m'
  | 'strut_spacing_m'
  | 'track_width_m'
  | 'wheel_radius_m'
  | 'encoder_counts_per_turn'
  | 'wheel_left_scale_norm'
  | 'wheel_right_scale_norm'
  | 'lean_range_rad'
  | 'turn_range_rad'
  | 'neutral_lean_m'
  | 'neutral_turn_rad'
  | 'lean_dead_band_norm'
  | 'lean_tau_normal_s'
  | 'lean_tau_release_s'
  | 'braking_softness_norm'
  | 'reversal_gain_norm'
  | 'lean_gain_direct_units'
  | 'lean_gain_filtered_units'
  | 'lean_filtered_units_max'
  | 'speed_per_unit_m_s'
  | 'turn_dead_band_norm'
  | 'turn_tau_normal_s'
  | 'turn_tau_release_s'
  | 'turn_gain_direct_units'
  | 'turn_gain_filtered_units'
  | 'yaw_rate_per_unit_rad_s'
  | 'speed_m_s_max'
  | 'yaw_rate_rad_s_max'
  | 'acceleration_m_s2_max'
  | 'jerk_m_s3_max'
  | 'yaw_acceleration_rad_s2_max'
  | 'speed_cap_norm'
  | 'protective_deceleration_m_s2'
  | 'bumper_deceleration_m_s2'
  | 'remote_speed_m_s_max'
  | 'remote_yaw_rate_rad_s_max'
  | 'remote_slow_age_s'
  | 'remote_stop_age_s'
  | 'guided_length_m_max'
  | 'guided_deviation_m_max'
  | 'guided_lag_start_rad'
  | 'fall_tilt_rad'
  | 'fall_rate_rad_s'
  | 'fall_static_tilt_rad'
  | 'fall_static_s'
  | 'battery_low_v'
  | 'battery_empty_v'
  | 'neutral_start_tolerance_norm'
  | 'loop_late_s_max'
  | 'base_tilt_slow_rad'
  | 'base_tilt_stop_rad'
  | 'base_tilt_speed_m_s_max'
  | 'hang_tilt_rad'
  | 'hang_tilt_s'
  | 'hang_speed_m_s'
  | 'hang_still_s'
  | 'hang_sway_m'
  | 'battery_uneven_v'
  | 'tilt_rad_max'
  | 'tilt_rate_rad_s_max'
  | 'strut_apart_rad_max'
  | 'strut_twist_rad_max'
  | 'overspeed_margin_m_s'
  | 'following_error_m_s_max'
  | 'following_error_s'
  | 'drift_rad_max'
  | 'fault_stops_max'
  | 'fault_stops_window_s'
  | 'slip_stop_s'
  | 'cadence_cancel_norm'
  | 'drive_velocity_gain_v_s_rad'
  | 'drive_velocity_integral_v_rad'
  | 'drive_current_limit_a'
  | 'drive_acceleration_rad_s2'
  | 'tilt_kalman_angle_norm'
  | 'tilt_kalman_bias_per_s'
  | 'bus_load_norm_max'
  | 'left_alpha_zero_rad'
  | 'left_beta_zero_rad'
  | 'right_alpha_zero_rad'
  | 'right_beta_zero_rad'
  | 'base_alpha_zero_rad'
  | 'base_beta_zero_rad'
  | 'base_yaw_bias_rad_s'
  | 'calibrated_zero_s'
  | 'calibrated_neutral_s'
  | 'calibrated_gyro_s'
  | 'calibrated_strut_length_s'
  | 'calibrated_strut_spacing_s'
  | 'calibrated_wheel_radius_s'
  | 'calibrated_track_s'
  | 'calibrated_square_s'
  | 'calibrated_encoders_s'
  | 'calibrated_bumpers_s'
  | 'calibrated_struts_s'
  | 'calibrated_nodes_id';

export interface ParamInfo {
  id: number;
  name: ParamName;
  unit: string;
  min: number;
  default: number;
  max: number;
  /** live: also while moving; stopped: only when the hoist stands still on standby. */
  edit: 'live' | 'stopped';
  scope: 'core' | 'drive' | 'tilt';
  /** Who may change it. */
  role: 'viewer' | 'therapist' | 'engineer';
  source: string;
  title: Words;
  effect: Words;
}

export const params: readonly ParamInfo[] = [
  {
    id: 1, name: 'strut_length_m', unit: 'm', min: 0.3, default: 0.8, max: 1.5,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'assumed; d in eq (1)',
    title: { en: 'Strut length', de: 'Strebenlänge' },
    effect: { en: 'Height of the support bar above the ball joints.', de: 'Höhe des Haltebügels über den Kugelgelenken.' },
  },
  {
    id: 2, name: 'strut_spacing_m', unit: 'm', min: 0.2, default: 0.6, max: 1.2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'assumed; d_s in eq (3)',
    title: { en: 'Strut spacing', de: 'Strebenabstand' },
    effect: { en: 'Distance between the two struts.', de: 'Abstand der beiden Streben.' },
  },
  {
    id: 3, name: 'track_width_m', unit: 'm', min: 0.3, default: 0.7, max: 1.2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'assumed; d_ww in eq (20)',
    title: { en: 'Track width', de: 'Spurweite' },
    effect: { en: 'Distance between the driven wheels.', de: 'Abstand der Antriebsräder.' },
  },
  {
    id: 4, name: 'wheel_radius_m', unit: 'm', min: 0.03, default: 0.1, max: 0.3,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'assumed',
    title: { en: 'Wheel radius', de: 'Radradius' },
    effect: { en: 'Rolling radius of the driven wheels.', de: 'Rollradius der Antriebsräder.' },
  },
  {
    id: 5, name: 'encoder_counts_per_turn', unit: 'counts', min: 100, default: 60000, max: 1e+07,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'assumed; 2000 counts at the motor, gear 30',
    title: { en: 'Encoder counts per wheel turn', de: 'Geberimpulse je Radumdrehung' },
    effect: { en: 'Counts of one full turn of a driven wheel.', de: 'Impulse einer vollen Umdrehung eines Antriebsrads.' },
  },
  {
    id: 6, name: 'wheel_left_scale_norm', unit: '', min: 0.9, default: 1, max: 1.1,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration; K_p>m per wheel, eq (19)',
    title: { en: 'Left wheel correction', de: 'Korrektur linkes Rad' },
    effect: { en: 'Corrects the distance counted by the left wheel.', de: 'Korrigiert die gezählte Strecke des linken Rads.' },
  },
  {
    id: 7, name: 'wheel_right_scale_norm', unit: '', min: 0.9, default: 1, max: 1.1,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration; K_p>m per wheel, eq (19)',
    title: { en: 'Right wheel correction', de: 'Korrektur rechtes Rad' },
    effect: { en: 'Corrects the distance counted by the right wheel.', de: 'Korrigiert die gezählte Strecke des rechten Rads.' },
  },
  {
    id: 10, name: 'lean_range_rad', unit: 'rad', min: 0.0698132, default: 0.157079633, max: 0.261799388,
    edit: 'stopped', scope: 'core', role: 'therapist', source: 'SOURCES 3, simulated: 9 deg, one below the guards',
    title: { en: 'Lean for full speed', de: 'Neigung für volle Fahrt' },
    effect: { en: 'How far the patient leans for full effect. Smaller: less lean needed.', de: 'Wie weit sich der Patient für volle Wirkung neigt. Kleiner: weniger Neigung nötig.' },
  },
  {
    id: 11, name: 'turn_range_rad', unit: 'rad', min: 0.0698132, default: 0.174532925, max: 0.261799388,
    edit: 'stopped', scope: 'core', role: 'therapist', source: 'SOURCES 3: strut angle of a full turn, 10 deg',
    title: { en: 'Strut angle for full turn', de: 'Strebenwinkel für volle Drehung' },
    effect: { en: 'How far the struts twist against each other for a full turn.', de: 'Wie weit sich die Streben für eine volle Drehung gegeneinander neigen.' },
  },
  {
    id: 12, name: 'neutral_lean_m', unit: 'm', min: -0.1, default: 0, max: 0.1,
    edit: 'stopped', scope: 'core', role: 'therapist', source: 'captured with the patient strapped in; dx0 in D5',
    title: { en: 'Neutral lean', de: 'Neutrale Neigung' },
    effect: { en: 'Where the patient stands upright. Set by "Set neutral".', de: 'Wo der Patient aufrecht steht. Wird mit "Neutral setzen" erfasst.' },
  },
  {
    id: 13, name: 'neutral_turn_rad', unit: 'rad', min: -0.2, default: 0, max: 0.2,
    edit: 'stopped', scope: 'core', role: 'therapist', source: 'captured with the patient strapped in; dpsi0 in D5',
    title: { en: 'Neutral turn', de: 'Neutrale Drehung' },
    effect: { en: 'Where the pelvis points straight ahead. Set by "Set neutral".', de: 'Wo das Becken geradeaus zeigt. Wird mit "Neutral setzen" erfasst.' },
  },
  {
    id: 20, name: 'lean_dead_band_norm', unit: '', min: 0, default: 0.05, max: 0.5,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, D_x',
    title: { en: 'Standing zone', de: 'Stehzone' },
    effect: { en: 'Lean that is ignored. Larger: stands more calmly, reacts later.', de: 'Neigung, die ignoriert wird. Größer: steht ruhiger, reagiert später.' },
  },
  {
    id: 21, name: 'lean_tau_normal_s', unit: 's', min: 0.5, default: 10, max: 60,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, tau_n',
    title: { en: 'Speed build-up time', de: 'Zeit für den Tempoaufbau' },
    effect: { en: 'How slowly speed builds up while leaning. Larger: gentler.', de: 'Wie langsam sich das Tempo beim Neigen aufbaut. Größer: sanfter.' },
  },
  {
    id: 22, name: 'lean_tau_release_s', unit: 's', min: 0.1, default: 2, max: 20,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, tau_dec',
    title: { en: 'Roll-out time', de: 'Ausrollzeit' },
    effect: { en: 'How long the hoist rolls on when the patient stands upright.', de: 'Wie lange das Gerät ausrollt, wenn der Patient aufrecht steht.' },
  },
  {
    id: 23, name: 'braking_softness_norm', unit: '', min: 0.5, default: 2, max: 50,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, L_dec, Fig. 2',
    title: { en: 'Braking softness', de: 'Bremsweichheit' },
    effect: { en: 'How softly leaning back brakes. Above 5 a light lean brakes less than standing upright.', de: 'Wie weich Zurücklehnen bremst. Über 5 bremst leichtes Lehnen schwächer als aufrechtes Stehen.' },
  },
  {
    id: 24, name: 'reversal_gain_norm', unit: '', min: 0, default: 1e-04, max: 0.01,
    edit: 'live', scope: 'core', role: 'engineer', source: 'paper U6, K_2,r',
    title: { en: 'Reversal gain', de: 'Umkehrverstärkung' },
    effect: { en: 'Share of the lean that feeds the build-up while braking.', de: 'Anteil der Neigung, der beim Bremsen in den Tempoaufbau eingeht.' },
  },
  {
    id: 25, name: 'lean_gain_direct_units', unit: 'units', min: 0, default: 2, max: 10,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, K_P',
    title: { en: 'Immediate response', de: 'Direkte Wirkung' },
    effect: { en: 'How much speed follows the lean at once.', de: 'Wie viel Tempo der Neigung sofort folgt.' },
  },
  {
    id: 26, name: 'lean_gain_filtered_units', unit: 'units', min: 0, default: 50, max: 100,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, K_P,f',
    title: { en: 'Build-up strength', de: 'Stärke des Tempoaufbaus' },
    effect: { en: 'How much speed builds up over time while leaning.', de: 'Wie viel Tempo sich beim Neigen mit der Zeit aufbaut.' },
  },
  {
    id: 27, name: 'lean_filtered_units_max', unit: 'units', min: 1, default: 20, max: 100,
    edit: 'live', scope: 'core', role: 'therapist', source: 'SOURCES 3, v_f,max: 20 units of 0.03 m/s = 0.6 m/s',
    title: { en: 'Largest built-up speed', de: 'Größtes aufgebautes Tempo' },
    effect: { en: 'Upper end of the speed that builds up.', de: 'Obergrenze des aufgebauten Tempos.' },
  },
  {
    id: 28, name: 'speed_per_unit_m_s', unit: 'm/s', min: 0.002, default: 0.03, max: 0.05,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 3, s_v (D18)',
    title: { en: 'Speed per unit', de: 'Tempo je Einheit' },
    effect: { en: 'Metres per second of one controller unit.', de: 'Meter pro Sekunde je Reglereinheit.' },
  },
  {
    id: 30, name: 'turn_dead_band_norm', unit: '', min: 0, default: 0.05, max: 0.5,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, D_psi',
    title: { en: 'Straight-ahead zone', de: 'Geradeauszone' },
    effect: { en: 'Pelvis turn that is ignored. Larger: walks straighter.', de: 'Beckendrehung, die ignoriert wird. Größer: geht gerader.' },
  },
  {
    id: 31, name: 'turn_tau_normal_s', unit: 's', min: 0.1, default: 2, max: 20,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, tau_psi,n',
    title: { en: 'Turn build-up time', de: 'Zeit für den Drehaufbau' },
    effect: { en: 'How slowly a turn builds up. Larger: gentler curves.', de: 'Wie langsam sich eine Drehung aufbaut. Größer: sanftere Kurven.' },
  },
  {
    id: 32, name: 'turn_tau_release_s', unit: 's', min: 0.02, default: 0.1, max: 5,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, tau_psi,dec',
    title: { en: 'Turn release time', de: 'Auslaufzeit der Drehung' },
    effect: { en: 'How quickly turning ends when the pelvis points ahead.', de: 'Wie schnell die Drehung endet, wenn das Becken geradeaus zeigt.' },
  },
  {
    id: 33, name: 'turn_gain_direct_units', unit: 'units', min: 0, default: 2, max: 10,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, K_psi,P',
    title: { en: 'Immediate turn', de: 'Direkte Drehung' },
    effect: { en: 'How much turning follows the pelvis at once.', de: 'Wie viel Drehung dem Becken sofort folgt.' },
  },
  {
    id: 34, name: 'turn_gain_filtered_units', unit: 'units', min: 0, default: 50, max: 100,
    edit: 'live', scope: 'core', role: 'therapist', source: 'paper U6, K_psi,P,f',
    title: { en: 'Turn strength', de: 'Drehstärke' },
    effect: { en: 'How fast the hoist turns at full pelvis turn.', de: 'Wie schnell sich das Gerät bei voller Beckendrehung dreht.' },
  },
  {
    id: 35, name: 'yaw_rate_per_unit_rad_s', unit: 'rad/s', min: 0.001, default: 0.011635528, max: 0.05,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 3, s_w = 2/3 deg/s (D18)',
    title: { en: 'Turn rate per unit', de: 'Drehrate je Einheit' },
    effect: { en: 'Turn rate of one controller unit.', de: 'Drehrate je Reglereinheit.' },
  },
  {
    id: 40, name: 'speed_m_s_max', unit: 'm/s', min: 0.05, default: 0.65, max: 0.65,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 3; hazard H1',
    title: { en: 'Top speed', de: 'Höchsttempo' },
    effect: { en: 'The hoist never drives faster.', de: 'Das Gerät fährt nie schneller.' },
  },
  {
    id: 41, name: 'yaw_rate_rad_s_max', unit: 'rad/s', min: 0.05, default: 0.872664626, max: 0.872664626,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 3: 50 deg/s',
    title: { en: 'Top turn rate', de: 'Höchste Drehrate' },
    effect: { en: 'The hoist never turns faster.', de: 'Das Gerät dreht nie schneller.' },
  },
  {
    id: 42, name: 'acceleration_m_s2_max', unit: 'm/s²', min: 0.05, default: 0.5, max: 0.5,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.1: normal ramps',
    title: { en: 'Acceleration', de: 'Beschleunigung' },
    effect: { en: 'How quickly speed may change in normal walking.', de: 'Wie schnell sich das Tempo beim Gehen ändern darf.' },
  },
  {
    id: 43, name: 'jerk_m_s3_max', unit: 'm/s³', min: 0.5, default: 3, max: 10,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.1: normal motion only; the stopping distance shown was measured up to 10',
    title: { en: 'Jerk', de: 'Ruck' },
    effect: { en: 'How suddenly acceleration may change.', de: 'Wie plötzlich sich die Beschleunigung ändern darf.' },
  },
  {
    id: 44, name: 'yaw_acceleration_rad_s2_max', unit: 'rad/s²', min: 0.1, default: 2.0943951, max: 2.0943951,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 3: 120 deg/s2',
    title: { en: 'Turn acceleration', de: 'Drehbeschleunigung' },
    effect: { en: 'How quickly the turn rate may change.', de: 'Wie schnell sich die Drehrate ändern darf.' },
  },
  {
    id: 45, name: 'speed_cap_norm', unit: '', min: 0.2, default: 1, max: 1,
    edit: 'live', scope: 'core', role: 'therapist', source: 'for each patient',
    title: { en: 'Speed limit for this patient', de: 'Tempogrenze für diesen Patienten' },
    effect: { en: 'Share of the top speed that this patient may reach.', de: 'Anteil des Höchsttempos, den dieser Patient erreichen darf.' },
  },
  {
    id: 46, name: 'protective_deceleration_m_s2', unit: 'm/s²', min: 0.8, default: 1, max: 1,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.1: Krasna 2021, no stepping at 1.0; never gentler than letting go',
    title: { en: 'Protective braking', de: 'Schutzbremsung' },
    effect: { en: 'Braking of an automatic stop.', de: 'Bremsung eines automatischen Halts.' },
  },
  {
    id: 47, name: 'bumper_deceleration_m_s2', unit: 'm/s²', min: 0.8, default: 1.5, max: 1.5,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.1',
    title: { en: 'Bumper braking', de: 'Bremsung am Stoßfänger' },
    effect: { en: 'Braking when a bumper is touched.', de: 'Bremsung bei Berührung eines Stoßfängers.' },
  },
  {
    id: 50, name: 'remote_speed_m_s_max', unit: 'm/s', min: 0.05, default: 0.3, max: 0.6,
    edit: 'live', scope: 'core', role: 'therapist', source: 'assumed: slow, medium, fast',
    title: { en: 'Driving speed', de: 'Fahrtempo' },
    effect: { en: 'Speed with the joystick fully deflected.', de: 'Tempo bei vollem Ausschlag des Joysticks.' },
  },
  {
    id: 51, name: 'remote_yaw_rate_rad_s_max', unit: 'rad/s', min: 0.05, default: 0.523598776, max: 0.872664626,
    edit: 'live', scope: 'core', role: 'therapist', source: 'assumed: 30 deg/s',
    title: { en: 'Driving turn rate', de: 'Fahr-Drehrate' },
    effect: { en: 'Turn rate with the joystick fully deflected.', de: 'Drehrate bei vollem Ausschlag des Joysticks.' },
  },
  {
    id: 52, name: 'remote_slow_age_s', unit: 's', min: 0.05, default: 0.15, max: 0.2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H17',
    title: { en: 'Slow down after', de: 'Verlangsamen ab' },
    effect: { en: 'Age of the last driving command, network delay included, from which speed falls.', de: 'Alter des letzten Fahrbefehls samt Funkverzögerung, ab dem das Tempo sinkt.' },
  },
  {
    id: 53, name: 'remote_stop_age_s', unit: 's', min: 0.1, default: 0.25, max: 0.25,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H17',
    title: { en: 'Stop after', de: 'Halten ab' },
    effect: { en: 'Age of the last driving command, network delay included, at which the hoist stops.', de: 'Alter des letzten Fahrbefehls samt Funkverzögerung, ab dem das Gerät hält.' },
  },
  {
    id: 170, name: 'guided_length_m_max', unit: 'm', min: 1, default: 200, max: 1000,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'assumed; about ten minutes at 0.3 m/s',
    title: { en: 'Longest exercise', de: 'Längste Übung' },
    effect: { en: 'Longer exercises are refused, all laps together.', de: 'Längere Übungen werden abgelehnt, alle Runden zusammen.' },
  },
  {
    id: 171, name: 'guided_deviation_m_max', unit: 'm', min: 0.05, default: 0.25, max: 1,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'assumed; half the free width beside the hoist in a room of 5 m',
    title: { en: 'Deviation from the exercise', de: 'Abweichung von der Übung' },
    effect: { en: 'Distance from the line at which the hoist stops.', de: 'Abstand von der Linie, bei dem das Gerät anhält.' },
  },
  {
    id: 172, name: 'guided_lag_start_rad', unit: 'rad', min: 0.02, default: 0.0436, max: 0.08,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'simulated: 2.5 deg',
    title: { en: 'Exercise: slow from', de: 'Übung: langsam ab' },
    effect: { en: 'Lag of the patient from which an exercise goes slowly.', de: 'Rückstand des Patienten, ab dem eine Übung langsam fährt.' },
  },
  {
    id: 60, name: 'fall_tilt_rad', unit: 'rad', min: 0.1, default: 0.174532925, max: 0.22,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H15: 10 deg',
    title: { en: 'Fall detection: lean', de: 'Sturzerkennung: Neigung' },
    effect: { en: 'Lean from which a quick further lean counts as a fall.', de: 'Neigung, ab der schnelles Weiterneigen als Sturz gilt.' },
  },
  {
    id: 61, name: 'fall_rate_rad_s', unit: 'rad/s', min: 0.2, default: 0.436332313, max: 1,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H15: 25 deg/s',
    title: { en: 'Fall detection: rate', de: 'Sturzerkennung: Rate' },
    effect: { en: 'Outward rate that counts as a fall.', de: 'Neigungsrate nach außen, die als Sturz gilt.' },
  },
  {
    id: 62, name: 'fall_static_tilt_rad', unit: 'rad', min: 0.15, default: 0.226892803, max: 0.255,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H15: 13 deg in walk, 14 deg in paper',
    title: { en: 'Fall detection: lasting lean', de: 'Sturzerkennung: Dauerneigung' },
    effect: { en: 'Lean that counts as a fall when it lasts.', de: 'Neigung, die als Sturz gilt, wenn sie andauert.' },
  },
  {
    id: 63, name: 'fall_static_s', unit: 's', min: 0.05, default: 0.1, max: 2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H15: 0.1 s in walk, 2 s in paper',
    title: { en: 'Fall detection: time of lean', de: 'Sturzerkennung: Dauer' },
    effect: { en: 'How long the lasting lean is tolerated.', de: 'Wie lange die Dauerneigung anhalten darf.' },
  },
  {
    id: 64, name: 'battery_low_v', unit: 'V', min: 20, default: 23, max: 26,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H12',
    title: { en: 'Battery low', de: 'Batterie schwach' },
    effect: { en: 'Voltage of both batteries together that raises a warning.', de: 'Spannung beider Batterien zusammen, ab der gewarnt wird.' },
  },
  {
    id: 65, name: 'battery_empty_v', unit: 'V', min: 19, default: 22, max: 25,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H12',
    title: { en: 'Battery empty', de: 'Batterie leer' },
    effect: { en: 'Voltage at which the hoist stops gently.', de: 'Spannung, bei der das Gerät sanft hält.' },
  },
  {
    id: 66, name: 'neutral_start_tolerance_norm', unit: '', min: 0.02, default: 0.2, max: 0.5,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'assumed; start only near neutral, hazard table 2.3',
    title: { en: 'Upright enough to start', de: 'Aufrecht genug zum Starten' },
    effect: { en: 'Largest lean or turn, as a share of full, at which walking may start.', de: 'Größte Neigung oder Drehung als Anteil des vollen Wegs, bei der gestartet werden darf.' },
  },
  {
    id: 67, name: 'loop_late_s_max', unit: 's', min: 0.005, default: 0.03, max: 0.2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H22: one step more than 30 ms late',
    title: { en: 'Latest control step', de: 'Spätester Regelschritt' },
    effect: { en: 'A control step that begins later than this stops the hoist.', de: 'Beginnt ein Regelschritt später, hält das Gerät an.' },
  },
  {
    id: 110, name: 'base_tilt_slow_rad', unit: 'rad', min: 0.034906585, default: 0.0872664626, max: 0.0872664626,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H9: 5 deg',
    title: { en: 'Sloping floor: slow from', de: 'Schräger Boden: langsam ab' },
    effect: { en: 'Slope from which the hoist goes slowly.', de: 'Schräge, ab der das Gerät langsam fährt.' },
  },
  {
    id: 111, name: 'base_tilt_stop_rad', unit: 'rad', min: 0.0872664626, default: 0.13962634, max: 0.13962634,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H9: 8 deg',
    title: { en: 'Sloping floor: stop from', de: 'Schräger Boden: Halt ab' },
    effect: { en: 'Slope at which the hoist stops.', de: 'Schräge, bei der das Gerät hält.' },
  },
  {
    id: 112, name: 'base_tilt_speed_m_s_max', unit: 'm/s', min: 0.05, default: 0.2, max: 0.2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H9',
    title: { en: 'Speed on sloping floor', de: 'Tempo auf schrägem Boden' },
    effect: { en: 'Top speed while the floor slopes.', de: 'Höchsttempo, solange der Boden schräg ist.' },
  },
  {
    id: 113, name: 'hang_tilt_rad', unit: 'rad', min: 0.1, default: 0.174532925, max: 0.255,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H16: 10 deg; 14 deg in paper',
    title: { en: 'Hanging detection: lean', de: 'Hängeerkennung: Neigung' },
    effect: { en: 'Lean that counts as hanging when it lasts.', de: 'Neigung, die als Hängen gilt, wenn sie andauert.' },
  },
  {
    id: 114, name: 'hang_tilt_s', unit: 's', min: 0.5, default: 2, max: 3,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H16',
    title: { en: 'Hanging detection: time of lean', de: 'Hängeerkennung: Dauer der Neigung' },
    effect: { en: 'How long that lean may last.', de: 'Wie lange diese Neigung andauern darf.' },
  },
  {
    id: 115, name: 'hang_speed_m_s', unit: 'm/s', min: 0.05, default: 0.1, max: 0.2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H16',
    title: { en: 'Hanging detection: speed', de: 'Hängeerkennung: Tempo' },
    effect: { en: 'Speed from which a patient who does not sway counts as pulled along.', de: 'Tempo, ab dem ein Patient, der nicht pendelt, als gezogen gilt.' },
  },
  {
    id: 116, name: 'hang_still_s', unit: 's', min: 1.5, default: 2, max: 4,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H16; trade-off in firmware/sim/PATIENTS.md',
    title: { en: 'Hanging detection: time without steps', de: 'Hängeerkennung: Dauer ohne Schritte' },
    effect: { en: 'How long the hoist may roll without the sway of steps.', de: 'Wie lange das Gerät ohne das Pendeln von Schritten rollen darf.' },
  },
  {
    id: 117, name: 'hang_sway_m', unit: 'm', min: 0.002, default: 0.006, max: 0.02,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'a third of what small steps sway from side to side: trade-off in firmware/sim/PATIENTS.md',
    title: { en: 'Hanging detection: sway of a step', de: 'Hängeerkennung: Pendeln eines Schritts' },
    effect: { en: 'Sideways motion of the harness that counts as a step.', de: 'Seitliche Bewegung des Gurts, die als Schritt gilt.' },
  },
  {
    id: 118, name: 'battery_uneven_v', unit: 'V', min: 0.2, default: 0.5, max: 2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H12',
    title: { en: 'Batteries uneven', de: 'Batterien ungleich' },
    effect: { en: 'Difference of the two batteries that raises a warning.', de: 'Unterschied der beiden Batterien, ab dem gewarnt wird.' },
  },
  {
    id: 119, name: 'tilt_rad_max', unit: 'rad', min: 0.261799388, default: 0.322885912, max: 0.35,
    edit: 'stopped', scope: 'core', role: 'engineer', source: '18.5 deg, 3.5 beyond the mechanical stop: control DECISIONS 56',
    title: { en: 'Plausible lean', de: 'Plausible Neigung' },
    effect: { en: 'Largest lean that a sensor may report.', de: 'Größte Neigung, die ein Sensor melden darf.' },
  },
  {
    id: 120, name: 'tilt_rate_rad_s_max', unit: 'rad/s', min: 2, default: 3.490658504, max: 4.2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H7: 200 deg/s',
    title: { en: 'Plausible rate of lean', de: 'Plausible Neigungsrate' },
    effect: { en: 'Fastest change of lean that a sensor may report.', de: 'Schnellste Änderung der Neigung, die ein Sensor melden darf.' },
  },
  {
    id: 121, name: 'strut_apart_rad_max', unit: 'rad', min: 0.034906585, default: 0.0698131701, max: 0.13962634,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H7: 4 deg, the top bar is rigid',
    title: { en: 'Struts apart sideways', de: 'Streben seitlich auseinander' },
    effect: { en: 'Largest difference of the two struts\' sideways tilt.', de: 'Größter Unterschied der seitlichen Neigung beider Streben.' },
  },
  {
    id: 122, name: 'strut_twist_rad_max', unit: 'rad', min: 0.261799388, default: 0.436332313, max: 0.523598776,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H7: 25 deg',
    title: { en: 'Struts twisted', de: 'Streben verdreht' },
    effect: { en: 'Largest difference of the two struts\' forward tilt.', de: 'Größter Unterschied der Neigung beider Streben nach vorn.' },
  },
  {
    id: 123, name: 'overspeed_margin_m_s', unit: 'm/s', min: 0.05, default: 0.1, max: 0.1,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H1',
    title: { en: 'Too fast from', de: 'Zu schnell ab' },
    effect: { en: 'Excess over the top speed at which the hoist stops.', de: 'Überschreitung des Höchsttempos, bei der das Gerät hält.' },
  },
  {
    id: 124, name: 'following_error_m_s_max', unit: 'm/s', min: 0.08, default: 0.15, max: 0.15,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H1',
    title: { en: 'Wheel speed error', de: 'Tempofehler eines Rads' },
    effect: { en: 'How far a wheel\'s speed may differ from its command.', de: 'Wie weit das Tempo eines Rads von der Vorgabe abweichen darf.' },
  },
  {
    id: 125, name: 'following_error_s', unit: 's', min: 0.05, default: 0.15, max: 0.15,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H1',
    title: { en: 'Time of a wheel speed error', de: 'Dauer eines Tempofehlers' },
    effect: { en: 'How long that error may last.', de: 'Wie lange dieser Fehler andauern darf.' },
  },
  {
    id: 126, name: 'drift_rad_max', unit: 'rad', min: 0.261799388, default: 0.523598776, max: 1,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H8: 30 deg in 10 s, the struts stop at 15',
    title: { en: 'Plausible turn of a sensor', de: 'Plausible Drehung eines Sensors' },
    effect: { en: 'Largest turn that a tilt sensor may report within ten seconds.', de: 'Größte Drehung, die ein Neigungssensor in zehn Sekunden melden darf.' },
  },
  {
    id: 100, name: 'fault_stops_max', unit: '', min: 2, default: 3, max: 5,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.3 and 2.2, H22: three times',
    title: { en: 'Stops until out of service', de: 'Halte bis außer Betrieb' },
    effect: { en: 'Number of stops by the same fault that puts the hoist out of service.', de: 'Anzahl der Halte durch dieselbe Störung, die das Gerät außer Betrieb setzt.' },
  },
  {
    id: 101, name: 'fault_stops_window_s', unit: 's', min: 60, default: 600, max: 3600,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'assumed: within one training of ten minutes',
    title: { en: 'Time window of stops', de: 'Zeitfenster der Halte' },
    effect: { en: 'Stops by the same fault within this time are counted together.', de: 'Halte durch dieselbe Störung innerhalb dieser Zeit werden zusammengezählt.' },
  },
  {
    id: 130, name: 'slip_stop_s', unit: 's', min: 0.3, default: 1, max: 10,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'SOURCES 2.2, H10: R1 after 1 s',
    title: { en: 'Longest slip', de: 'Längster Schlupf' },
    effect: { en: 'How long the wheels may slip before the hoist stops gently.', de: 'Wie lange die Räder rutschen dürfen, bevor das Gerät sanft hält.' },
  },
  {
    id: 131, name: 'cadence_cancel_norm', unit: '', min: 0, default: 0, max: 1,
    edit: 'stopped', scope: 'core', role: 'therapist', source: 'option, off: 0; all of the sway: 1',
    title: { en: 'Gait sway compensation', de: 'Pendeln beim Gehen ausgleichen' },
    effect: { en: 'Share of the sway of each stride that is removed from lean and turn. 0: as published.', de: 'Anteil des Pendelns bei jedem Schritt, der aus Neigung und Drehung entfernt wird. 0: wie veröffentlicht.' },
  },
  {
    id: 80, name: 'drive_velocity_gain_v_s_rad', unit: 'V s/rad', min: 0.1, default: 0.12, max: 0.25,
    edit: 'live', scope: 'drive', role: 'engineer', source: 'tuned on the motor model, P1-P9; in this range the stopping distance holds',
    title: { en: 'Drive: gain', de: 'Antrieb: Verstärkung' },
    effect: { en: 'Stiffness of the speed control of the motors.', de: 'Steifigkeit der Drehzahlregelung der Motoren.' },
  },
  {
    id: 81, name: 'drive_velocity_integral_v_rad', unit: 'V/rad', min: 2.3, default: 2.4, max: 20,
    edit: 'live', scope: 'drive', role: 'engineer', source: 'tuned on the motor model, P1-P9; in this range the stopping distance holds',
    title: { en: 'Drive: integral gain', de: 'Antrieb: Integralverstärkung' },
    effect: { en: 'How quickly the motors remove a lasting speed error.', de: 'Wie schnell die Motoren eine bleibende Abweichung ausregeln.' },
  },
  {
    id: 82, name: 'drive_current_limit_a', unit: 'A', min: 0.5, default: 6, max: 12,
    edit: 'stopped', scope: 'drive', role: 'engineer', source: 'assumed; 100 W at 24 V',
    title: { en: 'Drive: current limit', de: 'Antrieb: Stromgrenze' },
    effect: { en: 'Largest motor current.', de: 'Größter Motorstrom.' },
  },
  {
    id: 83, name: 'drive_acceleration_rad_s2', unit: 'rad/s²', min: 50, default: 450, max: 2000,
    edit: 'stopped', scope: 'drive', role: 'engineer', source: '1.5 m/s2 at the wheel through gear 30: bumper stop must fit',
    title: { en: 'Drive: ramp', de: 'Antrieb: Rampe' },
    effect: { en: 'Fastest change of the motor speed.', de: 'Schnellste Änderung der Motordrehzahl.' },
  },
  {
    id: 90, name: 'tilt_kalman_angle_norm', unit: '', min: 0, default: 0.0102, max: 0.2,
    edit: 'stopped', scope: 'tilt', role: 'engineer', source: 'paper eq (14), first gain',
    title: { en: 'Tilt filter: angle gain', de: 'Neigungsfilter: Winkel' },
    effect: { en: 'How strongly the accelerometer corrects the angle.', de: 'Wie stark der Beschleunigungssensor den Winkel korrigiert.' },
  },
  {
    id: 91, name: 'tilt_kalman_bias_per_s', unit: '1/s', min: -0.2, default: -0.0013, max: 0,
    edit: 'stopped', scope: 'tilt', role: 'engineer', source: 'paper eq (14), second gain',
    title: { en: 'Tilt filter: bias gain', de: 'Neigungsfilter: Drift' },
    effect: { en: 'How quickly the filter corrects the drift of the gyroscope.', de: 'Wie schnell der Filter die Drift des Drehratensensors ausgleicht.' },
  },
  {
    id: 92, name: 'bus_load_norm_max', unit: '', min: 0.5, default: 0.95, max: 1.2,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'load plan: 86 % at most with every option on and the service reserve, counted with the most stuff bits',
    title: { en: 'Bus load limit', de: 'Grenze der Buslast' },
    effect: { en: 'The hoist stops when the bus to sensors and drives is busier for a second.', de: 'Das Gerät hält an, wenn der Bus zu Sensoren und Antrieben eine Sekunde lang stärker ausgelastet ist.' },
  },
  {
    id: 150, name: 'left_alpha_zero_rad', unit: 'rad', min: -0.0872664626, default: 0, max: 0.0872664626,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: strut and chassis zero',
    title: { en: 'Left strut zero, forward', de: 'Nullpunkt linke Strebe, vor' },
    effect: { en: 'Reading of the left strut sensor while the strut stands upright.', de: 'Messwert der linken Strebe, während sie aufrecht steht.' },
  },
  {
    id: 151, name: 'left_beta_zero_rad', unit: 'rad', min: -0.0872664626, default: 0, max: 0.0872664626,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: strut and chassis zero',
    title: { en: 'Left strut zero, sideways', de: 'Nullpunkt linke Strebe, seitlich' },
    effect: { en: 'Reading of the left strut sensor while the strut stands upright.', de: 'Messwert der linken Strebe, während sie aufrecht steht.' },
  },
  {
    id: 152, name: 'right_alpha_zero_rad', unit: 'rad', min: -0.0872664626, default: 0, max: 0.0872664626,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: strut and chassis zero',
    title: { en: 'Right strut zero, forward', de: 'Nullpunkt rechte Strebe, vor' },
    effect: { en: 'Reading of the right strut sensor while the strut stands upright.', de: 'Messwert der rechten Strebe, während sie aufrecht steht.' },
  },
  {
    id: 153, name: 'right_beta_zero_rad', unit: 'rad', min: -0.0872664626, default: 0, max: 0.0872664626,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: strut and chassis zero',
    title: { en: 'Right strut zero, sideways', de: 'Nullpunkt rechte Strebe, seitlich' },
    effect: { en: 'Reading of the right strut sensor while the strut stands upright.', de: 'Messwert der rechten Strebe, während sie aufrecht steht.' },
  },
  {
    id: 154, name: 'base_alpha_zero_rad', unit: 'rad', min: -0.0872664626, default: 0, max: 0.0872664626,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: strut and chassis zero',
    title: { en: 'Chassis zero, forward', de: 'Nullpunkt Fahrgestell, vor' },
    effect: { en: 'Reading of the chassis sensor on a level floor.', de: 'Messwert des Fahrgestells auf ebenem Boden.' },
  },
  {
    id: 155, name: 'base_beta_zero_rad', unit: 'rad', min: -0.0872664626, default: 0, max: 0.0872664626,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: strut and chassis zero',
    title: { en: 'Chassis zero, sideways', de: 'Nullpunkt Fahrgestell, seitlich' },
    effect: { en: 'Reading of the chassis sensor on a level floor.', de: 'Messwert des Fahrgestells auf ebenem Boden.' },
  },
  {
    id: 156, name: 'base_yaw_bias_rad_s', unit: 'rad/s', min: -0.0523598776, default: 0, max: 0.0523598776,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: gyroscopes at rest',
    title: { en: 'Chassis turn-rate zero', de: 'Nullpunkt der Drehrate' },
    effect: { en: 'Turn rate that the chassis sensor reports at rest.', de: 'Drehrate, die der Sensor des Fahrgestells in Ruhe meldet.' },
  },
  {
    id: 157, name: 'calibrated_zero_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Struts zeroed', de: 'Streben genullt' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 158, name: 'calibrated_neutral_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Neutral set', de: 'Neutral gesetzt' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 159, name: 'calibrated_gyro_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Gyroscopes checked', de: 'Drehraten geprüft' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 160, name: 'calibrated_strut_length_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Strut length measured', de: 'Strebenlänge gemessen' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 161, name: 'calibrated_strut_spacing_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Strut spacing measured', de: 'Strebenabstand gemessen' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 162, name: 'calibrated_wheel_radius_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Wheel radius measured', de: 'Radradius gemessen' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 163, name: 'calibrated_track_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Track width measured', de: 'Spurweite gemessen' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 164, name: 'calibrated_square_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Square driven', de: 'Quadrat gefahren' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 165, name: 'calibrated_encoders_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Encoders checked', de: 'Geber geprüft' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 166, name: 'calibrated_bumpers_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Bumpers checked', de: 'Stoßfänger geprüft' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 167, name: 'calibrated_struts_s', unit: 's', min: 0, default: 0, max: 253402300799,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: seconds since 1970-01-01 UTC',
    title: { en: 'Strut sensors checked', de: 'Strebensensoren geprüft' },
    effect: { en: 'Date of the latest calibration; 0 means never.', de: 'Zeitpunkt der letzten Kalibrierung; 0 heißt nie.' },
  },
  {
    id: 168, name: 'calibrated_nodes_id', unit: '', min: 0, default: 0, max: 4294967295,
    edit: 'stopped', scope: 'core', role: 'engineer', source: 'calibration: of the serial numbers of all sensors and drives',
    title: { en: 'Checked parts', de: 'Geprüfte Teile' },
    effect: { en: 'Stands for the sensors and drives that were there at the latest check; 0 means none.', de: 'Steht für die Sensoren und Antriebe, die bei der letzten Prüfung da waren; 0 heißt keine.' },
  },
];

export interface PresetInfo {
  name: string;
  title: Words;
  doc: Words;
  values: Partial<Record<ParamName, number>>;
}

export const presets: readonly PresetInfo[] = [
  {
    name: 'walk', title: { en: 'Walking', de: 'Gehen' },
    doc: { en: 'For walking at 0.3 to 0.6 m/s. Recommended.', de: 'Für Gehen mit 0,3 bis 0,6 m/s. Empfohlen.' },
    values: { lean_range_rad: 0.157079633, turn_range_rad: 0.174532925, lean_filtered_units_max: 20, speed_per_unit_m_s: 0.03, yaw_rate_per_unit_rad_s: 0.011635528, fall_static_tilt_rad: 0.226892803, fall_static_s: 0.1, hang_tilt_rad: 0.174532925, },
  },
  {
    name: 'paper', title: { en: 'As published', de: 'Wie veröffentlicht' },
    doc: { en: 'The published settings, for walking up to 0.3 m/s. The same speed for the same lean; full lean is 13° instead of 15°, below the guards.', de: 'Die veröffentlichten Einstellungen, für Gehen bis 0,3 m/s. Gleiches Tempo bei gleicher Neigung; volle Neigung bei 13° statt 15°, unter Sturz- und Hängeerkennung.' },
    values: { lean_range_rad: 0.226892803, turn_range_rad: 0.261799388, lean_filtered_units_max: 50, speed_per_unit_m_s: 0.0086, yaw_rate_per_unit_rad_s: 0.017453293, fall_static_tilt_rad: 0.244346095, fall_static_s: 2, hang_tilt_rad: 0.244346095, },
  },
];
