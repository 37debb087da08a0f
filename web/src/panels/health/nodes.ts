// State of each sensor and drive, from the core's live values.
import type { SignalName, TickRecord } from '../../contract/signals.gen';

export type NodeState = 'works' | 'losing' | 'reports' | 'waiting' | 'silent' | 'never';

export interface NodeView {
  name: string;
  state: NodeState;
  /** Since its latest message; null = longer ago than the core counts, or never. */
  age_ms: number | null;
  lostLately: number;
  lostAll: number;
  /** Code of its latest emergency message while an error is active; 0 for none. */
  emergency: number;
}

/** The core counts ages in its steps: 0 = within the latest one. */
export const tick_ms = 10;
const oldest_ticks = 255;
/** The core counts a node as lost after 50 ms; the screen updates twice a second, so its limit for "silent" is longer. */
const silent_ticks = 25;
const neverHeard = 255;
const operational = 5;

/** All nodes except the computer, in display order. */
export const partNames = ['tilt_left', 'tilt_right', 'tilt_base', 'drive_left', 'drive_right', 'io'] as const;
export type PartName = (typeof partNames)[number];

export function nodeView(record: TickRecord, name: PartName): NodeView {
  const value = (what: string): number => record[`${name}_${what}` as SignalName];
  const age = value('age_ticks');
  const lostLately = value('lost_10s');
  let state: NodeState = 'works';
  if (age >= silent_ticks) {
    const lives = value('nmt_state') !== neverHeard && value('heartbeats_missed') < 2;
    state = lives && value('nmt_state') !== operational ? 'waiting' : value('nmt_state') === neverHeard ? 'never' : 'silent';
  } else if (value('error_register') !== 0) state = 'reports';
  else if (lostLately > 0) state = 'losing';
  return {
    name,
    state,
    age_ms: age < oldest_ticks ? age * tick_ms : null,
    lostLately,
    lostAll: value('lost_frames'),
    emergency: value('error_register') !== 0 ? value('emcy_code') : 0,
  };
}
