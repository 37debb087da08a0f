// What can be done now, and how old the values are. Derived only here, from the whole store.
import type { TickRecord } from '../contract/signals.gen';
import { refusals, type RefusalName } from '../contract/faults.gen';
import { moving, stopped, unknown, useStore, type State } from './store';

export type Start = 'user' | 'remote' | 'guided';
export interface Readiness {
  /** The server answers. */
  reachable: boolean;
  /** The server answers, and the role may more than watch and stop. */
  may: boolean;
  /** The mode is known. Lost: it was known before; at the start neither. */
  known: boolean;
  lost: boolean;
  /** Values of sensors and drives are old. */
  old: boolean;
  motion: 'still' | 'moving' | null;
  lead: 'mine' | 'other' | 'nobody' | null;
  /** In motion by the last record: a lost connection must not turn End into Start. */
  led: boolean;
  stopped: boolean;
  /** Reasons against starting each motion, as names of refusals; empty: it may start. */
  start: Readonly<Record<Start, readonly string[]>>;
  /** Hold-to-run works. */
  hand: boolean;
  end: boolean;
  /** Actions that need STANDBY are allowed. */
  standby: boolean;
  /** Key of the sentence without an alarm. */
  calm: ReturnType<typeof calmOf>;
}

type Known = Pick<
  State,
  | 'link'
  | 'everOpen'
  | 'data'
  | 'coreConnected'
  | 'role'
  | 'mode'
  | 'blockedBits'
  | 'standingStill'
  | 'waits'
  | 'sensed'
  | 'bumpers'
  | 'bumpersHeld'
  | 'lease'
  | 'rtt_s'
  | 'silentNodes'
>;

const tooSlow_s = 0.3;
/** From here on driving is refused: a release would arrive late. */
export const tooSlow = (s: Pick<State, 'rtt_s'>): boolean => s.rtt_s !== null && s.rtt_s > tooSlow_s;

const bitOf = (name: string): number => refusals.find((row) => row.name === name)?.bit ?? -1;
/** Start takes control itself; the mode is judged by itself. */
const notOfStart: readonly RefusalName[] = ['no_lease', 'not_standby'];

function startReasons(s: Known, to: Start): readonly string[] {
  if (s.link !== 'open') return ['link_lost'];
  if (unknown(s) || s.data === 'none') return ['core_gone'];
  if (s.role === 'viewer') return ['not_allowed'];
  if (stopped(s.mode)) return ['release_stop'];
  if (s.mode === 'init') return ['nodes_missing'];
  if (s.mode === 'calibrate') return ['calibrating'];
  if (s.mode !== 'standby') return ['not_standby'];
  const leaves = to === 'remote' && s.bumpersHeld;
  return refusals
    .filter((row) => ((s.blockedBits >>> row.bit) & 1) === 1 && !notOfStart.includes(row.name) && !(leaves && row.name === 'bumper_start'))
    .map((row) => row.name);
}

function calmOf(s: Known, start: readonly string[]) {
  if (s.link !== 'open' || s.data === 'none' || unknown(s)) return 'strip.connecting';
  if (stopped(s.mode)) return 'strip.stopped';
  switch (s.mode) {
    case 'user':
      return 'strip.walking';
    case 'remote':
      return s.bumpers !== 0 ? 'strip.offBumper' : s.lease.mine ? 'strip.driving' : 'strip.drivingOther';
    case 'guided':
      return s.waits ? 'strip.waits' : s.lease.mine ? 'strip.guiding' : 'strip.drivingOther';
    case 'init':
      return s.silentNodes === '' ? 'strip.starting' : 'strip.waiting';
    case 'calibrate':
      return 'strip.calibrating';
    default:
      return start.length > 0 ? 'strip.notReady' : 'strip.ready';
  }
}

export function readinessOf(s: Known): Readiness {
  const reachable = s.link === 'open';
  const may = reachable && s.role !== 'viewer';
  const known = !unknown(s) && s.data !== 'none';
  const old = s.data !== 'fresh' || !s.sensed || !reachable;
  const start = { user: startReasons(s, 'user'), remote: startReasons(s, 'remote'), guided: startReasons(s, 'guided') };
  const byHand = s.mode === 'remote' || s.mode === 'guided';
  return {
    reachable,
    may,
    known,
    lost: unknown(s),
    old,
    motion: !known || !s.sensed ? null : s.standingStill ? 'still' : 'moving',
    lead: !reachable ? null : s.lease.mine ? 'mine' : s.lease.holder !== 0 ? 'other' : 'nobody',
    led: moving(s.mode),
    stopped: known && stopped(s.mode),
    start,
    hand: byHand && s.lease.mine && reachable && known && !tooSlow(s),
    end: may && known,
    standby: reachable && known && s.mode === 'standby',
    calm: calmOf(s, start.user),
  };
}

let before: { text: string; value: Readiness } | null = null;
/** The same object while nothing in it changes, so that a screen renders only then. */
function kept(s: State): Readiness {
  const value = readinessOf(s);
  const text = JSON.stringify(value);
  if (before?.text !== text) before = { text, value };
  return before.value;
}
export const useReadiness = (): Readiness => useStore(kept);

/** Whether a reason for a refusal still holds. Reasons without a visible state are shown for `toldFor_ms`. */
export const toldFor_ms = 10_000;
const shown: readonly string[] = [
  'nodes_missing',
  'fault_active',
  'not_neutral',
  'moving',
  'battery_empty_start',
  'sensors_settling',
  'stick_not_neutral',
  'bumper_start',
  'fault_mode',
  'emergency_stop_open',
  'node_version',
  'not_calibrated',
  'parts_unchecked',
];
const passing: readonly string[] = [
  'no_answer',
  'stale_command',
  'out_of_order',
  'set_outdated',
  'release_first',
  'cause_not_cleared',
  'cause_not_seen',
  'busy',
];
export function stillStands(reason: string, s: Known, age_ms: number): boolean {
  if (reason === 'link_lost') return s.link !== 'open';
  if (reason === 'no_lease') return !s.lease.mine && s.lease.holder !== 0;
  if (reason === 'not_standby' || reason === 'only_when_stopped') return s.mode !== 'standby';
  if (shown.includes(reason)) return ((s.blockedBits >>> bitOf(reason)) & 1) === 1;
  return !passing.includes(reason) || age_ms < toldFor_ms;
}

/** Voltages of both batteries. Nothing of both: the input node has not told of them yet, NaN; nothing of one is a battery that is off. */
export const batteries = (r: Pick<TickRecord, 'battery_a_v' | 'battery_b_v'> | null): [number, number] =>
  r !== null && r.battery_a_v + r.battery_b_v > 0 ? [r.battery_a_v, r.battery_b_v] : [NaN, NaN];
