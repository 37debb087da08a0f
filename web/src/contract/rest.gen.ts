// Made by `deploy/dev gen` from server/contract/api.def and schemas.cpp; do not edit.

/** The body may be left out.. */
export type AcknowledgeRequest = {
  echo?: Echo;
  /** Names of the faults that were shown when the hand went down, see /api/v1/faults; refused when another has come since. */
  seen?: readonly string[];
};

/** Who asked. */
export type Actor = {
  /** The sign-in: script, or device- and eight digits. */
  client: string;
  /** As screens show it; only of an account, and not in recordings. */
  name?: string;
  /** The protocol: rest, hoist.v1, foxglove or rosbridge; rehearsal: the server itself, for a rehearsal. */
  origin: string;
  role: string;
  /** The account; local for whoever uses this computer itself. */
  user: string;
};

/** null: not known, or the core by itself. */
export type ActorOrNull = Actor | null;

export type Alarm = {
  action: Words;
  /** What it is about: of a drive its emergency code; 0 = nothing more is known. */
  code: number;
  /** The fault that explains it. */
  consequence_of: string | null;
  name: string;
  text: Words;
};

export type AlarmList = {
  items: readonly ({
    /** As it was called then; words in /api/v1/faults. */
    fault: string;
    /** null: not over before the session's end. */
    lasted_s: number | null;
    session: number;
    simulated: boolean;
    subject: string | null;
    /** Since the session's start. */
    time_s: number;
    utc_ms: number;
  })[];
  next: string | null;
};

export type AlarmPauseRequest = {
  /** true: the alarms in force stop sounding for two minutes; false: they sound again. */
  paused: boolean;
};

/** What was done or tried: an action, or a REST operation. */
export type AuditAction = 'sign_in' | 'sign_out' | 'set_up' | 'change_password' | 'change_pin' | 'add_user' | 'change_user' | 'user' | 'add_token' | 'token' | 'remove_token' | 'set_tools' | 'change_settings' | 'set_time' | 'set_retention' | 'retention' | 'lose_rows' | 'start_job' | 'cancel_job' | 'get_job_file' | 'export_session' | 'export_mcap' | 'get_session_report' | 'get_visit_report' | 'change_session' | 'delete_session' | 'add_marker' | 'change_marker' | 'delete_marker' | 'control_recording' | 'begin_recording' | 'end_recording' | 'create_patient' | 'change_patient' | 'delete_patient' | 'choose_patient' | 'set_identity' | 'put_identity' | 'delete_identity' | 'change_visit' | 'create_profile' | 'change_profile' | 'delete_profile' | 'apply_profile' | 'create_line' | 'change_line' | 'delete_line' | 'change_parameters' | 'put_parameter' | 'keep_parameters' | 'undo_parameters' | 'apply_preset' | 'set_neutral' | 'set_pose' | 'begin_calibration' | 'measure_calibration' | 'use_calibration' | 'cancel_calibration' | 'update_firmware' | 'take_lease' | 'release_lease' | 'ask_lease' | 'withdraw_lease' | 'keep_lease' | 'hand_over' | 'set_mode' | 'start_motion' | 'end_motion' | 'choose_exercise' | 'choose_task' | 'choose_rehearsal' | 'pause_alarm' | 'stop' | 'acknowledge';

export type AuditCheck = {
  first_wrong: number | null;
  /** Digest of the newest row: note it elsewhere to prove later that no row was cut off. */
  head: string;
  rows: number;
};

export type AuditList = {
  items: readonly ({
    action: AuditAction;
    address: string;
    after: string | null;
    before: string | null;
    digest: string;
    id: number;
    /** HTTP status, or done, or the reason of a refusal. */
    result: string;
    role: string;
    steady_ns: number;
    /** Of an action: the protocol and what it was about; else the path. */
    target: string;
    user: string;
    utc_ms: number;
  })[];
  next: string | null;
};

export type Backup = {
  /** Its folder. */
  backup: string;
  /** Name of the computer. */
  device: string;
  files: readonly BackupFile[];
  hoist_id: BackupHoist;
  program: string;
  sessions: number;
  utc_ms: number;
};

export type BackupFile = {
  bytes: number;
  name: string;
  sha256: string;
};

/** UUID of the hoist; null: from before hoists had an id. A restore leaves the id of the hoist as it is. */
export type BackupHoist = string | null;

export type BackupResult = {
  backup: string;
  device: string;
  files: readonly BackupFile[];
  hoist_id: BackupHoist;
  kind: 'backup';
  program: string;
  sessions: number;
  utc_ms: number;
};

export type BackupsResult = {
  /** The allowed ones (--backup-root). */
  folders: readonly ({
    folder: string;
    free_bytes: number | null;
    there: boolean;
  })[];
  items: readonly Backup[];
  kind: 'list_backups';
};

export type BusHealth = {
  /** CAN id that comes far more often than planned. */
  babbling_id: number | null;
  /** Node id under which two devices answer; 127 = a second control computer. */
  duplicate_id: number | null;
  errors: number;
  frames_per_s: number;
  /** Counted with the most stuff bits: at most 18 % of itself too high. */
  load_norm: number;
  overflows: number;
  received: number;
  refused: number;
  reopened: number;
  rx_errors: number;
  send_refused: number;
  state: 'active' | 'warning' | 'passive' | 'off';
  syncs_lost: number;
  tx_errors: number;
  up: boolean;
};

export type Calibration = {
  items: readonly CalibrationItem[];
  reasons: readonly {
    name: string;
    text: Words;
  }[];
  under_way: CalibrationState | null;
  /** Whether a patient may walk; a simulated hoist needs no calibration; null = the core is not connected. */
  valid: boolean | null;
};

export type CalibrationItem = {
  action: Words;
  /** null = never. */
  done_utc_s: number | null;
  /** The step begins only with harness_empty: true. */
  empty_harness: boolean;
  /** What the operator measures; the sign is the direction. */
  entered: {
    least: number;
    most: number;
    unit: 'm' | 'rad';
  } | null;
  name: CalibrationStep;
  role: 'viewer' | 'therapist' | 'engineer';
  title: Words;
};

export type CalibrationMeasure = {
  /** In the unit of the step; the sign is the direction; of a square: its side. */
  figure: number;
  turning?: 'left' | 'right';
  /** Of a square: how far ahead of the shown place it truly ended. */
  x_m?: number;
  y_m?: number;
};

export type CalibrationRequest = {
  /** True: the operator confirms that nobody is strapped in; steps with empty_harness need it. */
  harness_empty?: boolean;
  step: CalibrationStep;
};

export type CalibrationState = {
  done_percent: number;
  phase: 'none' | 'resting' | 'measuring' | 'operator' | 'result' | 'refused';
  reason: string | null;
  result: readonly {
    before: number;
    name: ParamName;
    value: number;
  }[];
  step: CalibrationStep;
  value: number;
};

export type CalibrationStep = 'zero' | 'neutral' | 'gyro' | 'strut_length' | 'strut_spacing' | 'wheel_radius' | 'track' | 'square' | 'encoders' | 'bumpers' | 'struts';

export type ChangeHow = 'set' | 'trial' | 'preset' | 'profile' | 'undo' | 'trial_over' | 'neutral' | 'calibration' | 'not_seen';

export type ChoosePatient = {
  /** Id of a patient; null: nobody. */
  patient: number | null;
};

export type ChooseRequest = {
  /** What is walked next unless the start says otherwise. */
  exercise: Exercise;
};

export type ChosenPatient = {
  code: string | null;
  /** null: nobody is chosen. */
  id: number | null;
};

export type ComputedFrom = {
  /** Of the values of these inputs: FNV-1a, 16 hexadecimal digits. The same hash and version, the same figure. */
  hash: string;
  /** Recorded columns, gaps, exercise. */
  inputs: readonly string[];
  /** Why the figure is not valid, where it is null. */
  reason_code: NoFigure | null;
  /** Of the figure's definition. */
  version: number;
};

export type DeviceSettings = {
  computer_name: string;
  /** Empty: the computer's name. */
  device_name: string;
  etag: EditTag;
  /** UUID: made once, at random; cannot be changed. */
  hoist_id: string;
  language: LanguageOrNull;
};

export type DeviceSettingsPatch = {
  /** One line, at most 64 bytes of UTF-8. */
  device_name?: string;
  language?: LanguageOrNull;
};

/** One line, as screens show it. */
export type DisplayName = string;

export type Done = {
  ok: true;
};

export type DoneStored = {
  ok: true;
  stored: Stored;
};

export type DriveRequest = {
  /** time_ns of the newest record seen. */
  echo: number;
  /** Hold-to-run is held. */
  held: boolean;
  /** Rises with every message of one connection. */
  sequence: number;
  /** Share of the driving limit, forward positive. */
  speed: number;
  /** Share of the turning limit, left positive. */
  yaw: number;
};

/** time_ns of the newest record that the sender had seen. When it is older than 1 s, or not from this run of the core, motion does not begin and no stop is left (stale_command). Left out: over REST the first byte of the request counts. */
export type Echo = number;

/** Of what people may change in this row. Send it in quotes as If-Match with a change; the header ETag has it in quotes. */
export type EditTag = string;

export type Emergency = {
  code: number;
  detail: Words;
  name: string;
  text: Words;
};

/** No fields; the body may be left out.. */
export type Empty = Record<string, never>;

export type EventList = {
  items: readonly EventRow[];
  next: string | null;
};

export type EventRow = {
  actor: ActorOrNull;
  before: number;
  bits: number;
  code: number;
  item: number;
  kind: string;
  name: string;
  /** Within its session. */
  number: number;
  tick: number;
  /** Since the session's start. */
  time_s: number;
  value: number;
};

/** What is walked; null and free mean the same. */
export type Exercise = {
  /** Of the line. */
  length_m: number;
  shape: 'straight';
} | {
  /** Left and right exchanged. */
  clockwise?: boolean | null;
  /** Of the corners; without it, or 0, they are sharp. */
  corner_radius_m?: number | null;
  shape: 'square';
  /** Of the square. */
  side_m: number;
} | {
  /** Left and right exchanged. */
  clockwise?: boolean | null;
  /** Of the circle. */
  radius_m: number;
  shape: 'circle';
} | {
  /** From the crossing to a loop's centre. */
  c_m: number;
  /** Left and right exchanged. */
  clockwise?: boolean | null;
  /** Of the loops. */
  radius_m: number;
  shape: 'eight';
} | {
  /** Left and right exchanged. */
  clockwise?: boolean | null;
  shape: 'slalom';
  /** Between its four poles; the line passes them at 0.29 of it. */
  spacing_m: number;
} | {
  /** The last point is joined to the first; then at least three. */
  closed: boolean;
  /** Of the corners, smaller where a straight is too short for it; without it, or 0, they are sharp. */
  corner_radius_m?: number | null;
  shape: 'own';
  /** Of the points, in whole centimetres, in the order of walking; neighbours are at least 0.2 m apart. */
  x_m: readonly number[];
  /** As many as x_m. */
  y_m: readonly number[];
} | {
  shape: 'free';
};

export type ExerciseList = {
  items: readonly {
    /** May have laps. */
    closed: boolean;
    shape: string;
    sizes: readonly ExerciseSize[];
    title: Words;
    /** May be walked clockwise too. */
    turned: boolean;
  }[];
};

export type ExerciseOrNull = Exercise | null;

