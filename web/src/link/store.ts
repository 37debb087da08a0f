// The console's state. Screens read it through useStore; only link/ writes it.
import { useEffect, useReducer, useRef } from 'preact/hooks';
import { modes, type ModeName } from '../contract/faults.gen';
import type { LeaseMessage, RecordingMessage } from '../contract/messages.gen';
import { usualExercise } from '../contract/exercises.gen';
import type { Exercise, GuidedPath, LanguageOrNull, ReasonCode, RecordingsHealth, StandingNotice, TaskState } from '../contract/rest.gen';
import type { LinkState } from './socket';

export type Recording = Pick<RecordingMessage, 'state' | 'session' | 'standby' | 'started_utc_ms' | 'samples'> & {
  /** Reason of the failure: a row of the table of reasons. */
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
  /** Round trip; grows while an answer is overdue. */
  rtt_s: number | null;
  /** Age of what is shown: fresh, or late (over 0.5 s), or gone (over 1 s), or none yet. */
  data: 'none' | 'fresh' | 'late' | 'gone';
  dataAge_s: number;
  client: number | null;
  role: string;
  /** Who is signed in here, by the name that screens show; null: not known. */
  person: string | null;
  /** Signed in with an account, which can sign out; not with the link of this computer. */
  account: boolean;
  /** The language set for the hoist; null: none. */
  hoistLanguage: LanguageOrNull;
  version: string;
  simulated: boolean;
  scenario: string | null;
  /** Chosen for the next walk, on all screens. */
  exercise: Exercise;
  /** The clinical task of the next walks, on all screens; null: none. */
  task: TaskState | null;
  /** Exercise at the start of the present or latest motion. Null: unknown. */
  begun: Exercise | GuidedPath | null;
  /** Null: not received yet. */
  coreConnected: boolean | null;
  /** Why it is not connected. */
  coreReason: ReasonCode | null;
  parameters: Record<string, number>;
  parameterVersion: number;
  lease: Pick<LeaseMessage, 'epoch' | 'holder' | 'mine' | 'actor' | 'asking'>;
  /** Another screen has taken control, and the notice is not closed yet. */
  leaseTaken: boolean;
  recording: Recording;
  /** For whom the next walk is recorded, on all screens. */
  patient: { id: number; code: string } | null;
  // The slow part of the newest record: kept here so that screens render only when it changes.
  mode: ModeName;
  faultBits: number;
  /** Fault that came first of the latest stop, plus one; 0 = none. */
  stopCause: number;
  /** Detail codes of the faults (FaultCodes), as JSON so that equal ones compare equal. */
  faultCodes: string;
  /** Names of the nodes silent for 2.5 s or from the start, separated by blanks; empty while all or none are. */
  silentNodes: string;
  blockedBits: number;
  standingStill: boolean;
  /** In an exercise: the hoist slows down or stands for a lagging patient. */
  waits: boolean;
  /** Value of a row of speedCauses; 0 = the hoist goes as fast as it is asked to. */
  speedCause: number;
  /** Bus, drives and tilt sensors are received: their values are current. */
  sensed: boolean;
  bumpers: number;
  /** All pressed bumpers were acknowledged: the hoist may be driven away from them. */
  bumpersHeld: boolean;
  /** Priority that sounds at the hoist: 0 none, 1 low, 2 medium, 3 high. */
  alarmSound: number;
  /** Whole seconds until paused alarms sound again; 0 = not paused. */
  alarmPause_s: number;
  /** Whole seconds until the trial ends; 0 = no trial. */
  trial_s: number;
  /** Node id that two devices share, and CAN id that floods the bus: kept while its alarm is shown. Null = unknown. */
  duplicateId: number | null;
  babblingId: number | null;
  stopSent: boolean;
  stopFailed: boolean;
  log: LogLine[];
  emergencies: Emergency[];
  /** What the server knows of the file of recordings; null before Health was opened. */
  recordings: RecordingsHealth | null;
  notices: Notice[];
  /** Standing notices; shown in the strip. */
  standing: readonly StandingNotice[];
}

/** Modes that are left by acknowledgement, with the release button. */
export const stopped = (mode: ModeName): boolean => mode === 'protective_stop' || mode === 'fault' || mode === 'emergency_stop';

/** Motion modes, by the mode table. */
export const moving = (mode: ModeName): boolean => modes.some((row) => row.name === mode && row.moving);

/** The running figure, if known; in STANDBY the chosen one. */
export function figure({ mode, exercise, begun }: Pick<State, 'mode' | 'exercise' | 'begun'>): Exercise {
  return moving(mode) ? (begun ?? free) : exercise;
}
const free: Exercise = usualExercise.free;

/** Whether the hoist's state is known. Before the first message it counts as starting. */
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
  person: null,
  account: false,
  hoistLanguage: null,
  version: '',
  simulated: false,
  scenario: null,
  exercise: usualExercise.eight,
  task: null,
  begun: null,
  coreConnected: null,
  coreReason: null,
  parameters: {},
  parameterVersion: 0,
  lease: { epoch: 0, holder: 0, mine: false, actor: null, asking: [] },
  leaseTaken: false,
  recording: { state: 'idle', session: null, standby: false, started_utc_ms: null, samples: 0, reason: null },
  patient: null,
  mode: 'init',
  faultBits: 0,
  stopCause: 0,
  faultCodes: '{}',
  silentNodes: '',
  blockedBits: 0,
  standingStill: true,
  waits: false,
  speedCause: 0,
  sensed: true,
  bumpers: 0,
  bumpersHeld: true,
  alarmSound: 0,
  alarmPause_s: 0,
  trial_s: 0,
  duplicateId: null,
  babblingId: null,
  stopSent: false,
  stopFailed: false,
  log: [],
  emergencies: [],
  recordings: null,
  notices: [],
  standing: [],
};

export class Store<T extends object> {
  private listeners = new Set<() => void>();
  constructor(public value: T) {}

  /** Changes some fields; no notification when all stay equal. */
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

/** For link/ only, enforced by the linter. */
export const writable = new Store<State>(initial);
export const store: Pick<Store<State>, 'subscribe'> & { readonly value: State } = writable;

/** Renders the component when the selected part changes. */
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
