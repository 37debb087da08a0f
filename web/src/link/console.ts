// Joins the connection and the store, and offers the screens' actions. The only writer of the store.
import { codedFaults, faults, modes, type FaultName } from '../contract/faults.gen';
import { layoutHash } from '../contract/messages.gen';
import type { CalibrationMeasure, CalibrationStep, Exercise, GuidedPath, MarkerKind, ReasonCode, TaskRequest } from '../contract/rest.gen';
import type { ParamName } from '../contract/params.gen';
import { hasBit } from './bits';
import { readFrame, type Sample } from './frame';
import { live } from './live';
import { rememberSignedIn } from './known';
import { rest, type Answer, type Problem } from './rest';
import { causeReader } from './speed_cause';
import { Link, replyLost, type Question, type Reply, type Told } from './socket';
import { openTicketed } from './ticketed';
import { wants } from './wants';
import { moving, stopped, store, writable, type Emergency, type LogLine, type Notice, type State } from './store';

const late_ms = 500;
const gone_ms = 1000;
const ageCheck_ms = 100;
const logLines = 200;
/** If the hoist has not begun to stop after this time, STOP is sent again, also over plain HTTP. */
const stopAgain_ms = 300;
const stopTries = 10;

const link = new Link(
  {
    open: openTicketed,
    now_ms: () => performance.now(),
    setTimer: (call, delay_ms) => window.setTimeout(call, delay_ms),
    clearTimer: (timer) => window.clearTimeout(timer),
  },
  {
    state(state) {
      if (state === 'open') {
        writable.set({ link: state, everOpen: true, signedIn: true });
        rememberSignedIn();
        askStream();
        void askWho();
      } else writable.set({ link: state, lease: { ...store.value.lease, mine: false } });
    },
    binary: takeFrame,
    text: takeText,
    refused: () => void checkSignedIn(),
  },
);

async function askWho(): Promise<void> {
  const answer = await rest('GET /api/v1/session');
  if (!answer.ok) return;
  writable.set({ person: answer.value.display_name, account: answer.value.has_pin !== null, hoistLanguage: answer.value.device.language });
}

async function checkSignedIn(): Promise<void> {
  const answer = await rest('GET /api/v1/status');
  if (!answer.ok && (answer.problem.status === 401 || answer.problem.status === 403)) writable.set({ signedIn: false });
}

/** Run of the core that the newest sample is of. */
let run: string | null = null;
/** Samples before the answer to `stream` belong to the time that the server sends anew. */
let answerBy_ms = 0;
const answerWithin_ms = 1000;

/** Asks for what is shown; after a lost connection also for what was missed. */
function askStream(): void {
  const { choice } = wants;
  const resume = run !== null && live.record !== null ? { last_tick: live.newestTick, run } : {};
  if (!link.send({ type: 'stream', ...choice, ...resume })) return;
  asked = JSON.stringify(choice);
  if ('run' in resume) answerBy_ms = performance.now() + answerWithin_ms;
}

let asked = '';
function changeStream(): void {
  const choice = JSON.stringify(wants.choice);
  if (choice === asked) return;
  if (link.send({ type: 'stream', ...wants.choice })) asked = choice;
}

function takeFrame(buffer: ArrayBuffer): void {
  const frame = readFrame(buffer);
  if (!frame.ok) {
    if (frame.why === 'layout') writable.set({ layoutDiffers: true });
    return;
  }
  const newest = frame.samples.at(-1);
  if (newest === undefined || performance.now() < answerBy_ms) return;
  live.take(frame.samples, frame.topics, performance.now());
  writable.set({ ...age(), ...slowPart(newest) });
  if (stoppedModes.has(newest.mode)) endStop(false);
  // The message of a failed STOP ends once the hoist stands and no mode leads it.
  else if (store.value.stopFailed && newest.standing_still === 1 && !moving(store.value.mode)) writable.set({ stopFailed: false });
}

