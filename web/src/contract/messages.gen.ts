// Made by `deploy/dev gen` from server/contract/messages.def and reasons.def, control/contract/commands.hpp and can_dictionary.def; do not edit.

import type * as rest from './rest.gen';
import type { Actor, Exercise, FieldError, GuidedPath, JobKind, LeaseAsk, Pose, ReasonCode, StandingNotice, TaskState, TopicName } from './rest.gen';

/** Why something was not done, or is not there. */
export const reasons: Readonly<Record<ReasonCode, { en: string; de: string }>> = {
  refused: { en: 'The hoist refused this.', de: 'Das Gerät hat das abgelehnt.' },
  no_core: { en: 'The control computer does not answer.', de: 'Der Steuerrechner antwortet nicht.' },
  busy: { en: 'Busy just now. Try again in a moment.', de: 'Gerade beschäftigt. Gleich noch einmal versuchen.' },
  role: { en: 'Your role may not do this.', de: 'Ihre Rolle darf das nicht.' },
  no_session: { en: 'This device is not signed in.', de: 'Dieser Bildschirm ist nicht angemeldet.' },
  invalid: { en: 'This value cannot be used.', de: 'Dieser Wert ist nicht brauchbar.' },
  none_fits: { en: 'No session fits. Choose other days or another patient, or include the simulation.', de: 'Keine Sitzung passt. Andere Tage, eine andere Person oder auch die Simulation wählen.' },
  too_many: { en: 'Too many sessions for reports. Choose fewer days.', de: 'Zu viele Sitzungen für Berichte. Weniger Tage wählen.' },
  exercise: { en: 'The hoist cannot walk this exercise.', de: 'Diese Übung kann das Gerät nicht fahren.' },
  measurement: { en: 'This measurement cannot be used.', de: 'Diese Messung ist nicht brauchbar.' },
  message: { en: 'This page and the software of the hoist do not match. Load the page again.', de: 'Diese Seite passt nicht zur Software des Geräts. Seite neu laden.' },
  unknown: { en: 'This is no longer there.', de: 'Das gibt es nicht mehr.' },
  not_now: { en: 'This session is still being recorded.', de: 'Diese Sitzung wird noch aufgezeichnet.' },
  changed_meanwhile: { en: 'Someone else has changed this. Look at it again.', de: 'Das wurde inzwischen geändert. Bitte noch einmal ansehen.' },
  taken: { en: 'This name is already in use.', de: 'Diese Bezeichnung gibt es schon.' },
  patient_chosen: { en: 'This patient is chosen for the hoist. Choose another one first.', de: 'Diese Person ist für das Gerät gewählt. Zuerst eine andere wählen.' },
  identity_key: { en: 'The key of the names is missing or another one. Call service.', de: 'Der Schlüssel zu den Namen fehlt oder passt nicht. Service rufen.' },
  not_recording: { en: 'Nothing is being recorded.', de: 'Es läuft keine Aufnahme.' },
  lease_free: { en: 'Nobody else is in control.', de: 'Niemand sonst steuert.' },
  moving: { en: 'The hoist is moving. Try again when it stands.', de: 'Das Gerät fährt gerade. Sobald es steht, noch einmal versuchen.' },
  study_runs: { en: 'A study is already running. Wait for its end, or cancel it.', de: 'Es läuft schon eine Studie. Ihr Ende abwarten oder sie abbrechen.' },
  not_simulated: { en: 'Rehearsals need the simulated hoist. This one is real.', de: 'Proben gibt es nur am simulierten Gerät. Dieses ist echt.' },
  no_simulator: { en: 'The simulator takes no requests. Start the demo again.', de: 'Der Simulator nimmt keine Aufträge an. Demo neu starten.' },
  rehearsal_runs: { en: 'A rehearsal is under way. Cancel it first.', de: 'Es läuft schon eine Probe. Zuerst abbrechen.' },
  job_ended: { en: 'This job has already ended.', de: 'Dieser Auftrag ist schon beendet.' },
  system_clock: { en: 'The operating system keeps the time. Set it there.', de: 'Die Uhr stellt das Betriebssystem. Bitte dort stellen.' },
  disk_full: { en: 'The storage is full.', de: 'Der Speicher ist voll.' },
  read_only: { en: 'This storage is write-protected.', de: 'Dieser Speicher ist schreibgeschützt.' },
  storage: { en: 'The storage does not answer. Call service if it stays so.', de: 'Der Speicher antwortet nicht. Bleibt es so, Service rufen.' },
  internal: { en: 'Something went wrong in the server. Call service if it stays so.', de: 'Im Server ging etwas schief. Bleibt es so, Service rufen.' },
  wrong_secret: { en: 'The password or PIN does not belong to this name. Check it.', de: 'Passwort oder PIN passt nicht zum Namen. Bitte prüfen.' },
  too_soon: { en: 'Too many attempts. Wait a moment.', de: 'Zu viele Versuche. Kurz warten.' },
  sign_in_over: { en: 'Your sign-in has run out. Sign in again.', de: 'Die Anmeldung ist abgelaufen. Bitte neu anmelden.' },
  set_up_first: { en: 'The hoist has no accounts yet. Set it up first.', de: 'Das Gerät hat noch keine Konten. Zuerst einrichten.' },
  pin_not_here: { en: 'The PIN works only where you have signed in before. Use the password.', de: 'Die PIN gilt nur, wo Sie schon angemeldet waren. Bitte das Passwort nehmen.' },
  no_account: { en: 'This is no account with a password.', de: 'Dieses Konto hat kein Passwort.' },
  not_found: { en: 'This is no longer there.', de: 'Das gibt es nicht mehr.' },
  set_up_closed: { en: 'Turn the set-up switch off and on, and read the new code.', de: 'Einrichtungsschalter aus- und einschalten und den neuen Code ablesen.' },
  wrong_code: { en: 'This is not the code. Read it once more from the hoist.', de: 'Der Code stimmt nicht. Bitte noch einmal am Gerät ablesen.' },
  accounts: { en: 'The accounts cannot be used. Call service.', de: 'Die Konten sind nicht nutzbar. Service rufen.' },
  core_absent: { en: 'The control program is not running.', de: 'Das Steuerprogramm läuft nicht.' },
  core_silent: { en: 'The control program is running but gives no reply.', de: 'Das Steuerprogramm läuft, reagiert aber nicht.' },
  core_gone: { en: 'The control program has ended.', de: 'Das Steuerprogramm wurde beendet.' },
  core_taken: { en: 'Another console server is connected to it.', de: 'Ein anderer Konsolenserver ist damit verbunden.' },
  core_build: { en: 'Its parts are of different software versions: switch the hoist off and on.', de: 'Seine Teile haben verschiedene Softwarestände: Gerät aus- und einschalten.' },
  core_refused: { en: 'The control program refused the console server. Call service.', de: 'Das Steuerprogramm weist den Konsolenserver ab. Service rufen.' },
  core_unreachable: { en: 'The console server cannot reach the control program.', de: 'Der Konsolenserver erreicht das Steuerprogramm nicht.' },
  no_exercise: { en: 'No exercise was chosen.', de: 'Es war keine Übung gewählt.' },
  no_motion: { en: 'Nobody walked in this session.', de: 'In dieser Sitzung ging niemand.' },
  no_bout: { en: 'Nobody walked faster than 0.05 m/s for a second.', de: 'Niemand ging eine Sekunde lang schneller als 0,05 m/s.' },
  part_missing: { en: 'Part of this walk is not recorded.', de: 'Ein Teil dieses Wegs ist nicht aufgezeichnet.' },
  several_walks: { en: 'This recording holds more than one walk: it was restarted, or the mode changed.', de: 'Diese Aufzeichnung enthält mehr als einen Weg: Er wurde neu begonnen, oder die Betriebsart hat gewechselt.' },
  start_unclear: { en: 'It is not clear where on the exercise this walk began.', de: 'Es ist unklar, an welcher Stelle der Übung dieser Weg begann.' },
  not_comparable: { en: 'The recorded path cannot be compared with this exercise.', de: 'Der aufgezeichnete Weg lässt sich mit dieser Übung nicht vergleichen.' },
  too_short: { en: 'The walk was too short, or had no turn in it.', de: 'Der Weg war zu kurz oder hatte keine Drehung.' },
  no_lap: { en: 'The exercise was not walked to its end.', de: 'Die Übung wurde nicht bis zum Ende gegangen.' },
  few_strides: { en: 'There were too few steady strides.', de: 'Es waren zu wenige gleichmäßige Schritte.' },
  no_rhythm: { en: 'The sideways sway shows no clear stride.', de: 'Das seitliche Pendeln zeigt keinen klaren Schritt.' },
  no_turn: { en: 'There was no turn of 45° or more.', de: 'Es gab keine Drehung von 45° oder mehr.' },
  no_turn_back: { en: 'There was no turn of 160° or more on the way.', de: 'Unterwegs gab es keine Wende um 160° oder mehr.' },
  no_lead: { en: 'Pelvis and hoist did not turn alike.', de: 'Becken und Gerät drehten sich nicht ähnlich.' },
  too_long: { en: 'This value is defined for walks of up to ten minutes without a pause.', de: 'Dieser Wert gilt für Wege bis zehn Minuten ohne Pause.' },
  not_recorded: { en: 'This recording lacks a value that is needed.', de: 'Dieser Aufzeichnung fehlt ein nötiger Wert.' },
  no_task: { en: 'This session is not a repetition of such a task.', de: 'Diese Sitzung ist keine Wiederholung einer solchen Aufgabe.' },
  task_unfinished: { en: 'The end of the task was not reached.', de: 'Das Ende der Aufgabe wurde nicht erreicht.' },
  not_from_start: { en: 'The task began before this recording.', de: 'Die Aufgabe begann vor dieser Aufzeichnung.' },
  not_led: { en: 'The patient did not lead, or not far enough.', de: 'Der Patient führte nicht, oder nicht weit genug.' },
  settings_changed: { en: 'Settings were changed during this recording.', de: 'Während dieser Aufzeichnung wurden Einstellungen geändert.' },
  no_start: { en: 'The patient never set off from a standstill.', de: 'Der Patient ging nie aus dem Stand los.' },
  no_stop: { en: 'The patient never came to a stop by leaning back.', de: 'Der Patient hielt nie durch Zurücklehnen an.' },
  one_visit: { en: 'A comparison needs this value from two visits.', de: 'Für einen Vergleich braucht es diesen Wert aus zwei Terminen.' },
  few_repeats: { en: 'How much this value varies by itself is not known yet. Repeat the walk within a visit.', de: 'Wie stark dieser Wert von selbst schwankt, ist noch unklar. Den Weg am selben Termin wiederholen.' },
  within_noise: { en: 'The difference is no larger than the usual variation.', de: 'Der Unterschied ist nicht größer als die übliche Schwankung.' },
  few_walks: { en: 'This needs more walks within a visit: five in one, or two in each of six.', de: 'Dafür braucht es mehr Wege am selben Termin: fünf an einem, oder je zwei an sechs.' },
  no_slope: { en: 'From walk to walk it goes neither up nor down by more than chance.', de: 'Von Weg zu Weg geht es nicht mehr hinauf oder hinunter als der Zufall.' },
};

