// A clinical task as it is to be done: its sizes and numbers, who leads, and what follows: the line, the request to the hoist, floor and time.
import { exercises } from '../../contract/exercises.gen';
import type { Exercise, GuidedPath, Line, Task, TaskRange, TaskRequest, TaskState } from '../../contract/rest.gen';
import { patternPoints, slalomCurve } from '../../ui/geometry';

export type Lead = Task['leads'][number];

export interface Plan {
  task: Task;
  /** Of the task of own lines. */
  own: Line | null;
  lead: Lead;
  /** Those that the task adjusts, by name. */
  sizes: Readonly<Record<string, number>>;
  /** Of the task's end: times along the line, seconds, radians, metres. */
  goal: number;
  clockwise: boolean;
  repetitions: number;
  rest_s: number;
  /** Where the hoist leads. */
  speed_m_s: number;
}

/** A task as its file has it. Who leads stays, where the task allows it. */
export const planOf = (task: Task, before?: Pick<Plan, 'lead' | 'speed_m_s'>, own: Line | null = null): Plan => ({
  task,
  own,
  lead: before !== undefined && task.leads.includes(before.lead) ? before.lead : task.leads[0]!,
  sizes: Object.fromEntries(Object.entries(task.sizes).map(([name, range]) => [name, range.usual])),
  goal: task.ends.goal.usual,
  clockwise: false,
  repetitions: task.repetitions.usual,
  rest_s: task.rest_s.usual,
  speed_m_s: before?.speed_m_s ?? 0.3,
});

/** What the speed buttons offer; the hoist also checks its own limits. */
export const speeds: TaskRange = { usual: 0.3, least: 0.1, most: 0.6, step: 0.05 };
export const adjustable = (range: TaskRange): boolean => range.most > range.least;

/** One step up or down, on the grid of the steps and within the range's ends. */
export function stepped({ least, most, step }: TaskRange, value: number, by: 1 | -1): number {
  const next = Math.round(value / step + by) * step;
  return Number(Math.min(most, Math.max(least, next)).toFixed(3));
}

/** The plan as the hoist may lead it now: not faster than this patient's limit. */
export const withinCap = (plan: Plan, speedMost_m_s: number): Plan => ({ ...plan, speed_m_s: Math.min(plan.speed_m_s, speedMost_m_s) });

const rowOf = (task: Task) => exercises.find((row) => row.shape === (task.line ?? 'free'))!;

/** The line for drawing, walking and recording. A size that the task does not adjust keeps its proportion to the first. */
export function exerciseOf(plan: Plan): Exercise {
  if (plan.own !== null) return plan.own.exercise;
  const row = rowOf(plan.task);
  const first = row.sizes[0];
  const scale = first === undefined ? 1 : (plan.sizes[first.name] ?? first.usual_m) / first.usual_m;
  const sizes = row.sizes.flatMap(({ name, required, usual_m }) => {
    const value = plan.sizes[name] ?? usual_m * scale;
    return required || value > 0 ? [[name, Number(value.toFixed(6))] as const] : [];
  });
  return { shape: row.shape, ...Object.fromEntries(sizes), ...(row.turned && plan.clockwise ? { clockwise: true } : {}) } as Exercise;
}

/** Whether the line goes round, so that it may have laps. */
export function hasLaps(plan: Plan): boolean {
  const exercise = exerciseOf(plan);
  return exercise.shape === 'own' ? exercise.closed : rowOf(plan.task).closed;
}

/** How often the line is gone along. */
export const laps = (plan: Plan): number => (hasLaps(plan) && plan.task.ends.by === 'distance' ? plan.goal : 1);

export function pathOf(plan: Plan): GuidedPath {
  return { ...exerciseOf(plan), speed_m_s: plan.speed_m_s, ...(rowOf(plan.task).closed ? { laps: laps(plan) } : {}) } as GuidedPath;
}

export const requestOf = (plan: Plan): TaskRequest => ({
  task: plan.task.name,
  ...(Object.keys(plan.sizes).length > 0 ? { sizes: { ...plan.sizes } } : {}),
  ...(rowOf(plan.task).turned && plan.clockwise ? { clockwise: true } : {}),
  goal: plan.goal,
  repetitions: plan.repetitions,
  rest_s: plan.rest_s,
  ...(plan.own === null ? {} : { line: { name: plan.own.name, exercise: plan.own.exercise } }),
});

/** Whether this plan is chosen already: choosing it again would begin its repetitions anew. */
export function isChosen(plan: Plan, state: TaskState | null, exercise: Exercise): boolean {
  const mine = exerciseOf(plan);
  const alike = (a: Exercise, b: Exercise): boolean =>
    Object.entries(a).every(([name, value]) => {
      const other = (b as Record<string, unknown>)[name];
      if (Array.isArray(value)) return JSON.stringify(value) === JSON.stringify(other);
      return typeof value === 'number' && typeof other === 'number' ? Math.abs(value - other) < 1e-6 : value === other;
    });
  return (
    state !== null &&
    state.task === plan.task.name &&
    state.goal === plan.goal &&
    state.repetitions === plan.repetitions &&
    state.rest_s === plan.rest_s &&
    state.line === (plan.own?.name ?? null) &&
    alike(mine, exercise) &&
    alike(exercise, mine)
  );
}

export function length_m(plan: Plan): number {
  const points = patternPoints(exerciseOf(plan));
  let sum = 0;
  for (let i = 1; i < points.length; i++) sum += Math.hypot(points[i]!.x - points[i - 1]!.x, points[i]!.y - points[i - 1]!.y);
  return sum * laps(plan);
}

/** The share of the turning limit that the hoist takes in a curve (guided_path.hpp). */
const yawShare = 0.8;

function curveRadius_m(exercise: Exercise): number {
  if (exercise.shape === 'straight' || exercise.shape === 'own' || exercise.shape === 'free') return 0;
  if (exercise.shape === 'square') return exercise.corner_radius_m ?? 0;
  return exercise.shape === 'slalom' ? slalomCurve * exercise.spacing_m : exercise.radius_m;
}

/** The speed in the tightest curve, when it is below the chosen one; null when no curve slows the hoist. */
export function curveSpeed_m_s(plan: Plan, yawLimit_rad_s: number): number | null {
  const radius = curveRadius_m(exerciseOf(plan));
  if (radius <= 0 || yawLimit_rad_s <= 0) return null;
  const most = yawShare * yawLimit_rad_s * radius;
  return most < plan.speed_m_s - 0.005 ? most : null;
}

/** Duration in seconds without a release: the path, slower in curves, and the turns in sharp corners. */
export function duration_s(plan: Plan, yawLimit_rad_s: number): number {
  const ramp_s = 2;
  const { line } = plan.task;
  const exercise = exerciseOf(plan);
  const curve = curveSpeed_m_s(plan, yawLimit_rad_s);
  const curved = line === 'circle' || line === 'eight' || line === 'slalom';
  const speed = curved ? (curve ?? plan.speed_m_s) : plan.speed_m_s;
  const corners = exercise.shape === 'square' && (exercise.corner_radius_m ?? 0) === 0 ? 4 * laps(plan) : 0;
  const corner_s = yawLimit_rad_s > 0 ? Math.PI / 2 / (yawShare * yawLimit_rad_s) + 3 : 0;
  return length_m(plan) / speed + ramp_s + corners * corner_s;
}
