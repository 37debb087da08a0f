// The recorded sessions as /api/v1/sessions gives them.
import type { SignalName } from '../../contract/signals.gen';
import type { Exercise } from '../../contract/messages.gen';

export interface Session {
  id: number;
  subject: string | null;
  started_utc_ms: number;
  duration_s: number;
  simulated: boolean;
  recording: boolean;
  exercise: Exercise | null;
  note: string;
  samples: number;
  gaps: number;
}
export interface SessionPage {
  items: Session[];
  next: string | null;
}
export interface Metrics {
  C: number | null;
  J_N: number | null;
  reference_length_m: number | null;
  /** In a motion mode, standing included. */
  duration_s: number | null;
  /** Of that, with a wheel turning. */
  motion_s: number | null;
  /** Motion that was not recorded; all values exclude it. */
  missing_s: number;
  distance_m: number | null;
  mean_speed_m_s: number | null;
  rms_position_m: number | null;
  rms_heading_rad: number | null;
  /** The compared track: slip-corrected, or the encoders' own. */
  track: 'fused' | 'encoders';
  exercise: Exercise | null;
  /** Why there is no comparison with a plan: a row of the table of reasons. */
  reason_code: string | null;
}
export interface SampleColumn {
  name: SignalName;
  unit: string;
  min: (number | null)[];
  max: (number | null)[];
}
export interface Samples {
  from_s: number[];
  to_s: number[];
  columns: SampleColumn[];
}
export interface SessionEvent {
  time_s: number;
  kind: string;
  name: string;
  value: number | null;
  before: number | null;
  code: number | null;
}
export interface SessionEvents {
  items: SessionEvent[];
  markers: { utc_ms: number; text: string }[];
}

/** Events and marks in order of time. Answers to single commands are left out, since their effects are events too. */
export function story(events: SessionEvents, started_utc_ms: number): SessionEvent[] {
  const marks = (events.markers ?? []).map((mark) => ({
    time_s: (mark.utc_ms - started_utc_ms) / 1000,
    kind: 'marker',
    name: mark.text,
    value: null,
    before: null,
    code: null,
  }));
  return [...events.items.filter((event) => event.kind !== 'command_done'), ...marks].sort((a, b) => a.time_s - b.time_s);
}

/** One curve through smallest and largest values of each run: [time, column, …] for the chart, each run giving two points. */
export function zigzag(samples: Samples, names: readonly SignalName[]): [number[], ...(number | null)[][]] {
  const time: number[] = [];
  const rows: (number | null)[][] = names.map(() => []);
  const columns = names.map((name) => samples.columns.find((column) => column.name === name));
  for (let i = 0; i < samples.from_s.length; i++) {
    const from = samples.from_s[i]!;
    const to = samples.to_s[i] ?? from;
    const single = to <= from;
    time.push(from);
    if (!single) time.push(to);
    columns.forEach((column, c) => {
      rows[c]!.push(column?.min[i] ?? null);
      if (!single) rows[c]!.push(column?.max[i] ?? null);
    });
  }
  return [time, ...rows];
}

/** The path from thinned columns: the middle of each run. */
export function pathOf(samples: Samples): { x: number[]; y: number[] } {
  const middle = (name: SignalName) => {
    const column = samples.columns.find((item) => item.name === name);
    return column === undefined ? [] : column.min.map((low, i) => ((low ?? NaN) + (column.max[i] ?? NaN)) / 2);
  };
  const fused = samples.columns.some((item) => item.name === 'fused_x_m');
  const xs = middle(fused ? 'fused_x_m' : 'x_m');
  const ys = middle(fused ? 'fused_y_m' : 'y_m');
  const x: number[] = [];
  const y: number[] = [];
  for (let i = 0; i < Math.min(xs.length, ys.length); i++) {
    if (!Number.isFinite(xs[i]) || !Number.isFinite(ys[i])) continue;
    x.push(xs[i]!);
    y.push(ys[i]!);
  }
  return { x, y };
}

/** Merges reloaded newest sessions with older ones on the screen, keeping the scroll position. `next` continues from the last row. Sessions come
 * newest first, by number. */
export function refreshed(shown: SessionPage | null, newest: SessionPage): SessionPage {
  const last = newest.items.at(-1)?.id;
  // Without an overlap there may be sessions in between that were not requested.
  if (shown === null || newest.next === null || last === undefined || !shown.items.some((item) => item.id >= last)) return newest;
  const older = shown.items.filter((item) => item.id < last);
  return older.length === 0 ? newest : { items: [...newest.items, ...older], next: shown.next };
}

/** Appends one page, without duplicate rows. */
export function continued(shown: SessionPage | null, more: SessionPage): SessionPage {
  const known = new Set((shown?.items ?? []).map((item) => item.id));
  return { items: [...(shown?.items ?? []), ...more.items.filter((item) => !known.has(item.id))], next: more.next };
}
