// The recorded sessions as /api/v1/sessions gives them.
import type { SignalName } from '../../contract/signals.gen';
import type { EventRow, MarkerRow, Samples, SessionList } from '../../contract/rest.gen';

/** An event, or a mark set by a therapist. */
export interface StoryLine {
  time_s: number;
  kind: string;
  name: string;
  value: number | null;
  before: number | null;
  code: number | null;
}

/** Events and marks in order of time. Answers to single commands are left out, since their effects are events too. */
export function story(events: readonly EventRow[], markers: readonly MarkerRow[]): StoryLine[] {
  const marks = markers.map((mark) => ({
    time_s: mark.time_s,
    kind: 'marker',
    name: mark.text,
    value: null,
    before: null,
    code: null,
  }));
  return [...events.filter((event) => event.kind !== 'command_done'), ...marks].sort((a, b) => a.time_s - b.time_s);
}

/** Reads a time as duration() shows it: 75, 1:15, 1:01:11; seconds may have decimals. Null when it is none. */
export function readDuration(text: string): number | null {
  const parts = /^(?:(?:(\d+):)?(\d{1,2}):)?(\d+(?:[.,]\d+)?)$/.exec(text.trim());
  if (parts === null) return null;
  const [hours, minutes, seconds] = [parts[1], parts[2], parts[3]].map((part) => Number((part ?? '0').replace(',', '.')));
  if (parts[2] !== undefined && seconds! >= 60) return null;
  if (parts[1] !== undefined && minutes! >= 60) return null;
  return hours! * 3600 + minutes! * 60 + seconds!;
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
    return column === undefined ? [] : column.min.map((low, i) => (low + (column.max[i] ?? low)) / 2);
  };
  const fused = samples.columns.some((item) => item.name === 'fused_x_m');
  return { x: middle(fused ? 'fused_x_m' : 'x_m'), y: middle(fused ? 'fused_y_m' : 'y_m') };
}

/** Merges reloaded newest sessions with older ones on the screen, keeping the scroll position. `next` continues from the last row. Sessions come
 * newest first, by number. */
export function refreshed(shown: SessionList | null, newest: SessionList): SessionList {
  const last = newest.items.at(-1)?.id;
  // Without an overlap there may be sessions in between that were not requested.
  if (shown === null || newest.next === null || last === undefined || !shown.items.some((item) => item.id >= last)) return newest;
  const older = shown.items.filter((item) => item.id < last);
  return older.length === 0 ? newest : { items: [...newest.items, ...older], next: shown.next, total: newest.total };
}

/** Appends one page, without duplicate rows. */
export function continued(shown: SessionList | null, more: SessionList): SessionList {
  const known = new Set((shown?.items ?? []).map((item) => item.id));
  return { items: [...(shown?.items ?? []), ...more.items.filter((item) => !known.has(item.id))], next: more.next, total: more.total };
}
