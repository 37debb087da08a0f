// A patient's figures over the sessions, and where there is none: why.
import type { MetricKey } from '../../contract/metrics.gen';
import type { Trend } from '../../contract/rest.gen';

export type TrendItem = Trend['items'][number];

/** What was walked: only walks of the same exercise and of the same task with the same goal are compared. Own lines by their points, not by name. */
export type Walked = Pick<TrendItem, 'exercise' | 'task' | 'ends' | 'line'>;
export const walkedKey = ({ exercise, task, ends }: Omit<Walked, 'line'>): string => JSON.stringify([exercise ?? { shape: 'free' }, task, ends]);

/** What was walked in a trend, the last one first: the newest walk of each. */
export function walkedOf(items: readonly TrendItem[]): Map<string, TrendItem> {
  const kinds = new Map<string, TrendItem>();
  for (const item of items) if (!kinds.has(walkedKey(item))) kinds.set(walkedKey(item), item);
  return kinds;
}

export type TrendChange = Trend['changes'][number];
/** What is told of a figure's change over comparable walks. */
export const changeOf = (changes: readonly TrendChange[], walked: string, figure: MetricKey): TrendChange | null =>
  changes.find((one) => one.figure === figure && walkedKey(one) === walked) ?? null;

export interface TrendPoint {
  item: TrendItem;
  /** Null: not valid for this session. */
  value: number | null;
}
/** Oldest first. */
export const pointsOf = (items: readonly TrendItem[], walked: string, figure: MetricKey): TrendPoint[] =>
  items
    .filter((item) => walkedKey(item) === walked)
    .map((item) => ({ item, value: item.figures?.[figure] ?? null }))
    .reverse();

/** Runs of neighbours that have a value: a line never crosses a session without one. */
export function runsOf(points: readonly TrendPoint[]): number[][] {
  const runs: number[][] = [];
  points.forEach(({ value }, i) => {
    if (value === null) return;
    if (i > 0 && points[i - 1]!.value !== null) runs.at(-1)!.push(i);
    else runs.push([i]);
  });
  return runs;
}

/** Smallest and largest value with some room; null without any value. */
export function spanOf(points: readonly TrendPoint[]): { low: number; high: number } | null {
  const values = points.flatMap(({ value }) => (value === null ? [] : [value]));
  if (values.length === 0) return null;
  const low = Math.min(...values);
  const high = Math.max(...values);
  const room = high > low ? (high - low) * 0.1 : Math.max(Math.abs(high) * 0.1, 0.1);
  return { low: low - room, high: high + room };
}