const bitOf = (name: FaultName) => faults.find((fault) => fault.name === name)!.bit;
const duplicateBit = bitOf('node_duplicate');
const babblingBit = bitOf('node_babbling');
const nobody = 0xffff;

const parts = ['drive_left', 'drive_right', 'io', 'tilt_left', 'tilt_right', 'tilt_base'] as const;
function silentNodes(record: Sample): string {
  const silent = parts.filter((name) => record[`${name}_age_ticks`] === 255);
  return silent.length === parts.length ? '' : silent.join(' ');
}

/** Nodes whose values are on the motion screens; silent for so long they are old. */
const sensors = ['drive_left', 'drive_right', 'tilt_left', 'tilt_right', 'tilt_base'] as const;
const silentTicks = 50;

/** Modes in which STOP has no effect. */
const stoppedModes = new Set(modes.filter((mode) => stopped(mode.name)).map((mode) => mode.value));

/** Value of guided_phase while the hoist waits for a lagging patient at less than half its speed. */
const guidedWaits = 5;

const speedCause = causeReader();

function slowPart(record: Sample) {
  return {
    mode: modes[record.mode]?.name ?? 'init',
    faultBits: record.fault_bits,
    stopCause: record.stop_cause,
    faultCodes: JSON.stringify(Object.fromEntries(codedFaults.map((name) => [name, record[`${name}_code`]]))),
    silentNodes: silentNodes(record),
    blockedBits: record.blocked_bits,
    standingStill: record.standing_still === 1,
    waits: record.guided_phase === guidedWaits,
    speedCause: speedCause(record),
    sensed: record.bus_up === 1 && sensors.every((name) => record[`${name}_age_ticks`] < silentTicks),
    bumpers: record.bumpers,
    bumpersHeld: (record.bumpers & ~record.bumpers_acknowledged) === 0,
    alarmSound: record.alarm_sound,
    alarmPause_s: Math.ceil(record.alarm_pause_s),
    trial_s: Math.ceil(record.settings_trial_s),
    // The alarm and its device name stay until acknowledged, also after the cause is gone.
    duplicateId: record.duplicate_id !== 0 ? record.duplicate_id : hasBit(record.fault_bits, duplicateBit) ? store.value.duplicateId : null,
    babblingId: record.babbling_id !== nobody ? record.babbling_id : hasBit(record.fault_bits, babblingBit) ? store.value.babblingId : null,
  } as const;
}

/** This page controlled the hoist, also before a lost connection. */
let led = false;

