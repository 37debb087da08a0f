// The recorded sessions as /api/v1/sessions gives them.
import type { SignalName } from '../../contract/signals.gen';
import type { EventList, Samples, SessionList } from '../../contract/rest.gen';

/** A line of what happened: an event, or a mark that somebody set. */
export interface StoryLine {
  time_s: number;
  kind: string;
  name: string;
  value: number | null;
  before: number | null;
  code: number | null;
}

/** What happened, with the marks in between, in order of time. Answers to single commands are left out: their effect is there too. */
export function story(events: EventList, started_utc_ms: number): StoryLine[] {
  const marks = events.markers.map((mark) => ({
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
    return column === undefined ? [] : column.min.map((low, i) => (low + (column.max[i] ?? low)) / 2);
  };
  const fused = samples.columns.some((item) => item.name === 'fused_x_m');
  return { x: middle(fused ? 'fused_x_m' : 'x_m'), y: middle(fused ? 'fused_y_m' : 'y_m') };
}

/** The newest sessions, asked for again, put before the older ones that are on the screen already: whoever has scrolled far down stays
 * there. `next` goes on from the last row. Sessions come newest first, by their numbers. */
export function refreshed(shown: SessionList | null, newest: SessionList): SessionList {
  const last = newest.items.at(-1)?.id;
  // Without an overlap there may be sessions in between that nobody has asked for.
  if (shown === null || newest.next === null || last === undefined || !shown.items.some((item) => item.id >= last)) return newest;
  const older = shown.items.filter((item) => item.id < last);
  return older.length === 0 ? newest : { items: [...newest.items, ...older], next: shown.next, total: newest.total };
}

/** One page more at the end; a row that is there already does not come twice. */
export function continued(shown: SessionList | null, more: SessionList): SessionList {
  const known = new Set((shown?.items ?? []).map((item) => item.id));
  return { items: [...(shown?.items ?? []), ...more.items.filter((item) => !known.has(item.id))], next: more.next, total: more.total };
}
