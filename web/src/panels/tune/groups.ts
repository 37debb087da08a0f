// Groups of settings. A setting not named here appears under "Other".
import { params, type ParamInfo, type ParamName } from '../../contract/params.gen';
import type { TextKey } from '../../text/en';

export interface Group {
  title: TextKey;
  rows: ParamInfo[];
}

const order: readonly { title: TextKey; names: readonly ParamName[] }[] = [
  {
    title: 'tune.group.lean',
    names: [
      'lean_gain_filtered_units',
      'lean_gain_direct_units',
      'lean_tau_normal_s',
      'lean_tau_release_s',
      'braking_softness_norm',
      'lean_dead_band_norm',
      'lean_range_rad',
      'lean_filtered_units_max',
      'reversal_gain_norm',
      'speed_per_unit_m_s',
    ],
  },
  {
    title: 'tune.group.turn',
    names: [
      'turn_gain_filtered_units',
      'turn_gain_direct_units',
      'turn_tau_normal_s',
      'turn_tau_release_s',
      'turn_dead_band_norm',
      'turn_range_rad',
      'yaw_rate_per_unit_rad_s',
    ],
  },
  { title: 'tune.group.patient', names: ['speed_cap_norm', 'neutral_lean_m', 'neutral_turn_rad', 'neutral_start_tolerance_norm'] },
  {
    title: 'tune.group.drive',
    names: [
      'remote_speed_m_s_max',
      'remote_yaw_rate_rad_s_max',
      'remote_slow_age_s',
      'remote_stop_age_s',
      'guided_length_m_max',
      'guided_deviation_m_max',
      'guided_lag_start_rad',
    ],
  },
  {
    title: 'tune.group.limits',
    names: [
      'speed_m_s_max',
      'yaw_rate_rad_s_max',
      'acceleration_m_s2_max',
      'jerk_m_s3_max',
      'yaw_acceleration_rad_s2_max',
      'protective_deceleration_m_s2',
      'bumper_deceleration_m_s2',
    ],
  },
  {
    title: 'tune.group.guards',
    names: [
      'fall_tilt_rad',
      'fall_rate_rad_s',
      'fall_static_tilt_rad',
      'fall_static_s',
      'hang_tilt_rad',
      'hang_tilt_s',
      'hang_speed_m_s',
      'hang_still_s',
      'hang_sway_m',
      'base_tilt_slow_rad',
      'base_tilt_stop_rad',
      'base_tilt_speed_m_s_max',
      'battery_low_v',
      'battery_empty_v',
      'battery_uneven_v',
      'overspeed_margin_m_s',
      'following_error_m_s_max',
      'following_error_s',
      'tilt_rad_max',
      'tilt_rate_rad_s_max',
      'strut_apart_rad_max',
      'strut_twist_rad_max',
      'drift_rad_max',
    ],
  },
  {
    title: 'tune.group.machine',
    names: [
      'strut_length_m',
      'strut_spacing_m',
      'track_width_m',
      'wheel_radius_m',
      'encoder_counts_per_turn',
      'wheel_left_scale_norm',
      'wheel_right_scale_norm',
      'left_alpha_zero_rad',
      'left_beta_zero_rad',
      'right_alpha_zero_rad',
      'right_beta_zero_rad',
      'base_alpha_zero_rad',
      'base_beta_zero_rad',
      'base_yaw_bias_rad_s',
      'drive_velocity_gain_v_s_rad',
      'drive_velocity_integral_v_rad',
      'drive_current_limit_a',
      'drive_acceleration_rad_s2',
      'tilt_kalman_angle_norm',
      'tilt_kalman_bias_per_s',
    ],
  },
];

export function groups(): Group[] {
  // Dates of calibrations are no settings: they stand on the Calibrate screen.
  const left = new Map(params.filter((row) => !row.name.startsWith('calibrated_')).map((row) => [row.name, row]));
  const result: Group[] = order.map(({ title, names }) => ({
    title,
    rows: names.flatMap((name) => {
      const row = left.get(name);
      left.delete(name);
      return row === undefined ? [] : [row];
    }),
  }));
  if (left.size > 0) result.push({ title: 'tune.group.other', rows: [...left.values()] });
  return result.filter((group) => group.rows.length > 0);
}

/** Values travel as 64-bit numbers, but drives keep 32-bit ones. */
export const same = (a: number, b: number): boolean => Math.abs(a - b) <= 1e-6 * Math.max(Math.abs(a), Math.abs(b), 1e-9);

/** A step for the slider: about two hundred over the range, of the form 1, 2 or 5 times a power of ten. */
export function niceStep(range: number): number {
  const raw = range / 200;
  const power = 10 ** Math.floor(Math.log10(raw));
  const lead = raw / power;
  return (lead < 1.5 ? 1 : lead < 3.5 ? 2 : lead < 7.5 ? 5 : 10) * power;
}