/** Take control; take_over takes it from somebody else while standing still. */
export type LeaseTakeRequest = { type: 'lease_take'; request: number } & rest.LeaseRequest;

/** Give control back. */
export type LeaseReleaseRequest = { type: 'lease_release'; request: number };

/** Ask the holder for control, who sees who asks, for a minute. */
export type LeaseAskRequest = { type: 'lease_ask'; request: number } & rest.LeaseAskRequest;

/** Keep control: those who ask are told. */
export type LeaseKeepRequest = { type: 'lease_keep'; request: number };

/** Give control to another client or person while the hoist stands still. */
export type LeaseHandOverRequest = { type: 'lease_hand_over'; request: number } & rest.HandOverRequest;

/** Start motion, which needs control, or end it, which anyone may. An exercise that was broken off goes on; another one begins at its start. */
export type ModeRequest = { type: 'mode'; request: number } & rest.ModeRequest;

/** STOP. Never refused. */
export type StopRequest = { type: 'stop' };

/** Leave a stop once its cause is gone. */
export type AcknowledgeRequest = { type: 'acknowledge'; request: number } & rest.AcknowledgeRequest;

/** The alarms in force stop sounding for two minutes, at the hoist and on every screen; their lights go on. A new alarm sounds at once. */
export type PauseAlarmRequest = { type: 'pause_alarm'; request: number } & rest.AlarmPauseRequest;

