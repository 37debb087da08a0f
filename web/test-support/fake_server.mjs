// A small stand-in for hoist-server, for work on screens without the other programs: serves dist/, streams records of a scripted walk,
// answers commands. It implements the protocol, not the hoist.
//
//   node test-support/fake_server.mjs [--port 8099] [--dist dist]
import { createReadStream, existsSync, readdirSync, readFileSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';
import { WebSocketServer } from 'ws';

const here = fileURLToPath(new URL('..', import.meta.url));
const table = (name) => readFileSync(join(here, 'src/contract', `${name}.gen.ts`), 'utf8');
const signalText = table('signals');
export const recordBytes = Number(/tickRecordBytes = (\d+)/.exec(signalText)[1]);
export const signals = [...signalText.matchAll(/id: \d+, name: '(\w+)', type: '(\w+)', unit: '([^']*)', lsb: [^,]+, offset: (\d+)/g)].map(
  ([, name, type, unit, offset]) => ({ name, type, unit, offset: Number(offset) }),
);
export const layoutHash = /layoutHash = '(\w+)'/.exec(table('messages'))[1];
const taskFolder = join(here, '../db/tasks');
const tasks = readdirSync(taskFolder)
  .sort()
  .map((file) => JSON.parse(readFileSync(join(taskFolder, file), 'utf8')));
// A change, one that may stay, a change at standstill only, and one that this session does not tell.
const swayed = { en: 'sway of the lean while standing', de: 'Schwanken der Neigung im Stehen' };
const reacts = { en: 'share of the standing time in which the hoist would react', de: 'Anteil der Stehzeit, in dem das Gerät reagieren würde' };
const leaned = { en: 'mean lean while walking', de: 'mittlere Neigung beim Gehen' };
const stray = { en: 'stray turning in step', de: 'Pendeln der Drehung im Schritt' };
const suggestion = (name, [now, suggested, measured, effect_now, effect_then], measures, effect, measured_unit = '') => ({
  name,
  reason_code: null,
  reason: null,
  ...{ now, suggested, measured, effect_now, effect_then },
  ...{ measured_unit, measures, effect },
  formula: '',
});
const suggestions = [
  suggestion('lean_dead_band_norm', [0.05, 0.08, 0.059, 0.31, 0.004], swayed, reacts),
  suggestion('lean_gain_filtered_units', [50, 62.5, 0.55, 0.55, 0.443], leaned, {
    en: 'mean lean for the same speed',
    de: 'mittlere Neigung bei gleicher Geschwindigkeit',
  }),
  suggestion('turn_dead_band_norm', [0.05, 0.05, 0.032, 0, 0], swayed, reacts),
  {
    ...suggestion('turn_gain_filtered_units', [null, null, null, null, null], leaned, leaned),
    reason_code: 'no_turning',
    reason: { en: 'The patient led for less than 5 s of turning.', de: 'Der Patient führte weniger als 5 s lang eine Drehung.' },
  },
  suggestion('cadence_cancel_norm', [0, 1, 0.014, 0.014, 0.0056], stray, stray, 'rad/s'),
];
// Every figure has a number but those of the steps' spread.
const metricKeys = [...table('metrics').matchAll(/key: '(\w+)'/g)].map(([, key]) => key);
const withoutFigure = ['stride_time_cv_norm', 'step_asymmetry_norm'];
const figures = {
  ...Object.fromEntries(metricKeys.map((key, i) => [key, withoutFigure.includes(key) ? null : 0.1 * i])),
  computed: Object.fromEntries(
    metricKeys.map((key) => [
      key,
      { version: 1, inputs: ['mode'], hash: '0'.repeat(16), reason_code: withoutFigure.includes(key) ? 'few_strides' : null },
    ]),
  ),
};
const paramRows = [...table('params').matchAll(/name: '(\w+)', unit: '[^']*', min: (\S+), default: (\S+), max: ([^,\s]+),\s+edit: '(\w+)'/g)].map(
  ([, name, min, def, max, edit]) => ({ name, min: Number(min), default: Number(def), max: Number(max), edit }),
);
const presetValues = Object.fromEntries(
  [...table('params').matchAll(/name: '(\w+)', title: [^\n]*\n\s+doc: [^\n]*\n\s+values: \{([^}]*)\}/g)].map(([, name, body]) => [
    name,
    Object.fromEntries([...body.matchAll(/(\w+): ([^,\s]+)/g)].map(([, key, value]) => [key, Number(value)])),
  ]),
);
const faultBit = Object.fromEntries(
  [...table('faults').matchAll(/bit: (\d+), name: '(\w+)', priority/g)].map(([, bit, name]) => [name, Number(bit)]),
);
const modeValue = Object.fromEntries([...table('faults').matchAll(/value: (\d+), name: '(\w+)'/g)].map(([, value, name]) => [name, Number(value)]));

/** The page of a list that a request asks for: rows behind the number that `cursor` names. */
function pageOf(rows, url) {
  const limit = Number(url.searchParams.get('limit') ?? 50);
  const rest = rows.filter(({ number }) => number > Number(url.searchParams.get('cursor') ?? -1));
  return { items: rest.slice(0, limit), next: rest.length > limit ? String(rest[limit - 1].number) : null };
}

export function encodeRecords(records) {
  const buffer = Buffer.alloc(16 + records.length * recordBytes);
  buffer.writeUInt8(1, 0);
  buffer.writeUInt8(1, 1);
  buffer.writeUInt16LE(records.length, 2);
  buffer.writeUInt32LE(recordBytes, 4);
  buffer.writeBigUInt64LE(BigInt(`0x${layoutHash}`), 8);
  records.forEach((record, i) => {
    for (const { name, type, offset } of signals) {
      const at = 16 + i * recordBytes + offset;
      const value = record[name] ?? 0;
      if (type === 'u64') buffer.writeBigUInt64LE(BigInt(Math.round(value)), at);
      else if (type === 'u32') buffer.writeUInt32LE(value >>> 0, at);
      else if (type === 'i32') buffer.writeInt32LE(value | 0, at);
      else if (type === 'f32') buffer.writeFloatLE(value, at);
      else if (type === 'u16') buffer.writeUInt16LE(value, at);
      else buffer.writeUInt8(value, at);
    }
  });
  return buffer;
}

/** Some of the hoist's steps of calibration, with their numbers in the live values. */
const steps = [
  {
    number: 1,
    name: 'zero',
    role: 'therapist',
    entered: null,
    empty_harness: true,
    date: 'calibrated_zero_s',
    title: { en: 'Struts upright', de: 'Streben aufrecht' },
    action: {
      en: 'Take the patient out of the harness. Let the struts stand upright by themselves, and let go.',
      de: 'Patient aus dem Gurt nehmen. Die Streben von selbst aufrecht stehen lassen und loslassen.',
    },
    found: { left_alpha_zero_rad: 0.0061, right_alpha_zero_rad: -0.0042, base_beta_zero_rad: 0.0013 },
  },
  {
    number: 6,
    name: 'wheel_radius',
    role: 'engineer',
    entered: { unit: 'm', least: 1, most: 20 },
    date: 'calibrated_wheel_radius_s',
    title: { en: 'Wheel radius', de: 'Radradius' },
    action: {
      en: 'Push the hoist straight ahead along a measured way, enter it, press Measure; then back.',
      de: 'Das Gerät einen gemessenen Weg geradeaus schieben, eingeben, Messen drücken; dann zurück.',
    },
    found: { wheel_radius_m: 0.0982 },
  },
  {
    number: 8,
    name: 'square',
    role: 'engineer',
    entered: { unit: 'm', least: 1, most: 20 },
    date: 'calibrated_square_s',
    title: { en: 'Driven squares', de: 'Gefahrene Quadrate' },
    action: {
      en: 'Drive the square once turning left and once turning right. Enter how far off the shown place the hoist truly ended.',
      de: 'Das Quadrat einmal linksherum und einmal rechtsherum fahren. Eingeben, wie weit entfernt das Gerät wirklich endete.',
    },
    found: { track_width_m: 0.68 },
  },
  {
    number: 10,
    name: 'bumpers',
    role: 'therapist',
    entered: null,
    date: 'calibrated_bumpers_s',
    title: { en: 'Bumpers', de: 'Stoßfänger' },
    action: {
      en: 'Press the bumpers one after the other: front, rear, left, right.',
      de: 'Die Stoßfänger nacheinander drücken: vorn, hinten, links, rechts.',
    },
    found: {},
  },
];
const phases = ['none', 'resting', 'measuring', 'operator', 'result'];

const types = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript',
  '.css': 'text/css',
  '.svg': 'image/svg+xml',
  '.webmanifest': 'application/manifest+json',
};
const dt_s = 0.01;