export type ExerciseSize = {
  doc: string;
  /** Where the hoist drives by itself. */
  driven_least_m: number;
  driven_most_m: number;
  least_m: number;
  most_m: number;
  name: string;
  required: boolean;
  /** At most this share of the shape's first size; 0 = no such limit. */
  share: number;
  title: Words;
  /** 0 = left out. */
  usual_m: number;
};

export type ExportResult = {
  bytes: number;
  file_name: string;
  kind: 'export_sessions';
  sessions: number;
};

export type FaultList = {
  items: readonly ({
    action: Words;
    bit: number;
    hazard: string;
    name: string;
    priority: 'low' | 'medium' | 'high';
    reaction: 'warn' | 'soft_stop' | 'protective_stop' | 'out_of_service' | 'power_off';
    text: Words;
  })[];
  refusals: readonly {
    bit: number;
    name: string;
    text: Words;
  }[];
};

export type FieldError = {
  field: string;
  max?: number;
  message: string;
  min?: number;
  value?: number;
};

export type FigureChange = {
  ends: TaskGoalOrNull;
  exercise: ExerciseOrNull;
  figure: string;
  first: number;
  first_session: number;
  last: number;
  last_session: number;
  /** Within visits, from walk to walk. */
  learning: {
    /** Why no learning can be told; null: the interval leaves out 0. */
    reason_code: NoChange | null;
    /** Median of the slopes between two walks of a visit, per walk, and its 95 % interval; null: too few walks. */
    slope: {
      high: number;
      low: number;
      middle: number;
    } | null;
    /** With at least two walks. */
    visits: number;
    /** Of visits with at least two walks. */
    walks: number;
  };
  /** 95 %, in the figure's unit: the published one or that of the patient's own repeats, the larger one; null: not known. */
  minimal_detectable_change: number | null;
  /** Why no change can be told; null: last differs from first by more than the minimal detectable change. */
  reason_code: NoChange | null;
  /** Degrees of freedom of the patient's own repeats within visits; 10 are needed. */
  repeats: number;
  /** What was kept: first value of the newest visit (after) against the last one of the visit before; null: only one visit. */
  retention: {
    after: number;
    after_session: number;
    before: number;
    before_session: number;
    /** null: they differ by more than the minimal detectable change. */
    reason_code: NoChange | null;
  } | null;
  /** Where it is published; null: the patient's own repeats, or not known. */
  source: string | null;
  task: string | null;
  /** Whom and what it is published of. */
  whom: {
    de: string;
    en: string;
  } | null;
};

export type Firmware = {
  nodes: readonly ({
    /** 8 hexadecimal digits. */
    crc: string | null;
    /** null = not heard since this server or the node started. */
    in_loader: boolean | null;
    name: string;
    title: string;
    version: string | null;
  })[];
  update: FirmwareUpdate | null;
};

export type FirmwareUpdate = {
  bytes_sent: number;
  bytes_total: number;
  node: string;
  phase: 'listening' | 'asking_drives' | 'asking_node' | 'entering_loader' | 'sending' | 'checking' | 'starting' | 'done' | 'failed';
  result: 'running' | 'done' | 'unchanged' | 'failed' | 'interrupted';
  /** Of the sending. */
  seconds_left: number | null;
  text: string;
  version: string;
};

export type GapList = {
  items: readonly GapRow[];
  next: string | null;
};

export type GapRow = {
  from_tick: number;
  /** Within its session. */
  number: number;
  /** See the table of reasons in db/README.md. */
  reason: string;
  /** ticks, events or bus. */
  stream: string;
  to_tick: number;
};

/** What the hoist drives while the driver holds: the sizes of an exercise, its speed and its laps, held against the limits in force. */
export type GuidedPath = {
  laps?: number | null;
  /** Of the line. */
  length_m: number;
  shape: 'straight';
  /** Slower in curves that need it. */
  speed_m_s: number;
} | {
  /** Left and right exchanged. */
  clockwise?: boolean | null;
  /** Of the corners; without it, or 0, they are sharp. */
  corner_radius_m?: number | null;
  laps?: number | null;
  shape: 'square';
  /** Of the square. */
  side_m: number;
  /** Slower in curves that need it. */
  speed_m_s: number;
} | {
  /** Left and right exchanged. */
  clockwise?: boolean | null;
  laps?: number | null;
  /** Of the circle. */
  radius_m: number;
  shape: 'circle';
  /** Slower in curves that need it. */
  speed_m_s: number;
} | {
  /** From the crossing to a loop's centre. */
  c_m: number;
  /** Left and right exchanged. */
  clockwise?: boolean | null;
  laps?: number | null;
  /** Of the loops. */
  radius_m: number;
  shape: 'eight';
  /** Slower in curves that need it. */
  speed_m_s: number;
} | {
  /** Left and right exchanged. */
  clockwise?: boolean | null;
  laps?: number | null;
  shape: 'slalom';
  /** Between its four poles; the line passes them at 0.29 of it. */
  spacing_m: number;
  /** Slower in curves that need it. */
  speed_m_s: number;
};

export type GuidedPathOrNull = GuidedPath | null;

export type HandOverRequest = {
  /** Number of the client, as in asking. */
  client?: number;
  /** Account: the client of this person that asks, else the one that came last. */
  user?: string;
};

export type Health = {
  bus: BusHealth | null;
  connected: boolean;
  /** The latest 64, newest first. */
  emergencies: readonly {
    age_s: number;
    emergency: Emergency;
    error_register: number;
    node: string;
    time_ns: number;
  }[];
  /** Empty while the core is not connected. */
  nodes: readonly NodeHealth[];
  recordings: RecordingsHealth;
};

export type Identity = {
  etag: EditTag;
  identity: Person | null;
  /** key_missing, key_foreign: the key file beside the database is not there, or of another hoist. */
  state: 'none' | 'readable' | 'key_missing' | 'key_foreign' | 'damaged';
};

export type IdentityRequest = {
  /** YYYY-MM-DD. */
  birth_date?: string | null;
  /** One line, at most 200 bytes of UTF-8. */
  name: string;
  note?: string;
};

export type IntegrityResult = {
  /** Stored blobs that were looked at; 0 when the structure is damaged. */
  blobs: number;
  damaged_blobs: number;
  damaged_sessions: readonly number[];
  kind: 'integrity_check';
  sound: boolean;
  /** Damaged pages, tables and indexes: the file is set aside and a new one begun. */
  structure: readonly string[];
};

export type Job = {
  actor: ActorOrNull;
  asked_utc_ms: number;
  /** Why it failed. */
  detail: string;
  ended_utc_ms: number | null;
  id: number;
  kind: JobKind;
  progress: number;
  /** The same for programs. */
  reason_code: ReasonCode | null;
  /** Not in lists; null until it is done. */
  result?: IntegrityResult | MetricsResult | BackupResult | RestoreResult | BackupsResult | ExportResult | RetentionResult | StudyJobResult | StudyDeleted | null;
  state: 'waiting' | 'running' | 'done' | 'failed' | 'cancelled';
};

export type JobKind = 'integrity_check' | 'recompute_metrics' | 'backup' | 'restore' | 'export_sessions' | 'list_backups' | 'preview_retention' | 'retention' | 'study' | 'study_recorded' | 'delete_study';

export type JobList = {
  items: readonly Job[];
  next: string | null;
};

/** What to do. */
export type JobRequest = {
  kind: 'integrity_check';
} | {
  kind: 'recompute_metrics';
  /** The newest 1000 when not given. */
  sessions?: readonly number[];
} | {
  /** One of the allowed folders (list_backups) or a folder in one; the first when not given. */
  folder?: string;
  /** true: the key of the sealed names goes with it. Who has such a backup can read them. */
  identity_key?: boolean;
  kind: 'backup';
} | {
  /** As list_backups names it. */
  backup: string;
  kind: 'restore';
} | {
  /** Its shape. */
  exercise?: string;
  /** YYYY-MM-DD. */
  from_day?: string;
  kind: 'export_sessions';
  /** Of the layout reports; en when not given. */
  language?: 'en' | 'de';
  /** files (when not given): a folder per session; bids: a data set as Motion-BIDS lays it out, without notes and user names; sqlite: one SQLite file with plain tables; reports: pages for print of at most 1000 sessions, and one of all. */
  layout?: 'files' | 'bids' | 'sqlite' | 'reports';
  /** Of the layout reports: one page in plain words, or full (when not given). */
  report?: 'patient' | 'full';
  /** These only; the filters do not count. */
  sessions?: readonly number[];
  /** false: without recordings of a simulated hoist. */
  simulated?: boolean;
  /** The whole patient code. */
  subject?: string;
  /** A word of the session's note that begins with #, without the #. */
  tag?: string;
  /** YYYY-MM-DD. */
  to_day?: string;
  visit?: number;
} | {
  kind: 'list_backups';
} | {
  kind: 'preview_retention';
  rule: RetentionRule;
} | {
  kind: 'retention';
} | {
  kind: 'study';
  /** The same seed gives the same subjects and runs. */
  seed: number;
  /** Virtual subjects; the paper had 11. */
  subjects: number;
} | {
  /** YYYY-MM-DD. */
  from_day?: string;
  kind: 'study_recorded';
  /** false: without recordings of a simulated hoist. */
  simulated?: boolean;
  /** The whole patient code. */
  subject?: string;
  /** YYYY-MM-DD. */
  to_day?: string;
} | {
  kind: 'delete_study';
  study: number;
};

/** The body may be left out.. */
export type KeepRequest = {
  version?: LookedAt;
};

/** null: as each browser asks. */
export type LanguageOrNull = 'en' | 'de' | null;

/** Those that hold something, earliest first. */
export type LatenessBuckets = readonly ({
  count: number;
  from_s: number;
  to_s: number | null;
})[];

export type Lease = {
  actor: ActorOrNull;
  /** Those who ask the holder for control, oldest first. */
  asking: readonly LeaseAsk[];
  /** Rises with each change of holder. */
  epoch: number;
  /** Only in GET /api/v1/lease: when control taken over REST ends without use; null = nobody has it, or a WebSocket, whose end ends it. */
  expires_in_s?: number | null;
  /** Number of the client in control; 0 = nobody. */
  holder: number;
};

export type LeaseAsk = {
  actor: ActorOrNull;
  client: number;
};

export type LeaseAskRequest = {
  /** True: control is asked for no longer. */
  withdraw?: boolean;
};

/** The body may be left out.. */
export type LeaseRequest = {
  /** Also when somebody else is in control; only while the hoist stands still. */
  take_over?: boolean;
};

export type LeaseResult = {
  epoch: number;
  holder: number;
};

export type Line = {
  etag: EditTag;
  exercise: Exercise;
  id: number;
  /** Once along it, with its round corners. */
  length_m: number;
  name: string;
  saved_utc_ms: number;
  /** Counts the savings. */
  version: number;
};

export type LineList = {
  items: readonly Line[];
  next: string | null;
};

/** One line, at most 64 bytes of UTF-8; of a place, never of a patient. */
export type LineName = string;

/** Name of the own line; null: none. */
export type LineOrNull = string | null;

export type LinePatch = {
  /** Of the shape own. */
  exercise?: Exercise;
  name?: LineName;
};

export type LineRequest = {
  /** Of the shape own. */
  exercise: Exercise;
  name: LineName;
};

/** Version of the parameters that were looked at; refused when others have changed them meanwhile, or the core was restarted. */
export type LookedAt = number;

