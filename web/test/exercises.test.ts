// Computed by the screen of tasks: the line as points, its floor space, the requests to the hoist.
import { readdirSync, readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import {
  adjustable,
  curveSpeed_m_s,
  duration_s,
  exerciseOf,
  hasLaps,
  isChosen,
  laps,
  length_m,
  pathOf,
  planOf,
  requestOf,
  speeds,
  stepped,
  withinCap,
  type Plan,
} from '../src/panels/exercises/plan';
import { exercises, usualExercise, usualOwnLine } from '../src/contract/exercises.gen';
import { modes } from '../src/contract/faults.gen';
import type { Line, Task, TaskState } from '../src/contract/rest.gen';
import { moving } from '../src/link/store';
import { floorSpace, patternPoints, polesOf } from '../src/ui/geometry';
import { tooSlow } from '../src/link/readiness';
import { phaseOf } from '../src/ui/task_strip';

const folder = new URL('../../db/tasks/', import.meta.url);
const tasks = readdirSync(folder).map((file) => JSON.parse(readFileSync(new URL(file, folder), 'utf8')) as Task);
const plan = (name: string, part: Partial<Plan> = {}): Plan => ({ ...planOf(tasks.find((task) => task.name === name)!), ...part });
const at = (task: Task, end: 'least' | 'most'): Plan => ({
  ...planOf(task),
  sizes: Object.fromEntries(Object.entries(task.sizes).map(([name, range]) => [name, range[end]])),
});

const usual = { ...usualExercise, own: usualOwnLine };
const yawLimit_rad_s = (30 * Math.PI) / 180;

describe('lines', () => {
  it('pass each pole of a slalom at half of their curve, on alternate sides', () => {
    for (const clockwise of [false, true]) {
      const slalom = { shape: 'slalom', spacing_m: 2, clockwise } as const;
      const line = patternPoints(slalom);
      const sides = polesOf(slalom).map((pole) => {
        const nearest = line.reduce((a, b) => (Math.hypot(a.x - pole.x, a.y - pole.y) < Math.hypot(b.x - pole.x, b.y - pole.y) ? a : b));
        expect(Math.hypot(nearest.x - pole.x, nearest.y - pole.y)).toBeCloseTo(2 * 0.57735 * 0.5, 3);
        return Math.sign(nearest.y - pole.y);
      });
      expect(sides).toEqual(clockwise ? [-1, 1, -1, 1] : [1, -1, 1, -1]);
    }
  });
  it('are drawn as long as the hoist walks them', () => {
    for (const { shape, usual_length_m } of exercises) {
      const points = patternPoints(usual[shape]);
      const drawn = points.slice(1).reduce((sum, to, i) => sum + Math.hypot(to.x - points[i]!.x, to.y - points[i]!.y), 0);
      // Arcs are drawn as chords, which are up to 0.1 % shorter.
      expect(Math.abs(drawn - usual_length_m), shape).toBeLessThanOrEqual(0.001 * usual_length_m);
    }
  });
  it('have no size that the hoist does not drive', () => {
    for (const task of tasks.filter(({ leads }) => leads.includes('guided')))
      for (const end of ['least', 'most'] as const) {
        const asked: Readonly<Record<string, unknown>> = { ...exerciseOf(at(task, end)) };
        for (const { name, required, driven_least_m, driven_most_m } of exercises.find(({ shape }) => shape === task.line)!.sizes) {
          if (!required && !(name in asked)) continue;
          expect(asked[name], `${task.name}.${name}`).toBeGreaterThanOrEqual(driven_least_m);
          expect(asked[name], `${task.name}.${name}`).toBeLessThanOrEqual(driven_most_m);
        }
      }
  });
  it('close, where the table says so, and keep their length when mirrored', () => {
    for (const { shape, closed, turned } of exercises.filter((row) => row.shape !== 'free')) {
      const left = patternPoints(usual[shape]);
      const right = patternPoints({ ...usual[shape], ...(turned ? { clockwise: true } : {}) });
      const [first, last] = [left[0]!, left.at(-1)!];
      const apart_m = Math.hypot(last.x - first.x, last.y - first.y);
      if (closed) expect(apart_m, shape).toBeCloseTo(0, 9);
      else expect(apart_m, shape).toBeGreaterThan(1);
      left.forEach((point, i) => {
        expect(right[i]!.x).toBeCloseTo(point.x);
        if (turned) expect(right[i]!.y).toBeCloseTo(-point.y);
      });
    }
  });
  it('have the length of the geometry', () => {
    expect(length_m(plan('square', { goal: 2 }))).toBeCloseTo(2 * 4 * 3.2);
    expect(length_m(plan('circle'))).toBeCloseTo(2 * Math.PI * 1.5, 1);
    expect(length_m(plan('square', { sizes: { side_m: 3.2, corner_radius_m: 0.5 } }))).toBeCloseTo(4 * 3.2 - (8 - 2 * Math.PI) * 0.5, 1);
  });
  it('keep the proportion that a task does not adjust', () => {
    expect(exerciseOf(plan('eight', { sizes: { c_m: 2 } }))).toEqual({ shape: 'eight', c_m: 2, radius_m: 1.6 });
    expect(exerciseOf(plan('turn_360'))).toEqual({ shape: 'free' });
  });
});

describe('the floor', () => {
  it('holds the figure with the hoist on it, in half metres', () => {
    expect(floorSpace({ shape: 'straight', length_m: 10 })).toEqual({ along_m: 11.5, across_m: 1.5 });
    expect(floorSpace({ shape: 'square', side_m: 3 })).toEqual({ along_m: 4.5, across_m: 4.5 });
    const eight = floorSpace({ shape: 'eight', c_m: 1, radius_m: 0.8 });
    expect(eight.along_m).toBeGreaterThanOrEqual(2 * 1.8 + 1.4);
    expect(eight.across_m).toBeGreaterThanOrEqual(1.6 + 1.4);
  });
});

describe('the wish', () => {
  it('says no more than its shape has', () => {
    expect(pathOf(plan('straight'))).toEqual({ shape: 'straight', length_m: 10, speed_m_s: 0.3 });
    expect(pathOf(plan('square'))).not.toHaveProperty('corner_radius_m');
    expect(pathOf(plan('square', { clockwise: true }))).toHaveProperty('clockwise', true);
    expect(requestOf(plan('turn_180'))).toEqual({ task: 'turn_180', goal: Math.PI, repetitions: 4, rest_s: 30 });
  });
  it('goes round as often as asked', () => {
    expect(pathOf(plan('eight', { goal: 3 }))).toHaveProperty('laps', 3);
    expect(laps(plan('straight'))).toBe(1);
  });
  it('steps on a grid and stops at its ends', () => {
    expect(stepped(speeds, 0.3, 1)).toBe(0.35);
    expect(stepped(speeds, 0.1, -1)).toBe(0.1);
    const goal = plan('eight').task.ends.goal;
    expect(stepped(goal, 20, 1)).toBe(20);
    expect(adjustable(goal)).toBe(true);
    expect(adjustable(plan('turn_180').task.ends.goal)).toBe(false);
  });
  it('keeps who leads where the next task allows it', () => {
    const next = (lead: Plan['lead']) => planOf(plan('turn_180').task, { lead, speed_m_s: 0.2 }).lead;
    expect([next('remote'), next('guided')]).toEqual(['remote', 'user']);
  });
  it('asks for no more speed than the patient may have', () => {
    expect(pathOf(withinCap(plan('straight', { speed_m_s: 0.5 }), 0.2275)).speed_m_s).toBe(0.2275);
    expect(withinCap(plan('straight'), 0.65)).toEqual(plan('straight'));
  });
  it('tells when a curve is slower than chosen', () => {
    expect(curveSpeed_m_s(plan('circle', { sizes: { radius_m: 0.5 }, speed_m_s: 0.6 }), yawLimit_rad_s)).toBeCloseTo(0.8 * yawLimit_rad_s * 0.5);
    expect(curveSpeed_m_s(plan('circle', { sizes: { radius_m: 3 } }), yawLimit_rad_s)).toBeNull();
    expect(curveSpeed_m_s(plan('straight'), yawLimit_rad_s)).toBeNull();
    expect(duration_s(plan('straight'), yawLimit_rad_s)).toBeCloseTo(10 / 0.3 + 2);
  });
});

const state: TaskState = {
  task: 'straight',
  version: 1,
  ends: 'distance',
  goal: 1,
  repetitions: 3,
  rest_s: 60,
  repetition: 0,
  begun_tick: null,
  reached: false,
  ended_tick: null,
  line: null,
};

const hall: Line = { id: 3, name: 'Hall', version: 1, saved_utc_ms: 0, exercise: usualOwnLine, length_m: 11.9, etag: 'a' };
const open = { ...hall, exercise: { ...usualOwnLine, closed: false } };
const own = (line: Line): Plan =>
  planOf(
    tasks.find((task) => task.line === 'own')!,
    { lead: 'guided', speed_m_s: 0.2 },
    line,
  );

describe('an own line', () => {
  it('is walked or driven, never led, with laps when it goes round', () => {
    expect(own(hall).lead).toBe('user');
    expect(own(hall).task.leads).toEqual(['user', 'remote']);
    expect(exerciseOf(own(hall))).toBe(usualOwnLine);
    expect([hasLaps(own(hall)), hasLaps(own(open))]).toEqual([true, false]);
    expect(laps({ ...own(hall), goal: 3 })).toBe(3);
    expect(length_m(own(hall))).toBeCloseTo(11.878, 1);
  });
  it('goes with its name and points to the hoist, and is not chosen twice', () => {
    expect(requestOf(own(hall))).toEqual({
      task: 'own_line',
      goal: 1,
      repetitions: 3,
      rest_s: 60,
      line: { name: 'Hall', exercise: usualOwnLine },
    });
    const chosen = { ...state, task: 'own_line', line: 'Hall' };
    expect(isChosen(own(hall), chosen, { ...usualOwnLine })).toBe(true);
    expect(isChosen(own(hall), { ...chosen, line: 'Hallway' }, usualOwnLine)).toBe(false);
    expect(isChosen(own(hall), chosen, { ...usualOwnLine, x_m: [0, 4, 4, 2, 0.1] })).toBe(false);
  });
});

describe('a chosen task', () => {
  it('is not chosen again by a start on it', () => {
    const straight = plan('straight');
    expect(isChosen(straight, state, { shape: 'straight', length_m: 10 })).toBe(true);
    expect(isChosen(straight, null, { shape: 'straight', length_m: 10 })).toBe(false);
    expect(isChosen(straight, state, { shape: 'straight', length_m: 9 })).toBe(false);
    expect(isChosen(straight, { ...state, rest_s: 30 }, { shape: 'straight', length_m: 10 })).toBe(false);
    const eight = plan('eight', { clockwise: true });
    expect(isChosen(eight, { ...state, task: 'eight' }, { shape: 'eight', c_m: 1, radius_m: 0.8 })).toBe(false);
  });
  it('says what there is to do now', () => {
    expect(phaseOf(state, 100, false).key).toBe('task.ready');
    expect(phaseOf({ ...state, repetition: 1, begun_tick: 100 }, 1100, true)).toEqual({ key: 'task.under', seconds: 10 });
    expect(phaseOf({ ...state, ends: 'time', goal: 120, repetition: 1, begun_tick: 100 }, 2100, true)).toEqual({ key: 'task.left', seconds: 100 });
    const ended = { ...state, repetition: 1, begun_tick: 100, reached: true, ended_tick: 2000 };
    // Reached while the hoist still ramps down.
    expect(phaseOf({ ...ended, ended_tick: null }, 1990, true)).toEqual({ key: 'task.resting', seconds: 60 });
    expect(phaseOf({ ...ended, ended_tick: null, repetition: 3 }, 1990, true).key).toBe('task.done');
    // Moved aside after its end.
    expect(phaseOf({ ...ended, ended_tick: null }, 5000, false).key).toBe('task.next');
    expect(phaseOf(ended, 3000, false)).toEqual({ key: 'task.resting', seconds: 50 });
    expect(phaseOf(ended, 8001, false).key).toBe('task.next');
    expect(phaseOf({ ...ended, repetition: 3 }, 3000, false).key).toBe('task.done');
    // Broken off before its end: the same repetition goes on.
    expect(phaseOf({ ...ended, reached: false }, 3000, false).key).toBe('task.broken');
  });
});

describe('leading by hand', () => {
  it('is locked when the connection is too slow, and only then', () => {
    expect([null, 0.08, 0.3, 0.301, 4].map((rtt_s) => tooSlow({ rtt_s }))).toEqual([false, false, false, true, true]);
  });
  it('is going on in the modes that the table calls moving', () => {
    expect(modes.filter((mode) => moving(mode.name)).map((mode) => mode.name)).toEqual(['user', 'remote', 'guided']);
  });
});
