// What the console knows at this moment. Screens read it through useStore; only link/ writes it.
import { useEffect, useReducer, useRef } from 'preact/hooks';
import { modes, type ModeName } from '../contract/faults.gen';
import type { RecordingMessage } from '../contract/messages.gen';
import type { Exercise, GuidedPath, ReasonCode, StandingNotice } from '../contract/rest.gen';
import type { LinkState } from './socket';

export type Recording = Pick<RecordingMessage, 'state' | 'session' | 'started_utc_ms' | 'samples'> & {
  /** Why it failed. */
  reason: ReasonCode | null;
};
export interface LogLine {
  time_ns: number;
  kind: string;
  name: string;
  value: number | null;
  before: number | null;
  code: number | null;
}
/** An emergency message of a node; code 0 says that an error has ended. */
export interface Emergency {
  time_ns: number;
  node: string;
  code: number;
  errorRegister: number;
}
export interface Notice {
  id: number;
  level: 'info' | 'warning' | 'error';
  /** Key of the message files, or a sentence when `plain`. */
  text: string;
  plain: boolean;
}

export interface State {
  link: LinkState;
  everOpen: boolean;
  signedIn: boolean;
  layoutDiffers: boolean;
  rtt_s: number | null;
  /** Age of the newest record: fresh, or late (over 0.5 s), or gone (over 1 s), or none yet. */
  data: 'none' | 'fresh' | 'late' | 'gone';
  dataAge_s: number;
  client: number | null;
  role: string;
  version: string;
  simulated: boolean;
  scenario: string | null;
  /** Chosen for the next walk, on all screens. */
  exercise: Exercise;
  /** What the present or the latest motion began with. Null: not known. */
  begun: Exercise | GuidedPath | null;
  /** Null: not told yet. */
  coreConnected: boolean | null;
  /** Why it is not connected. */
  coreReason: ReasonCode | null;
  parameters: Record<string, number>;
  parameterVersion: number;
  lease: { epoch: number; holder: number; mine: boolean };
  /** Another screen has taken control from this one, and the notice is not closed yet. */
  leaseTaken: boolean;
  recording: Recording;
  // The slow part of the newest record: kept here so that screens draw anew only when it changes.
  mode: ModeName;
  faultBits: number;
  /** Fault that came first of the latest stop, plus one; 0 = none. */
  stopCause: number;
  /** What the faults are about (FaultCodes), as JSON so that equal ones are equal. */
  faultCodes: string;
  /** Names of the nodes that have not been heard for 2.5 s or never, with a blank between; empty while all or none of them are. */
  silentNodes: string;
  blockedBits: number;
  standingStill: boolean;
  /** In an exercise: the patient lags, and the hoist goes slowly or stands until he has caught up. */
  waits: boolean;
  /** Bus, drives and tilt sensors are heard: what is shown of them is of now. */
  sensed: boolean;
  bumpers: number;
  /** All that touch were acknowledged: the hoist may be driven away from them. */
  bumpersHeld: boolean;
  /** Whole seconds until values on trial go back; 0 = none are. */
  trial_s: number;
  /** Node id that two devices share, and CAN id that floods the bus: kept while the alarm about it is shown. Null = not told. */
  duplicateId: number | null;
  babblingId: number | null;
  stopSent: boolean;
  stopFailed: boolean;
  log: LogLine[];
  emergencies: Emergency[];
  notices: Notice[];
  /** What stays wrong until it is mended; shown in the strip. */
  standing: readonly StandingNotice[];
}

/** Stopped until somebody acknowledges: the modes that the big release button is for. */
export const stopped = (mode: ModeName): boolean => mode === 'protective_stop' || mode === 'fault' || mode === 'emergency_stop';

/** Somebody leads the hoist, by the mode table. */
export const moving = (mode: ModeName): boolean => modes.some((row) => row.name === mode && row.moving);

/** The figure that is under way, as far as this page knows it; on standby the chosen one. */
export function figure({ mode, exercise, begun }: Pick<State, 'mode' | 'exercise' | 'begun'>): Exercise {
  return moving(mode) ? (begun ?? free) : exercise;
}
const free: Exercise = { shape: 'free' };

/** Whether anybody knows what the hoist does now. At the very first, before anything was heard, it is taken to be starting. */
export const unknown = ({ link, everOpen, data, coreConnected }: Pick<State, 'link' | 'everOpen' | 'data' | 'coreConnected'>): boolean =>
  data === 'gone' || (data === 'none' && (coreConnected === false || (everOpen && link !== 'open')));

export const initial: State = {
  link: 'connecting',
  everOpen: false,
  signedIn: true,
  layoutDiffers: false,
  rtt_s: null,
  data: 'none',
  dataAge_s: 0,
  client: null,
  role: '',
  version: '',
  simulated: false,
  scenario: null,
  exercise: { shape: 'eight', c_m: 1.0, radius_m: 0.8 },
  begun: null,
  coreConnected: null,
  coreReason: null,
  parameters: {},
  parameterVersion: 0,
  lease: { epoch: 0, holder: 0, mine: false },
  leaseTaken: false,
  recording: { state: 'idle', session: null, started_utc_ms: null, samples: 0, reason: null },
  mode: 'init',
  faultBits: 0,
  stopCause: 0,
  faultCodes: '{}',
  silentNodes: '',
  blockedBits: 0,
  standingStill: true,
  waits: false,
  sensed: true,
  bumpers: 0,
  bumpersHeld: true,
  trial_s: 0,
  duplicateId: null,
  babblingId: null,
  stopSent: false,
  stopFailed: false,
  log: [],
  emergencies: [],
  notices: [],
  standing: [],
};

export class Store<T extends object> {
  private listeners = new Set<() => void>();
  constructor(public value: T) {}

  /** Changes some fields; tells nobody when all of them stay as they are. */
  set(change: Partial<T>): void {
    let differs = false;
    for (const key of Object.keys(change) as (keyof T)[]) if (!Object.is(this.value[key], change[key])) differs = true;
    if (!differs) return;
    this.value = { ...this.value, ...change };
    for (const listener of [...this.listeners]) listener();
  }

  subscribe(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}

/** For link/ only; a rule of the linter keeps others from it. */
export const writable = new Store<State>(initial);
export const store: Pick<Store<State>, 'subscribe'> & { readonly value: State } = writable;

/** Draws the component anew when the chosen part changes. */
export function useStore<R>(choose: (state: State) => R): R {
  const [, again] = useReducer((n: number) => n + 1, 0);
  const chosen = choose(store.value);
  const last = useRef(chosen);
  last.current = chosen;
  useEffect(() => {
    const check = () => {
      if (!Object.is(choose(store.value), last.current)) again(0);
    };
    check();
    return store.subscribe(check);
  }, []);
  return chosen;
}