export type Loop = {
  allocations: number;
  /** Core that the control thread is bound to. */
  cpu: number | null;
  ever: LatenessBuckets;
  /** Steps that began more than 2 ms late. */
  late: number;
  lately: LatenessBuckets;
  lateness_max_s: number;
  lateness_p50_s: number;
  lateness_p99_s: number;
  latest_ever_s: number;
  longest_step_s: number;
  memory_locked: boolean;
  /** Steps that did not take place because one before them began or ended too late. */
  missed: number;
  page_faults: number;
  /** Under SCHED_FIFO; null = not granted. */
  priority: number | null;
  steps: number;
};

/** What kind of moment it marks; note: none of these. */
export type MarkerKind = 'note' | 'help' | 'stumble' | 'rest' | 'good';

export type MarkerList = {
  items: readonly MarkerRow[];
  next: string | null;
};

export type MarkerPatch = {
  kind?: MarkerKind;
  text?: string;
  /** Since the session's start, within its samples. */
  time_s?: number;
};

export type MarkerRequest = {
  kind?: MarkerKind;
  text: string;
};

export type MarkerRow = {
  actor: ActorOrNull;
  etag: EditTag;
  kind: MarkerKind;
  /** Within its session. */
  number: number;
  /** The result that the text tells, of a rehearsal on a simulated hoist. */
  rehearsal: RehearsalResult | null;
  session: number;
  text: string;
  tick: number;
  /** Since the session's start. */
  time_s: number;
  utc_ms: number;
};

/** The figures of db/metrics/metric_list.hpp. */
export type Metrics = {
  /** Correlation of pelvis turn and path turn at zero lag, -1 to 1: whether the patient turns where the path turns. No measure of distance from the path. */
  C: number | null;
  /** The correlation C at the shift in time at which it is largest. */
  C_best: number | null;
  /** How much before the path the pelvis turns, by the shift of C_best. */
  C_best_lag_s: number | null;
  /** Squared error of the walk per metre of path, at 100 Hz: it grows with slowness, too. */
  J_N: number | null;
  /** Squared error of the walk over time per metre of path: J_N without the sampling rate. */
  J_T_m_s: number | null;
  /** Walk, turn, walk back: time of the way back. */
  back_time_s: number | null;
  /** Sudden leans far out, faster than this walk's own: losses of balance and catches. */
  balance_events: number | null;
  /** Number of bouts of walking: a second or longer at more than 0.05 m/s. */
  bouts: number | null;
  /** Steps a minute, two to a stride. */
  cadence_steps_min: number | null;
  /** Share of the exercise that was walked; laps beyond the first count on. */
  completion_norm: number | null;
  /** Of each figure. */
  computed: {
    C: ComputedFrom;
    C_best: ComputedFrom;
    C_best_lag_s: ComputedFrom;
    J_N: ComputedFrom;
    J_T_m_s: ComputedFrom;
    back_time_s: ComputedFrom;
    balance_events: ComputedFrom;
    bouts: ComputedFrom;
    cadence_steps_min: ComputedFrom;
    completion_norm: ComputedFrom;
    cross_track_max_m: ComputedFrom;
    cross_track_mean_m: ComputedFrom;
    dead_band_norm: ComputedFrom;
    effort_s_m: ComputedFrom;
    interventions: ComputedFrom;
    lap_time_best_s: ComputedFrom;
    lap_time_mean_s: ComputedFrom;
    ldlj: ComputedFrom;
    max_speed_m_s: ComputedFrom;
    mean_speed_m_s: ComputedFrom;
    missing_s: ComputedFrom;
    motion_s: ComputedFrom;
    out_time_s: ComputedFrom;
    patient_led_norm: ComputedFrom;
    protective_stops: ComputedFrom;
    reference_length_m: ComputedFrom;
    rms_heading_rad: ComputedFrom;
    rms_lateral_m: ComputedFrom;
    rms_pose_m: ComputedFrom;
    rms_position_m: ComputedFrom;
    sparc: ComputedFrom;
    start_latency_s: ComputedFrom;
    step_asymmetry_norm: ComputedFrom;
    step_regularity_norm: ComputedFrom;
    step_symmetry_norm: ComputedFrom;
    steps: ComputedFrom;
    stopping_way_m: ComputedFrom;
    stops: ComputedFrom;
    stride_regularity_norm: ComputedFrom;
    stride_time_cv_norm: ComputedFrom;
    stride_time_s: ComputedFrom;
    task_distance_m: ComputedFrom;
    task_time_s: ComputedFrom;
    timed_speed_m_s: ComputedFrom;
    turn_angle_rad: ComputedFrom;
    turn_lead_s: ComputedFrom;
    turn_time_s: ComputedFrom;
    turning_time_s: ComputedFrom;
    turns_left: ComputedFrom;
    turns_right: ComputedFrom;
    under_way_s: ComputedFrom;
    walked_m: ComputedFrom;
    walking_s: ComputedFrom;
    walking_speed_m_s: ComputedFrom;
  };
  /** Largest distance from the exercise. */
  cross_track_max_m: number | null;
  /** Mean distance from the exercise. */
  cross_track_mean_m: number | null;
  /** Share of the time led by the patient in which the lean asked for nothing. */
  dead_band_norm: number | null;
  /** Effort of a metre: lean as a share of its range, times the time it is held, per metre. */
  effort_s_m: number | null;
  exercise: ExerciseOrNull;
  /** How often patient-led walking was broken off: by a stop, a fault or the therapist. */
  interventions: number | null;
  /** Shortest time for once along the exercise. */
  lap_time_best_s: number | null;
  /** Mean time for once along the exercise, pauses included. */
  lap_time_mean_s: number | null;
  /** Logarithmic dimensionless jerk of the forward speed of the longest bout: nearer to 0 is smoother. */
  ldlj: number | null;
  /** Largest absolute speed while under way. */
  max_speed_m_s: number;
  /** walked_m over motion_s: standing does not count. */
  mean_speed_m_s: number | null;
  /** Motion that is not recorded: all figures are of the rest. */
  missing_s: number;
  /** Of that, time in which a wheel turned at 0.02 m/s or more. */
  motion_s: number;
  /** Walk, turn, walk back: time of the way out. */
  out_time_s: number | null;
  /** Share of the time in motion in which the patient led. */
  patient_led_norm: number | null;
  /** How often the hoist stopped by itself or by the emergency stop. */
  protective_stops: number | null;
  reason_code: NoFigure | null;
  /** Why there is no C, J_N, or one of them; of the other figures: computed. */
  reason_if_none: string | null;
  /** Progress along the exercise. */
  reference_length_m: number | null;
  /** Angle against the exercise, root mean square. */
  rms_heading_rad: number | null;
  /** Distance across the path, root mean square. */
  rms_lateral_m: number | null;
  /** What J_N is made of in plain units: distance and heading error together, root mean square, 1 rad as 1 m. */
  rms_pose_m: number | null;
  /** Distance from the exercise, root mean square. */
  rms_position_m: number | null;
  session: number;
  /** Spectral arc length of the forward speed of the longest bout: nearer to 0 is smoother. */
  sparc: number | null;
  /** From leaning to moving off: how long until the hoist follows at 0.05 m/s. */
  start_latency_s: number | null;
  /** How much longer the harness takes from right to left than back, as a share of their mean. */
  step_asymmetry_norm: number | null;
  /** How alike successive steps are, left to right: 1 = all the same. */
  step_regularity_norm: number | null;
  /** 1 = left and right steps are as alike as successive strides. */
  step_symmetry_norm: number | null;
  /** Steps taken in bouts of walking, two to a stride. */
  steps: number | null;
  /** Way that the hoist rolls after the patient has leant back. */
  stopping_way_m: number | null;
  /** How often walking was interrupted for a second or longer. */
  stops: number | null;
  /** How alike successive strides are: 1 = all the same. */
  stride_regularity_norm: number | null;
  /** How much the time of a stride varies, as a share of its mean. */
  stride_time_cv_norm: number | null;
  /** Time of a stride (two steps), from the sideways sway of the harness. */
  stride_time_s: number | null;
  /** Way walked in the time of the task. */
  task_distance_m: number | null;
  /** Time that the task took, from the first movement to its end. */
  task_time_s: number | null;
  /** Mean speed over the timed middle of the line: setting off and stopping do not count. */
  timed_speed_m_s: number | null;
  /** Which track was compared: with slip repaired, or the encoders' own. */
  track: 'fused' | 'encoders';
  /** Mean angle of the turns. */
  turn_angle_rad: number | null;
  /** How much before the hoist the pelvis turns. */
  turn_lead_s: number | null;
  /** Mean time of the turns. */
  turn_time_s: number | null;
  /** Walk, turn, walk back: time of the turn. */
  turning_time_s: number | null;
  /** Turns of the hoist to the left by 45 degrees or more. */
  turns_left: number | null;
  /** Turns of the hoist to the right by 45 degrees or more. */
  turns_right: number | null;
  /** Time in which the hoist was under way (a mode in which the wheels may turn), standing included. */
  under_way_s: number;
  /** Way walked, forward and backward: absolute speed times 10 ms, summed over the time under way. */
  walked_m: number;
  /** Time in bouts of more than 0.05 m/s that last a second or longer. */
  walking_s: number;
  /** Mean speed in these bouts: setting off, stopping and standing hardly count. */
  walking_speed_m_s: number | null;
};

export type MetricsResult = {
  failed: readonly {
    detail: string;
    session: number;
  }[];
  items: readonly Metrics[];
  kind: 'recompute_metrics';
};

export type ModeList = {
  items: readonly {
    moving: boolean;
    name: string;
    title: Words;
    value: number;
  }[];
};

export type ModeRequest = {
  echo?: Echo;
  exercise?: ExerciseOrNull;
  mode: 'user' | 'remote' | 'guided' | 'standby';
  path?: GuidedPathOrNull;
  /** True sets a new start mark. Otherwise the same exercise goes on from where the hoist is; another one begins at its start. */
  start_again?: boolean;
};

export type ModeState = {
  blocked: readonly string[];
  mode: string;
  moving: boolean;
  standing_still: boolean;
  /** The fault that came first of the stop the hoist is in; null in every other mode. */
  stop_cause: readonly string[] | null;
};

export type Network = {
  computer_name: string;
  interfaces: readonly {
    addresses: readonly string[];
    loopback: boolean;
    name: string;
    up: boolean;
  }[];
  port: number;
  tls: {
    /** Of the hoist's own authority, SHA-256; null: it has none. */
    fingerprint: string | null;
    /** Under which the hoist may be called. */
    names: readonly string[];
    on: boolean;
    /** Path of the page that explains how a device comes to trust it. */
    trust_page: string | null;
  };
};

export type NewToken = {
  days: number;
  /** What it is for. */
  name: string;
  /** The most it may do; never more than its owner. */
  scope: RoleName;
};

export type NewUser = {
  display_name: DisplayName;
  password: Password;
  role: RoleName;
  user: UserName;
};

export type NoChange = 'one_visit' | 'few_repeats' | 'within_noise' | 'few_walks' | 'no_slope';

export type NoFigure = 'no_exercise' | 'no_motion' | 'no_bout' | 'part_missing' | 'several_walks' | 'start_unclear' | 'not_comparable' | 'too_short' | 'no_lap' | 'few_strides' | 'no_rhythm' | 'no_turn' | 'no_turn_back' | 'no_lead' | 'too_long' | 'not_recorded' | 'no_task' | 'task_unfinished' | 'not_from_start' | 'not_led' | 'settings_changed' | 'no_start' | 'no_stop';

