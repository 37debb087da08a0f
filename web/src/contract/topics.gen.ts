// Made by `deploy/dev gen` from server/contract/topics.def; do not edit.

import type { TopicName } from './rest.gen';
import type { SignalName, TickRecord } from './signals.gen';

/** A page made for another table cannot read the samples. */
export const topicsHash = '3e3123dac86fae03';

/** The live values of each topic. */
export interface TopicValues {
  /** What the hoist does, and why it does not: in every sample, chosen or not. */
  state:
    | 'tick'
    | 'time_ns'
    | 'fault_bits'
    | 'settings_trial_s'
    | 'alarm_pause_s'
    | 'blocked_bits'
    | 'babbling_id'
    | 'drive_left_fault_code'
    | 'drive_right_fault_code'
    | 'tilt_implausible_code'
    | 'overspeed_code'
    | 'mode'
    | 'stop_cause'
    | 'bumpers'
    | 'tilt_left_age_ticks'
    | 'tilt_right_age_ticks'
    | 'tilt_base_age_ticks'
    | 'drive_left_age_ticks'
    | 'drive_right_age_ticks'
    | 'io_age_ticks'
    | 'bumpers_acknowledged'
    | 'switches'
    | 'standing_still'
    | 'alarm_sound'
    | 'alarm_light'
    | 'speed_cause'
    | 'guided_phase'
    | 'guided_end'
    | 'bus_state'
    | 'bus_up'
    | 'duplicate_id';
  /** How the hoist moves: speed, turn rate, distance, stopping distance. */
  motion:
    | 'speed_command_m_s'
    | 'stop_distance_m'
    | 'speed_m_s'
    | 'yaw_rate_rad_s'
    | 'distance_m';
  /** Where the hoist stands, slip corrected; whoever begins to follow it gets the message `walk`. */
  pose:
    | 'fused_x_m'
    | 'fused_y_m'
    | 'fused_psi_rad';
  /** Tilts of struts and chassis. */
  posture:
    | 'left_alpha_rad'
    | 'left_beta_rad'
    | 'right_alpha_rad'
    | 'right_beta_rad'
    | 'base_alpha_rad'
    | 'base_beta_rad';
  /** What the patient wants: lean and turn. */
  intent:
    | 'lean_norm'
    | 'turn_norm';
  /** The exercise that the hoist drives. */
  exercise:
    | 'guided_progress_norm'
    | 'guided_cross_track_m'
    | 'guided_heading_error_rad'
    | 'guided_remaining_m';
  /** The batteries. */
  power:
    | 'battery_a_v'
    | 'battery_b_v';
  /** The step of calibration under way. */
  calibration:
    | 'calibration_value'
    | 'calibration_step'
    | 'calibration_phase'
    | 'calibration_done_percent'
    | 'calibration_reason';
  /** Every live value, as whole records; further topics add nothing. */
  all: SignalName;
}

export interface TopicBlock {
  name: Exclude<TopicName, 'all'>;
  bytes: number;
  /** Reads the block that begins at byte `at`. */
  read: (view: DataView, at: number) => Partial<TickRecord>;
}

/** The blocks of a sample, in the order of their bits in the header. */
export const topicBlocks: readonly TopicBlock[] = [
  {
    name: 'state',
    bytes: 66,
    read: (view, at) => ({
      tick: Number(view.getBigUint64(at + 0, true)),
      time_ns: Number(view.getBigUint64(at + 8, true)),
      fault_bits: Number(view.getBigUint64(at + 16, true)),
      settings_trial_s: view.getFloat32(at + 24, true),
      alarm_pause_s: view.getFloat32(at + 28, true),
      blocked_bits: view.getUint32(at + 32, true),
      babbling_id: view.getUint16(at + 36, true),
      drive_left_fault_code: view.getUint16(at + 38, true),
      drive_right_fault_code: view.getUint16(at + 40, true),
      tilt_implausible_code: view.getUint16(at + 42, true),
      overspeed_code: view.getUint16(at + 44, true),
      mode: view.getUint8(at + 46),
      stop_cause: view.getUint8(at + 47),
      bumpers: view.getUint8(at + 48),
      tilt_left_age_ticks: view.getUint8(at + 49),
      tilt_right_age_ticks: view.getUint8(at + 50),
      tilt_base_age_ticks: view.getUint8(at + 51),
      drive_left_age_ticks: view.getUint8(at + 52),
      drive_right_age_ticks: view.getUint8(at + 53),
      io_age_ticks: view.getUint8(at + 54),
      bumpers_acknowledged: view.getUint8(at + 55),
      switches: view.getUint8(at + 56),
      standing_still: view.getUint8(at + 57),
      alarm_sound: view.getUint8(at + 58),
      alarm_light: view.getUint8(at + 59),
      speed_cause: view.getUint8(at + 60),
      guided_phase: view.getUint8(at + 61),
      guided_end: view.getUint8(at + 62),
      bus_state: view.getUint8(at + 63),
      bus_up: view.getUint8(at + 64),
      duplicate_id: view.getUint8(at + 65),
    }),
  },
  {
    name: 'motion',
    bytes: 20,
    read: (view, at) => ({
      speed_command_m_s: view.getFloat32(at + 0, true),
      stop_distance_m: view.getFloat32(at + 4, true),
      speed_m_s: view.getFloat32(at + 8, true),
      yaw_rate_rad_s: view.getFloat32(at + 12, true),
      distance_m: view.getFloat32(at + 16, true),
    }),
  },
  {
    name: 'pose',
    bytes: 12,
    read: (view, at) => ({
      fused_x_m: view.getFloat32(at + 0, true),
      fused_y_m: view.getFloat32(at + 4, true),
      fused_psi_rad: view.getFloat32(at + 8, true),
    }),
  },
  {
    name: 'posture',
    bytes: 24,
    read: (view, at) => ({
      left_alpha_rad: view.getFloat32(at + 0, true),
      left_beta_rad: view.getFloat32(at + 4, true),
      right_alpha_rad: view.getFloat32(at + 8, true),
      right_beta_rad: view.getFloat32(at + 12, true),
      base_alpha_rad: view.getFloat32(at + 16, true),
      base_beta_rad: view.getFloat32(at + 20, true),
    }),
  },
  {
    name: 'intent',
    bytes: 8,
    read: (view, at) => ({
      lean_norm: view.getFloat32(at + 0, true),
      turn_norm: view.getFloat32(at + 4, true),
    }),
  },
  {
    name: 'exercise',
    bytes: 16,
    read: (view, at) => ({
      guided_progress_norm: view.getFloat32(at + 0, true),
      guided_cross_track_m: view.getFloat32(at + 4, true),
      guided_heading_error_rad: view.getFloat32(at + 8, true),
      guided_remaining_m: view.getFloat32(at + 12, true),
    }),
  },
  {
    name: 'power',
    bytes: 8,
    read: (view, at) => ({
      battery_a_v: view.getFloat32(at + 0, true),
      battery_b_v: view.getFloat32(at + 4, true),
    }),
  },
  {
    name: 'calibration',
    bytes: 8,
    read: (view, at) => ({
      calibration_value: view.getFloat32(at + 0, true),
      calibration_step: view.getUint8(at + 4),
      calibration_phase: view.getUint8(at + 5),
      calibration_done_percent: view.getUint8(at + 6),
      calibration_reason: view.getUint8(at + 7),
    }),
  },
];