/** Driving command, 25 per second while held. Not answered; refusals are counted and told at most once per second. */
export type DriveRequest = { type: 'drive' } & rest.DriveRequest;

/** Change parameters, all or nothing. */
export type SetRequest = { type: 'set'; request: number } & rest.SetRequest;

/** Values on trial stay. */
export type KeepSettingsRequest = { type: 'keep_settings'; request: number } & rest.KeepRequest;

/** Values on trial go back at once. */
export type UndoSettingsRequest = { type: 'undo_settings'; request: number };

/** Set all values of a preset. */
export type PresetRequest = { type: 'preset'; request: number } & rest.PresetRequest;

/** Choose the exercise of the next walk, for all screens; not while the hoist is led. */
export type ChooseRequest = { type: 'choose'; request: number } & rest.ChooseRequest;

/** Choose whom the hoist walks with, for all screens; not while it is led. Forgotten after half an hour without motion. */
export type ChoosePatientRequest = { type: 'choose_patient'; request: number } & rest.ChoosePatient;

/** Take the way the patient stands now as upright. */
export type NeutralRequest = { type: 'neutral'; request: number };

/** Begin a step of calibration on standby, or another one. The wheels never turn by themselves. */
export type CalibrateRequest = { type: 'calibrate'; request: number } & rest.CalibrationRequest;

