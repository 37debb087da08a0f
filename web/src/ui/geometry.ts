// Shapes on the floor: the planned figures as points, and the frame that shows everything. Same figures as the hoist's own
// (square counter-clockwise from its lower left corner; eight from the crossing, right circle first; all others from the origin along x, to the
// left).
import type { Exercise } from '../contract/rest.gen';
import { ownPath, type Point } from './own_line';

export type { Point };

const arcSteps = 48;
/** A slalom goes round so many poles and crosses their line at this angle (control/contract/reference_path.hpp). */
const poles = 4;
const swing = Math.PI / 3;
/** Radius of its curves, as a share of the spacing. */
export const slalomCurve = 1 / (2 * Math.sin(swing));

export function patternPoints(exercise: Exercise): Point[] {
  return turned(exercise, leftHanded(exercise));
}

/** What stands on the floor and is walked round. */
export function polesOf(exercise: Exercise): Point[] {
  if (exercise.shape !== 'slalom') return [];
  const { spacing_m } = exercise;
  return turned(
    exercise,
    Array.from({ length: poles }, (_, i) => ({ x: (i + 1) * spacing_m, y: (slalomCurve * spacing_m) / 2 })),
  );
}

const turned = (exercise: Exercise, points: Point[]): Point[] =>
  'clockwise' in exercise && exercise.clockwise === true ? points.map(({ x, y }) => ({ x, y: -y })) : points;

/** Points of an arc about a centre, from one angle over another. */
function arc(centre_x: number, centre_y: number, radius: number, from: number, over: number): Point[] {
  return Array.from({ length: arcSteps + 1 }, (_, i) => {
    const angle = from + (over * i) / arcSteps;
    return { x: centre_x + radius * Math.cos(angle), y: centre_y + radius * Math.sin(angle) };
  });
}

function leftHanded(exercise: Exercise): Point[] {
  switch (exercise.shape) {
    case 'square': {
      const h = exercise.side_m / 2;
      const r = exercise.corner_radius_m ?? 0;
      if (r > 0 && r <= h) {
        // Round corners: from the middle of the first side, so that every corner is one arc.
        const inner = h - r;
        return [
          { x: 0, y: -h },
          ...arc(inner, -inner, r, -Math.PI / 2, Math.PI / 2),
          ...arc(inner, inner, r, 0, Math.PI / 2),
          ...arc(-inner, inner, r, Math.PI / 2, Math.PI / 2),
          ...arc(-inner, -inner, r, Math.PI, Math.PI / 2),
          { x: 0, y: -h },
        ];
      }
      return [
        { x: -h, y: -h },
        { x: h, y: -h },
        { x: h, y: h },
        { x: -h, y: h },
        { x: -h, y: -h },
      ];
    }
    case 'circle':
      return arc(0, exercise.radius_m, exercise.radius_m, -Math.PI / 2, 2 * Math.PI);
    case 'slalom': {
      const { spacing_m } = exercise;
      const radius = slalomCurve * spacing_m;
      // Over the first pole, under the second … : the centres lie on two lines that are a radius apart.
      const round = Array.from({ length: poles }, (_, i) =>
        i % 2 === 0
          ? arc((i + 1) * spacing_m, 0, radius, Math.PI / 2 + swing, -2 * swing)
          : arc((i + 1) * spacing_m, radius, radius, -Math.PI / 2 - swing, 2 * swing),
      );
      return [
        ...arc(0, radius, radius, -Math.PI / 2, swing),
        ...round.flat(),
        ...arc((poles + 1) * spacing_m, 0, radius, Math.PI / 2 + swing, -swing),
      ];
    }
    case 'straight':
      return [
        { x: 0, y: 0 },
        { x: exercise.length_m, y: 0 },
      ];
    case 'eight': {
      const { c_m, radius_m } = exercise;
      if (!(radius_m > 0) || radius_m > c_m) return [];
      const slope = Math.asin(radius_m / c_m);
      // Each circle is entered and left where its tangent passes through the crossing.
      return [
        { x: 0, y: 0 },
        ...arc(c_m, 0, radius_m, Math.PI / 2 + slope, -(Math.PI + 2 * slope)),
        ...arc(-c_m, 0, radius_m, Math.PI / 2 - slope, Math.PI + 2 * slope),
        { x: 0, y: 0 },
      ];
    }
    case 'own':
      return ownPath(exercise).points;
    case 'free':
      return [];
  }
}

/** Margin around the line: half a hoist's diagonal and a hand's breadth. */
export const beside_m = 0.7;

/** The free floor that a figure needs, rounded up to half metres: along the first view of the hoist, and across. */
export function floorSpace(exercise: Exercise): { along_m: number; across_m: number } {
  const points = patternPoints(exercise);
  const span = (of: (point: Point) => number) => Math.max(...points.map(of)) - Math.min(...points.map(of)) + 2 * beside_m;
  const up = (metres: number) => Math.ceil(metres * 2 - 1e-6) / 2;
  if (points.length === 0) return { along_m: 0, across_m: 0 };
  return { along_m: up(span((p) => p.x)), across_m: up(span((p) => p.y)) };
}

export interface Frame {
  centre_x: number;
  centre_y: number;
  pixels_per_m: number;
}

/** Screen position of a floor point: x up, y to the left, so that forward on the joystick is up on the floor view at the start. */
export const onScreen = ({ x, y }: Point, frame: Frame, width_px: number, height_px: number) => ({
  left: width_px / 2 - (y - frame.centre_y) * frame.pixels_per_m,
  top: height_px / 2 - (x - frame.centre_x) * frame.pixels_per_m,
});

/** A frame that holds all points with a margin; never closer than a floor of 3 m, so that standing still does not zoom in. */
export function fit(points: Iterable<Point>, width_px: number, height_px: number, margin_m = 0.5, least_m = 3): Frame {
  let x0 = Infinity;
  let x1 = -Infinity;
  let y0 = Infinity;
  let y1 = -Infinity;
  for (const { x, y } of points) {
    if (!Number.isFinite(x) || !Number.isFinite(y)) continue;
    x0 = Math.min(x0, x);
    x1 = Math.max(x1, x);
    y0 = Math.min(y0, y);
    y1 = Math.max(y1, y);
  }
  if (x0 > x1) {
    x0 = x1 = y0 = y1 = 0;
  }
  const wide = Math.max(least_m, y1 - y0 + 2 * margin_m);
  const high = Math.max(least_m, x1 - x0 + 2 * margin_m);
  return { centre_x: (x0 + x1) / 2, centre_y: (y0 + y1) / 2, pixels_per_m: Math.max(1, Math.min(width_px / wide, height_px / high)) };
}
