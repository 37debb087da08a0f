// Made by `deploy/dev gen` from server/contract/messages.def and reasons.def, control/contract/commands.hpp and can_dictionary.def; do not edit.

import type { Actor, Exercise, FieldError, GuidedPath, JobKind, Pose, ReasonCode, StandingNotice } from './rest.gen';

/** Why something was not done, or is not there. */
export const reasons: Readonly<Record<ReasonCode, { en: string; de: string }>> = {
  refused: { en: 'The hoist refused this.', de: 'Das Gerät hat das abgelehnt.' },
  no_core: { en: 'The control computer does not answer.', de: 'Der Steuerrechner antwortet nicht.' },
  busy: { en: 'Busy just now. Try again in a moment.', de: 'Gerade beschäftigt. Gleich noch einmal versuchen.' },
  role: { en: 'Your role may not do this.', de: 'Ihre Rolle darf das nicht.' },
  no_session: { en: 'This device is not signed in.', de: 'Dieser Bildschirm ist nicht angemeldet.' },
  invalid: { en: 'This value cannot be used.', de: 'Dieser Wert ist nicht brauchbar.' },
  exercise: { en: 'The hoist cannot walk this exercise.', de: 'Diese Übung kann das Gerät nicht fahren.' },
  measurement: { en: 'This measurement cannot be used.', de: 'Diese Messung ist nicht brauchbar.' },
  message: { en: 'This page and the software of the hoist do not match. Load the page again.', de: 'Diese Seite passt nicht zur Software des Geräts. Seite neu laden.' },
  unknown: { en: 'This is no longer there.', de: 'Das gibt es nicht mehr.' },
  not_now: { en: 'This session is still being recorded.', de: 'Diese Sitzung wird noch aufgezeichnet.' },
  not_recording: { en: 'Nothing is being recorded.', de: 'Es läuft keine Aufnahme.' },
  job_ended: { en: 'This job has already ended.', de: 'Dieser Auftrag ist schon beendet.' },
  disk_full: { en: 'The storage is full.', de: 'Der Speicher ist voll.' },
  read_only: { en: 'This storage is write-protected.', de: 'Dieser Speicher ist schreibgeschützt.' },
  storage: { en: 'The storage does not answer. Call service if it stays so.', de: 'Der Speicher antwortet nicht. Bleibt es so, Service rufen.' },
  internal: { en: 'Something went wrong in the server. Call service if it stays so.', de: 'Im Server ging etwas schief. Bleibt es so, Service rufen.' },
  wrong_secret: { en: 'Name and password do not match. Check both.', de: 'Name und Passwort passen nicht zusammen. Bitte beides prüfen.' },
  too_soon: { en: 'Too many attempts. Wait a moment.', de: 'Zu viele Versuche. Kurz warten.' },
  pin_not_here: { en: 'The PIN works only where you have signed in before. Use the password.', de: 'Die PIN gilt nur, wo Sie schon angemeldet waren. Bitte das Passwort nehmen.' },
  no_account: { en: 'This is no account with a password.', de: 'Dieses Konto hat kein Passwort.' },
  not_found: { en: 'This is no longer there.', de: 'Das gibt es nicht mehr.' },
  set_up_closed: { en: 'Turn the set-up switch off and on, and read the new code.', de: 'Einrichtungsschalter aus- und einschalten und den neuen Code ablesen.' },
  wrong_code: { en: 'This is not the code. Read it once more from the hoist.', de: 'Der Code stimmt nicht. Bitte noch einmal am Gerät ablesen.' },
  accounts: { en: 'The accounts cannot be read. Call service.', de: 'Die Konten sind nicht lesbar. Service rufen.' },
  core_absent: { en: 'The control program is not running.', de: 'Das Steuerprogramm läuft nicht.' },
  core_silent: { en: 'The control program is running but gives no reply.', de: 'Das Steuerprogramm läuft, reagiert aber nicht.' },
  core_gone: { en: 'The control program has ended.', de: 'Das Steuerprogramm wurde beendet.' },
  core_taken: { en: 'Another console server is connected to it.', de: 'Ein anderer Konsolenserver ist damit verbunden.' },
  core_build: { en: 'Its parts are of different software versions: switch the hoist off and on.', de: 'Seine Teile haben verschiedene Softwarestände: Gerät aus- und einschalten.' },
  core_refused: { en: 'The control program refused the console server. Call service.', de: 'Das Steuerprogramm weist den Konsolenserver ab. Service rufen.' },
  core_unreachable: { en: 'The console server cannot reach the control program.', de: 'Der Konsolenserver erreicht das Steuerprogramm nicht.' },
  no_exercise: { en: 'No exercise was chosen.', de: 'Es war keine Übung gewählt.' },
  no_motion: { en: 'Nobody walked in this session.', de: 'In dieser Sitzung ging niemand.' },
  part_missing: { en: 'Part of this walk is not recorded.', de: 'Ein Teil dieses Wegs ist nicht aufgezeichnet.' },
  several_walks: { en: 'This recording holds more than one walk: it was started anew, or led by someone else.', de: 'Diese Aufzeichnung enthält mehr als einen Weg: Es wurde neu begonnen, oder jemand anderes hat geführt.' },
  start_unclear: { en: 'It is not clear where on the exercise this walk began.', de: 'Es ist unklar, an welcher Stelle der Übung dieser Weg begann.' },
  not_comparable: { en: 'The recorded path cannot be compared with this exercise.', de: 'Der aufgezeichnete Weg lässt sich mit dieser Übung nicht vergleichen.' },
  too_short: { en: 'The walk was too short, or had no turn in it.', de: 'Der Weg war zu kurz oder hatte keine Drehung.' },
};