function takeText(message: Told): void {
  const now = store.value;
  switch (message.type) {
    case 'welcome': {
      writable.set({
        client: message.client,
        role: message.role,
        version: message.version,
        simulated: message.simulated,
        scenario: message.scenario,
        layoutDiffers: message.layout_hash !== layoutHash,
      });
      break;
    }
    case 'parameters':
      writable.set({ parameters: message.values, parameterVersion: message.version });
      break;
    case 'lease':
      writable.set({ lease: { epoch: message.epoch, holder: message.holder, mine: message.mine, actor: message.actor, asking: message.asking } });
      if (message.mine || now.leaseTaken) writable.set({ leaseTaken: !message.mine && message.holder !== 0 });
      else if (led && message.holder !== 0) writable.set({ leaseTaken: true });
      led = message.mine;
      break;
    case 'recording': {
      const { state, session, standby, started_utc_ms, samples, reason_code } = message;
      writable.set({ recording: { state, session, standby, started_utc_ms, samples, reason: reason_code } });
      break;
    }
    case 'patient':
      writable.set({ patient: message.id === null ? null : { id: message.id, code: message.code ?? '' } });
      break;
    case 'notices':
      writable.set({ standing: message.items });
      break;
    case 'walk': {
      live.takeWalk(message);
      // A server restarted in the middle of a walk does not know its start.
      const begun = message.begun ?? (message.mark === null && live.record !== null ? now.begun : null);
      writable.set({ exercise: message.exercise, task: message.task, begun });
      break;
    }
    case 'core':
      run = message.run;
      writable.set({ coreConnected: message.connected, coreReason: message.reason_code });
      break;
    case 'streaming':
      answerBy_ms = 0;
      break;
    case 'gap':
      live.takeGap(message);
      break;
    case 'event': {
      const line: LogLine = {
        time_ns: message.time_ns,
        kind: message.kind,
        name: message.name ?? '',
        value: message.value ?? null,
        before: message.before ?? null,
        code: message.code ?? null,
      };
      if (line.kind === 'emergency')
        takeEmergencies([{ time_ns: line.time_ns, node: line.name, code: line.code ?? 0, errorRegister: message.bits ?? 0 }]);
      // Other ends are shown by the strip, or were requested.
      if (line.kind === 'guided_ended' && line.name === 'finished') notify('info', 'guided.finished');
      if (line.kind === 'guided_ended' && line.name === 'off_path') notify('warning', 'guided.off_path');
      // The hoist may behave otherwise from here on, perhaps in the middle of a walk.
      if (line.kind === 'parameters_reverted') notify('warning', 'trial.reverted');
      writable.set({ log: [...now.log, line].slice(-logLines) });
      break;
    }
    case 'notice':
      notify(message.level, message.text_key);
      break;
    case 'job':
      // Only a screen that shows it has it: the result stands on Health, not in the message.
      if (message.kind === 'integrity_check' && store.value.recordings !== null) void fetchHealth();
      break;
    case 'firmware_progress': // no screen shows updates yet
      break;
  }
}

const emergenciesMost = 64;
function takeEmergencies(more: readonly Emergency[]): void {
  const all = new Map([...store.value.emergencies, ...more].map((item) => [`${item.time_ns} ${item.node} ${item.code}`, item]));
  writable.set({ emergencies: [...all.values()].sort((a, b) => a.time_ns - b.time_ns).slice(-emergenciesMost) });
}

/** Emergency messages from before this page was opened, and what is known of the recordings. */
export async function fetchHealth(): Promise<Answer<unknown>> {
  const answer = await rest('GET /api/v1/health');
  if (answer.ok) {
    writable.set({ recordings: answer.value.recordings });
    takeEmergencies(
      answer.value.emergencies.map((item) => ({
        time_ns: item.time_ns,
        node: item.node,
        code: item.emergency.code,
        errorRegister: item.error_register,
      })),
    );
  }
  return answer;
}

let noticeId = 0;
const noticesMost = 3;
const noticeFor_ms = 6000;
/** A short sentence at the edge of the screen. */
export function notify(level: Notice['level'], text: string, plain = false): void {
  if (text === '') return;
  const id = ++noticeId;
  // The same message again replaces the previous one for its full time, so that a second mark is visible.
  writable.set({ notices: [...store.value.notices.filter((notice) => notice.text !== text), { id, level, text, plain }].slice(-noticesMost) });
  window.setTimeout(() => writable.set({ notices: store.value.notices.filter((notice) => notice.id !== id) }), noticeFor_ms);
}

/** How old is what is shown: since it came, or as long as the round trip, whose half it may have taken to come. The sum would be exceeded by a WiFi
 * with short bursts of delay. */
function age(): Partial<State> {
  const { rtt_s } = link;
  if (live.record === null) return { rtt_s };
  const age_ms = Math.max(performance.now() - live.received_ms, (rtt_s ?? 0) * 1000);
  const data = age_ms > gone_ms ? 'gone' : age_ms > late_ms ? 'late' : 'fresh';
  return { rtt_s, data, dataAge_s: data === 'fresh' ? 0 : Math.floor(age_ms / 100) / 10 };
}

export function startLink(): void {
  wants.onChange(changeStream);
  link.start();
  window.setInterval(() => writable.set(age()), ageCheck_ms);
  document.addEventListener('visibilitychange', () => {
    if (!document.hidden) link.hurry();
  });
  window.addEventListener('online', () => link.hurry());
}

