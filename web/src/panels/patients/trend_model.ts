// A patient's figures over the sessions, and where there is none: why.
import type { Exercise, Trend } from '../../contract/rest.gen';

export type TrendItem = Trend['items'][number];
export type FigureKey = keyof NonNullable<TrendItem['figures']>;

/** Only walks of the same exercise are compared: a circle is no harder or easier than an eight of another size. */
export const exerciseKey = (exercise: Exercise | null): string => JSON.stringify(exercise ?? { shape: 'free' });

/** The exercises of a trend, the one that was walked last first. */
export function exercisesOf(items: readonly TrendItem[]): Map<string, Exercise | null> {
  return new Map(items.map(({ exercise }) => [exerciseKey(exercise), exercise]));
}

export type TrendChange = Trend['changes'][number];
/** What is told of a figure's change over the walks of one exercise. */
export const changeOf = (changes: readonly TrendChange[], exercise: string, figure: FigureKey): TrendChange | null =>
  changes.find((one) => one.figure === figure && exerciseKey(one.exercise) === exercise) ?? null;

export interface TrendPoint {
  item: TrendItem;
  /** Null: not valid for this session. */
  value: number | null;
}
/** Oldest first. */
export const pointsOf = (items: readonly TrendItem[], exercise: string, figure: FigureKey): TrendPoint[] =>
  items
    .filter((item) => exerciseKey(item.exercise) === exercise)
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