/** Take control; take_over takes it from somebody else while standing still. */
export interface LeaseTakeRequest {
  type: 'lease_take';
  /** Comes back in the reply. */
  request: number;
  /** Also when somebody else is in control. */
  take_over?: boolean;
}

/** Give control back. */
export interface LeaseReleaseRequest {
  type: 'lease_release';
  /** Comes back in the reply. */
  request: number;
}

/** Start motion, which needs control, or end it, which anyone may. An exercise that was broken off goes on; another one begins at its start. */
export interface ModeRequest {
  type: 'mode';
  /** Comes back in the reply. */
  request: number;
  /** What to change to. */
  mode: "user" | "remote" | "guided" | "standby";
  /** What is walked; goes into the recording. */
  exercise?: Exercise | null;
  /** For guided: what the hoist drives while the button is held; is the exercise, too. */
  path?: GuidedPath | null;
  /** Sets a new start mark although the same exercise could go on. */
  start_again?: boolean;
}

/** STOP. Never refused. */
export interface StopRequest {
  type: 'stop';
}

/** Leave a stop once its cause is gone. */
export interface AcknowledgeRequest {
  type: 'acknowledge';
  /** Comes back in the reply. */
  request: number;
  /** Faults that were shown when the hand went down; refused when another has come since. */
  seen?: readonly string[];
}

/** Driving command, 25 per second while held. Not answered; refusals are counted and told at most once per second. */
export interface DriveRequest {
  type: 'drive';
  /** Rises with every message of one connection. */
  sequence: number;
  /** time_ns of the newest record seen. */
  echo: number;
  /** -1 to 1 of the driving limit, forward positive. */
  speed: number;
  /** -1 to 1 of the turning limit, left positive. */
  yaw: number;
  /** Hold-to-run is held. */
  held: boolean;
}

/** Change parameters, all or nothing. */
export interface SetRequest {
  type: 'set';
  /** Comes back in the reply. */
  request: number;
  /** Names and new values. */
  values: Record<string, number>;
  /** Of the parameters that were looked at; refused when others have changed them meanwhile. */
  version?: number;
  /** Only on trial: the values before come back after so many seconds unless confirmed. */
  revert_after_s?: number;
}

/** Values on trial stay. */
export interface KeepSettingsRequest {
  type: 'keep_settings';
  /** Comes back in the reply. */
  request: number;
  /** Of the parameters that were looked at; refused when others have changed them meanwhile. */
  version?: number;
}

/** Values on trial go back at once. */
export interface UndoSettingsRequest {
  type: 'undo_settings';
  /** Comes back in the reply. */
  request: number;
}

/** Set all values of a preset. */
export interface PresetRequest {
  type: 'preset';
  /** Comes back in the reply. */
  request: number;
  /** Name of the preset. */
  name: string;
  /** As of set. */
  version?: number;
}

/** Choose the exercise of the next walk, for all screens; not while the hoist is led. */
export interface ChooseRequest {
  type: 'choose';
  /** Comes back in the reply. */
  request: number;
  /** What is walked next unless the start says otherwise. */
  exercise: Exercise;
}

/** Take the way the patient stands now as upright. */
export interface NeutralRequest {
  type: 'neutral';
  /** Comes back in the reply. */
  request: number;
}