/** What the operator measured; taken as soon as everything rests. */
export type CalibrateMeasureRequest = { type: 'calibrate_measure'; request: number } & rest.CalibrationMeasure;

/** The result becomes parameters, all or nothing. */
export type CalibrateUseRequest = { type: 'calibrate_use'; request: number };

/** End calibrating; the old values stay. */
export type CalibrateCancelRequest = { type: 'calibrate_cancel'; request: number };

/** Set the odometry's pose while standing still. */
export type PoseRequest = { type: 'pose'; request: number } & rest.Pose;

/** Set a marker now in the session that is being recorded. */
export type MarkerRequest = { type: 'marker'; request: number } & rest.MarkerRequest;

/** Choose which live values come and how often; answered by `streaming`. What is left out is as on connecting: state, motion, pose, posture and intent of every step, five in a message. Whole records: topics ["all"]. */
export type StreamRequest = { type: 'stream' } & rest.StreamRequest;

/** Measure the way there and back. */
export type PingRequest = { type: 'ping' } & rest.PingRequest;

/** What the console may send. */
export type ClientMessage =
  | LeaseTakeRequest
  | LeaseReleaseRequest
  | LeaseAskRequest
  | LeaseKeepRequest
  | LeaseHandOverRequest
  | ModeRequest
  | StopRequest
  | AcknowledgeRequest
  | PauseAlarmRequest
  | DriveRequest
  | SetRequest
  | KeepSettingsRequest
  | UndoSettingsRequest
  | PresetRequest
  | ChooseRequest
  | ChoosePatientRequest
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
  /** Rises with each change; each run of the core begins at another number. */
  version: number;
  values: Record<string, number>;
}

/** Who is in control and who asks for it: on connecting and after each change. */
export interface LeaseMessage {
  type: 'lease';
  epoch: number;
  /** 0 for nobody. */
  holder: number;
  mine: boolean;
  /** Who is in control, by name; null: nobody, or not known here. */
  actor: Actor | null;
  /** Who asks for control, oldest first. */
  asking: readonly LeaseAsk[];
}

/** What is being recorded. */
export interface RecordingMessage {
  type: 'recording';
  state: "idle" | "recording" | "failed";
  session: number | null;
  /** True: no walk, but the time in standby with a patient chosen. */
  standby: boolean;
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
  /** Which run of the core the steps are of; those of different runs do not compare. null: none was seen. */
  run: string | null;
}

/** Answer to `stream`: what comes from here on. */
export interface StreamingMessage {
  type: 'streaming';
  /** The blocks of a sample, in this order; only "all": whole records. */
  topics: readonly TopicName[];
  /** Samples per second; changes of state come besides. At least 20 for the client in control. */
  rate_hz: number;
  /** A message for each step, not for each batch of five. */
  every_tick: boolean;
  /** Length of one sample. */
  sample_bytes: number;
}

/** Steps of which this client gets no values, in their place between the others. */
export interface GapMessage {
  type: 'gap';
  /** First missing step. */
  from_tick: number;
  /** Last missing step; null: not known, of an earlier run of the core. */
  to_tick: number | null;
  /** Samples that are missing at the chosen rate. */
  count: number | null;
  /** The client or its network takes too little; the server came too late; older than what it keeps for a client that comes back; another run of the core. */
  reason: "slow_client" | "server_late" | "too_old" | "core_restarted";
}

/** The exercise and the walk since the start mark: on connecting, and when anything but the newest step changes it. */
export interface WalkMessage {
  type: 'walk';
  /** Chosen for the next walk. */
  exercise: Exercise;
  /** What the present or the latest motion began with; null: not known to this server. */
  begun: Exercise | GuidedPath | null;
  /** The chosen task and its repetition; null: none. */
  task: TaskState | null;
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

/** Whom the hoist walks with: on connecting and when another is chosen. */
export interface PatientMessage {
  type: 'patient';
  /** null: nobody is chosen. */
  id: number | null;
  code: string | null;
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
  | StreamingMessage
  | GapMessage
  | WalkMessage
  | PatientMessage
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
  'sync_input',
  'parameters_on_trial',
  'parameters_confirmed',
  'parameters_reverted',
  'parameter_settled',
  'alarm_paused',
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
export const layoutHash = 'ed2793582363e4cf';
