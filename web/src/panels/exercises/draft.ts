// A line while it is drawn: its points on the grid, what is wrong with it, and whether it fits the floor.
import type { Line, LineRequest, TaskRange } from '../../contract/rest.gen';
import { beside_m, type Point } from '../../ui/geometry';
import { ownPath, pointsOf, type OwnLine, type OwnPath } from '../../ui/own_line';

export interface Draft {
  name: string;
  points: readonly Point[];
  closed: boolean;
  corner_radius_m: number;
}

export const pointsMost = 24;
/** Neighbouring points are at least so far apart (control/contract/own_line.hpp). */
const edgeLeast_m = 0.2;
/** A tap and a step of the arrow keys. */
export const grid_m = 0.1;
export const corners: TaskRange = { usual: 0.5, least: 0, most: 3, step: 0.1 };
/** Below this the hoist is not asked for a curve, but for a sharp corner. */
const radiusLeast_m = 0.3;
export const floorSide: TaskRange = { usual: 6, least: 3, most: 40, step: 0.5 };

/** The free floor, about the origin: x along, y across. */
export interface Floor {
  along_m: number;
  across_m: number;
}

export const emptyDraft: Draft = { name: '', points: [], closed: false, corner_radius_m: corners.usual };
export function draftOf({ name, exercise }: Line): Draft {
  if (exercise.shape !== 'own') return { ...emptyDraft, name };
  return { name, points: pointsOf(exercise), closed: exercise.closed, corner_radius_m: exercise.corner_radius_m ?? 0 };
}

/** A line under way. */
export interface Drawing {
  /** The stored line that is changed; null: a new one. */
  line: Line | null;
  draft: Draft;
}
export const beginOf = (line: Line | null): Drawing => ({ line, draft: line === null ? emptyDraft : draftOf(line) });
/** Whether there is anything to lose. */
export const isChanged = ({ line, draft }: Drawing): boolean => JSON.stringify(draft) !== JSON.stringify(beginOf(line).draft);

export const ownOf = ({ points, closed, corner_radius_m }: Draft): OwnLine => ({
  shape: 'own',
  closed,
  x_m: points.map(({ x }) => x),
  y_m: points.map(({ y }) => y),
  ...(corner_radius_m > 0 ? { corner_radius_m } : {}),
});
export const requestOfDraft = (draft: Draft): LineRequest => ({ name: draft.name.trim(), exercise: ownOf(draft) });

/** One button press on the radius: sharp, or a radius that can be walked. */
export function steppedRadius(value: number, by: 1 | -1): number {
  const next = Number((Math.round(value / corners.step + by) * corners.step).toFixed(1));
  if (next > 0 && next < radiusLeast_m) return by > 0 ? radiusLeast_m : 0;
  return Math.min(corners.most, Math.max(0, next));
}

const snapped = (value: number) => Number((Math.round(value / grid_m) * grid_m).toFixed(2));
/** The nearest place on the grid that is on the floor. */
export function onFloor({ x, y }: Point, { along_m, across_m }: Floor): Point {
  const within = (value: number, side_m: number) => Math.min(side_m / 2, Math.max(-side_m / 2, snapped(value)));
  return { x: within(x, along_m), y: within(y, across_m) };
}

export const moved = (draft: Draft, index: number, to: Point): Draft => ({
  ...draft,
  points: draft.points.map((point, i) => (i === index ? to : point)),
});
export const without = (draft: Draft, index: number): Draft => ({ ...draft, points: draft.points.filter((_, i) => i !== index) });
export const withPoint = (draft: Draft, at: Point, index = draft.points.length): Draft =>
  draft.points.length >= pointsMost ? draft : { ...draft, points: [...draft.points.slice(0, index), at, ...draft.points.slice(index)] };

/** Where a new point goes that is not placed by hand: a metre on in the direction of the last straight, or to the left where the floor ends. */
export function nextPoint({ points }: Draft, floor: Floor): Point {
  const last = points.at(-1);
  if (last === undefined) return onFloor({ x: -floor.along_m / 2 + 1, y: 0 }, floor);
  const before = points.at(-2) ?? { x: last.x - 1, y: last.y };
  const length = Math.hypot(last.x - before.x, last.y - before.y) || 1;
  const [x, y] = [(last.x - before.x) / length, (last.y - before.y) / length];
  const apart = (at: Point) => Math.hypot(at.x - last.x, at.y - last.y);
  const ways = [
    { x: last.x + x, y: last.y + y },
    { x: last.x - y, y: last.y + x },
    { x: last.x + y, y: last.y - x },
    { x: last.x - x, y: last.y - y },
  ].map((at) => onFloor(at, floor));
  return ways.find((at) => apart(at) >= 0.5) ?? ways[0]!;
}

/** Place in the list of a point that is put on the line itself: behind the straight that it lies on; null: on none. */
export function edgeAt({ points, closed }: Draft, at: Point, within_m: number): number | null {
  let best: { index: number; away: number } | null = null;
  const edges = closed && points.length > 2 ? points.length : points.length - 1;
  for (let i = 0; i < edges; i++) {
    const a = points[i]!;
    const b = points[(i + 1) % points.length]!;
    const length2 = (b.x - a.x) ** 2 + (b.y - a.y) ** 2;
    const share = length2 === 0 ? 0 : Math.min(1, Math.max(0, ((at.x - a.x) * (b.x - a.x) + (at.y - a.y) * (b.y - a.y)) / length2));
    const away = Math.hypot(at.x - a.x - share * (b.x - a.x), at.y - a.y - share * (b.y - a.y));
    if (away <= within_m && (best === null || away < best.away)) best = { index: i + 1, away };
  }
  return best?.index ?? null;
}

export type Wrong = 'few' | 'near';
export interface Judged extends OwnPath {
  /** Why it is no line yet; null: it is one. */
  wrong: Wrong | null;
  /** Numbers of two neighbours that are too near. */
  near: readonly [number, number] | null;
  fits: boolean;
}

export function judge(draft: Draft, floor: Floor): Judged {
  const { points, closed } = draft;
  const path = ownPath(ownOf(draft));
  const edges = closed ? points.length : points.length - 1;
  const near = points.findIndex((a, i) => {
    const b = points[(i + 1) % points.length]!;
    return i < edges && points.length > 1 && Math.hypot(b.x - a.x, b.y - a.y) < edgeLeast_m - 1e-9;
  });
  const wrong = points.length < (closed ? 3 : 2) ? 'few' : near >= 0 ? 'near' : null;
  const room = (value: number, side_m: number) => Math.abs(value) + beside_m <= side_m / 2 + 1e-9;
  return {
    ...path,
    wrong,
    near: near < 0 ? null : [near + 1, ((near + 1) % points.length) + 1],
    fits: path.points.every(({ x, y }) => room(x, floor.along_m) && room(y, floor.across_m)),
  };
}