/** Begin a step of calibration on standby, or another one. The wheels never turn by themselves. */
export interface CalibrateRequest {
  type: 'calibrate';
  /** Comes back in the reply. */
  request: number;
  /** Name of the step, see GET /api/v1/calibration. */
  step: string;
  /** True: the operator confirms that nobody is strapped in; steps with empty_harness need it. */
  harness_empty?: boolean;
}

/** What the operator measured; taken as soon as everything rests. */
export interface CalibrateMeasureRequest {
  type: 'calibrate_measure';
  /** Comes back in the reply. */
  request: number;
  /** In the unit of the step; the sign is the direction. */
  figure: number;
  /** Of a driven square: how far ahead of the shown place it truly ended. */
  x_m?: number;
  /** Of a driven square: how far to the left. */
  y_m?: number;
  /** Of a driven square: which way round. */
  turning?: "left" | "right";
}

/** The result becomes parameters, all or nothing. */
export interface CalibrateUseRequest {
  type: 'calibrate_use';
  /** Comes back in the reply. */
  request: number;
}

/** End calibrating; the old values stay. */
export interface CalibrateCancelRequest {
  type: 'calibrate_cancel';
  /** Comes back in the reply. */
  request: number;
}

/** Set the odometry's pose while standing still. */
export interface PoseRequest {
  type: 'pose';
  /** Comes back in the reply. */
  request: number;
  x_m: number;
  y_m: number;
  psi_rad: number;
}

/** Set a marker now in the session that is being recorded. */
export interface MarkerRequest {
  type: 'marker';
  /** Comes back in the reply. */
  request: number;
  /** At most 500 bytes. */
  text: string;
}

/** Choose how often live values come; every step only for whoever is in control. */
export interface StreamRequest {
  type: 'stream';
  every_tick: boolean;
}

/** Measure the way there and back. */
export interface PingRequest {
  type: 'ping';
  /** Comes back in the pong. */
  t: number;
}

/** What the console may send. */
export type ClientMessage =
  | LeaseTakeRequest
  | LeaseReleaseRequest
  | ModeRequest
  | StopRequest
  | AcknowledgeRequest
  | DriveRequest
  | SetRequest
  | KeepSettingsRequest
  | UndoSettingsRequest
  | PresetRequest
  | ChooseRequest
  | NeutralRequest
  | CalibrateRequest
  | CalibrateMeasureRequest
  | CalibrateUseRequest
  | CalibrateCancelRequest
  | PoseRequest
  | MarkerRequest
  | StreamRequest
  | PingRequest;

/** First message: who you are, what runs here. */
export interface WelcomeMessage {
  type: 'welcome';
  /** Number of this connection. */
  client: number;
  role: string;
  version: string;
  /** 16 hexadecimal digits; a page made for another layout reloads. */
  layout_hash: string;
  record_bytes: number;
  simulated: boolean;
  scenario: string | null;
}

/** Answer to a message with `request`. */
export interface ReplyMessage {
  type: 'reply';
  /** That of the message; 0 for a refused one that carried no whole number. */
  request: number;
  ok: boolean;
  /** Names of the refusal table. */
  refusals?: readonly string[];
  /** Which field, what is allowed. */
  errors?: readonly FieldError[];
  detail?: string;
  /** Why not, where no refusal says it; a row of reasons.def. */
  reason_code?: ReasonCode;
  /** Number of the lease just taken. */
  epoch?: number;
  /** Of a change of settings. False: in force, and not on the disk; see notices. */
  stored?: boolean;
}

/** Something the core did. */
export interface EventMessage {
  type: 'event';
  kind: string;
  tick: number;
  time_ns: number;
  code?: number;
  /** Name of the fault, mode, parameter or node. */
  name?: string;
  item?: number;
  /** Name of the node that a fault is about. */
  node?: string;
  /** Error register of an emergency message. */
  bits?: number;
  value?: number;
  before?: number;
  /** Who asked for it, where a client did; null: not known here. */
  actor?: Actor | null;
  refusals?: readonly string[];
}

/** Values in force, on connecting and after each change. */
export interface ParametersMessage {
  type: 'parameters';
  version: number;
  values: Record<string, number>;
}

/** Who is in control. */
export interface LeaseMessage {
  type: 'lease';
  epoch: number;
  /** 0 for nobody. */
  holder: number;
  mine: boolean;
}

/** What is being recorded. */
export interface RecordingMessage {
  type: 'recording';
  state: "idle" | "recording" | "failed";
  session: number | null;
  started_utc_ms: number | null;
  samples: number;
  /** Newest step that is safe on disk. */
  durable_tick: number | null;
  detail: string;
  /** Why it failed; a row of reasons.def. */
  reason_code: ReasonCode | null;
}

