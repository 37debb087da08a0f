import { describe, expect, it } from 'vitest';
import { signals, type TickRecord } from '../src/contract/signals.gen';
import type { GapMessage, WalkMessage } from '../src/contract/messages.gen';
import { modes } from '../src/contract/faults.gen';
import { Live } from '../src/link/live';
import { Trace } from '../src/link/trace';
import { activeFaults } from '../src/ui/alarms';
import { wishArrow } from '../src/ui/hoist_picture';
import { fit, onScreen, patternPoints } from '../src/ui/geometry';
import type { Samples } from '../src/contract/rest.gen';
import { zigzag, pathOf } from '../src/panels/sessions/model';

const record = (change: Partial<TickRecord>): TickRecord => ({
  ...(Object.fromEntries(signals.map((row) => [row.name, 0])) as TickRecord),
  ...change,
});
const take = (live: Live, samples: TickRecord[]) => live.take(samples, ['all'], 0);
const gap = (change: Partial<GapMessage>): GapMessage => ({ type: 'gap', from_tick: 0, to_tick: 0, count: 0, reason: 'slow_client', ...change });
const user = modes.find((mode) => mode.name === 'user')!.value;

const walk = (change: Partial<WalkMessage>): WalkMessage => ({
  type: 'walk',
  exercise: { shape: 'free' },
  begun: null,
  task: null,
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
    take(there, steps.slice(0, 7000));
    expect(there.path.step_m).toBeCloseTo(0.04);
    // The server's walk by the same rule; a frame still in transit counts once.
    reloaded.takeWalk(walk({ tick: 7000, motion_s: there.motion_s, mark, step_m: there.path.step_m, x_m: there.path.x, y_m: there.path.y }));
    take(reloaded, steps.slice(6997, 7000));
    for (const live of [there, reloaded]) take(live, steps.slice(7000));
    expect(reloaded.path.x).toEqual(there.path.x);
    expect(reloaded.path.y).toEqual(there.path.y);
    expect(there.path.x.length).toBeLessThan(2048);
    expect(reloaded.motion_s).toBeCloseTo(there.motion_s, 6);
    expect(there.motion_s).toBeCloseTo(89.99, 6);
  });

  // The hoist's own count begins anew only with the next start.
  it('shows nothing of the walk before once the server tells of another patient', () => {
    const live = new Live();
    live.takeWalk(walk({ tick: 0, motion_s: 0, mark, x_m: [0], y_m: [0] }));
    const steps = [1, 2, 3].map((tick) => record({ tick, time_ns: tick * 1e7, fused_x_m: tick, distance_m: tick, mode: user }));
    take(live, steps);
    expect(live.walked_m(steps[2]!)).toBe(3);
    live.takeWalk(walk({ tick: 3, motion_s: 0, mark: { ...mark, x_m: 3 }, x_m: [3], y_m: [0] }));
    expect(live.path.x).toEqual([3]);
    expect(live.walked_m(steps[2]!)).toBe(0);
    expect(new Live().walked_m(steps[2]!), 'how long it has walked is not known').toBe(3);
  });

  it('restarts at the start mark of the server, not by itself', () => {
    const live = new Live();
    live.takeWalk(walk({ tick: 0, motion_s: 0, mark, x_m: [0], y_m: [0] }));
    take(live, [record({ tick: 1, fused_x_m: 1 }), record({ tick: 2, fused_x_m: 5 })]);
    expect(live.path.x).toEqual([0, 1, 5]);
    live.takeWalk(walk({ tick: 2, motion_s: 0, mark, x_m: [-1.6], y_m: [0] }));
    expect(live.path.x).toEqual([-1.6]);
  });

  it('keeps what it has when a server comes back that knows less, and nothing of another core', () => {
    const live = new Live();
    live.takeWalk(walk({ tick: 0, motion_s: 7, mark, x_m: [0], y_m: [0] }));
    take(live, [record({ tick: 900, fused_x_m: 1 })]);
    live.takeWalk(walk({ tick: 950, x_m: [1], y_m: [0] }));
    expect(live.path.x).toEqual([0, 1]);
    expect(live.motion_s).toBe(7);
    live.takeWalk(walk({ tick: 3, motion_s: 0, mark, x_m: [2], y_m: [0] }));
    take(live, [record({ tick: 4, fused_x_m: 2 })]);
    expect(live.path.x).toEqual([2]);
    expect(live.motion_s).toBe(0);
  });

  it('counts what the server names as missing, and starts over with a new core', () => {
    const live = new Live();
    take(live, [record({ tick: 10 }), record({ tick: 15 })]);
    expect(live.lost).toBe(0); // between two samples of a lower rate nothing is missing
    live.takeGap(gap({ from_tick: 16, to_tick: 20, count: 5 }));
    expect([live.lost, live.newestTick]).toEqual([5, 20]);
    live.takeGap(gap({ from_tick: 21, to_tick: null, count: null, reason: 'core_restarted' }));
    take(live, [record({ tick: 2, fused_x_m: 3 })]);
    expect([live.lost, live.newestTick]).toEqual([5, 2]);
    expect(live.path.x).toEqual([3]);
  });

  it('does not join the path over a gap, but over what the server has counted', () => {
    const live = new Live();
    live.takeWalk(walk({ tick: 0, motion_s: 0, mark, x_m: [0], y_m: [0] }));
    take(live, [record({ tick: 1, fused_x_m: 1 }), record({ tick: 6, fused_x_m: 2 })]);
    live.takeGap(gap({ from_tick: 7, to_tick: 40, count: 34 }));
    take(live, [record({ tick: 41, fused_x_m: 9 })]);
    expect(live.path.x).toEqual([0, 1, 2, NaN, 9]);
    live.takeWalk(walk({ tick: 60, motion_s: 0, mark, x_m: [0, 5, 10], y_m: [0, 0, 0] }));
    live.takeGap(gap({ from_tick: 42, to_tick: 60, count: 19, reason: 'too_old' }));
    take(live, [record({ tick: 61, fused_x_m: 11 })]);
    expect(live.path.x).toEqual([0, 5, 10, 11]);
  });

  it('keeps gaps when the path is thinned', () => {
    const trace = new Trace();
    for (let i = 0; i < 3000; i++) {
      if (i === 1000 || i === 1100) trace.lift(); // at an even and at an odd place
      trace.add(i * 0.021, 0);
    }
    const gaps = trace.x.flatMap((x, i) => (Number.isNaN(x) ? [i] : []));
    expect(gaps).toHaveLength(2);
    expect(trace.y.flatMap((y, i) => (Number.isNaN(y) ? [i] : []))).toEqual(gaps);
    for (const [gap, at] of [
      [gaps[0]!, 1000 * 0.021],
      [gaps[1]!, 1100 * 0.021],
    ] as const)
      expect([trace.x[gap - 1]! < at, trace.x[gap + 1]! >= at]).toEqual([true, true]);
  });

  it('shows no value that is not received: after another choice, and where positions are not followed', () => {
    const live = new Live();
    const { tick, time_ns, speed_m_s } = record({ tick: 1, speed_m_s: 0.5 });
    live.take([{ ...record({}), tick, time_ns, speed_m_s }], ['state', 'motion'], 0);
    expect(live.with('motion')?.speed_m_s).toBe(0.5);
    expect(live.with('state')).not.toBeNull();
    expect(live.with('pose')).toBeNull();
    expect(live.with('motion', 'pose')).toBeNull();
    expect(live.with('all')).toBeNull();
    live.take([record({ tick: 2 })], ['all'], 0);
    expect(live.with('motion', 'pose')).not.toBeNull();
    expect(live.with('all')).not.toBeNull();
  });

  it('counts the time of a mode to its end at any rate', () => {
    const live = new Live();
    live.takeWalk(walk({ tick: 100, motion_s: 2, mark, x_m: [0], y_m: [0] }));
    const at = (tick: number, mode = 0) => record({ tick, time_ns: tick * 1e7, mode });
    take(live, [at(98, user), at(118, user), at(138, user), at(145), at(158)]);
    // 101 to 144: the server has counted up to 100, and from 145 on the mode is another one.
    expect(live.motion_s).toBeCloseTo(2.44, 9);
  });

  it('counts time in motion only, and does not claim a time that nobody told', () => {
    const live = new Live();
    take(live, [record({ tick: 1, time_ns: 1e9, mode: user }), record({ tick: 2, time_ns: 2e9, mode: user })]);
    expect(live.motion_s).toBeNaN();
    live.takeWalk(walk({ tick: 2, motion_s: 0, mark, x_m: [0], y_m: [0] }));
    take(live, [record({ tick: 3, time_ns: 5.5e9, mode: user }), record({ tick: 4, time_ns: 9e9 }), record({ tick: 5, time_ns: 20e9, mode: user })]);
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
    // Its tip is seen at full lean, too: the picture ends at -92 and 80.
    expect(end(wishArrow(1, 0, -72))[1]).toBe(-8);
    expect(end(wishArrow(-1, 0, 44))[1]).toBe(24);
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
