import { describe, expect, it } from 'vitest';
import { signals, type TickRecord } from '../src/contract/signals.gen';
import type { WalkMessage } from '../src/contract/messages.gen';
import { modes } from '../src/contract/faults.gen';
import { Live } from '../src/link/live';
import { activeFaults } from '../src/ui/alarms';
import { wishArrow } from '../src/ui/hoist_picture';
import { fit, onScreen, patternPoints } from '../src/ui/geometry';
import type { Samples } from '../src/contract/rest.gen';
import { zigzag, pathOf } from '../src/panels/sessions/model';

const record = (change: Partial<TickRecord>): TickRecord => ({
  ...(Object.fromEntries(signals.map((row) => [row.name, 0])) as TickRecord),
  ...change,
});
const user = modes.find((mode) => mode.name === 'user')!.value;

const walk = (change: Partial<WalkMessage>): WalkMessage => ({
  type: 'walk',
  exercise: { shape: 'free' },
  begun: null,
  tick: null,
  motion_s: null,
  mark: null,
  step_m: 0.02,
  x_m: [],
  y_m: [],
  ...change,
});
const mark = { x_m: 0, y_m: 0, psi_rad: 0 };

describe('Live', () => {
  it('shows the same walk on a screen that was there and on one that was loaded in the middle', () => {
    const there = new Live();
    const reloaded = new Live();
    there.takeWalk(walk({ tick: 0, motion_s: 0, mark, x_m: [0], y_m: [0] }));
    const steps = Array.from({ length: 9000 }, (_, i) =>
      record({ tick: i + 1, time_ns: (i + 1) * 1e7, fused_x_m: 0.007 * (i + 1), fused_y_m: Math.sin(i / 300), mode: user }),
    );
    there.take(steps.slice(0, 7000), 0);
    expect(there.path.step_m).toBeCloseTo(0.04);
    // The server's walk by the same rule; a frame still in transit counts once.
    reloaded.takeWalk(walk({ tick: 7000, motion_s: there.motion_s, mark, step_m: there.path.step_m, x_m: there.path.x, y_m: there.path.y }));
    reloaded.take(steps.slice(6997, 7000), 0);
    for (const live of [there, reloaded]) live.take(steps.slice(7000), 0);
    expect(reloaded.path.x).toEqual(there.path.x);
    expect(reloaded.path.y).toEqual(there.path.y);
    expect(there.path.x.length).toBeLessThan(2048);
    expect(reloaded.motion_s).toBeCloseTo(there.motion_s, 6);
    expect(there.motion_s).toBeCloseTo(89.99, 6);
  });

  it('restarts at the start mark of the server, not by itself', () => {
    const live = new Live();
    live.takeWalk(walk({ tick: 0, motion_s: 0, mark, x_m: [0], y_m: [0] }));
    live.take([record({ tick: 1, fused_x_m: 1 }), record({ tick: 2, fused_x_m: 5 })], 0);
    expect(live.path.x).toEqual([0, 1, 5]);
    live.takeWalk(walk({ tick: 2, motion_s: 0, mark, x_m: [-1.6], y_m: [0] }));
    expect(live.path.x).toEqual([-1.6]);
  });

  it('keeps what it has when a server comes back that knows less, and nothing of another core', () => {
    const live = new Live();
    live.takeWalk(walk({ tick: 0, motion_s: 7, mark, x_m: [0], y_m: [0] }));
    live.take([record({ tick: 900, fused_x_m: 1 })], 0);
    live.takeWalk(walk({ tick: 950, x_m: [1], y_m: [0] }));
    expect(live.path.x).toEqual([0, 1]);
    expect(live.motion_s).toBe(7);
    live.takeWalk(walk({ tick: 3, motion_s: 0, mark, x_m: [2], y_m: [0] }));
    live.take([record({ tick: 4, fused_x_m: 2 })], 0);
    expect(live.path.x).toEqual([2]);
    expect(live.motion_s).toBe(0);
  });

  it('counts steps that did not arrive, and starts over with a new core', () => {
    const live = new Live();
    live.take([record({ tick: 10 }), record({ tick: 11 }), record({ tick: 15 })], 0);
    expect(live.lost).toBe(3);
    live.take([record({ tick: 2 })], 0);
    expect(live.lost).toBe(3);
    expect(live.history.speed_m_s.length).toBe(1);
  });

  it('counts time in motion only, and does not claim a time that nobody told', () => {
    const live = new Live();
    live.take([record({ tick: 1, time_ns: 1e9, mode: user }), record({ tick: 2, time_ns: 2e9, mode: user })], 0);
    expect(live.motion_s).toBeNaN();
    live.takeWalk(walk({ tick: 2, motion_s: 0, mark, x_m: [0], y_m: [0] }));
    live.take(
      [record({ tick: 3, time_ns: 5.5e9, mode: user }), record({ tick: 4, time_ns: 9e9 }), record({ tick: 5, time_ns: 20e9, mode: user })],
      0,
    );
    expect(live.motion_s).toBeCloseTo(3.5, 9);
    const late = new Live();
    late.takeWalk(walk({ tick: 9, x_m: [0], y_m: [0] }));
    expect(late.motion_s).toBeNaN();
  });
});