/** Whether the control core answers. */
export interface CoreMessage {
  type: 'core';
  connected: boolean;
  /** Why it is not connected, as in GET /api/v1/status. */
  problem: string | null;
  /** The same for programs; a row of reasons.def. */
  reason_code: ReasonCode | null;
}

/** The exercise and the walk since the start mark: on connecting, and when anything but the newest step changes it. */
export interface WalkMessage {
  type: 'walk';
  /** Chosen for the next walk. */
  exercise: Exercise;
  /** What the present or the latest motion began with; null: not known to this server. */
  begun: Exercise | GuidedPath | null;
  /** Newest step in what follows; null: none yet. */
  tick: number | null;
  /** Time in motion since the start mark; null: the mark is older than this server. */
  motion_s: number | null;
  /** Pose at the start mark; null: older than this server. */
  mark: Pose | null;
  /** A point of the path each so many metres. */
  step_m: number;
  /** The path walked so far, at most 2048 points. */
  x_m: readonly number[];
  y_m: readonly number[];
}

/** Answer to ping. */
export interface PongMessage {
  type: 'pong';
  t: number;
  /** The server's steady clock. */
  time_ns: number;
}

/** Something to tell the person. */
export interface NoticeMessage {
  type: 'notice';
  level: "info" | "warning";
  text_key: string;
  refusals?: readonly string[];
}

/** What stays wrong until it is mended: on connecting and after each change. */
export interface NoticesMessage {
  type: 'notices';
  items: readonly StandingNotice[];
}

/** Long work that was asked for, goes on (at most four times a second) or has ended; as in GET /api/v1/jobs, whose answer has all of them. */
export interface JobMessage {
  type: 'job';
  id: number;
  kind: JobKind;
  state: "waiting" | "running" | "done" | "failed" | "cancelled";
  /** 0 to 1. */
  progress: number;
  /** null: the server itself. */
  actor: Actor | null;
  asked_utc_ms: number;
  ended_utc_ms: number | null;
  /** Why it failed. */
  detail: string;
  /** The same for programs; a row of reasons.def. */
  reason_code: ReasonCode | null;
}

/** How far an update of a node's program has come: at most four times a second, and at its end. */
export interface FirmwareProgressMessage {
  type: 'firmware_progress';
  node: string;
  version: string;
  /** listening, asking_drives, asking_node, entering_loader, sending, checking, starting, done or failed. */
  phase: string;
  result: "running" | "done" | "unchanged" | "failed" | "interrupted";
  bytes_sent: number;
  bytes_total: number;
  /** Of the sending. */
  seconds_left: number | null;
  /** What happened and what to do next; empty while it runs. */
  text: string;
}

/** What the server sends as text. */
export type ServerMessage =
  | WelcomeMessage
  | ReplyMessage
  | EventMessage
  | ParametersMessage
  | LeaseMessage
  | RecordingMessage
  | CoreMessage
  | WalkMessage
  | PongMessage
  | NoticeMessage
  | NoticesMessage
  | JobMessage
  | FirmwareProgressMessage;

/** What the core reports. */
export const eventKinds = [
  'none',
  'command_done',
  'command_refused',
  'mode_changed',
  'fault_raised',
  'fault_cleared',
  'parameter_changed',
  'lease_changed',
  'node_changed',
  'pose_set',
  'neutral_set',
  'core_started',
  'emergency',
  'calibration_sample',
  'calibration_result',
  'calibration_ended',
  'guided_ended',
  'parameters_on_trial',
  'parameters_confirmed',
  'parameters_reverted',
] as const;
export type EventKind = (typeof eventKinds)[number];

export type NodeName =
  | 'drive_left'
  | 'drive_right'
  | 'io'
  | 'tilt_left'
  | 'tilt_right'
  | 'tilt_base'
  | 'core';

export interface NodeInfo {
  name: NodeName;
  id: number;
  title: string;
}

/** The nodes of the bus, in the order of their numbers in events. */
export const nodes: readonly NodeInfo[] = [
  { name: 'drive_left', id: 1, title: 'Left drive' },
  { name: 'drive_right', id: 2, title: 'Right drive' },
  { name: 'io', id: 8, title: 'Bumpers and batteries' },
  { name: 'tilt_left', id: 17, title: 'Left strut sensor' },
  { name: 'tilt_right', id: 18, title: 'Right strut sensor' },
  { name: 'tilt_base', id: 19, title: 'Chassis sensor' },
  { name: 'core', id: 127, title: 'Control computer' },
];

/** Two programs with different hashes do not understand each other. */
export const layoutHash = '98bbc4d56f903d5d';