export type NodeHealth = {
  /** Since its latest process data; null = longer than 2.5 s or never. */
  age_s: number | null;
  emergencies: number;
  error_register: number;
  heartbeats_missed: number;
  id: number;
  latest_emergency: Emergency | null;
  lost_10s: number;
  lost_frames: number;
  name: string;
  nmt_state: number | null;
  /** losing: frames were lost in the last ten seconds; waiting: it lives and is not started yet. */
  state: 'working' | 'losing' | 'waiting' | 'silent';
};

/** What a node had said of its program when the session began; null = not read. */
export type NodeProgram = {
  crc: string | null;
  name: string;
  product: string | null;
  revision: string | null;
  simulated: boolean | null;
  version: string | null;
};

/** Plain text, tabs and line ends allowed: at most 4000 bytes of UTF-8.. */
export type NoteText = string;

export type OpenApi = {
  openapi: '3.1.0';
};

export type ParamName = 'strut_length_m' | 'strut_spacing_m' | 'track_width_m' | 'wheel_radius_m' | 'encoder_counts_per_turn' | 'wheel_left_scale_norm' | 'wheel_right_scale_norm' | 'lean_range_rad' | 'turn_range_rad' | 'neutral_lean_m' | 'neutral_turn_rad' | 'lean_dead_band_norm' | 'lean_tau_normal_s' | 'lean_tau_release_s' | 'braking_softness_norm' | 'reversal_gain_norm' | 'lean_gain_direct_units' | 'lean_gain_filtered_units' | 'lean_filtered_units_max' | 'speed_per_unit_m_s' | 'turn_dead_band_norm' | 'turn_tau_normal_s' | 'turn_tau_release_s' | 'turn_gain_direct_units' | 'turn_gain_filtered_units' | 'yaw_rate_per_unit_rad_s' | 'speed_m_s_max' | 'yaw_rate_rad_s_max' | 'acceleration_m_s2_max' | 'jerk_m_s3_max' | 'yaw_acceleration_rad_s2_max' | 'speed_cap_norm' | 'protective_deceleration_m_s2' | 'bumper_deceleration_m_s2' | 'remote_speed_m_s_max' | 'remote_yaw_rate_rad_s_max' | 'remote_slow_age_s' | 'remote_stop_age_s' | 'guided_length_m_max' | 'guided_deviation_m_max' | 'guided_lag_start_rad' | 'fall_tilt_rad' | 'fall_rate_rad_s' | 'fall_static_tilt_rad' | 'fall_static_s' | 'battery_low_v' | 'battery_empty_v' | 'neutral_start_tolerance_norm' | 'loop_late_s_max' | 'base_tilt_slow_rad' | 'base_tilt_stop_rad' | 'base_tilt_speed_m_s_max' | 'hang_tilt_rad' | 'hang_tilt_s' | 'hang_speed_m_s' | 'hang_still_s' | 'hang_sway_m' | 'battery_uneven_v' | 'tilt_rad_max' | 'tilt_rate_rad_s_max' | 'strut_apart_rad_max' | 'strut_twist_rad_max' | 'overspeed_margin_m_s' | 'following_error_m_s_max' | 'following_error_s' | 'drift_rad_max' | 'fault_stops_max' | 'fault_stops_window_s' | 'slip_stop_s' | 'cadence_cancel_norm' | 'drive_velocity_gain_v_s_rad' | 'drive_velocity_integral_v_rad' | 'drive_current_limit_a' | 'drive_acceleration_rad_s2' | 'tilt_kalman_angle_norm' | 'tilt_kalman_bias_per_s' | 'bus_load_norm_max' | 'left_alpha_zero_rad' | 'left_beta_zero_rad' | 'right_alpha_zero_rad' | 'right_beta_zero_rad' | 'base_alpha_zero_rad' | 'base_beta_zero_rad' | 'base_yaw_bias_rad_s' | 'calibrated_zero_s' | 'calibrated_neutral_s' | 'calibrated_gyro_s' | 'calibrated_strut_length_s' | 'calibrated_strut_spacing_s' | 'calibrated_wheel_radius_s' | 'calibrated_track_s' | 'calibrated_square_s' | 'calibrated_encoders_s' | 'calibrated_bumpers_s' | 'calibrated_struts_s' | 'calibrated_nodes_id';

export type Parameter = {
  default: number;
  edit: 'live' | 'stopped';
  effect: Words;
  id: number;
  max: number;
  min: number;
  name: ParamName;
  role: 'viewer' | 'therapist' | 'engineer';
  scope: 'core' | 'drive' | 'tilt';
  source: string;
  title: Words;
  unit: string;
  value: number;
};

export type ParameterChange = {
  actor: ActorOrNull;
  before: number;
  how: ChangeHow;
  id: number;
  /** As it was then. */
  name: string;
  /** That was being recorded; null: none. */
  session: number | null;
  /** Name of the preset or profile. */
  source: string | null;
  utc_ms: number;
  value: number;
};

export type ParameterDiff = {
  from_utc_ms: number;
  items: readonly {
    from: number;
    name: string;
    to: number;
  }[];
  to_utc_ms: number;
};

export type ParameterHistory = {
  items: readonly ParameterChange[];
  next: string | null;
};

export type ParameterList = {
  items: readonly Parameter[];
  /** Rises with each change; each run of the core begins at another number. */
  version: number;
};

/** Names and new values. */
export type ParameterNumbers = Record<string, number>;

export type ParameterResult = {
  stored: Stored;
  values: Record<string, number>;
  version: number;
};

export type ParameterValue = {
  revert_after_s?: TrialTime;
  value: number;
};

/** Names and new values. */
export type ParameterValues = {
  revert_after_s?: TrialTime;
  [name: string]: number | undefined;
};

export type Password = string;

export type PasswordChange = {
  new_password: Password;
  /** The present one. */
  password: string;
};

export type Patient = {
  archived: boolean;
  /** Pseudonym. */
  code: string;
  etag: EditTag;
  first_day: string | null;
  has_identity: boolean;
  id: number;
  last_day: string | null;
  sessions: number;
  visits: number;
};

export type PatientList = {
  items: readonly Patient[];
  next: string | null;
};

export type PatientPatch = {
  archived?: boolean;
  code?: SubjectCode;
};

export type PatientRequest = {
  code: SubjectCode;
};

export type Person = {
  birth_date: string | null;
  name: string;
  note: string;
};

export type PinChange = {
  password: string;
  /** null removes it. */
  pin: string | null;
};

export type PingRequest = {
  /** Comes back in the pong. */
  t: number;
};

export type Pose = {
  psi_rad: number;
  x_m: number;
  y_m: number;
};

export type PresetList = {
  items: readonly {
    doc: Words;
    name: string;
    title: Words;
    values: Record<string, number>;
  }[];
};

export type PresetRequest = {
  /** Name of the preset. */
  name: string;
  version?: LookedAt;
};

export type Problem = {
  detail: string;
  errors?: readonly FieldError[];
  instance: string;
  /** Names of the refusal table, see /api/v1/faults. */
  refusals?: readonly string[];
  status: number;
  title: string;
  type: string;
};

export type Profile = {
  actor: ActorOrNull;
  etag: EditTag;
  id: number;
  name: string;
  patient: number;
  saved_utc_ms: number;
  settings: ProfileSettings;
  /** Counts the savings. */
  version: number;
};

export type ProfileApply = {
  /** Of the parameters that were looked at; refused when others have changed them meanwhile. */
  version: number;
};

export type ProfileDiff = {
  items: readonly ({
    in_force: number | null;
    name: string;
    profile: number;
    /** No parameter of a therapist in this software, or outside its range. */
    unusable: boolean;
  })[];
  /** Of the parameters in force; null: no core is connected. */
  version: number | null;
};

export type ProfileList = {
  items: readonly Profile[];
  next: string | null;
};

/** One line, at most 64 bytes of UTF-8. */
export type ProfileName = string;

export type ProfilePatch = {
  /** true: what is in force is saved as the next version. */
  from_in_force?: boolean;
  name?: ProfileName;
  /** Saved as the next version. */
  settings?: Record<string, never>;
};

export type ProfileRequest = {
  name: ProfileName;
  /** Left out: what is in force. */
  settings?: Record<string, never>;
};

/** Names and values of parameters that a therapist may change. */
export type ProfileSettings = Record<string, number>;

export type ReasonCode = 'refused' | 'no_core' | 'busy' | 'role' | 'no_session' | 'invalid' | 'none_fits' | 'too_many' | 'exercise' | 'measurement' | 'message' | 'unknown' | 'not_now' | 'changed_meanwhile' | 'taken' | 'patient_chosen' | 'identity_key' | 'not_recording' | 'lease_free' | 'moving' | 'study_runs' | 'not_simulated' | 'no_simulator' | 'rehearsal_runs' | 'job_ended' | 'system_clock' | 'disk_full' | 'read_only' | 'storage' | 'internal' | 'wrong_secret' | 'too_soon' | 'sign_in_over' | 'set_up_first' | 'pin_not_here' | 'no_account' | 'not_found' | 'set_up_closed' | 'wrong_code' | 'accounts' | 'core_absent' | 'core_silent' | 'core_gone' | 'core_taken' | 'core_build' | 'core_refused' | 'core_unreachable' | 'no_exercise' | 'no_motion' | 'no_bout' | 'part_missing' | 'several_walks' | 'start_unclear' | 'not_comparable' | 'too_short' | 'no_lap' | 'few_strides' | 'no_rhythm' | 'no_turn' | 'no_turn_back' | 'no_lead' | 'too_long' | 'not_recorded' | 'no_task' | 'task_unfinished' | 'not_from_start' | 'not_led' | 'settings_changed' | 'no_start' | 'no_stop' | 'one_visit' | 'few_repeats' | 'within_noise' | 'few_walks' | 'no_slope';

export type Recording = {
  detail: string;
  durable_tick: number | null;
  /** Why it failed, for programs. */
  reason_code: ReasonCode | null;
  samples: number;
  session: number | null;
  /** true: no walk, but the time in standby with a patient chosen. */
  standby: boolean;
  started_utc_ms: number | null;
  state: 'idle' | 'recording' | 'failed';
};

export type RecordingRequest = {
  action: 'start' | 'stop';
  note?: NoteText;
  subject?: SubjectCode;
};

export type RecordingsHealth = {
  checked_utc_ms: number | null;
  damaged_blobs: number;
  /** Parts of these cannot be read. */
  damaged_sessions: readonly number[];
  /** What is damaged, or why it could not be checked; for the engineer. */
  detail: string;
  /** While checking. */
  progress: number;
  /** Of the file in use. It is checked after each start; the job integrity_check does it again. */
  state: 'unchecked' | 'checking' | 'sound' | 'damaged';
};

/** What is looked at: stop: STOP was pressed, or the motion ended, within limit_s; look: at least limit_s passed between standstill and the first attempt to release the stop; cause_gone: no attempt to release the stop while its cause remained, or before the hoist stood; acknowledge: the stop was released within limit_s; zero: the posture was taken as upright after the release and before the next start; go_on: the walk went on within limit_s; regain: someone was in control again within limit_s; end: the walk was ended within limit_s; stay_ended: no start for limit_s after that; answer: the request for control was answered within limit_s: kept, or handed over; standing: no attempt to hand over while the hoist was led. */
export type RehearsalCheck = 'stop' | 'look' | 'cause_gone' | 'acknowledge' | 'zero' | 'go_on' | 'regain' | 'end' | 'stay_ended' | 'answer' | 'standing';

