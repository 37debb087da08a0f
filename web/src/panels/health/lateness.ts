// The loop's punctuality as the server tells it, and the bars that a screen draws of it.
import type { LatenessBuckets, Loop } from '../../contract/rest.gen';

/** The part of it that is drawn. */
export type LoopReport = Pick<Loop, 'steps' | 'latest_ever_s' | 'longest_step_s' | 'lately' | 'ever'>;

/** The drawing reaches from 1 µs to 1 s, each power of two a column; what lies outside stands in the first or last one. */
export const columns = 20;
const first_s = 1e-6;

export function columnOf(from_s: number): number {
  if (from_s < first_s) return 0;
  return Math.min(columns - 1, Math.floor(Math.log2(from_s / first_s) + 1e-9));
}

/** Where a time stands across the drawing, 0 to 1. */
export function placeOf(time_s: number): number {
  return Math.max(0, Math.min(1, Math.log2(time_s / first_s) / columns));
}

/** Steps per column. */
export function columnsOf(buckets: LatenessBuckets): number[] {
  const counts = new Array<number>(columns).fill(0);
  for (const bucket of buckets) {
    const column = columnOf(bucket.from_s);
    counts[column] = (counts[column] ?? 0) + bucket.count;
  }
  return counts;
}

/** Heights 0 to 1, by the logarithm: one late step in a million must be seen beside the punctual ones. */
export function heightsOf(counts: readonly number[]): number[] {
  const most = Math.max(...counts, 1);
  return counts.map((count) => (count === 0 ? 0 : (0.3 + Math.log10(count)) / (0.3 + Math.log10(most))));
}