/** A study of so many virtual subjects; the numbers only look like real ones. */
function studyOf(id, count, seed) {
  const shapes = ['square', 'eight', 'eight', 'square', 'eight', 'eight'];
  const runs = shapes.map((shape, i) => ({ run: i + 1, shape, led_by: i % 3 === 2 ? 'patient' : 'therapist', injured: i > 2 }));
  const names = Array.from({ length: count }, (_, i) => `S${String(i + 1).padStart(2, '0')}`);
  const subjects = [...names, ...Array.from({ length: Math.max(0, 11 - count) }, () => '-')];
  const table = (figure, means, spread) => {
    const column = (mean, shown, shift) =>
      subjects.map((_, row) =>
        row < shown && (mean.i < 3 || ![0, 1, 7, 8].includes(row)) ? mean.value + spread * Math.sin(row * 2.1 + mean.i + shift) : null,
      );
    const columns = (shown, shift) => means.map((value, i) => column({ value, i }, shown, shift));
    return { figure, decimals: 2, subjects, own: columns(count, seed), paper: columns(11, 0), own_mean: means, paper_mean: means };
  };
  const test = { pairs: 7, up: 6, down: 1, mean_first: 0.447, mean_second: 0.87, p: 0.0156 };
  const compared = [
    [2, 3],
    [5, 6],
    [2, 5],
    [3, 6],
  ].flatMap(([from, to]) => ['C', 'J_N'].map((figure) => ({ figure, from, to, decimals: 2, own: test, paper: { ...test, p: null } })));
  return {
    id,
    made_utc_ms: Date.UTC(2026, 10, 24, 9, 30),
    sessions: [{ session: 1, subject: 'S01', run: 1 }],
    drawings: ['figure-2', 'figure-7', 'figure-8'],
    report: {
      title: 'Bosnjak & Skrjanc, Tables I to III',
      virtual_subjects: true,
      subjects: count,
      seed,
      preset: 'walk',
      laps: 2,
      runs,
      tables: [table('C', [0.07, 0.45, 0.87, 0.11, 0.63, 0.9], 0.06), table('J_N', [35.6, 11.4, 6.7, 56.7, 12.3, 6.1], 2.5)],
      compared,
      others: ['C_best', 'rms_position_m', 'rms_heading_rad', 'walking_speed_m_s', 'lap_time_mean_s'].map((figure) => ({
        figure,
        means: [0.21, 0.22, 0.23, null, 0.25, 0.26],
      })),
      findings: { c_square: 0.04, c_led: 0.86, j_ratio: 4.2 },
      assumed: {
        wish_m_s: [0.2, 0.28],
        anticipation_norm: [0.5, 0.9],
        learning_norm: 0.04,
        trailing_s: 0.2,
        limp_norm: 0.2,
        injured_sway_norm: 1.2,
        therapist_m_s: 0.25,
        therapist_delay_s: 0.35,
        misjudgement_m: 0.15,
        misjudgement_rad: 0.0873,
      },
      left_out: [
        { subject: 'S05', run: 3, figure: 'C', reason_code: 'part_missing', laps: null },
        { subject: 'S07', run: 6, figure: null, reason_code: null, laps: 1.4 },
      ],
    },
  };
}

