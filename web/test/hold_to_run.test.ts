import { beforeEach, describe, expect, it } from 'vitest';
import { deadZone_norm, HoldToRun, keysWish, sendEach_ms, shape, takesKeys, zerosOnRelease } from '../src/ui/hold_to_run';

type Sent = { speed: number; yaw: number; held: boolean };
let sent: Sent[];
let ticking: { call: () => void; each_ms: number } | null;
let hold: HoldToRun;

beforeEach(() => {
  sent = [];
  ticking = null;
  hold = new HoldToRun((speed, yaw, held) => sent.push({ speed, yaw, held }), {
    every: (call, each_ms) => {
      ticking = { call, each_ms };
      return 1;
    },
    cancel: () => (ticking = null),
  });
});
const pass = (ticks: number) => {
  for (let i = 0; i < ticks; i++) ticking?.call();
};

describe('hold to run', () => {
  it('sends nothing before it is held, whatever moves', () => {
    hold.move(1, 1);
    hold.release();
    expect(sent).toEqual([]);
    expect(ticking).toBeNull();
  });

  it('sends at once and then 25 times a second while held, also when nothing moves', () => {
    hold.press(1, 0);
    expect(sent).toEqual([{ speed: 1, yaw: 0, held: true }]);
    expect(ticking!.each_ms).toBe(40);
    expect(sendEach_ms).toBe(40);
    pass(25);
    expect(sent).toHaveLength(26);
    expect(sent.every((one) => one.held && one.speed === 1)).toBe(true);
  });

  // H19: pointer lost, window left and tab hidden all end in this release.
  it('sends exactly three zeros at once on release and then nothing', () => {
    hold.press(1, -1);
    pass(3);
    sent = [];
    hold.release();
    expect(sent).toEqual(Array.from({ length: zerosOnRelease }, () => ({ speed: 0, yaw: 0, held: false })));
    expect(zerosOnRelease).toBe(3);
    expect(ticking).toBeNull();
    pass(5);
    hold.release();
    hold.release();
    expect(sent).toHaveLength(3);
  });

  it('does not carry an old wish into the next press', () => {
    hold.press(1, 1);
    hold.release();
    sent = [];
    hold.press(0, 0);
    pass(1);
    expect(sent).toEqual([
      { speed: 0, yaw: 0, held: true },
      { speed: 0, yaw: 0, held: true },
    ]);
  });

  it('runs one timer however often it is pressed', () => {
    hold.press(0.5, 0);
    const first = ticking;
    hold.press(1, 0);
    expect(ticking).toBe(first);
    pass(1);
    expect(sent.at(-1)).toEqual({ speed: 1, yaw: 0, held: true });
  });

  it('never sends what is not a number or beyond full', () => {
    hold.press(NaN, Infinity);
    hold.move(-7, 7);
    pass(1);
    for (const one of sent) {
      expect(Math.abs(one.speed)).toBeLessThanOrEqual(1);
      expect(Math.abs(one.yaw)).toBeLessThanOrEqual(1);
    }
    expect(sent[0]).toEqual({ speed: 0, yaw: 0, held: true });
    expect(sent[1]).toEqual({ speed: -1, yaw: 1, held: true });
  });
});

describe('Cmd', () => {
  it('takes the keys away, as it goes down and as long as it is held', () => {
    expect(takesKeys({ key: 'Meta', metaKey: true })).toBe(true);
    expect(takesKeys({ key: 'Meta', metaKey: false })).toBe(true);
    expect(takesKeys({ key: 'c', metaKey: true })).toBe(true);
    expect(takesKeys({ key: 'w', metaKey: false })).toBe(false);
  });
});

describe('shape', () => {
  it('is zero in the dead zone, continuous at its edge, full at full, and odd', () => {
    for (const value of [0, deadZone_norm, -deadZone_norm, deadZone_norm / 2]) expect(shape(value)).toBeCloseTo(0, 12);
    expect(shape(deadZone_norm + 1e-6)).toBeLessThan(1e-5);
    expect(shape(1)).toBe(1);
    let before = -Infinity;
    for (let value = -1.2; value <= 1.2; value += 0.01) {
      expect(shape(value)).toBeGreaterThanOrEqual(before);
      expect(shape(-value)).toBeCloseTo(-shape(value), 12);
      before = shape(value);
    }
  });
});

describe('keys', () => {
  it('turn left with A and the left arrow, right with D; opposite keys cancel', () => {
    expect(keysWish(['KeyA'])).toEqual({ speed: 0, yaw: 1 });
    expect(keysWish(['ArrowLeft'])).toEqual({ speed: 0, yaw: 1 });
    expect(keysWish(['KeyD'])).toEqual({ speed: 0, yaw: -1 });
    expect(keysWish(['KeyW', 'ArrowUp'])).toEqual({ speed: 1, yaw: 0 });
    expect(keysWish(['KeyW', 'KeyS'])).toEqual({ speed: 0, yaw: 0 });
    expect(keysWish(['KeyW', 'KeyA'])).toEqual({ speed: 1, yaw: 1 });
    expect(keysWish(['KeyQ'])).toEqual({ speed: 0, yaw: 0 });
  });
});