describe('alarms', () => {
  it('come most important first, and only those that are on', () => {
    expect(activeFaults(0)).toEqual([]);
    const rank = { high: 0, medium: 1, low: 2 };
    const all = activeFaults(2 ** 53 - 1);
    for (let i = 1; i < all.length; i++) expect(rank[all[i]!.priority]).toBeGreaterThanOrEqual(rank[all[i - 1]!.priority]);
    expect(activeFaults(0b10)).toMatchObject([{ bit: 1 }]);
  });
});

describe('the arrow of the wish', () => {
  it('is absent at rest, points up when leaning forward, down when leaning back, left for a left turn', () => {
    const end = (path: string) => path.split(' ').slice(-2).map(Number) as [number, number];
    expect(wishArrow(0, 0)).toBe('');
    expect(end(wishArrow(1, 0))[1]).toBeLessThan(-50);
    expect(end(wishArrow(-1, 0))[1]).toBeGreaterThan(50);
    expect(end(wishArrow(0.5, 0.5))[0]).toBeLessThan(-10);
    expect(end(wishArrow(0.5, -0.5))[0]).toBeGreaterThan(10);
  });
});

describe('the planned figures', () => {
  const length = (points: { x: number; y: number }[]) =>
    points.slice(1).reduce((sum, point, i) => sum + Math.hypot(point.x - points[i]!.x, point.y - points[i]!.y), 0);

  it('have their exact lengths', () => {
    expect(length(patternPoints({ shape: 'square', side_m: 3.2 }))).toBeCloseTo(12.8, 9);
    expect(length(patternPoints({ shape: 'straight', length_m: 10 }))).toBeCloseTo(10, 9);
    const slope = Math.asin(0.8);
    const exact = 4 * 0.6 + 2 * 0.8 * (Math.PI + 2 * slope);
    const drawn = length(patternPoints({ shape: 'eight', c_m: 1, radius_m: 0.8 }));
    expect(drawn).toBeLessThan(exact);
    expect(drawn).toBeGreaterThan(exact * 0.998);
    expect(patternPoints({ shape: 'free' })).toEqual([]);
    expect(patternPoints({ shape: 'eight', c_m: 0.5, radius_m: 0.8 })).toEqual([]);
  });

  it('turn right first on the eight and left on the square', () => {
    const eight = patternPoints({ shape: 'eight', c_m: 1, radius_m: 0.8 });
    expect(eight[1]!.x).toBeGreaterThan(0);
    expect(eight[1]!.y).toBeGreaterThan(0);
    expect(eight[40]!.y).toBeLessThan(0);
    const square = patternPoints({ shape: 'square', side_m: 2 });
    expect(square[0]).toEqual({ x: -1, y: -1 });
    expect(square[2]).toEqual({ x: 1, y: 1 });
  });

  it('show a hoist that drives forward from its start mark going up, and one that turns left going left, as the joystick does', () => {
    const frame = fit([], 300, 300);
    const start = onScreen({ x: 0, y: 0 }, frame, 300, 300);
    expect(onScreen({ x: 1, y: 0 }, frame, 300, 300)).toEqual({ left: start.left, top: start.top - 100 });
    expect(onScreen({ x: 0, y: 1 }, frame, 300, 300)).toEqual({ left: start.left - 100, top: start.top });
  });

  it('fit the frame, whatever is not a number', () => {
    const frame = fit(
      [
        { x: -2, y: 0 },
        { x: 2, y: 1 },
        { x: NaN, y: 3 },
      ],
      400,
      500,
    );
    expect(frame.centre_x).toBe(0);
    expect(frame.pixels_per_m).toBe(100);
    expect(fit([], 300, 300)).toEqual({ centre_x: 0, centre_y: 0, pixels_per_m: 100 });
  });
});

describe('thinned samples', () => {
  const samples: Samples = {
    from_s: [0, 1, 2],
    to_s: [0.5, 1.5, 2],
    gap_before: [0, 0, 0],
    columns: [
      { name: 'x_m', unit: 'm', min: [0, 1, 3], max: [2, 3, 3] },
      { name: 'y_m', unit: 'm', min: [0, 2, 1], max: [0, 4, 1] },
    ],
  };
  it('become a curve through smallest and largest, with nothing for a column that was not recorded', () => {
    expect(zigzag(samples, ['x_m', 'y_m'])).toEqual([
      [0, 0.5, 1, 1.5, 2],
      [0, 2, 1, 3, 3],
      [0, 0, 2, 4, 1],
    ]);
    expect(zigzag(samples, ['speed_m_s'])[1]).toEqual([null, null, null, null, null]);
  });
  it('become a path through the middle of each run', () => {
    expect(pathOf(samples)).toEqual({ x: [1, 2, 3], y: [0, 3, 1] });
  });
});