export function startFakeServer({
  port = 0,
  dist = join(here, 'dist'),
  signedIn = true,
  account = true,
  set_up = { needed: false, switch_on: false, seconds_left: 0 },
  pins = true,
  jobs_ms = 1000,
  exercise = { shape: 'eight', c_m: 1, radius_m: 0.8 },
} = {}) {
  const values = Object.fromEntries(paramRows.map((row) => [row.name, row.default]));
  const hoist = {
    tick: 0,
    mode: 'standby',
    x: 0,
    y: 0,
    psi: 0,
    v: 0,
    w: 0,
    distance: 0,
    lean: 0,
    turn: 0,
    faults: 0,
    silentUntil: 0,
    exercise,
    version: 1,
    drive: { speed: 0, yaw: 0, held: false, tick: -1000 },
    drives: [],
    trouble: {},
    calibration: null,
    trial: null,
    standing: [],
    chosen: exercise,
    task: null,
    begun: null,
    session: null,
    patient: null,
    sessionTick: 0,
    commands: [],
  };
  const lease = { epoch: 0, holder: 0, asking: [] };
  const clients = new Map();
  let nextClient = 1;
  const day_ms = 86_400_000;
  const sessions = [3, 2, 1].map((id) => ({
    id,
    subject: id === 2 ? null : 'K-07',
    started_utc_ms: Date.UTC(2026, 10, 21, 9, 30) - (3 - id) * day_ms,
    duration_s: 60 + id * 37.4,
    simulated: true,
    study: id === 1 ? { study: 1, subject: 'S01', run: 1 } : null,
    recording: false,
    exercise: id === 1 ? { shape: 'square', side_m: 3.2 } : exercise,
    task: id === 3 ? { task: 'eight', version: 1, ends: 'distance', goal: 1, edge_m: 0, repetition: 2, repetitions: 3, rest_s: 60 } : null,
    note: id === 3 ? 'Calmer with a larger standing zone' : '',
    samples: 6000,
    gaps: 0,
    etag: `s${id}`,
  }));

  const dayOf = (ms) => new Date(ms).toISOString().slice(0, 10);
  const patient = (id, code, last_day, more = {}) => ({
    id,
    code,
    archived: false,
    has_identity: false,
    visits: 3,
    sessions: 9,
    first_day: '2026-10-02',
    last_day,
    etag: `p${id}`,
    ...more,
  });
  const patients = [
    patient(5, 'P-017', dayOf(Date.now()), { has_identity: true }),
    patient(1, 'K-07', '2026-11-21'),
    patient(4, 'P-016', '2026-11-19'),
    patient(3, 'M-112', null, { visits: 0, sessions: 0, first_day: null }),
  ];
  const names = new Map([[5, { name: 'Erika Musterfrau', birth_date: '1951-04-12', note: '' }]]);
  const lines = [
    {
      id: 3,
      name: 'Hall',
      version: 1,
      saved_utc_ms: Date.UTC(2026, 6, 1),
      exercise: { shape: 'own', closed: true, x_m: [-1.5, 1.5, 1.5, 0, -1.5], y_m: [-1.5, -1.5, 1, 1.8, 1], corner_radius_m: 0.5 },
      length_m: 9.7,
      etag: 'line-3-1',
    },
  ];
  const profiles = [
    {
      id: 7,
      patient: 5,
      name: 'With brace',
      version: 2,
      saved_utc_ms: Date.UTC(2026, 10, 20, 10, 5),
      actor: null,
      settings: { lean_gain_filtered_units: 42, lean_range_rad: 0.2 },
      etag: 'f7',
    },
  ];
  const markers = [
    { kind: 'stumble', text: 'Stumble', time_s: 31 },
    { kind: 'note', text: 'Held the rail with the left hand', time_s: 64.2 },
    { kind: 'help', text: 'Helped', time_s: 80 },
  ].map((row, i) => ({
    session: 3,
    number: i,
    tick: 100,
    utc_ms: 0,
    actor: { user: 'berg', role: 'therapist' },
    rehearsal: null,
    etag: `m${i}`,
    ...row,
  }));
  const whenStopped = ['stop', 'look', 'acknowledge', 'zero', 'go_on'];
  const rehearsalKinds = Object.entries({
    trip: ['stop', 'look', 'cause_gone', 'acknowledge', 'zero', 'go_on'],
    freeze: whenStopped,
    bumper: ['stop', 'look', 'cause_gone', 'acknowledge', 'zero', 'go_on'],
    link_loss: ['regain'],
    low_battery: ['end', 'stay_ended'],
    second_therapist: ['answer', 'standing'],
  }).map(([rehearsal, looks]) => ({ rehearsal, looks: looks.map((check) => ({ check, limit_s: 5 })) }));
  const rehearsal = { reason_code: null, kinds: rehearsalKinds, phase: 'none', rehearsal: null, seed: null, session: null, result: null };
  const visits = [
    { id: 12, patient: 5, code: 'P-017', day: dayOf(Date.now()), note: 'Tired, shorter than planned', sessions: [4], standby: [], etag: 'v12' },
    { id: 11, patient: 1, code: 'K-07', day: '2026-11-21', note: '', sessions: [3], standby: [2], etag: 'v11' },
    { id: 10, patient: 1, code: 'K-07', day: '2026-11-19', note: '', sessions: [1], standby: [], etag: 'v10' },
  ];
  const people = [
    { user: 'berg', display_name: 'Anna Berg', role: 'therapist', enabled: true, has_pin: true, password: 'berg and valley 1' },
    { user: 'kos', display_name: 'Miha Kos', role: 'engineer', enabled: true, has_pin: true, password: 'kos and valley 12' },
    { user: 'maier', display_name: 'Jonas Maier', role: 'viewer', enabled: false, has_pin: false, password: 'maier and valley' },
  ];
  const told = ({ password: _password, ...person }) => person;
  let person = signedIn ? people[1] : null;
  let failures = 0;
  const retention = { days: null, disk_percent: null, needs_backup: true, etag: 'r1' };
  const tools = { enabled: false, foxglove: '/foxglove', rosbridge: '/rosbridge', foxglove_layout: '/foxglove-layout.json', etag: 's1' };
  const tokens = [{ id: 1, user: 'kos', name: 'Gait study', scope: 'viewer', created_utc_s: 1.79e9, expires_utc_s: 1.81e9, etag: 't1' }];
  const audit = [
    { action: 'sign_in', user: 'kos', target: '', before: null, after: null, result: 'done' },
    {
      action: 'change_parameters',
      user: 'berg',
      target: 'hoist.v1',
      before: '{"lean_gain_filtered_units":50}',
      after: '{"lean_gain_filtered_units":60}',
      result: 'done',
    },
    { action: 'sign_in', user: 'berg', target: 'password', before: null, after: null, result: 'wrong-secret' },
    { action: 'delete_session', user: 'berg', target: 'rest session 17', before: null, after: null, result: 'done' },
    { action: 'put_identity', user: 'maier', target: '/api/v1/patients/1/identity', before: null, after: null, result: '403' },
    {
      action: 'export_mcap',
      user: 'kos',
      target: '/api/v1/sessions/3/session.mcap',
      before: null,
      after: '1630000 of 9000000 bytes in 52 parts',
      result: '206',
    },
    { action: 'hand_over', user: 'kos', target: 'hoist.v1 berg', before: null, after: null, result: 'done' },
    { action: 'choose_patient', user: 'berg', target: 'hoist.v1 patient 5', before: null, after: null, result: 'done' },
    { action: 'retention', user: 'hoist-server', address: '-', target: '', before: null, after: '12 sessions, 3 to 17', result: 'done' },
  ].map((row, i) => ({ id: 40 - i, utc_ms: Date.UTC(2026, 10, 24, 9, 58 - 7 * i), role: 'engineer', address: '192.168.4.7', ...row }));
  const device = { hoist_id: '3f9a11c0-7d52-488b-8e6e-f4219caa35d7', device_name: 'Room 3', computer_name: 'hoist', language: null, etag: 'd1' };
  const berg = { user: 'berg', role: 'therapist', origin: 'hoist.v1', client: 'device-12345678' };
  const history = [
    { name: 'lean_gain_filtered_units', value: 42, before: 50, how: 'profile', source: 'With brace', actor: berg, session: 3 },
    { name: 'speed_m_s_max', value: 0.45, before: 0.6, how: 'preset', source: 'gentle', actor: { ...berg, user: 'kos' }, session: null },
    { name: 'lean_dead_band_norm', value: 0.1, before: 0.15, how: 'trial_over', source: null, actor: null, session: 3 },
    { name: 'lean_dead_band_norm', value: 0.15, before: 0.1, how: 'trial', source: null, actor: berg, session: 3 },
    { name: 'speed_m_s_max', value: 0.6, before: 0.5, how: 'set', source: null, actor: berg, session: null },
    { name: 'wheel_radius_m', value: 0.0982, before: 0.1, how: 'calibration', source: null, actor: { ...berg, user: 'kos' }, session: null },
  ].map((row, i) => ({ id: 60 - i, utc_ms: Date.UTC(2026, 10, 24, 9, 58 - 11 * i), ...row }));
  const trendFigures = (i) => ({
    C: 0.7 + 0.03 * i,
    J_N: 9 - 0.6 * i,
    reference_length_m: 11.4,
    rms_position_m: 0.2 - 0.015 * i,
    rms_heading_rad: 0.3 - 0.02 * i,
    under_way_s: 90 + 12 * i,
    motion_s: 80 + 11 * i,
    missing_s: 0,
    walked_m: 20 + 2.1 * i,
    walking_speed_m_s: 0.25 + 0.02 * i + 0.015 * (i % 3),
    mean_speed_m_s: 0.24 + 0.02 * i + 0.015 * (i % 3),
    max_speed_m_s: 0.5,
  });
  const trend = Array.from({ length: 9 }, (_, i) => ({
    session: 21 + i,
    visit: 11,
    day: dayOf(Date.UTC(2026, 9, 2 + 6 * i)),
    started_utc_ms: Date.UTC(2026, 9, 2 + 6 * i, 9, 30),
    exercise: i === 1 ? null : i === 2 ? { shape: 'square', side_m: 3.2 } : i === 3 ? lines[0].exercise : { shape: 'eight', c_m: 1, radius_m: 0.8 },
    task: i === 1 ? 'walk_6min' : i === 3 ? 'own_line' : null,
    ends: i === 1 ? { by: 'time', goal: 120, edge_m: 0 } : i === 3 ? { by: 'distance', goal: 1, edge_m: 0 } : null,
    line: i === 3 ? lines[0].name : null,
    figures: i === 6 ? null : i === 4 ? { ...trendFigures(i), C: null, J_N: null, rms_position_m: null, rms_heading_rad: null } : trendFigures(i),
    reasons: i === 4 ? { C: 'part_missing', J_N: 'part_missing', rms_position_m: 'part_missing', rms_heading_rad: 'part_missing' } : {},
    reason_code: i === 4 ? 'part_missing' : null,
  })).reverse();
  const trendChanges = ['walking_speed_m_s', 'walked_m', 'C'].map((figure, i) => ({
    exercise: { shape: 'eight', c_m: 1, radius_m: 0.8 },
    task: null,
    ends: null,
    figure,
    first_session: 21,
    last_session: 28,
    first: [0.25, 20, 0.7][i],
    last: [0.4, 20.5, 0.94][i],
    minimal_detectable_change: i === 2 ? null : 0.1 * (1 + 20 * i),
    source: i === 0 ? 'Lewek & Sykes 2019' : null,
    whom: i === 0 ? { en: 'people after a stroke, 10 m', de: 'Menschen nach Schlaganfall, 10 m' } : null,
    repeats: [2, 12, 3][i],
    reason_code: i === 2 ? 'few_repeats' : i === 1 ? 'within_noise' : null,
    retention: { before_session: 27, after_session: 28, before: 0.42, after: 0.4, reason_code: i === 2 ? 'few_repeats' : 'within_noise' },
    learning: {
      walks: i === 2 ? 4 : 9,
      visits: 2,
      slope: [{ middle: 0.02, low: 0.01, high: 0.03 }, { middle: 0, low: -0.5, high: 0.4 }, null][i],
      reason_code: i === 2 ? 'few_walks' : i === 1 ? 'no_slope' : null,
    },
  }));
  const studies = [studyOf(1, 11, 1)];
  const jobs = [];
  let failing = null;
  let refusing = null;
  let hurry = false;
  const backups = [
    {
      backup: '/media/usb/hoist-2026-11-20',
      device: 'hoist',
      program: 'fake',
      utc_ms: Date.UTC(2026, 10, 20, 17),
      sessions: 311,
      hoist_id: '8e4bc973-05fe-4190-ad2d-b8471ce35610',
      files: [{ name: 'hoist.db', bytes: 2.13e9, sha256: '' }],
    },
  ];
  /** A job that takes a second. */
  const startJob = (kind, result, asked) => {
    const job = {
      asked,
      id: jobs.length + 1,
      kind,
      state: 'running',
      progress: 0,
      actor: null,
      asked_utc_ms: Date.now(),
      ended_utc_ms: null,
      detail: '',
      reason_code: null,
      result: null,
    };
    jobs.push(job);
    const begun = performance.now();
    const lasts_ms = kind === 'list_backups' ? 0 : jobs_ms;
    hurry = false;
    const timer = setInterval(() => {
      if (job.state !== 'running') return clearInterval(timer);
      job.progress = lasts_ms === 0 || hurry ? 1 : Math.min(1, (performance.now() - begun) / lasts_ms);
      if (job.progress < 1) return;
      clearInterval(timer);
      if (failing?.kind === kind) {
        Object.assign(job, { state: 'failed', reason_code: failing.reason, ended_utc_ms: Date.now() });
        failing = null;
        return;
      }
      Object.assign(job, { state: 'done', ended_utc_ms: Date.now(), result: { kind, ...result() } });
    }, 20);
    return job;
  };

  const tell = (message, only) => {
    const text = JSON.stringify(message);
    for (const [id, client] of clients) if (only === undefined || only === id) client.socket.send(text);
  };
  const event = (kind, more = {}) => tell({ type: 'event', kind, tick: hoist.tick, time_ns: hoist.tick * 1e7, ...more });
  const actorOf = (id) => (id === 0 ? null : { user: 'local', role: 'engineer', origin: 'hoist.v1', client: 'device-00000000' });
  const leaseMessage = (id) => ({ type: 'lease', ...lease, mine: lease.holder === id, actor: actorOf(lease.holder) });
  const tellLease = () => {
    for (const id of clients.keys()) tell(leaseMessage(id), id);
  };
  const giveLease = (id) => {
    if (lease.holder !== id) lease.epoch++;
    Object.assign(lease, { holder: id, asking: [] });
    tellLease();
    return { ok: true };
  };
  const tellPatient = (only) => tell({ type: 'patient', id: hoist.patient?.id ?? null, code: hoist.patient?.code ?? null }, only);
  const tellRecording = () => {
    const standby = hoist.session === null && hoist.patient !== null;
    tell({
      type: 'recording',
      state: standby || hoist.session !== null ? 'recording' : 'idle',
      session: standby ? 5 : hoist.session,
      standby,
      started_utc_ms: Date.now(),
      samples: hoist.tick - hoist.sessionTick,
      durable_tick: hoist.tick,
      detail: '',
      reason_code: null,
    });
  };
  const setMode = (mode) => {
    if (hoist.mode === mode) return;
    hoist.mode = mode;
    if (mode === 'user' || mode === 'remote' || mode === 'guided') {
      hoist.session = 4;
      hoist.sessionTick = hoist.tick;
    } else hoist.session = null;
    event('mode_changed', { name: mode });
    tellRecording();
  };
  const tellWalk = (only) =>
    tell(
      {
        type: 'walk',
        exercise: hoist.chosen,
        begun: hoist.begun,
        task: hoist.task,
        tick: hoist.tick,
        motion_s: 0,
        mark: { x_m: hoist.x, y_m: hoist.y, psi_rad: hoist.psi },
        step_m: 0.02,
        x_m: [hoist.x],
        y_m: [hoist.y],
      },
      only,
    );
  // Bit operators on numbers cut to 32 bits.
  const raise = (name) => {
    hoist.faults = Number(BigInt(hoist.faults) | (1n << BigInt(faultBit[name])));
  };
  const stopNow = () => {
    raise('stop_pressed');
    setMode('protective_stop');
    event('fault_raised', { name: 'stop_pressed' });
  };
  const heading0 = () => (hoist.exercise.shape === 'eight' ? Math.asin(hoist.exercise.radius_m / hoist.exercise.c_m) : 0);

  // The walk as a bead on the figure: speed up, follow the curvature, wobble a little.
  const curvature = () => {
    const e = hoist.exercise;
    if (e.shape === 'square') {
      const along = hoist.distance % e.side_m;
      return along > e.side_m - 0.25 ? Math.PI / 2 / 0.25 : 0;
    }
    if (e.shape === 'circle') return (e.clockwise ? -1 : 1) / e.radius_m;
    if (e.shape !== 'eight') return 0;
    const slope = Math.asin(e.radius_m / e.c_m);
    const straight = Math.sqrt(e.c_m ** 2 - e.radius_m ** 2);
    const arc = e.radius_m * (Math.PI + 2 * slope);
    const along = hoist.distance % (4 * straight + 2 * arc);
    if (along < straight) return 0;
    if (along < straight + arc) return -1 / e.radius_m;
    if (along < 3 * straight + arc) return 0;
    return along < 3 * straight + 2 * arc ? 1 / e.radius_m : 0;
  };
  // Rest for a second, measure for two; steps with an entered value are measured twice.
  const calibrationPhase = () => {
    if (hoist.calibration === null) return 0;
    const { step, begun, measured } = hoist.calibration;
    if (step.entered !== null) return measured < 2 ? 3 : 4;
    if (step.name === 'bumpers') return hoist.tick - begun < 400 ? 3 : 4;
    return hoist.tick - begun < 100 ? 1 : hoist.tick - begun < 300 ? 2 : 4;
  };
  const calibration = () => {
    if (hoist.calibration === null) return {};
    const { step, begun, measured } = hoist.calibration;
    const ticks = hoist.tick - begun;
    return {
      calibration_step: step.number,
      calibration_phase: calibrationPhase(),
      calibration_value: step.name === 'bumpers' ? Math.min(3, Math.floor(ticks / 100)) : step.entered ? 2.01 : 0.0061,
      calibration_done_percent: Math.min(100, step.entered ? 50 * measured : ticks / 4),
    };
  };
  /** What is found; each measurement of an entered value after the second one changes it. */
  const foundNow = ({ step, measured }) =>
    Object.fromEntries(Object.entries(step.found).map(([name, value]) => [name, step.entered === null ? value : value + 0.001 * (measured - 2)]));
  const endTrial = (keep) => {
    const { before } = hoist.trial;
    hoist.trial = null;
    if (!keep) setValues(before);
  };
  const step = () => {
    hoist.tick++;
    if (hoist.trial !== null && hoist.tick >= hoist.trial.until) endTrial(false);
    let wish = 0;
    let turn = 0;
    if (hoist.mode === 'user') {
      wish = 0.42 + 0.03 * Math.sin(hoist.tick / 90);
      turn = curvature() * hoist.v * (1 + 0.03 * Math.sin(hoist.tick / 47));
      hoist.lean = 0.35 + 0.08 * Math.sin(hoist.tick / 55);
      hoist.turn = Math.max(-1, Math.min(1, turn / 0.58));
    } else if (hoist.mode === 'remote' && hoist.drive.held && hoist.tick - hoist.drive.tick < 25) {
      wish = hoist.drive.speed * values.remote_speed_m_s_max;
      turn = hoist.drive.yaw * values.remote_yaw_rate_rad_s_max;
      hoist.lean = 0.02 * Math.sin(hoist.tick / 60);
      hoist.turn = 0;
    } else if (hoist.mode === 'guided') {
      wish = hoist.drive.held && hoist.tick - hoist.drive.tick < 25 ? hoist.guided.speed_m_s : 0;
      turn = curvature() * hoist.v;
      hoist.lean = 0.03 * Math.sin(hoist.tick / 60);
      hoist.turn = 0;
      if (hoist.distance >= hoist.guided.total_m) {
        setMode('standby');
        event('guided_ended', { name: 'finished', code: 1, value: 0 });
      }
    } else {
      hoist.lean = 0.015 * Math.sin(hoist.tick / 60);
      hoist.turn = 0.01 * Math.sin(hoist.tick / 75);
    }
    const ramp = (hoist.mode === 'protective_stop' ? 1.0 : 0.5) * dt_s;
    hoist.v += Math.max(-ramp, Math.min(ramp, wish - hoist.v));
    hoist.w = hoist.v === 0 && wish === 0 && hoist.mode !== 'remote' ? 0 : turn;
    hoist.psi += hoist.w * dt_s;
    hoist.x += hoist.v * Math.cos(hoist.psi) * dt_s;
    hoist.y += hoist.v * Math.sin(hoist.psi) * dt_s;
    hoist.distance += Math.abs(hoist.v) * dt_s;
    const range = values.lean_range_rad;
    const sway = hoist.mode === 'user' ? 0.03 * Math.sin(hoist.tick / 32) : 0.004 * Math.sin(hoist.tick / 80);
    return {
      tick: hoist.tick,
      time_ns: hoist.tick * 1e7,
      left_alpha_rad: (hoist.lean - 0.5 * hoist.turn) * range,
      right_alpha_rad: (hoist.lean + 0.5 * hoist.turn) * range,
      left_beta_rad: sway,
      right_beta_rad: sway,
      base_alpha_rad: 0.002,
      base_beta_rad: 0.001,
      lean_norm: hoist.lean,
      turn_norm: hoist.turn,
      dx_m: 0.8 * Math.tan(hoist.lean * range),
      dy_m: -0.8 * Math.tan(sway),
      speed_wish_m_s: wish,
      speed_command_m_s: hoist.v,
      speed_m_s: hoist.v,
      yaw_rate_rad_s: hoist.w,
      x_m: hoist.x,
      y_m: hoist.y,
      psi_rad: hoist.psi,
      fused_x_m: hoist.x,
      fused_y_m: hoist.y,
      fused_psi_rad: hoist.psi,
      distance_m: hoist.distance,
      stop_distance_m: hoist.v ** 2 / 1.6,
      remote_age_s: 9.999,
      battery_a_v: 12.43,
      battery_b_v: 12.38,
      left_supply_v: 24.7,
      right_supply_v: 24.7,
      left_current_a: 0.6 + hoist.v,
      right_current_a: 0.5 + hoist.v,
      wake_lateness_s: 6e-5,
      tick_duration_s: 2.1e-4,
      lateness_p50_s: 6e-5,
      lateness_p99_s: 2.1e-4,
      lateness_max_s: 4.1e-4,
      missed_ticks: 3,
      overruns: 5,
      page_faults: 0,
      allocations: 0,
      loop_priority: 49,
      loop_cpu: 3,
      memory_locked: 1,
      bus_frames: hoist.tick * 7,
      fault_bits: hoist.faults,
      // A stop is high here, whatever its cause.
      alarm_sound: hoist.faults !== 0 && hoist.tick >= hoist.silentUntil ? 3 : 0,
      alarm_light: hoist.faults !== 0 ? 3 : 0,
      alarm_pause_s: hoist.faults === 0 ? 0 : Math.max(0, (hoist.silentUntil - hoist.tick) * dt_s),
      blocked_bits: hoist.faults ? 4 : 0,
      lease_epoch: lease.epoch,
      lease_holder: lease.holder,
      speed_cause: 0,
      guided_phase: hoist.mode === 'guided' ? 2 : 0,
      guided_progress_norm: hoist.guided ? Math.min(1, hoist.distance / hoist.guided.total_m) : 0,
      guided_remaining_m: hoist.guided ? Math.max(0, hoist.guided.total_m - hoist.distance) : 0,
      guided_cross_track_m: hoist.mode === 'guided' ? 0.012 * Math.sin(hoist.tick / 70) : 0,
      parameter_version: hoist.version,
      settings_trial_s: hoist.trial === null ? 0 : (hoist.trial.until - hoist.tick) * dt_s,
      ...calibration(),
      stop_cause: 0,
      ...health(hoist.tick),
      mode: modeValue[hoist.mode],
      simulated: 1,
      server_alive: 1,
      standing_still: Math.abs(hoist.v) < 0.02 ? 1 : 0,
    };
  };

  // Nodes and bus: without errors, or with those set by trouble().
  const parts = ['drive_left', 'drive_right', 'io', 'tilt_left', 'tilt_right', 'tilt_base'];
  const health = () => ({
    ...Object.fromEntries(
      parts.flatMap((name) => [
        [`${name}_nmt_state`, 5],
        [`${name}_age_ticks`, name === 'io' ? hoist.tick % 2 : 0],
      ]),
    ),
    bus_up: 1,
    bus_load_norm: 0.41,
    bus_frames_per_s: 905,
    babbling_id: 65535,
    ...hoist.trouble,
  });

  const refuse = (...refusals) => ({ ok: false, refusals, errors: [] });
  const setValues = (wanted) => {
    const errors = [];
    const moving = ['user', 'remote', 'guided'].includes(hoist.mode);
    for (const [name, value] of Object.entries(wanted)) {
      const row = paramRows.find((item) => item.name === name);
      if (row === undefined) return { ok: false, refusals: ['unknown_item'], errors: [{ field: name, value }] };
      if (row.edit === 'stopped' && moving) return { ok: false, refusals: ['only_when_stopped'], errors: [{ field: name, value }] };
      if (!(value >= row.min && value <= row.max)) errors.push({ field: name, value, min: row.min, max: row.max, message: '' });
    }
    if (errors.length > 0) return { ok: false, refusals: ['out_of_range'], errors };
    for (const [name, value] of Object.entries(wanted)) {
      event('parameter_changed', { name, value, before: values[name] });
      const made = { id: history[0].id + 1, utc_ms: Date.now(), how: 'set', source: null, actor: berg, session: hoist.session };
      if (value !== values[name]) history.unshift({ ...made, name, value, before: values[name] });
      values[name] = value;
    }
    hoist.version++;
    tell({ type: 'parameters', version: hoist.version, values });
    return { ok: true };
  };
  const commands = {
    lease_take(message, id) {
      if (lease.holder !== 0 && lease.holder !== id && message.take_over !== true) return refuse('no_lease');
      return giveLease(id);
    },
    lease_release: (_message, id) => (lease.holder === id ? giveLease(0) : { ok: true }),
    lease_ask(_message, id) {
      if (lease.holder === 0 || lease.holder === id) return { ok: false, refusals: [], errors: [], detail: '', reason_code: 'lease_free' };
      lease.asking = [...lease.asking.filter((ask) => ask.client !== id), { client: id, actor: actorOf(id) }];
      tellLease();
      return { ok: true };
    },
    lease_keep(_message, id) {
      if (lease.holder !== id) return refuse('no_lease');
      for (const ask of lease.asking) tell({ type: 'notice', level: 'info', text_key: 'lease_kept' }, ask.client);
      lease.asking = [];
      tellLease();
      return { ok: true };
    },
    lease_hand_over(message, id) {
      if (lease.holder !== id) return refuse('no_lease');
      if (Math.abs(hoist.v) >= 0.02 && ['user', 'remote', 'guided'].includes(hoist.mode)) return refuse('moving');
      return giveLease(message.client);
    },
    mode(message, id) {
      if (message.mode === 'standby') {
        if (hoist.task) Object.assign(hoist.task, { reached: true, ended_tick: hoist.tick });
        setMode('standby');
        tellWalk();
        return { ok: true };
      }
      if (lease.holder !== id) return refuse('no_lease');
      if (hoist.mode !== 'standby') return refuse('not_standby', ...(hoist.faults ? ['fault_active'] : []));
      hoist.exercise = message.path ?? message.exercise ?? { shape: 'free' };
      if (message.mode === 'guided') {
        const { length_m = 0, side_m = 0, radius_m = 0, laps = 1, speed_m_s } = message.path;
        hoist.guided = { speed_m_s, total_m: laps * (length_m + 4 * side_m + 2 * Math.PI * radius_m) };
      }
      const square = hoist.exercise.shape === 'square' ? -hoist.exercise.side_m / 2 : 0;
      Object.assign(hoist, { x: square, y: square, psi: heading0(), distance: 0 });
      event('pose_set');
      hoist.begun = hoist.exercise;
      if (hoist.task) Object.assign(hoist.task, { repetition: hoist.task.repetition + 1, begun_tick: hoist.tick, reached: false, ended_tick: null });
      tellWalk();
      setMode(message.mode);
      return { ok: true };
    },
    pause_alarm(message) {
      if (hoist.faults === 0) return refuse('out_of_order');
      hoist.silentUntil = message.paused ? hoist.tick + 12_000 : 0;
      return { ok: true };
    },
    acknowledge(_message, id) {
      if (lease.holder !== id) return refuse('no_lease');
      hoist.faults = 0;
      setMode('standby');
      return { ok: true };
    },
    choose(message) {
      hoist.chosen = message.exercise;
      hoist.task = null;
      tellWalk();
      return { ok: true };
    },
    choose_patient(message) {
      const one = patients.find(({ id }) => id === message.patient) ?? null;
      if (message.patient !== null && one === null) return { ok: false, refusals: [], reason_code: 'unknown' };
      hoist.patient = one;
      tellPatient();
      tellRecording();
      return { ok: true };
    },
    neutral: () => ({ ok: true }),
    pose: () => ({ ok: true }),
    marker: (message) => (hoist.session === null ? refuse('not_standby') : (event('marker', { name: message.text }), { ok: true })),
    set(message) {
      const before = Object.fromEntries(Object.keys(message.values).map((name) => [name, values[name]]));
      const answer = setValues(message.values);
      if (answer.ok && message.revert_after_s > 0)
        hoist.trial = { until: hoist.tick + message.revert_after_s * 100, before: { ...before, ...hoist.trial?.before } };
      return answer;
    },
    keep_settings(message) {
      if (hoist.trial === null) return refuse('out_of_order');
      if (message.version !== undefined && message.version !== hoist.version) return refuse('set_outdated');
      endTrial(true);
      return { ok: true };
    },
    undo_settings() {
      if (hoist.trial === null) return refuse('out_of_order');
      endTrial(false);
      return { ok: true };
    },
    calibrate(message, id) {
      const step = steps.find((one) => one.name === message.step);
      if (lease.holder !== id) return refuse('no_lease');
      if (step === undefined) return refuse('unknown_item');
      if (hoist.mode !== 'standby' && hoist.mode !== 'calibrate') return refuse('not_standby');
      if (step.empty_harness && message.harness_empty !== true) return refuse('harness_unconfirmed');
      hoist.calibration = { step, begun: hoist.tick, measured: 0 };
      setMode('calibrate');
      return { ok: true };
    },
    calibrate_measure() {
      if (hoist.calibration === null) return refuse('out_of_order');
      hoist.calibration.measured++;
      return { ok: true };
    },
    calibrate_use() {
      if (calibrationPhase() !== 4) return refuse('out_of_order');
      const { step } = hoist.calibration;
      const found = foundNow(hoist.calibration);
      hoist.calibration = null;
      setMode('standby');
      return setValues({ ...found, [step.date]: Math.floor(Date.now() / 1000) });
    },
    calibrate_cancel() {
      hoist.calibration = null;
      setMode('standby');
      return { ok: true };
    },
    preset: (message) => setValues(presetValues[message.name] ?? { unknown: 0 }),
  };
  const take = (message, id, socket) => {
    hoist.commands.push(message);
    if (hoist.commands.length > 10_000) hoist.commands.shift();
    if (message.type === 'ping') socket.send(JSON.stringify({ type: 'pong', t: message.t, time_ns: hoist.tick * 1e7 }));
    // Everyone gets whole records here, also after a choice.
    else if (message.type === 'stream')
      socket.send(JSON.stringify({ type: 'streaming', topics: ['all'], rate_hz: 100, every_tick: false, sample_bytes: recordBytes }));
    else if (message.type === 'stop') stopNow();
    else if (message.type === 'drive') {
      if (lease.holder === id) hoist.drive = { ...message, tick: hoist.tick };
    } else if (message.type in commands) {
      const reply = refusing?.type === message.type ? refuse(refusing.reason) : commands[message.type](message, id);
      socket.send(JSON.stringify({ type: 'reply', request: message.request, ...reply }));
    }
  };

  const sampleColumn = (name, i, id) => {
    const s = i / 1000;
    const loop = s * 4 * Math.PI + id;
    if (name === 'x_m' || name === 'fused_x_m') return 1.8 * Math.sin(loop);
    if (name === 'y_m' || name === 'fused_y_m') return 0.75 * Math.sin(2 * loop) + 0.04 * Math.sin(31 * s);
    if (name === 'speed_m_s') return 0.42 * Math.min(1, 12 * s) + 0.02 * Math.sin(90 * s);
    if (name === 'speed_command_m_s') return 0.42 * Math.min(1, 12 * s) + 0.015 * Math.sin(80 * s);
    return 0.3 * Math.sin(20 * s + name.length);
  };
  const chooseTask = ({ task: name, sizes = {}, clockwise, goal, repetitions, rest_s, line = null }) => {
    const task = tasks.find((row) => row.name === name);
    hoist.task = null;
    if (task !== undefined) {
      const usual = Object.fromEntries(Object.entries(task.sizes).map(([size, range]) => [size, range.usual]));
      hoist.chosen = { shape: task.line ?? 'free', ...usual, ...sizes, ...(clockwise ? { clockwise } : {}) };
      if (line !== null) hoist.chosen = line.exercise;
      if (task.line === 'eight') hoist.chosen.radius_m = 0.8 * hoist.chosen.c_m;
      if (hoist.chosen.corner_radius_m === 0) delete hoist.chosen.corner_radius_m;
      hoist.task = {
        task: name,
        version: 1,
        ends: task.ends.by,
        goal: goal ?? task.ends.goal.usual,
        repetitions: repetitions ?? task.repetitions.usual,
        rest_s: rest_s ?? task.rest_s.usual,
        repetition: 0,
        begun_tick: null,
        reached: false,
        ended_tick: null,
        line: line?.name ?? null,
      };
    }
    tellWalk();
  };
  const api = (request, url, body, send) => {
    if (url.pathname === '/api/v1/tasks') return send(200, { items: tasks });
    if (url.pathname === '/api/v1/task' && request.method === 'PUT') {
      chooseTask(JSON.parse(body));
      return send(200, { ok: true });
    }
    const path = url.pathname.replace('/api/v1', '');
    const given = body === '' ? {} : JSON.parse(body);
    const enter = (one, right) => {
      if (one !== undefined && right) {
        failures = 0;
        person = one;
        return send(200, who());
      }
      failures++;
      return failures > 2
        ? send(429, { type: '/problems/too-many', title: 'Wait', status: 429 }, { 'Retry-After': String(2 ** (failures - 2)) })
        : send(401, { type: '/problems/wrong-secret', title: 'Wrong', status: 401 });
    };
    const named = (name) => people.find((one) => one.user === name && one.enabled);
    const who = () => ({
      signed_in: person !== null,
      user: person?.user ?? null,
      display_name: person?.display_name ?? null,
      role: person?.role ?? null,
      has_pin: person === null || !account ? null : person.has_pin,
      seconds_left: null,
      here: pins ? people.filter(({ has_pin }) => has_pin).map(({ user, display_name }) => ({ user, display_name })) : [],
      set_up,
      device: { name: device.device_name === '' ? device.computer_name : device.device_name, language: device.language },
      problem: null,
    });
    if (path === '/session' && request.method === 'GET') return send(200, who());
    if (path === '/session' && request.method === 'POST')
      return enter(named(given.user), given.pin === undefined ? named(given.user)?.password === given.password : given.pin === '1234');
    if (path === '/setup') {
      if (!set_up.switch_on || given.code !== '12345678') return send(403, { type: '/problems/wrong-code', title: 'Wrong', status: 403 });
      people.push({ user: given.user, display_name: given.display_name, role: 'engineer', enabled: true, has_pin: false, password: given.password });
      set_up = { needed: false, switch_on: false, seconds_left: 0 };
      return send(200, { ok: true });
    }
    if (path === '/stop' && request.method === 'POST') {
      stopNow();
      return send(200, { ok: true });
    }
    if (person === null) return send(401, { type: '/problems/no-session', title: 'Not signed in', status: 401 });
    if (path === '/session' && request.method === 'DELETE') {
      person = null;
      for (const client of clients.values()) client.socket.close(4401);
      return send(204, null);
    }
    if (path === '/session/password' || path === '/session/pin') return send(200, { ok: true });
    if (path === '/users' && request.method === 'POST') {
      people.push({ ...given, enabled: true, has_pin: false });
      return send(201, told(people.at(-1)));
    }
    if (path === '/users') return send(200, { items: people.map(told), next: null });
    if (path.startsWith('/users/'))
      return send(
        200,
        told(
          Object.assign(
            people.find(({ user }) => path.endsWith(`/${user}`)),
            given,
          ),
        ),
      );
    if (path === '/tokens' && request.method === 'POST') {
      const { name, scope, days } = given;
      tokens.push({
        id: tokens.length + 1,
        user: person.user,
        name,
        scope,
        created_utc_s: 1.795e9,
        expires_utc_s: 1.795e9 + days * 86_400,
        etag: 't2',
      });
      return send(201, { id: tokens.length, token: 'hoist_7mZk2Qw9xT4vLr8sJd3fGh6yBn1pCe5a' });
    }
    if (path === '/tokens') return send(200, { items: tokens, next: null });
    if (path.startsWith('/tokens/')) {
      tokens.splice(0, tokens.length, ...tokens.filter(({ id }) => !path.endsWith(`/${id}`)));
      return send(204, null);
    }
    if (path === '/tools' && request.method === 'PUT') {
      if (request.headers['if-match'] !== `"${tools.etag}"`) return send(412, { type: '/problems/changed-meanwhile', title: 'Changed', status: 412 });
      return send(200, Object.assign(tools, { enabled: given.enabled, etag: `${tools.etag}+` }));
    }
    if (path === '/tools') return send(200, tools);
    if (path === '/audit/check') return send(200, { rows: audit.length, first_wrong: null, head: '' });
    if (path === '/audit') return send(200, { items: audit, next: null });
    if (path === '/status') return send(200, { version: 'fake' });
    if (path === '/settings') {
      if (request.method === 'PATCH') Object.assign(device, given, { etag: `d${Number(device.etag.slice(1)) + 1}` });
      return send(200, device);
    }
    if (path === '/time')
      return send(200, {
        utc_ms: Date.now(),
        steady_ns: hoist.tick * 1e7,
        kept_by: 'operating_system',
        synchronised: true,
        client_behind_s: (Date.now() - Number(url.searchParams.get('client_utc_ms'))) / 1000,
      });
    if (path === '/network')
      return send(200, {
        computer_name: 'hoist',
        port: 443,
        interfaces: [
          { name: 'lo', up: true, loopback: true, addresses: ['127.0.0.1', '::1'] },
          { name: 'wlan0', up: true, loopback: false, addresses: ['192.168.7.20', 'fe80::5054:ff:fe12:3456'] },
        ],
        tls: {
          on: true,
          names: ['hoist.local', '192.168.7.20'],
          fingerprint: '3F:9A:11:C0:7D:52:88:0B:6E:F4:21:9C:AA:35:D7:60:12:8E:4B:C9:73:05:FE:61:90:2D:B8:47:1C:E3:56:0A',
          trust_page: '/trust',
        },
      });
    if (path === '/parameters/history') {
      const limit = Number(url.searchParams.get('limit') ?? 50);
      return send(200, { items: history.slice(0, limit), next: history.length > limit ? '1' : null });
    }
    if (path === '/ws-ticket') return send(200, { ticket: 'fake' });
    if (path === '/health')
      return send(200, {
        connected: true,
        nodes: [],
        bus: null,
        recordings: {
          state: 'sound',
          progress: 1,
          checked_utc_ms: Date.UTC(2026, 10, 24, 6, 12),
          damaged_blobs: 0,
          damaged_sessions: [],
          detail: '',
        },
        emergencies: hoist.tick < 100 ? [] : [{ node: 'io', time_ns: 5e8, age_s: 1, error_register: 0, emergency: { code: 0x8140 } }],
      });
    if (path === '/loop') {
      const bucket = (from_s, count) => ({ from_s, to_s: from_s * 1.25, count });
      return send(200, {
        steps: 184_402,
        missed: 3,
        late: 5,
        lateness_p50_s: 6e-5,
        lateness_p99_s: 2.1e-4,
        lateness_max_s: 4.1e-4,
        latest_ever_s: 0.0231,
        longest_step_s: 8e-4,
        page_faults: 0,
        allocations: 0,
        priority: 49,
        cpu: 3,
        memory_locked: true,
        lately: [bucket(2e-5, 30), bucket(5e-5, 800), bucket(1e-4, 150), bucket(4e-4, 6)],
        ever: [
          bucket(0, 12),
          bucket(2e-5, 9_000),
          bucket(5e-5, 150_000),
          bucket(1e-4, 25_000),
          bucket(4e-4, 380),
          bucket(9e-4, 5),
          bucket(2.5e-3, 3),
          bucket(0.02, 2),
        ],
      });
    }
    if (path === '/calibration') {
      const under = hoist.calibration?.step;
      const phase = phases[calibrationPhase()];
      return send(200, {
        valid: steps.every((step) => values[step.date] > 0),
        under_way:
          under === undefined
            ? null
            : {
                step: under.name,
                phase,
                result:
                  phase !== 'result'
                    ? []
                    : Object.entries(foundNow(hoist.calibration)).map(([name, value]) => ({ name, value, before: values[name] })),
              },
        items: steps.map(({ name, role, entered, empty_harness = false, title, action, date }) => ({
          name,
          role,
          entered,
          empty_harness,
          title,
          action,
          done_utc_s: values[date] > 0 ? values[date] : null,
        })),
        reasons: [],
      });
    }
    if (path === '/rehearsal') {
      if (request.method === 'GET') return send(200, rehearsal);
      const chosen = given.rehearsal;
      Object.assign(rehearsal, { phase: chosen === null ? 'none' : 'waiting', rehearsal: chosen, seed: 7, session: null, result: null });
      return send(200, { ok: true });
    }
    if (path === '/jobs' && request.method === 'POST') {
      const { kind } = given;
      if (kind === 'list_backups')
        return send(
          202,
          startJob(kind, () => ({ folders: [{ folder: '/media/usb', there: true, free_bytes: 5.4e10 }], items: backups })),
        );
      return send(
        202,
        startJob(
          kind,
          () => {
            if (kind === 'export_sessions') return { file_name: 'hoist-sessions.zip', bytes: 4.1e7, sessions: 3 };
            if (kind === 'preview_retention' || kind === 'retention')
              return {
                rule: given.rule ?? retention,
                sessions: 37,
                bytes: 9.1e8,
                from_utc_ms: Date.UTC(2025, 2, 3, 9),
                to_utc_ms: Date.UTC(2025, 10, 20, 15),
                without_backup: 12,
                used_bytes: 5.1e9,
                disk_bytes: 6.4e10,
                excess_bytes: 0,
              };
            if (kind === 'study') {
              studies.unshift(studyOf(studies.length + 1, given.subjects, given.seed));
              return { study: studies[0].id };
            }
            if (kind === 'study_recorded') {
              const of = studyOf(studies.length + 1, 2, null);
              studies.unshift({ ...of, sessions: [], report: { ...of.report, virtual_subjects: false, seed: null, assumed: null } });
              return { study: studies[0].id };
            }
            if (kind === 'delete_study') {
              studies.splice(
                studies.findIndex(({ id }) => id === given.study),
                1,
              );
              return { study: given.study, sessions: 54 };
            }
            if (kind === 'restore') return { backup: given.backup, set_aside: '/var/lib/hoist/hoist.db.2026-11-24' };
            const made = { ...backups[0], hoist_id: device.hoist_id, backup: `${given.folder}/hoist-${dayOf(Date.now())}`, utc_ms: Date.now() };
            backups.unshift(made);
            return made;
          },
          given,
        ),
      );
    }
    if (path === '/studies')
      return send(200, { items: studies.map(({ id, made_utc_ms, report }) => ({ id, made_utc_ms, ...report, sessions: 54 })), next: null });
    const [, studyId] = /^\/studies\/(\d+)$/.exec(path) ?? [];
    const study = studies.find(({ id }) => id === Number(studyId));
    if (studyId !== undefined) return study ? send(200, study) : send(404, { type: '/problems/unknown', title: 'Unknown', status: 404 });
    if (path === '/retention' && request.method === 'PUT') return send(200, Object.assign(retention, given, { etag: 'r2' }));
    if (path === '/retention') return send(200, retention);
    if (path === '/jobs') return send(200, { items: jobs.map((job) => ({ ...job, result: undefined })), next: null });
    const [, jobId] = /^\/jobs\/(\d+)$/.exec(path) ?? [];
    if (jobId !== undefined) {
      const job = jobs[Number(jobId) - 1];
      if (request.method === 'DELETE' && job.state === 'running') job.state = 'cancelled';
      return send(request.method === 'DELETE' ? 202 : 200, job);
    }
    const [, visitId] = /^\/visits\/(\d+)$/.exec(path) ?? [];
    const visit = visits.find(({ id }) => id === Number(visitId));
    if (visit !== undefined) {
      if (request.method === 'PATCH' && request.headers['if-match'] !== `"${visit.etag}"`)
        return send(412, { type: '/problems/changed-meanwhile', title: 'Changed', status: 412 });
      if (request.method === 'PATCH') Object.assign(visit, given, { etag: `${visit.etag}+` });
      return send(200, visit);
    }
    if (path === '/visits')
      return send(200, {
        items: visits.filter((visit) => !url.searchParams.has('patient') || visit.patient === Number(url.searchParams.get('patient'))),
        next: null,
      });
    if (path === '/patients' && request.method === 'POST') {
      const made = patient(100 + patients.length, given.code, null, { visits: 0, sessions: 0, first_day: null });
      patients.unshift(made);
      return send(201, made);
    }
    if (path === '/patients') {
      const q = (url.searchParams.get('q') ?? '').toLowerCase();
      const archived = url.searchParams.get('archived');
      const wanted = (one) => one.code.toLowerCase().includes(q) && (archived === null || one.archived === (archived === '1'));
      return send(200, { items: patients.filter(wanted), next: null });
    }
    const [, lineId] = /^\/lines(?:\/(\d+))?$/.exec(path) ?? [];
    if (path === '/lines' && request.method === 'GET') return send(200, { items: lines, next: null });
    if (path === '/lines' || lineId !== undefined) {
      const at = lines.findIndex(({ id }) => id === Number(lineId));
      if (request.method === 'DELETE') {
        lines.splice(at, 1);
        return send(204, null);
      }
      const before = lines[at] ?? { id: 10 + lines.length, version: 0, length_m: 0 };
      const saved = { ...before, ...given, version: before.version + 1, saved_utc_ms: Date.now() };
      saved.etag = `line-${saved.id}-${saved.version}`;
      if (at < 0) lines.unshift(saved);
      else lines[at] = saved;
      return send(at < 0 ? 201 : 200, saved);
    }
    const [, profileId, deed] = /^\/profiles\/(\d+)(?:\/(\w+))?$/.exec(path) ?? [];
    const profile = profiles.find(({ id }) => id === Number(profileId));
    if (profile !== undefined) {
      const items = Object.entries(profile.settings)
        .filter(([name, value]) => values[name] !== value)
        .map(([name, value]) => ({ name, profile: value, in_force: values[name], unusable: false }));
      if (deed === 'diff') return send(200, { version: hoist.version, items });
      if (deed === 'apply') return send(200, setValues(profile.settings));
      if (request.method === 'DELETE') {
        profiles.splice(profiles.indexOf(profile), 1);
        return send(204, null);
      }
      profile.settings = Object.fromEntries(Object.keys(profile.settings).map((name) => [name, values[name]]));
      return send(200, profile);
    }
    const [, patientId, of] = /^\/patients\/(\d+)(?:\/(\w+))?$/.exec(path) ?? [];
    if (patientId !== undefined) {
      const one = patients.find(({ id }) => id === Number(patientId));
      if (one === undefined) return send(404, { type: '/problems/unknown', title: 'Unknown', status: 404 });
      if (of === 'identity') {
        if (request.method === 'PUT') {
          names.set(one.id, given);
          one.has_identity = true;
        }
        return send(200, { state: names.has(one.id) ? 'readable' : 'none', identity: names.get(one.id) ?? null, etag: one.etag });
      }
      if (of === 'trend')
        return send(200, {
          items: one.visits === 0 ? [] : trend,
          next: null,
          firsts: [],
          changes: one.visits === 0 ? [] : trendChanges,
          simulated_left_out: one.visits === 0 ? 0 : 2,
        });
      if (of === 'profiles' && request.method === 'POST') {
        profiles.unshift({ ...profiles[0], id: 50 + profiles.length, name: given.name, saved_utc_ms: Date.now(), settings: { ...values } });
        return send(201, profiles[0]);
      }
      if (of === 'profiles') return send(200, { items: profiles, next: null });
      if (request.method === 'DELETE') {
        patients.splice(patients.indexOf(one), 1);
        return send(204, null);
      }
      return send(200, Object.assign(one, given));
    }
    if (path === '/sessions') {
      const of = url.searchParams.get('patient');
      const own = visits.filter(({ patient }) => patient === Number(of)).flatMap((visit) => visit.sessions);
      const fits = ({ id, subject }) => (of === null || own.includes(id)) && (subject ?? '').includes(url.searchParams.get('q') ?? '');
      return send(200, { items: sessions.filter(fits), next: null });
    }
    const [, owner, number] = /^\/sessions\/(\d+)\/markers(?:\/(\d+))?$/.exec(path) ?? [];
    if (owner !== undefined && number === undefined) return send(200, { items: Number(owner) === 3 ? markers : [], next: null });
    if (owner !== undefined) {
      const marker = markers.find((row) => row.number === Number(number));
      if (request.headers['if-match'] !== `"${marker.etag}"`)
        return send(412, { type: '/problems/changed-meanwhile', title: 'Changed', status: 412 });
      if (request.method === 'DELETE') {
        markers.splice(markers.indexOf(marker), 1);
        return send(204, null);
      }
      if (given.time_s > 500)
        return send(422, { type: '/problems/invalid', title: 'Invalid', status: 422, errors: [{ field: 'time_s', message: '' }] });
      return send(200, Object.assign(marker, given, { etag: `${marker.etag}+` }));
    }
    const [, id, rest] = /^\/sessions\/(\d+)(?:\/([\w-]+))?$/.exec(path) ?? [];
    const session = sessions.find((item) => item.id === Number(id));
    if (session === undefined) return send(404, { type: '/problems/unknown', title: 'Unknown', status: 404 });
    if (rest === undefined && request.method === 'DELETE') {
      if (request.headers['if-match'] !== `"${session.etag}"`)
        return send(412, { type: '/problems/changed-meanwhile', title: 'Changed', status: 412 });
      sessions.splice(sessions.indexOf(session), 1);
      return send(204, null);
    }
    if (rest === undefined && request.method === 'PATCH') {
      if (request.headers['if-match'] !== `"${session.etag}"`)
        return send(412, { type: '/problems/changed-meanwhile', title: 'Changed', status: 412 });
      return send(200, Object.assign(session, JSON.parse(body), { etag: `${session.etag}+` }));
    }
    if (rest === undefined) return send(200, session);
    if (rest === 'metrics')
      return send(200, {
        ...figures,
        C: 0.82,
        J_N: 6.1,
        reference_length_m: 11.4,
        under_way_s: session.duration_s,
        motion_s: session.duration_s - 4,
        missing_s: session.id === 2 ? 0.3 : 0,
        walked_m: 25.8,
        mean_speed_m_s: 0.39,
        rms_position_m: 0.11,
        rms_heading_rad: 0.14,
        track: 'fused',
        exercise: session.exercise,
        reason_if_none: null,
        reason_code: null,
      });
    if (rest === 'tuning-advice') return send(200, { session: session.id, standing_s: 41.2, walking_s: 88.4, items: suggestions });
    if (rest === 'events') {
      const events = [
        { time_s: 0, kind: 'mode_changed', name: 'user' },
        { time_s: 12.3, kind: 'parameter_changed', name: 'lean_gain_filtered_units', before: 50, value: 60 },
        // Of one session more than two pages hold.
        ...Array.from({ length: session.id === 1 ? 450 : 20 }, (_, i) => ({
          time_s: 40 + i * 0.1,
          kind: 'parameter_changed',
          name: 'lean_gain_filtered_units',
          before: 60 + i,
          value: 61 + i,
        })),
        { time_s: 96, kind: 'fault_raised', name: 'stop_pressed' },
      ].map((event, number) => ({ number, ...event }));
      return send(200, pageOf(events, url));
    }
    if (rest === 'samples') {
      const names = (url.searchParams.get('columns') ?? '').split(',');
      const runs = Array.from({ length: 600 }, (_, i) => i * (1000 / 600));
      const at = runs.map((i) => (i / 1000) * session.duration_s);
      return send(200, {
        from_s: at,
        to_s: at.map((value) => value + 0.05),
        columns: names.map((name) => ({
          name,
          unit: signals.find((row) => row.name === name)?.unit ?? '',
          min: runs.map((i) => sampleColumn(name, i, session.id) - 0.003),
          max: runs.map((i) => sampleColumn(name, i, session.id) + 0.003),
        })),
      });
    }
    send(404, { title: 'Unknown', status: 404 });
  };

  const server = createServer((request, response) => {
    const url = new URL(request.url, 'http://fake');
    const send = (status, value, headers = {}) => {
      response.writeHead(status, { 'Content-Type': status < 400 ? 'application/json' : 'application/problem+json', ...headers });
      response.end(value === null ? undefined : JSON.stringify(value));
    };
    let body = '';
    request.on('data', (piece) => (body += piece));
    request.on('end', () => {
      const [, drawing] = /^\/api\/v1\/studies\/\d+\/drawings\/([\w-]+)$/.exec(url.pathname) ?? [];
      if (drawing !== undefined) {
        response.writeHead(200, { 'Content-Type': 'image/svg+xml' });
        return response.end(
          `<svg xmlns="http://www.w3.org/2000/svg" width="800" height="400"><rect width="100%" height="100%" fill="white"/>` +
            `<text x="20" y="40">${drawing}</text></svg>`,
        );
      }
      if (url.pathname.startsWith('/api/v1/')) return api(request, url, body, send);
      if (url.pathname === '/api/openapi.json') {
        response.writeHead(200, { 'Content-Type': 'application/json' });
        return response.end(readFileSync(join(here, '../server/contract/openapi.gen.json')));
      }
      if (url.pathname === '/api/docs') url.pathname = '/docs.html';
      const file = join(dist, normalize(url.pathname === '/' ? '/index.html' : url.pathname));
      if (!file.startsWith(dist) || !existsSync(file) || !statSync(file).isFile()) return send(404, { title: 'Unknown', status: 404 });
      response.writeHead(200, {
        'Content-Type': types[extname(file)] ?? 'application/octet-stream',
        'Content-Security-Policy': "default-src 'self'",
      });
      createReadStream(file).pipe(response);
    });
  });
  const sockets = new WebSocketServer({ noServer: true, handleProtocols: (offered) => (offered.has('hoist.v1') ? 'hoist.v1' : false) });
  server.on('upgrade', (request, socket, head) => {
    if (person === null) {
      socket.end('HTTP/1.1 401 Unauthorized\r\n\r\n');
      return;
    }
    sockets.handleUpgrade(request, socket, head, (ws) => {
      const id = nextClient++;
      clients.set(id, { socket: ws });
      const send = (message) => ws.send(JSON.stringify(message));
      send({
        type: 'welcome',
        client: id,
        role: person.role,
        version: 'fake',
        layout_hash: layoutHash,
        record_bytes: recordBytes,
        simulated: true,
        scenario: 'figure-eight',
      });
      send({ type: 'core', connected: true, problem: null, reason_code: null, run: '1' });
      tellWalk(id);
      tellPatient(id);
      send({ type: 'parameters', version: hoist.version, values });
      send(leaseMessage(id));
      send({ type: 'notices', items: hoist.standing });
      tellRecording();
      ws.on('message', (data, binary) => !binary && take(JSON.parse(data.toString()), id, ws));
      ws.on('close', () => {
        clients.delete(id);
        if (lease.holder === id) giveLease(0);
      });
    });
  });

  // Ticks follow the clock, not the timer, so that a busy machine does not slow the made-up walk.
  let began = performance.now();
  const timer = setInterval(() => {
    const due = Math.floor((performance.now() - began) / 10) - hoist.tick;
    for (let left = Math.min(due, 50); left > 0;) {
      const records = [];
      for (; left > 0 && records.length < 5; left--) records.push(step());
      const frame = encodeRecords(records);
      for (const client of clients.values()) client.socket.send(frame);
    }
    if (hoist.session !== null && hoist.tick % 50 < 5) tellRecording();
  }, 50);

  return new Promise((resolve) => {
    server.listen(port, '127.0.0.1', () =>
      resolve({
        url: `http://127.0.0.1:${server.address().port}/`,
        hoist,
        lease,
        values,
        clients,
        skip: (ticks) => {
          began -= ticks * 10;
          for (let i = 0; i < ticks; i++) {
            const record = step();
            if (i % 5 === 0) for (const client of clients.values()) client.socket.send(encodeRecords([record]));
          }
        },
        fault: raise,
        as: (role) => (person = { ...person, role }),
        jobs,
        finishJobs: () => (hurry = true),
        /** The rehearsal on this hoist is in another state, or its result is the marker of session 3. */
        rehearse: (state) => Object.assign(rehearsal, state),
        markRehearsal: (result) => Object.assign(markers[1], { text: 'Rehearsal, simulated hoist: …', rehearsal: result }),
        refuse: (type, reason) => (refusing = { type, reason }),
        failNext: (kind, reason) => (failing = { kind, reason }),
        trouble: (change) => (hoist.trouble = change),
        standing: (items) => {
          hoist.standing = items;
          tell({ type: 'notices', items });
        },
        event,
        dropAll: () => {
          for (const client of clients.values()) client.socket.terminate();
        },
        close: () =>
          new Promise((done) => {
            clearInterval(timer);
            for (const client of clients.values()) client.socket.terminate();
            sockets.close();
            server.close(done);
            // A page that stays open asks over these.
            server.closeAllConnections();
          }),
      }),
    );
  });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const option = (name, fallback) => (process.argv.includes(`--${name}`) ? process.argv[process.argv.indexOf(`--${name}`) + 1] : fallback);
  const fake = await startFakeServer({ port: Number(option('port', 8099)), dist: option('dist', join(here, 'dist')) });
  console.log(`Open ${fake.url}`);
}