export type RehearsalItem = {
  /** When it was done, since what happened; of look: how long. */
  after_s: number | null;
  check: RehearsalCheck;
  limit_s: number | null;
  /** missing: it was not done. */
  seen: 'good' | 'wrong' | 'missing';
};

/** What happens to staff who rehearse (server/contract/rehearsals.def). */
export type RehearsalKind = 'trip' | 'freeze' | 'bumper' | 'link_loss' | 'low_battery' | 'second_therapist';

export type RehearsalLook = {
  check: RehearsalCheck;
  /** null: none. */
  limit_s: number | null;
};

export type RehearsalRequest = {
  /** null: none. */
  rehearsal: RehearsalKind | null;
  /** Draws the moment when it happens; a new one when not given. */
  seed?: number | null;
};

/** What staff did in a rehearsal on a simulated hoist. */
export type RehearsalResult = {
  /** Of walking, when it happened. */
  after_s: number;
  items: readonly RehearsalItem[];
  rehearsal: RehearsalKind;
  seed: number;
};

export type RehearsalState = {
  kinds: readonly {
    looks: readonly RehearsalLook[];
    rehearsal: RehearsalKind;
  }[];
  /** lost: the core ended, so there is no result. */
  phase: 'none' | 'waiting' | 'happening' | 'over' | 'lost';
  /** Why none can be chosen here; null: one can. */
  reason_code: ReasonCode | null;
  rehearsal: RehearsalKind | null;
  /** When it is over. */
  result: RehearsalResult | null;
  seed: number | null;
  /** That was recorded when it happened; its markers have the result. */
  session: number | null;
};

export type RestoreResult = {
  backup: string;
  kind: 'restore';
  /** Where the file is that was in use before. */
  set_aside: string;
};

export type Retention = {
  days: number | null;
  disk_percent: number | null;
  etag: EditTag;
  needs_backup: boolean;
};

export type RetentionResult = {
  /** That these take. */
  bytes: number;
  /** Size of their disk. */
  disk_bytes: number;
  /** By which they still exceed their share afterwards; the rest is protected. */
  excess_bytes: number;
  /** Earliest start of them. */
  from_utc_ms: number | null;
  kind: 'preview_retention' | 'retention';
  rule: RetentionRule;
  /** That would be deleted, or were. */
  sessions: number;
  /** Latest start of them. */
  to_utc_ms: number | null;
  /** What the recordings took before. */
  used_bytes: number;
  /** Further sessions, which are kept because no checked backup holds them. */
  without_backup: number;
};

/** Off while both numbers are null. */
export type RetentionRule = {
  /** A session is deleted when it is older. */
  days: number | null;
  /** The oldest sessions are deleted while the recordings take more of their disk. */
  disk_percent: number | null;
  /** true: only sessions that a checked backup holds are deleted. */
  needs_backup: boolean;
};

export type RoleName = 'viewer' | 'therapist' | 'engineer';

export type Samples = {
  columns: readonly {
    max: readonly number[];
    min: readonly number[];
    name: string;
    unit: string;
  }[];
  from_s: readonly number[];
  gap_before: readonly number[];
  to_s: readonly number[];
};

export type Session = {
  close_reason: string;
  /** Of hoist-control; null = not recorded. */
  core_version: string | null;
  duration_s: number;
  ended_utc_ms: number | null;
  etag: EditTag;
  exercise: ExerciseOrNull;
  gaps: number;
  id: number;
  layout_hash: string;
  /** Not in lists. Empty = not recorded. */
  nodes?: readonly NodeProgram[];
  note: string;
  recording: boolean;
  samples: number;
  simulated: boolean;
  /** Of the program that recorded: version and commit. */
  software_version: string;
  /** true: recorded in standby with a patient chosen; no walk. */
  standby: boolean;
  started_utc_ms: number;
  stored_bytes: number;
  /** null: not of a virtual subject. */
  study: StudyRun | null;
  subject: string | null;
  /** null: no repetition of a task. */
  task: TaskRecord | null;
  /** null: no patient code is given. */
  visit: Visit | null;
};

export type SessionList = {
  items: readonly Session[];
  next: string | null;
  total: number;
};

export type SessionPatch = {
  exercise?: ExerciseOrNull;
  note?: NoteText;
  subject?: SubjectCode | null;
};

export type SetRequest = {
  revert_after_s?: TrialTime;
  values: ParameterNumbers;
  version?: LookedAt;
};

export type SetUpRequest = {
  code: string;
  display_name: DisplayName;
  password: Password;
  user: UserName;
};

export type SignInRequest = {
  password?: string;
  /** Instead of the password. */
  pin?: string;
  user: string;
};

export type SignalList = {
  items: readonly ({
    doc: string;
    id: number;
    lsb: number;
    name: string;
    offset: number;
    title: Words;
    type: 'u64' | 'u32' | 'i32' | 'f32' | 'u16' | 'u8';
    unit: string;
  })[];
  record_bytes: number;
};

/** Stays as long as its condition holds. */
export type StandingNotice = {
  action: Words;
  /** For the engineer. */
  detail: string;
  name: string;
  priority: 'low' | 'medium';
  text: Words;
};

export type Status = {
  clients: number;
  core: {
    /** The faults in the order in which to tell them: what endangers the patient, what stopped the hoist, each followed by its consequences. */
    alarms: readonly Alarm[];
    blocked: readonly string[];
    bus: {
      frames: number;
      refused: number;
    } | null;
    connected: boolean;
    faults: readonly string[];
    mode: string | null;
    problem: string | null;
    standing_still: boolean | null;
    tick: number | null;
    /** Of hoist-control: version and commit; null before one was connected. */
    version: string | null;
  };
  counters: Record<string, number>;
  /** UUID of this hoist, whatever it is called; null: the recordings file is not open. */
  hoist_id: string | null;
  lease: Lease;
  notices: readonly StandingNotice[];
  recording: Recording;
  scenario: string | null;
  server: {
    layout_hash: string;
    uptime_s: number;
  };
  simulated: boolean;
  started: string;
  version: string;
};

/** true: on the disk, file and folder synced. false: in force and not stored; see the notices of /api/v1/status. */
export type Stored = boolean;

export type StreamRequest = {
  /** A message for each step; only for the client in control. */
  every_tick?: boolean;
  /** Newest step that the client has: later ones come first, or are named as missing (gap). */
  last_tick?: number;
  /** Samples per second; left out: 100. A change of state is sent at once at any rate. */
  rate_hz?: 1 | 2 | 5 | 10 | 20 | 50 | 100;
  /** Run of the core that last_tick is of, as in the message core. */
  run?: string;
  /** Blocks of live values; left out: state, motion, pose, posture, intent. */
  topics?: readonly TopicName[];
};

export type Study = {
  /** Figures 2, 7 and 8 of the paper by name: /api/v1/studies/{id}/drawings/{name}. */
  drawings: readonly string[];
  id: number;
  made_utc_ms: number;
  report: StudyReport;
  /** Its runs that are still there. */
  sessions: readonly {
    run: number;
    session: number;
    subject: string;
  }[];
};

export type StudyAssumed = {
  anticipation_norm: StudyRange;
  injured_sway_norm: number;
  learning_norm: number;
  limp_norm: number;
  misjudgement_m: number;
  misjudgement_rad: number;
  therapist_delay_s: number;
  therapist_m_s: number;
  trailing_s: number;
  wish_m_s: StudyRange;
};

/** null: no value. */
export type StudyColumn = readonly (number | null)[];

/** By run, then by row. */
export type StudyColumns = readonly StudyColumn[];

export type StudyDeleted = {
  kind: 'delete_study';
  sessions: number;
  study: number;
};

export type StudyJobResult = {
  kind: 'study' | 'study_recorded';
  study: number;
};

export type StudyList = {
  /** Newest first. */
  items: readonly ({
    id: number;
    made_utc_ms: number;
    seed: number | null;
    /** That are still there. */
    sessions: number;
    subjects: number;
    title: string;
  })[];
  next: string | null;
};

export type StudyRange = readonly number[];

/** What `hoist study` prints, as numbers. */
export type StudyReport = {
  /** What is put in for virtual subjects: no finding. null: they were people. */
  assumed: StudyAssumed | null;
  compared: readonly ({
    decimals: number;
    figure: 'C' | 'J_N';
    from: number;
    own: StudyTest;
    paper: StudyTest;
    to: number;
  })[];
  /** What comes out by itself: mean C of the squares, of the eights that the patient leads, and J_N of squares by that of the therapist's eights. */
  findings: {
    c_led: number | null;
    c_square: number | null;
    j_ratio: number | null;
  };
  laps: number;
  /** Runs that do not count, and why. */
  left_out: readonly ({
    /** That is not valid; null: too few laps. */
    figure: string | null;
    /** Walked, when they are too few. */
    laps: number | null;
    reason_code: NoFigure | null;
    run: number;
    subject: string;
  })[];
  /** Means of other figures, by run. */
  others: readonly ({
    figure: 'C_best' | 'rms_position_m' | 'rms_heading_rad' | 'walking_speed_m_s' | 'lap_time_mean_s';
    means: StudyColumn;
  })[];
  preset: string;
  runs: readonly ({
    /** With the orthosis that simulates an injury. */
    injured: boolean;
    led_by: 'patient' | 'therapist';
    run: number;
    shape: 'square' | 'eight';
  })[];
  seed: number | null;
  subjects: number;
  /** Tables II (C) and III (J_N). */
  tables: readonly ({
    decimals: number;
    figure: 'C' | 'J_N';
    own: StudyColumns;
    own_mean: StudyColumn;
    paper: StudyColumns;
    paper_mean: StudyColumn;
    /** Of the rows; - where only the paper has one. */
    subjects: readonly string[];
  })[];
  title: string;
  virtual_subjects: boolean;
};

/** Which run of a study with virtual subjects a session is. */
export type StudyRun = {
  /** Its number in the protocol. */
  run: number;
  study: number;
  subject: string;
};

/** Wilcoxon's signed ranks, two-sided, exact, of the subjects who did both runs. */
export type StudyTest = {
  down: number;
  mean_first: number;
  mean_second: number;
  p: number | null;
  pairs: number;
  up: number;
};

/** A code, never a name: 1 to 32 letters, digits, dots, hyphens or underscores, beginning with a letter or digit. Spaces around it are dropped; capital and small letters do not tell codes apart.. */
export type SubjectCode = string;

/** A clinical task: a file of db/tasks. */
export type Task = {
  /** At both ends of the line, walked but not timed. */
  edge_m: number;
  ends: {
    by: TaskEnd;
    goal: TaskRange;
  };
  /** What the patient is told. */
  instruction: Words;
  /** Modes in which it may be done. */
  leads: readonly ('user' | 'remote' | 'guided')[];
  /** Shape of its exercise; null = without a line. */
  line: string | null;
  name: string;
  repetitions: TaskRange;
  rest_s: TaskRange;
  /** Figures of a session that are its results. */
  results: readonly string[];
  /** Sizes that may be adjusted, m; the others keep their proportion. */
  sizes: Record<string, TaskRange>;
  title: Words;
  version: number;
};

