// An own line: points joined by straights, with round corners as the hoist makes them (control/contract/reference_path.hpp).
import type { Exercise } from '../contract/rest.gen';

export interface Point {
  x: number;
  y: number;
}

export type OwnLine = Extract<Exercise, { shape: 'own' }>;

/** A corner of a smaller radius is sharp. */
const sharp_m = 0.05;
const arcSteps = 16;

export interface OwnPath {
  /** For drawing, arcs as chords. */
  points: Point[];
  length_m: number;
  /** Smallest radius; 0 = a sharp corner, null = no corner at all. */
  tightest_m: number | null;
}

export const pointsOf = ({ x_m, y_m }: OwnLine): Point[] => x_m.map((x, i) => ({ x, y: y_m[i] ?? 0 }));

interface Corner {
  turn: number;
  /** Of both its straights, taken by the arc. */
  cut: number;
}

export function ownPath(line: OwnLine): OwnPath {
  const points = pointsOf(line);
  const n = points.length;
  const edges = line.closed ? n : n - 1;
  if (n < (line.closed ? 3 : 2)) return { points: points.slice(0, 1), length_m: 0, tightest_m: null };
  const at = (i: number) => points[((i % n) + n) % n]!;
  const edge_m = (i: number) => Math.hypot(at(i + 1).x - at(i).x, at(i + 1).y - at(i).y);
  const heading = (i: number) => Math.atan2(at(i + 1).y - at(i).y, at(i + 1).x - at(i).x);
  const corner = (i: number): Corner => {
    const raw = heading(i) - heading(i - 1);
    const turn = Math.atan2(Math.sin(raw), Math.cos(raw));
    const slope = Math.tan(Math.abs(turn) / 2);
    const cut = Math.min((line.corner_radius_m ?? 0) * slope, Math.min(edge_m(i - 1), edge_m(i)) / 2);
    return { turn, cut: slope > 0 && cut / slope > sharp_m ? cut : 0 };
  };
  const corners = points.map((_, i): Corner => (line.closed || (i > 0 && i < edges) ? corner(i) : { turn: 0, cut: 0 }));
  const along = (i: number, by: number): Point => ({ x: at(i).x + by * Math.cos(heading(i)), y: at(i).y + by * Math.sin(heading(i)) });
  // A closed line whose first corner is round begins in the middle of its first straight.
  const first = corners[0]!.cut > 0 ? edge_m(0) / 2 : 0;
  const drawn = [along(0, first)];
  let length_m = -first;
  let tightest_m: number | null = null;
  for (let i = 0; i < edges; i++) {
    const { turn, cut } = corners[(i + 1) % n]!;
    drawn.push(along(i, edge_m(i) - cut));
    length_m += edge_m(i) - (i === 0 ? 0 : corners[i]!.cut) - cut;
    const turns = Math.abs(turn) > 1e-6;
    if (cut > 0) {
      const radius = cut / Math.tan(Math.abs(turn) / 2);
      const from = drawn.at(-1)!;
      const begin = heading(i);
      const side = Math.sign(turn);
      for (let step = 1; step <= arcSteps; step++) {
        const psi = begin + (turn * step) / arcSteps;
        drawn.push({
          x: from.x + side * radius * (Math.sin(psi) - Math.sin(begin)),
          y: from.y - side * radius * (Math.cos(psi) - Math.cos(begin)),
        });
      }
      length_m += radius * Math.abs(turn);
      tightest_m = Math.min(tightest_m ?? Infinity, radius);
    } else if (turns) tightest_m = 0;
  }
  if (first > 0) {
    drawn.push(along(0, first));
    length_m += first - corners[0]!.cut;
  }
  return { points: drawn, length_m, tightest_m };
}