/** The sign-in of this device has changed: the connection starts again. */
export function reconnect(): void {
  link.stop();
  link.start();
}

// ------------------------------------------------------------------------------------------------ actions of screens
let stopTimer = 0;

/** STOP. Sent at once, and repeated, also over plain HTTP, until the hoist reports the stop. A press meanwhile goes over both, and does not delay
 * the repetition or the report that STOP failed. */
export function stop(): void {
  const again = store.value.stopSent;
  sendStop(again);
  if (again) return;
  writable.set({ stopSent: true });
  let left = stopTries;
  stopTimer = window.setInterval(() => {
    if (--left > 0) sendStop(true);
    else endStop(true);
  }, stopAgain_ms);
}

function sendStop(http: boolean): void {
  if (!link.send({ type: 'stop' }) || http) void rest('POST /api/v1/stop').then((answer) => answer.ok && endStop(false));
}

function endStop(stopFailed: boolean): void {
  window.clearInterval(stopTimer);
  writable.set({ stopSent: false, stopFailed });
}

/** The newest time stamp seen: driving commands, starts and acknowledgements echo it, so that old ones are recognised. */
export const echo = () => live.record?.time_ns ?? 0;

let driveSequence = 0;
export function drive(speed: number, yaw: number, held: boolean): boolean {
  // A stalled link must not fill up with old wishes: they would all be late.
  if (link.queued > 2048) return false;
  return link.send({ type: 'drive', sequence: ++driveSequence, echo: echo(), speed, yaw, held });
}

export const takeLease = (take_over: boolean): Promise<Reply> => link.request({ type: 'lease_take', take_over });
export const releaseLease = (): Promise<Reply> => {
  led = false;
  return link.request({ type: 'lease_release' });
};
/** The holder sees who asks. */
export const askLease = async (): Promise<Reply> => {
  const reply = await link.request({ type: 'lease_ask' });
  if (reply.ok) notify('info', 'lease.asked');
  return reply;
};
export const keepLease = (): Promise<Reply> => link.request({ type: 'lease_keep' });
export const handOver = async (client: number): Promise<Reply> => {
  led = false; // it is not taken from this screen
  const reply = await link.request({ type: 'lease_hand_over', client });
  if (!reply.ok) led = store.value.lease.mine;
  return reply;
};
export const takenSeen = (): void => writable.set({ leaseTaken: false });

/** Asks whether to take control from another client; set by the shell, which shows the question. */
export const dialogs: { askTakeOver: () => Promise<boolean> } = { askTakeOver: () => Promise.resolve(false) };

/** Ensures that this console is in control. Takes free control at once, asks before taking it from another. */
export async function ensureLease(): Promise<Reply> {
  const { lease, link: state } = store.value;
  if (state !== 'open') return replyLost;
  if (lease.mine) return { ok: true, refusals: [], errors: [] };
  if (lease.holder === 0) {
    const reply = await takeLease(false);
    if (reply.ok) return reply;
    if (store.value.lease.holder === 0) return reply;
  }
  if (!(await dialogs.askTakeOver())) return { ok: false, refusals: ['kept'], errors: [] };
  return takeLease(true);
}

/** What begins motion or leaves a stop is refused when the hoist gets it more than a second after what this screen had seen. */
const dated = (message: Question): Question => (message.type === 'mode' || message.type === 'acknowledge' ? { ...message, echo: echo() } : message);

async function withLease(message: Question, unanswered?: Question): Promise<Reply> {
  const lease = await ensureLease();
  if (!lease.ok) return lease;
  const reply = await link.request(dated(message), unanswered);
  if (reply.ok && reply.stored === false) notify('warning', 'settings.notStored');
  return reply;
}

/** Settings need no control; they carry a version. */
async function change(message: Extract<Question, { version?: number }>): Promise<Reply> {
  const version = store.value.parameterVersion;
  const reply = await link.request({ ...message, ...(version > 0 ? { version } : {}) });
  if (reply.ok && reply.stored === false) notify('warning', 'settings.notStored');
  return reply;
}