/** What ends it: so many times along its line, seconds since the first movement, radians turned, metres away and back, or the therapist. */
export type TaskEnd = 'distance' | 'time' | 'turn' | 'back' | 'hand';

/** What ended the task when it was walked; null: no task. */
export type TaskGoalOrNull = null | {
  by: TaskEnd;
  edge_m: number;
  /** Times along the line, seconds, radians, metres. */
  goal: number;
};

export type TaskList = {
  items: readonly Task[];
};

export type TaskRange = {
  least: number;
  most: number;
  /** Of a button. */
  step: number;
  usual: number;
};

/** The task that a session is a repetition of. */
export type TaskRecord = {
  edge_m: number;
  ends: TaskEnd;
  goal: number;
  /** Name of the own line, as it was then; left out: none. */
  line?: string;
  repetition: number;
  repetitions: number;
  rest_s: number;
  task: string;
  version: number;
};

/** What is left out is as usual. */
export type TaskRequest = {
  clockwise?: boolean | null;
  /** Of its end: times along the line, seconds, radians, metres. */
  goal?: number | null;
  /** Of the task own_line: what is walked, and what it is called. */
  line?: LineRequest | null;
  repetitions?: number | null;
  rest_s?: number | null;
  sizes?: Record<string, number> | null;
  /** null: no task, only the exercise. */
  task: string | null;
};

export type TaskState = {
  /** Step of its first movement. */
  begun_tick: number | null;
  /** Step in which its motion ended: the rest is counted from here. */
  ended_tick: number | null;
  ends: TaskEnd;
  goal: number;
  line: LineOrNull;
  /** Its end was reached. */
  reached: boolean;
  /** The latest one that was begun; 0 = none yet. */
  repetition: number;
  repetitions: number;
  rest_s: number;
  task: string;
  version: number;
};

export type Ticket = {
  ticket: string;
};

export type Time = {
  /** How far the client's clock is behind, the way of the request included. */
  client_behind_s: number | null;
  /** Who may set it. */
  kept_by: 'operating_system' | 'engineers';
  steady_ns: number;
  /** Whether the operating system has it from a time server; null: it does not say. */
  synchronised: boolean | null;
  utc_ms: number;
};

export type TimeRequest = {
  utc_ms: number;
};

export type Token = {
  created_utc_s: number;
  etag: EditTag;
  expires_utc_s: number;
  id: number;
  name: string;
  scope: RoleName;
  user: string;
};

export type TokenList = {
  items: readonly Token[];
  next: string | null;
};

export type TokenMade = {
  id: number;
  /** Shown this once: Authorization: Bearer .... */
  token: string;
};

export type Tools = {
  enabled: boolean;
  etag: EditTag;
  /** Path of the WebSocket. */
  foxglove: string;
  /** Path of a layout file for Foxglove Studio. */
  foxglove_layout: string;
  /** Path of the WebSocket. */
  rosbridge: string;
};

export type ToolsRequest = {
  enabled: boolean;
};

export type TopicName = 'state' | 'motion' | 'pose' | 'posture' | 'intent' | 'exercise' | 'power' | 'calibration' | 'all';

export type Trend = {
  /** Newest value of this page against the first one of all, of each figure, within one exercise, task and goal. */
  changes: readonly FigureChange[];
  /** The first walk of each exercise, task and goal among the items, where it is older than this page; newest first. */
  firsts: readonly TrendItem[];
  items: readonly TrendItem[];
  next: string | null;
  /** Recordings of this patient with a simulated hoist. */
  simulated_left_out: number;
};

/** The figures of db/metrics/metric_list.hpp; null: not defined for this session. */
export type TrendFigures = {
  /** Correlation of pelvis turn and path turn at zero lag, -1 to 1: whether the patient turns where the path turns. No measure of distance from the path. */
  C: number | null;
  /** The correlation C at the shift in time at which it is largest. */
  C_best: number | null;
  /** How much before the path the pelvis turns, by the shift of C_best. */
  C_best_lag_s: number | null;
  /** Squared error of the walk per metre of path, at 100 Hz: it grows with slowness, too. */
  J_N: number | null;
  /** Squared error of the walk over time per metre of path: J_N without the sampling rate. */
  J_T_m_s: number | null;
  /** Walk, turn, walk back: time of the way back. */
  back_time_s: number | null;
  /** Sudden leans far out, faster than this walk's own: losses of balance and catches. */
  balance_events: number | null;
  /** Number of bouts of walking: a second or longer at more than 0.05 m/s. */
  bouts: number | null;
  /** Steps a minute, two to a stride. */
  cadence_steps_min: number | null;
  /** Share of the exercise that was walked; laps beyond the first count on. */
  completion_norm: number | null;
  /** Largest distance from the exercise. */
  cross_track_max_m: number | null;
  /** Mean distance from the exercise. */
  cross_track_mean_m: number | null;
  /** Share of the time led by the patient in which the lean asked for nothing. */
  dead_band_norm: number | null;
  /** Effort of a metre: lean as a share of its range, times the time it is held, per metre. */
  effort_s_m: number | null;
  /** How often patient-led walking was broken off: by a stop, a fault or the therapist. */
  interventions: number | null;
  /** Shortest time for once along the exercise. */
  lap_time_best_s: number | null;
  /** Mean time for once along the exercise, pauses included. */
  lap_time_mean_s: number | null;
  /** Logarithmic dimensionless jerk of the forward speed of the longest bout: nearer to 0 is smoother. */
  ldlj: number | null;
  /** Largest absolute speed while under way. */
  max_speed_m_s: number;
  /** walked_m over motion_s: standing does not count. */
  mean_speed_m_s: number | null;
  /** Motion that is not recorded: all figures are of the rest. */
  missing_s: number;
  /** Of that, time in which a wheel turned at 0.02 m/s or more. */
  motion_s: number;
  /** Walk, turn, walk back: time of the way out. */
  out_time_s: number | null;
  /** Share of the time in motion in which the patient led. */
  patient_led_norm: number | null;
  /** How often the hoist stopped by itself or by the emergency stop. */
  protective_stops: number | null;
  /** Progress along the exercise. */
  reference_length_m: number | null;
  /** Angle against the exercise, root mean square. */
  rms_heading_rad: number | null;
  /** Distance across the path, root mean square. */
  rms_lateral_m: number | null;
  /** What J_N is made of in plain units: distance and heading error together, root mean square, 1 rad as 1 m. */
  rms_pose_m: number | null;
  /** Distance from the exercise, root mean square. */
  rms_position_m: number | null;
  /** Spectral arc length of the forward speed of the longest bout: nearer to 0 is smoother. */
  sparc: number | null;
  /** From leaning to moving off: how long until the hoist follows at 0.05 m/s. */
  start_latency_s: number | null;
  /** How much longer the harness takes from right to left than back, as a share of their mean. */
  step_asymmetry_norm: number | null;
  /** How alike successive steps are, left to right: 1 = all the same. */
  step_regularity_norm: number | null;
  /** 1 = left and right steps are as alike as successive strides. */
  step_symmetry_norm: number | null;
  /** Steps taken in bouts of walking, two to a stride. */
  steps: number | null;
  /** Way that the hoist rolls after the patient has leant back. */
  stopping_way_m: number | null;
  /** How often walking was interrupted for a second or longer. */
  stops: number | null;
  /** How alike successive strides are: 1 = all the same. */
  stride_regularity_norm: number | null;
  /** How much the time of a stride varies, as a share of its mean. */
  stride_time_cv_norm: number | null;
  /** Time of a stride (two steps), from the sideways sway of the harness. */
  stride_time_s: number | null;
  /** Way walked in the time of the task. */
  task_distance_m: number | null;
  /** Time that the task took, from the first movement to its end. */
  task_time_s: number | null;
  /** Mean speed over the timed middle of the line: setting off and stopping do not count. */
  timed_speed_m_s: number | null;
  /** Mean angle of the turns. */
  turn_angle_rad: number | null;
  /** How much before the hoist the pelvis turns. */
  turn_lead_s: number | null;
  /** Mean time of the turns. */
  turn_time_s: number | null;
  /** Walk, turn, walk back: time of the turn. */
  turning_time_s: number | null;
  /** Turns of the hoist to the left by 45 degrees or more. */
  turns_left: number | null;
  /** Turns of the hoist to the right by 45 degrees or more. */
  turns_right: number | null;
  /** Time in which the hoist was under way (a mode in which the wheels may turn), standing included. */
  under_way_s: number;
  /** Way walked, forward and backward: absolute speed times 10 ms, summed over the time under way. */
  walked_m: number;
  /** Time in bouts of more than 0.05 m/s that last a second or longer. */
  walking_s: number;
  /** Mean speed in these bouts: setting off, stopping and standing hardly count. */
  walking_speed_m_s: number | null;
};

export type TrendItem = {
  day: string;
  ends: TaskGoalOrNull;
  exercise: ExerciseOrNull;
  /** null: the recording cannot be read. */
  figures: TrendFigures | null;
  /** Name of an own line when it was walked. */
  line: string | null;
  /** Why there is no C, J_N, or one of them. */
  reason_code: NoFigure | null;
  /** Of each figure that is null: why. */
  reasons: Record<string, NoFigure>;
  session: number;
  started_utc_ms: number;
  /** Name of the task that it is a repetition of; walks are compared within one exercise, task and goal. */
  task: string | null;
  visit: number;
};

/** Only on trial: the values before come back after so many seconds unless confirmed. */
export type TrialTime = number;

/** Advice only: a person decides and sets a value. */
export type TuningAdvice = {
  items: readonly TuningSuggestion[];
  session: number;
  /** Standing that it is drawn from, with the patient's standby just before. */
  standing_s: number;
  /** Walking led by the patient. */
  walking_s: number;
};

export type TuningSuggestion = {
  effect: Words;
  effect_now: number | null;
  /** To be expected. */
  effect_then: number | null;
  formula: string;
  measured: number | null;
  /** Of measured and both effects; empty: a share. */
  measured_unit: string;
  measures: Words;
  /** Of the parameter. */
  name: string;
  /** In force when the session began. */
  now: number | null;
  reason: Words | null;
  /** Why there is no suggestion; its numbers are null then. */
  reason_code: string | null;
  /** Inside the parameter's range; the same as now: it may stay. */
  suggested: number | null;
};

export type User = {
  display_name: string;
  enabled: boolean;
  etag: EditTag;
  has_pin: boolean;
  role: RoleName;
  user: string;
};

export type UserList = {
  items: readonly User[];
  next: string | null;
};

/** For signing in: a-z 0-9 . _ -. */
export type UserName = string;

export type UserPatch = {
  display_name?: DisplayName;
  enabled?: boolean;
  password?: Password;
  role?: RoleName;
};

/** One patient on one day. */
export type Visit = {
  /** YYYY-MM-DD where the recording computer stands. */
  day: string;
  id: number;
  patient: number;
};

export type VisitList = {
  items: readonly VisitRow[];
  next: string | null;
};

export type VisitPatch = {
  note: NoteText;
};

/** One patient on one day. */
export type VisitRow = {
  code: string;
  day: string;
  etag: EditTag;
  id: number;
  note: string;
  patient: number;
  /** The walks, in the order of recording. */
  sessions: readonly number[];
  /** What was recorded in standby before and after them. */
  standby: readonly number[];
};

