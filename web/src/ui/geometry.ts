// Shapes on the floor: the planned figures as points, and the frame that shows everything. Same figures as the hoist's own
// (square counter-clockwise from its lower left corner; eight from the crossing, right circle first; straight along x).
import type { Exercise } from '../contract/messages.gen';

export interface Point {
  x: number;
  y: number;
}

const arcSteps = 48;

export function patternPoints(exercise: Exercise): Point[] {
  switch (exercise.shape) {
    case 'square': {
      const h = exercise.side_m / 2;
      return [
        { x: -h, y: -h },
        { x: h, y: -h },
        { x: h, y: h },
        { x: -h, y: h },
        { x: -h, y: -h },
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
      const points: Point[] = [{ x: 0, y: 0 }];
      // Each circle is entered and left where its tangent passes through the crossing.
      for (let i = 0; i <= arcSteps; i++) {
        const angle = Math.PI / 2 + slope - ((Math.PI + 2 * slope) * i) / arcSteps;
        points.push({ x: c_m + radius_m * Math.cos(angle), y: radius_m * Math.sin(angle) });
      }
      for (let i = 0; i <= arcSteps; i++) {
        const angle = Math.PI / 2 - slope + ((Math.PI + 2 * slope) * i) / arcSteps;
        points.push({ x: -c_m + radius_m * Math.cos(angle), y: radius_m * Math.sin(angle) });
      }
      points.push({ x: 0, y: 0 });
      return points;
    }
    case 'free':
      return [];
  }
}

export interface Frame {
  centre_x: number;
  centre_y: number;
  pixels_per_m: number;
}

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
  const wide = Math.max(least_m, x1 - x0 + 2 * margin_m);
  const high = Math.max(least_m, y1 - y0 + 2 * margin_m);
  return { centre_x: (x0 + x1) / 2, centre_y: (y0 + y1) / 2, pixels_per_m: Math.max(1, Math.min(width_px / wide, height_px / high)) };
}