/** The patient of the next walk, on all screens; null: none. Answered like a plain request, since the same screens use it. */
export async function choosePatient(patient: number | null): Promise<Problem | null> {
  const reply = await link.request({ type: 'choose_patient', patient });
  return reply.ok ? null : { status: 0, code: reply.reason_code ?? '', errors: reply.errors, refusals: reply.refusals, wait_s: null };
}

const end: Question = { type: 'mode', mode: 'standby' };
/** Anyone may end a motion. */
export const endMotion = (): Promise<Reply> => link.request(end);
/** The exercise of the next walk, on all screens. */
export const chooseExercise = (exercise: Exercise): Promise<Reply> => link.request({ type: 'choose', exercise });
/** The clinical task of the next walks and its line, on all screens. Null: done; otherwise why not. */
export async function chooseTask(task: TaskRequest): Promise<Reply | null> {
  const answer = await rest('PUT /api/v1/task', { body: task });
  if (answer.ok) return null;
  const { code, errors, refusals } = answer.problem;
  return { ok: false, detail: '', reason_code: code as ReasonCode, errors: [...errors], refusals: [...refusals] };
}
/** A start without an answer is followed by End: the hoist must not start after the screen has reported a failure. Without an exercise the hoist is
 * only moved: the one under way stays where it lies on the floor. */
export const requestMode = (mode: 'user' | 'remote', exercise: Exercise | null, start_again = false): Promise<Reply> =>
  withLease({ type: 'mode', mode, exercise, start_again }, end);
/** Starts GUIDED: an exercise that the hoist drives while the button is held. */
export const requestGuided = (path: GuidedPath, start_again: boolean): Promise<Reply> =>
  withLease({ type: 'mode', mode: 'guided', path, start_again }, end);
/** Acknowledges a stop. `seen`: names of the faults shown at the press; the hoist refuses when another has come since. */
export const acknowledge = (seen: readonly string[]): Promise<Reply> => withLease({ type: 'acknowledge', ...(seen.length > 0 ? { seen } : {}) });
/** The alarms in force stop sounding for two minutes, at the hoist and on every screen, or sound again. */
export const pauseAlarm = (paused: boolean): Promise<Reply> => link.request({ type: 'pause_alarm', paused });
export const setNeutral = (): Promise<Reply> => link.request({ type: 'neutral' });
export const calibrate = (step: CalibrationStep, harness_empty: boolean): Promise<Reply> =>
  withLease(harness_empty ? { type: 'calibrate', step, harness_empty } : { type: 'calibrate', step });
export const calibrateMeasure = (measured: CalibrationMeasure): Promise<Reply> => withLease({ type: 'calibrate_measure', ...measured });
export const calibrateUse = (): Promise<Reply> => withLease({ type: 'calibrate_use' });
export const calibrateCancel = (): Promise<Reply> => withLease({ type: 'calibrate_cancel' });
export const setParameters = (values: Partial<Record<ParamName, number>>): Promise<Reply> => change({ type: 'set', values });
/** Values on trial, which return by themselves unless kept: for changes during a walk. */
export const tryParameters = (values: Partial<Record<ParamName, number>>, revert_after_s: number): Promise<Reply> =>
  change({ type: 'set', values, revert_after_s });
/** Keeps the shown values; after another change meanwhile the hoist refuses (H27). */
export const keepSettings = (): Promise<Reply> => change({ type: 'keep_settings' });
export const undoSettings = (): Promise<Reply> => link.request({ type: 'undo_settings' });
export const applyPreset = (name: string): Promise<Reply> => change({ type: 'preset', name });
export const marker = (text: string, kind: MarkerKind): Promise<Reply> => link.request({ type: 'marker', text, kind });
export const everyTick = (on: boolean): void => wants.everyTick(on);