export type Walk = {
  /** What the present or the latest motion began with; null = not known to this server. */
  begun: Exercise | GuidedPath | null;
  /** Chosen for the next walk. */
  exercise: Exercise;
  /** Pose at the start mark. */
  mark: Pose | null;
  /** Time in motion since the start mark; null = the mark is older than this server. */
  motion_s: number | null;
  /** A point of the path each so many metres. */
  step_m: number;
  /** Chosen for the next walks; null = none. */
  task: TaskState | null;
  /** Newest step in what follows. */
  tick: number | null;
  x_m: readonly number[];
  y_m: readonly number[];
};

export type WhoAmI = {
  device: {
    language: LanguageOrNull;
    /** Of this hoist. */
    name: string;
  };
  display_name: string | null;
  /** null: no account. */
  has_pin: boolean | null;
  /** Who has signed in on this device and may use a PIN, latest first. */
  here: readonly {
    display_name: string;
    user: string;
  }[];
  /** Why the accounts cannot be used; for the engineer. */
  problem: string | null;
  role: RoleName | null;
  /** Until this sign-in ends at the latest; null: it does not end by itself. */
  seconds_left: number | null;
  set_up: {
    /** The accounts were read, and there is no engineer yet. */
    needed: boolean;
    /** How long the code is still valid; 0 = none is. */
    seconds_left: number;
    switch_on: boolean;
  };
  signed_in: boolean;
  /** local: whoever uses this computer itself. */
  user: string | null;
};

export type Words = {
  de: string;
  en: string;
};

