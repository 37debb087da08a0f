// The choices of an exercise, and what follows: the requested path, its floor space, its duration.
import { exercises, usualExercise } from '../../contract/exercises.gen';
import type { Exercise, GuidedPath } from '../../contract/rest.gen';
import { patternPoints } from '../../ui/geometry';

export type Shape = GuidedPath['shape'];
export const shapes: readonly Shape[] = exercises.flatMap(({ shape }) => (shape === 'free' ? [] : [shape]));

export interface Plan {
  shape: Shape;
  length_m: number;
  side_m: number;
  round: boolean;
  radius_m: number;
  eight_m: number;
  clockwise: boolean;
  speed_m_s: number;
  laps: number;
}
export const firstPlan: Plan = {
  shape: 'straight',
  length_m: usualExercise.straight.length_m,
  side_m: usualExercise.square.side_m,
  round: false,
  radius_m: usualExercise.circle.radius_m,
  eight_m: usualExercise.eight.c_m,
  clockwise: false,
  speed_m_s: 0.3,
  laps: 1,
};

export interface Step {
  least: number;
  most: number;
  step: number;
}
/** Steps of the buttons; the hoist also checks its own limits. */
export const steps = {
  length_m: { least: 1, most: 50, step: 0.5 },
  side_m: { least: 1, most: 10, step: 0.2 },
  radius_m: { least: 0.4, most: 5, step: 0.1 },
  eight_m: { least: 0.5, most: 4, step: 0.1 },
  speed_m_s: { least: 0.1, most: 0.6, step: 0.05 },
  laps: { least: 1, most: 20, step: 1 },
} as const satisfies Partial<Record<keyof Plan, Step>>;
export type Stepped = keyof typeof steps;
/** The size that a shape is changed by. */
export const sizeOf: Record<Shape, Stepped> = { straight: 'length_m', square: 'side_m', circle: 'radius_m', eight: 'eight_m' };

/** One step up or down, on the grid of the steps and within their ends. */
export function stepped({ least, most, step }: Step, value: number, by: 1 | -1): number {
  const next = Math.round(value / step + by) * step;
  return Number(Math.min(most, Math.max(least, next)).toFixed(3));
}

/** The plan as the hoist may drive it now: not faster than this patient's limit. */
export const withinCap = (plan: Plan, speedMost_m_s: number): Plan => ({ ...plan, speed_m_s: Math.min(plan.speed_m_s, speedMost_m_s) });

const cornerRadius_m = 0.5;
/** Loops a little smaller than half of the figure, so that they meet in a crossing. */
const loopShare = usualExercise.eight.radius_m / usualExercise.eight.c_m;

export function pathOf(plan: Plan): GuidedPath {
  const { speed_m_s, laps, clockwise } = plan;
  switch (plan.shape) {
    case 'straight':
      return { shape: 'straight', length_m: plan.length_m, speed_m_s };
    case 'square':
      return { shape: 'square', side_m: plan.side_m, ...(plan.round ? { corner_radius_m: cornerRadius_m } : {}), clockwise, speed_m_s, laps };
    case 'circle':
      return { shape: 'circle', radius_m: plan.radius_m, clockwise, speed_m_s, laps };
    case 'eight':
      return { shape: 'eight', c_m: plan.eight_m, radius_m: Number((loopShare * plan.eight_m).toFixed(3)), clockwise, speed_m_s, laps };
  }
}

/** The figure alone, for drawing and recording. */
export function exerciseOf(plan: Plan): Exercise {
  const { speed_m_s: _speed, laps: _laps, ...figure } = pathOf(plan);
  return figure;
}

export function length_m(plan: Plan): number {
  const points = patternPoints(exerciseOf(plan));
  let sum = 0;
  for (let i = 1; i < points.length; i++) sum += Math.hypot(points[i]!.x - points[i - 1]!.x, points[i]!.y - points[i - 1]!.y);
  return plan.shape === 'straight' ? sum : sum * plan.laps;
}

/** The share of the turning limit that the hoist takes in a curve (guided_path.hpp). */
const yawShare = 0.8;
/** The speed in the tightest curve, when it is below the chosen one; null when no curve slows the hoist. */
export function curveSpeed_m_s(plan: Plan, yawLimit_rad_s: number): number | null {
  const path = pathOf(plan);
  const radius = path.shape === 'straight' ? 0 : path.shape === 'square' ? (path.corner_radius_m ?? 0) : path.radius_m;
  if (radius <= 0 || yawLimit_rad_s <= 0) return null;
  const most = yawShare * yawLimit_rad_s * radius;
  return most < plan.speed_m_s - 0.005 ? most : null;
}

/** Duration in seconds without a release: the path, slower in curves, and the turns in sharp corners. */
export function duration_s(plan: Plan, yawLimit_rad_s: number): number {
  const ramp_s = 2;
  const curve = curveSpeed_m_s(plan, yawLimit_rad_s);
  const speed = plan.shape === 'circle' || plan.shape === 'eight' ? (curve ?? plan.speed_m_s) : plan.speed_m_s;
  const corners = plan.shape === 'square' && !plan.round ? 4 * plan.laps : 0;
  const corner_s = yawLimit_rad_s > 0 ? Math.PI / 2 / (yawShare * yawLimit_rad_s) + 3 : 0;
  return length_m(plan) / speed + ramp_s + corners * corner_s;
}
