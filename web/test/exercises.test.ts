// Computed by the exercises' screen: the figure as points, its floor space, the request to the hoist.
import { describe, expect, it } from 'vitest';
import { curveSpeed_m_s, duration_s, exerciseOf, firstPlan, length_m, pathOf, shapes, stepped, steps, withinCap } from '../src/panels/exercises/plan';
import { exercises, usualExercise } from '../src/contract/exercises.gen';
import { modes } from '../src/contract/faults.gen';
import { moving } from '../src/link/store';
import { floorSpace, patternPoints } from '../src/ui/geometry';
import { tooSlow } from '../src/link/readiness';

/** Of both ends of the buttons: the sizes of the request by name. */
const requested = (shape: (typeof shapes)[number], end: 'least' | 'most'): Readonly<Record<string, unknown>> => ({
  ...pathOf({
    ...firstPlan,
    shape,
    length_m: steps.length_m[end],
    side_m: steps.side_m[end],
    radius_m: steps.radius_m[end],
    eight_m: steps.eight_m[end],
  }),
});

const yawLimit_rad_s = (30 * Math.PI) / 180;

describe('figures', () => {
  it('are drawn as long as the hoist walks them', () => {
    for (const { shape, usual_length_m } of exercises) {
      const points = patternPoints(usualExercise[shape]);
      const drawn = points.slice(1).reduce((sum, to, i) => sum + Math.hypot(to.x - points[i]!.x, to.y - points[i]!.y), 0);
      // Arcs are drawn as chords, which are up to 0.1 % shorter.
      expect(Math.abs(drawn - usual_length_m), shape).toBeLessThanOrEqual(0.001 * usual_length_m);
    }
  });
  it('offers no size that the hoist does not drive', () => {
    for (const { shape, sizes } of exercises) {
      if (shape === 'free') continue;
      for (const { name, required, driven_least_m, driven_most_m } of sizes) {
        if (!required) continue;
        expect(requested(shape, 'least')[name], `${shape}.${name}`).toBeGreaterThanOrEqual(driven_least_m);
        expect(requested(shape, 'most')[name], `${shape}.${name}`).toBeLessThanOrEqual(driven_most_m);
      }
    }
  });
  it('close, except the straight, and keep their length when mirrored', () => {
    for (const shape of shapes) {
      const left = patternPoints(exerciseOf({ ...firstPlan, shape }));
      const right = patternPoints(exerciseOf({ ...firstPlan, shape, clockwise: true }));
      const [first, last] = [left[0]!, left.at(-1)!];
      if (shape === 'straight') expect(Math.hypot(last.x - first.x, last.y - first.y)).toBeCloseTo(firstPlan.length_m);
      else expect(Math.hypot(last.x - first.x, last.y - first.y)).toBeLessThan(1e-9);
      left.forEach((point, i) => {
        expect(right[i]!.x).toBeCloseTo(point.x);
        if (shape !== 'straight') expect(right[i]!.y).toBeCloseTo(-point.y);
      });
    }
  });
  it('have the length of the geometry', () => {
    expect(length_m({ ...firstPlan, shape: 'square', laps: 2 })).toBeCloseTo(2 * 4 * firstPlan.side_m);
    expect(length_m({ ...firstPlan, shape: 'circle' })).toBeCloseTo(2 * Math.PI * firstPlan.radius_m, 1);
    const rounded = length_m({ ...firstPlan, shape: 'square', round: true });
    expect(rounded).toBeCloseTo(4 * firstPlan.side_m - (8 - 2 * Math.PI) * 0.5, 1);
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
    expect(pathOf(firstPlan)).toEqual({ shape: 'straight', length_m: 10, speed_m_s: 0.3 });
    expect(pathOf({ ...firstPlan, shape: 'square' })).not.toHaveProperty('corner_radius_m');
    expect(pathOf({ ...firstPlan, shape: 'square', round: true })).toHaveProperty('corner_radius_m', 0.5);
  });
  it('steps on a grid and stops at its ends', () => {
    expect(stepped(steps.speed_m_s, 0.3, 1)).toBe(0.35);
    expect(stepped(steps.speed_m_s, 0.1, -1)).toBe(0.1);
    expect(stepped(steps.laps, 20, 1)).toBe(20);
  });
  it('asks for no more speed than the patient may have', () => {
    expect(pathOf(withinCap({ ...firstPlan, speed_m_s: 0.5 }, 0.2275)).speed_m_s).toBe(0.2275);
    expect(withinCap(firstPlan, 0.65)).toEqual(firstPlan);
  });
  it('tells when a curve is slower than chosen', () => {
    expect(curveSpeed_m_s({ ...firstPlan, shape: 'circle', radius_m: 0.4, speed_m_s: 0.6 }, yawLimit_rad_s)).toBeCloseTo(0.8 * yawLimit_rad_s * 0.4);
    expect(curveSpeed_m_s({ ...firstPlan, shape: 'circle', radius_m: 3 }, yawLimit_rad_s)).toBeNull();
    expect(curveSpeed_m_s(firstPlan, yawLimit_rad_s)).toBeNull();
    expect(duration_s({ ...firstPlan, shape: 'straight' }, yawLimit_rad_s)).toBeCloseTo(10 / 0.3 + 2);
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