/** Every route under /api/v1, with what it takes and what it answers: `never` where that is no JSON. */
export interface Routes {
  /** Leaves a stop once its cause is gone; needs the lease. */
  'POST /api/v1/acknowledge': {
    body?: AcknowledgeRequest;
    answer: Done;
  };
  /** Pauses the sound of the alarms in force for two minutes, at the hoist and on every screen; their lights go on, and a new alarm sounds at once. */
  'PUT /api/v1/alarm-pause': {
    body: AlarmPauseRequest;
    answer: Done;
  };
  /** Alarms of all recorded sessions, newest first; those of now are in the status. */
  'GET /api/v1/alarms': {
    query?: { limit?: number; cursor?: string; fault?: string; session?: number; from_utc_ms?: number; to_utc_ms?: number };
    answer: AlarmList;
  };
  /** Who did what, newest first; rows are only ever added. */
  'GET /api/v1/audit': {
    query?: { limit?: number; cursor?: string };
    answer: AuditList;
  };
  /** Whether a row of the audit log was changed or is missing. */
  'GET /api/v1/audit/check': {
    answer: AuditCheck;
  };
  /** Ends calibrating; the old values stay. */
  'DELETE /api/v1/calibration': {
    answer: Done;
  };
  /** What can be calibrated, when it last was, the step under way with its result. */
  'GET /api/v1/calibration': {
    answer: Calibration;
  };
  /** Begins a step on standby, or another one; the wheels never turn by themselves; needs the lease. */
  'POST /api/v1/calibration': {
    body: CalibrationRequest;
    answer: Done;
  };
  /** What the operator measured; taken as soon as everything rests. */
  'POST /api/v1/calibration/measure': {
    body: CalibrationMeasure;
    answer: Done;
  };
  /** The result becomes parameters, all or nothing. */
  'POST /api/v1/calibration/use': {
    body?: Empty;
    answer: DoneStored;
  };
  /** Chooses the exercise of the next walk, for all screens. */
  'PUT /api/v1/exercise': {
    body: Exercise;
    answer: Done;
  };
  /** The exercises: shapes, sizes with ranges and usual values, words. */
  'GET /api/v1/exercises': {
    answer: ExerciseList;
  };
  /** Faults and reasons for refusals, with words. */
  'GET /api/v1/faults': {
    answer: FaultList;
  };
  /** Programs of the nodes, as far as they were heard to name them, and the running or the last update. */
  'GET /api/v1/firmware': {
    answer: Firmware;
  };
  /** Puts a program (*.hoistfw, at most 128 KiB) into a node; on standby, needs the lease; goes on by itself, see firmware_progress on the WebSocket. */
  'POST /api/v1/firmware/{node}': {
    path: { node: string };
    query?: { force?: number };
    body: never;
    answer: Firmware;
  };
  /** Nodes and bus: who answers, who loses messages, latest emergency messages. */
  'GET /api/v1/health': {
    answer: Health;
  };
  /** Long work, oldest first: what waits, what runs, and the latest 16 that ended. */
  'GET /api/v1/jobs': {
    query?: { limit?: number; cursor?: string };
    answer: JobList;
  };
  /** Starts long work; its address is in the header Location, how far it is also on the WebSocket. */
  'POST /api/v1/jobs': {
    body: JobRequest;
    answer: Job;
  };
  /** Ends a job that waits or runs; what runs ends at its next page, recording or session. */
  'DELETE /api/v1/jobs/{id}': {
    path: { id: number };
    answer: Job;
  };
  /** One job with its result. */
  'GET /api/v1/jobs/{id}': {
    path: { id: number };
    answer: Job;
  };
  /** The file that an export has made, or a part of it (Range). */
  'GET /api/v1/jobs/{id}/file': {
    path: { id: number };
    answer: never;
  };
  /** Gives control back. */
  'DELETE /api/v1/lease': {
    answer: Done;
  };
  /** Who is in control and who asks for it; with X-Hoist-Lease it also keeps control. */
  'GET /api/v1/lease': {
    answer: Lease;
  };
  /** Takes control; given back 10 s after its last use: a request that needs it or sends X-Hoist-Lease. */
  'POST /api/v1/lease': {
    body?: LeaseRequest;
    answer: LeaseResult;
  };
  /** Asks for control no longer. */
  'DELETE /api/v1/lease/ask': {
    answer: Done;
  };
  /** Asks for control; its holder sees who asks, for a minute. */
  'POST /api/v1/lease/ask': {
    body?: Empty;
    answer: Done;
  };
  /** Gives control to another client or person while the hoist stands still. */
  'POST /api/v1/lease/hand-over': {
    body: HandOverRequest;
    answer: Done;
  };
  /** Keeps control: those who ask are told. */
  'POST /api/v1/lease/keep': {
    body?: Empty;
    answer: Done;
  };
  /** Own lines on the floor, newest first; the task own_line is walked along one of them. */
  'GET /api/v1/lines': {
    query?: { limit?: number; cursor?: string };
    answer: LineList;
  };
  /** Saves a line under a name. */
  'POST /api/v1/lines': {
    body: LineRequest;
    answer: Line;
  };
  /** Deletes an own line; sessions keep the line that they walked. */
  'DELETE /api/v1/lines/{id}': {
    path: { id: number };
    etag: string | null;
    answer: null;
  };
  /** One own line. */
  'GET /api/v1/lines/{id}': {
    path: { id: number };
    answer: Line;
  };
  /** Renames an own line, or saves it anew; sessions keep the line that they walked. */
  'PATCH /api/v1/lines/{id}': {
    path: { id: number };
    body: LinePatch;
    etag: string | null;
    answer: Line;
  };
  /** How punctual the control loop is: lateness in buckets, steps left out, page faults, what the computer granted. */
  'GET /api/v1/loop': {
    answer: Loop;
  };
  /** The mode the hoist is in. */
  'GET /api/v1/mode': {
    answer: ModeState;
  };
  /** Starts motion, which needs the lease, or ends it, which anyone may. */
  'POST /api/v1/mode': {
    body: ModeRequest;
    answer: Done;
  };
  /** The modes. */
  'GET /api/v1/modes': {
    answer: ModeList;
  };
  /** Addresses under which the hoist is reached, and how to trust it. */
  'GET /api/v1/network': {
    answer: Network;
  };
  /** Takes the way the patient stands now as upright. */
  'POST /api/v1/neutral': {
    body?: Empty;
    answer: DoneStored;
  };
  /** All parameters with value, range and words. */
  'GET /api/v1/parameters': {
    answer: ParameterList;
  };
  /** Changes several parameters, all or nothing. */
  'PATCH /api/v1/parameters': {
    body: ParameterValues;
    etag: string | null;
    answer: ParameterResult;
  };
  /** Values on trial stay. */
  'POST /api/v1/parameters/confirm': {
    body?: KeepRequest;
    answer: DoneStored;
  };
  /** Which parameters differed between two moments. */
  'GET /api/v1/parameters/diff': {
    query?: { from_utc_ms?: number; to_utc_ms?: number };
    answer: ParameterDiff;
  };
  /** Every change of a parameter, newest first: when, by whom, in which session, and how. */
  'GET /api/v1/parameters/history': {
    query?: { limit?: number; cursor?: string; name?: string; patient?: number; from_utc_ms?: number; to_utc_ms?: number };
    answer: ParameterHistory;
  };
  /** Values on trial go back at once. */
  'POST /api/v1/parameters/revert': {
    body?: Empty;
    answer: Done;
  };
  /** One parameter. */
  'GET /api/v1/parameters/{name}': {
    path: { name: string };
    answer: Parameter;
  };
  /** Changes one parameter; answers after the core has taken it. */
  'PUT /api/v1/parameters/{name}': {
    path: { name: string };
    body: ParameterValue;
    etag: string | null;
    answer: ParameterResult;
  };
  /** Whom the hoist walks with. */
  'GET /api/v1/patient': {
    answer: ChosenPatient;
  };
  /** Chooses whom standby and motion are recorded for, for all screens; forgotten after half an hour without motion. */
  'PUT /api/v1/patient': {
    body: ChoosePatient;
    answer: ChosenPatient;
  };
  /** Patients by their codes, newest first. */
  'GET /api/v1/patients': {
    query?: { limit?: number; cursor?: string; q?: string; archived?: number };
    answer: PatientList;
  };
  /** A new patient; the address is in the header Location. */
  'POST /api/v1/patients': {
    body: PatientRequest;
    answer: Patient;
  };
  /** Deletes a patient with sessions, visits, profiles and identity, overwritten. */
  'DELETE /api/v1/patients/{id}': {
    path: { id: number };
    etag: string | null;
    answer: null;
  };
  /** One patient. */
  'GET /api/v1/patients/{id}': {
    path: { id: number };
    answer: Patient;
  };
  /** Changes code or archive; not of the patient who is chosen. */
  'PATCH /api/v1/patients/{id}': {
    path: { id: number };
    body: PatientPatch;
    etag: string | null;
    answer: Patient;
  };
  /** Takes the identity away, overwritten. */
  'DELETE /api/v1/patients/{id}/identity': {
    path: { id: number };
    etag: string | null;
    answer: Patient;
  };
  /** Who a patient is, or why that cannot be shown; in no export or record. */
  'GET /api/v1/patients/{id}/identity': {
    path: { id: number };
    answer: Identity;
  };
  /** Stores who a patient is, sealed. */
  'PUT /api/v1/patients/{id}/identity': {
    path: { id: number };
    body: IdentityRequest;
    etag: string | null;
    answer: Patient;
  };
  /** A patient's settings by name, newest first. */
  'GET /api/v1/patients/{id}/profiles': {
    path: { id: number };
    query?: { limit?: number; cursor?: string };
    answer: ProfileList;
  };
  /** Saves settings under a name: the given ones, or those in force. */
  'POST /api/v1/patients/{id}/profiles': {
    path: { id: number };
    body: ProfileRequest;
    answer: Profile;
  };
  /** Figures of a patient's sessions, newest first; recordings of a simulated hoist never enter it. */
  'GET /api/v1/patients/{id}/trend': {
    path: { id: number };
    query?: { limit?: number; cursor?: string; comparable_to?: number };
    answer: Trend;
  };
  /** Sets the odometry's pose while standing still. */
  'POST /api/v1/pose': {
    body: Pose;
    answer: Done;
  };
  /** The presets and their values. */
  'GET /api/v1/presets': {
    answer: PresetList;
  };
  /** Sets all values of a preset, all or nothing. */
  'POST /api/v1/presets/{name}/apply': {
    path: { name: string };
    body?: KeepRequest;
    answer: ParameterResult;
  };
  /** Deletes a profile with its versions. */
  'DELETE /api/v1/profiles/{id}': {
    path: { id: number };
    etag: string | null;
    answer: null;
  };
  /** One profile as it was saved last. */
  'GET /api/v1/profiles/{id}': {
    path: { id: number };
    answer: Profile;
  };
  /** Renames a profile, or saves its next version. */
  'PATCH /api/v1/profiles/{id}': {
    path: { id: number };
    body: ProfilePatch;
    etag: string | null;
    answer: Profile;
  };
  /** Sets all values of a profile at standstill, all or nothing. */
  'POST /api/v1/profiles/{id}/apply': {
    path: { id: number };
    body: ProfileApply;
    answer: ParameterResult;
  };
  /** What would change if the profile were applied. */
  'GET /api/v1/profiles/{id}/diff': {
    path: { id: number };
    answer: ProfileDiff;
  };
  /** How a profile was saved, newest first. */
  'GET /api/v1/profiles/{id}/versions': {
    path: { id: number };
    query?: { limit?: number; cursor?: string };
    answer: ProfileList;
  };
  /** What is being recorded. */
  'GET /api/v1/recording': {
    answer: Recording;
  };
  /** Starts or ends a recording on standby. */
  'POST /api/v1/recording': {
    body: RecordingRequest;
    answer: Recording;
  };
  /** Rehearsals for staff on a simulated hoist: which there are, and the one that is chosen; its result is also a marker of the session. */
  'GET /api/v1/rehearsal': {
    answer: RehearsalState;
  };
  /** Chooses a rehearsal, which happens some time after the patient has begun to walk; null: none, or the end of the one under way. Refused on a real hoist. */
  'PUT /api/v1/rehearsal': {
    body: RehearsalRequest;
    answer: Done;
  };
  /** How long sessions are kept. */
  'GET /api/v1/retention': {
    answer: Retention;
  };
  /** Sets how long sessions are kept; the job preview_retention tells what a rule would delete. */
  'PUT /api/v1/retention': {
    body: RetentionRule;
    etag: string | null;
    answer: Retention;
  };
  /** Signs out; what this client drives stops. STOP stays possible. */
  'DELETE /api/v1/session': {
    answer: Done;
  };
  /** Who is signed in, who may sign in here by PIN, and whether a set-up is needed. */
  'GET /api/v1/session': {
    answer: WhoAmI;
  };
  /** Signs in with a password, or with a PIN on a device where this person has signed in before; the cookie is new each time. */
  'POST /api/v1/session': {
    body: SignInRequest;
    answer: WhoAmI;
  };
  /** Changes one's own password; the PIN is removed and other devices are signed out. */
  'PUT /api/v1/session/password': {
    body: PasswordChange;
    answer: Done;
  };
  /** Sets or removes one's own PIN. */
  'PUT /api/v1/session/pin': {
    body: PinChange;
    answer: Done;
  };
  /** Recorded sessions, newest first. */
  'GET /api/v1/sessions': {
    query?: { limit?: number; cursor?: string; q?: string; patient?: number; standby?: number };
    answer: SessionList;
  };
  /** Deletes a session with everything in it. */
  'DELETE /api/v1/sessions/{id}': {
    path: { id: number };
    etag: string | null;
    answer: null;
  };
  /** One session. */
  'GET /api/v1/sessions/{id}': {
    path: { id: number };
    answer: Session;
  };
  /** Changes note, patient code or exercise. */
  'PATCH /api/v1/sessions/{id}': {
    path: { id: number };
    body: SessionPatch;
    etag: string | null;
    answer: Session;
  };
  /** Events of a session, in the order in which they were recorded. */
  'GET /api/v1/sessions/{id}/events': {
    path: { id: number };
    query?: { limit?: number; cursor?: string };
    answer: EventList;
  };
  /** A session in one of the formats of db/export/formats.def; of mcap also a part (Range). */
  'GET /api/v1/sessions/{id}/export': {
    path: { id: number };
    query?: { format?: 'csv' | 'csv_de' | 'events' | 'json' | 'candump' | 'mcap' | 'mat' | 'sqlite' | 'zip'; columns?: string; constant?: number; comments?: number };
    answer: never;
  };
  /** What is missing in a session, and why. */
  'GET /api/v1/sessions/{id}/gaps': {
    path: { id: number };
    query?: { limit?: number; cursor?: string };
    answer: GapList;
  };
  /** Markers of a session, in the order in which they were set. */
  'GET /api/v1/sessions/{id}/markers': {
    path: { id: number };
    query?: { limit?: number; cursor?: string };
    answer: MarkerList;
  };
  /** Sets a marker now in the session that is being recorded. */
  'POST /api/v1/sessions/{id}/markers': {
    path: { id: number };
    body: MarkerRequest;
    answer: Done;
  };
  /** Deletes a marker, overwritten. */
  'DELETE /api/v1/sessions/{id}/markers/{number}': {
    path: { id: number; number: number };
    etag: string | null;
    answer: null;
  };
  /** Changes text, kind or time of a marker. */
  'PATCH /api/v1/sessions/{id}/markers/{number}': {
    path: { id: number; number: number };
    body: MarkerPatch;
    etag: string | null;
    answer: MarkerRow;
  };
  /** Figures of a session on its exercise. */
  'GET /api/v1/sessions/{id}/metrics': {
    path: { id: number };
    answer: Metrics;
  };
  /** A report of a session for print: figures, path, progress against the patient's first walk of the same exercise; without names. */
  'GET /api/v1/sessions/{id}/report': {
    path: { id: number };
    query?: { kind?: 'patient' | 'full'; language?: 'en' | 'de' };
    answer: never;
  };
  /** Columns of a session, smallest and largest of each run of samples. */
  'GET /api/v1/sessions/{id}/samples': {
    path: { id: number };
    query?: { columns?: string; from_s?: number; to_s?: number; points?: number };
    answer: Samples;
  };
  /** The same as the export in the format mcap, or a part of it (Range): an address that ends as Foxglove Studio expects of such a file. */
  'GET /api/v1/sessions/{id}/session.mcap': {
    path: { id: number };
    answer: never;
  };
  /** Settings suggested from how the patient stood and walked in a session; nothing is changed. */
  'GET /api/v1/sessions/{id}/tuning-advice': {
    path: { id: number };
    answer: TuningAdvice;
  };
  /** What this hoist is called, and its language. */
  'GET /api/v1/settings': {
    answer: DeviceSettings;
  };
  /** Changes name or language of this hoist. */
  'PATCH /api/v1/settings': {
    body: DeviceSettingsPatch;
    etag: string | null;
    answer: DeviceSettings;
  };
  /** Makes an engineer's account, or gives one a new password; needs the configuration switch and the code that the hoist shows. */
  'POST /api/v1/setup': {
    body: SetUpRequest;
    answer: Done;
  };
  /** The live values: names, units, words. */
  'GET /api/v1/signals': {
    answer: SignalList;
  };
  /** What runs, what is wrong, what was refused. */
  'GET /api/v1/status': {
    answer: Status;
  };
  /** STOP. Anyone may who was ever signed in; never refused, whatever the body. */
  'POST /api/v1/stop': {
    answer: Done;
  };
  /** The paper's experiment as virtual subjects have walked it here (job study), newest first. */
  'GET /api/v1/studies': {
    query?: { limit?: number; cursor?: string };
    answer: StudyList;
  };
  /** Tables II and III of a study beside the paper's, paired tests, what was assumed and what comes out. */
  'GET /api/v1/studies/{id}': {
    path: { id: number };
    answer: Study;
  };
  /** Figure 2, 7 or 8 of the paper, drawn from this study. */
  'GET /api/v1/studies/{id}/drawings/{name}': {
    path: { id: number; name: string };
    answer: never;
  };
  /** Chooses the task of the next walks and its line, for all screens; each start on it is a repetition. null: none. */
  'PUT /api/v1/task': {
    body: TaskRequest;
    answer: Done;
  };
  /** The clinical tasks: line, sizes with ranges, end, repetitions, rest, instruction, result figures. */
  'GET /api/v1/tasks': {
    answer: TaskList;
  };
  /** The hoist's clock, and how far the client's is from it. */
  'GET /api/v1/time': {
    query?: { client_utc_ms?: number };
    answer: Time;
  };
  /** Sets the clock, between two sessions; refused where the operating system keeps it. */
  'PUT /api/v1/time': {
    body: TimeRequest;
    answer: Time;
  };
  /** Tokens of scripts and tools: one's own, an engineer sees all; oldest first. */
  'GET /api/v1/tokens': {
    query?: { limit?: number; cursor?: string };
    answer: TokenList;
  };
  /** Makes a token; its text is shown once. */
  'POST /api/v1/tokens': {
    body: NewToken;
    answer: TokenMade;
  };
  /** Removes a token; its connections close. */
  'DELETE /api/v1/tokens/{id}': {
    path: { id: number };
    etag: string | null;
    answer: null;
  };
  /** Whether Foxglove and rosbridge may connect, and their addresses. */
  'GET /api/v1/tools': {
    answer: Tools;
  };
  /** Lets Foxglove and rosbridge connect, or ends that. */
  'PUT /api/v1/tools': {
    body: ToolsRequest;
    etag: string | null;
    answer: Tools;
  };
  /** The accounts, by name. */
  'GET /api/v1/users': {
    query?: { limit?: number; cursor?: string };
    answer: UserList;
  };
  /** Adds an account. */
  'POST /api/v1/users': {
    body: NewUser;
    answer: User;
  };
  /** Changes name on screen, role or password, or disables an account; disabling and a new password sign it out, and a new password removes its PIN; accounts are never deleted, since records name them. */
  'PATCH /api/v1/users/{name}': {
    path: { name: string };
    body: UserPatch;
    etag: string | null;
    answer: User;
  };
  /** Visits, newest first: one patient on one day, with the sessions of it. */
  'GET /api/v1/visits': {
    query?: { limit?: number; cursor?: string; patient?: number; day?: string };
    answer: VisitList;
  };
  /** One visit. */
  'GET /api/v1/visits/{id}': {
    path: { id: number };
    answer: VisitRow;
  };
  /** Writes a visit's note. */
  'PATCH /api/v1/visits/{id}': {
    path: { id: number };
    body: VisitPatch;
    etag: string | null;
    answer: VisitRow;
  };
  /** The main figures of a visit's sessions for print, with mean and standard deviation. */
  'GET /api/v1/visits/{id}/report': {
    path: { id: number };
    query?: { language?: 'en' | 'de' };
    answer: never;
  };
  /** The exercise and the walk since the start mark. */
  'GET /api/v1/walk': {
    answer: Walk;
  };
  /** A ticket for one WebSocket within 30 s: /ws?ticket=.... */
  'POST /api/v1/ws-ticket': {
    body?: Empty;
    answer: Ticket;
  };
}
