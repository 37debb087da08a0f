import { describe, expect, it } from 'vitest';
import { Ring } from '../src/link/ring';

describe('Ring', () => {
  it('gives the newest values, oldest first, before and after it wraps', () => {
    const ring = new Ring(4);
    expect([...ring.latest()]).toEqual([]);
    expect(ring.last).toBeNaN();
    const all: number[] = [];
    for (let i = 0; i < 23; i++) {
      ring.push(i);
      all.push(i);
      for (let count = 0; count <= 6; count++)
        expect([...ring.latest(count)]).toEqual(all.slice(-4).slice(count >= 4 ? 0 : Math.max(0, Math.min(4, all.length) - count)));
      expect(ring.last).toBe(i);
      expect(ring.length).toBe(Math.min(4, i + 1));
    }
  });

  it('copies nothing: a window is a view', () => {
    const ring = new Ring(8);
    ring.push(1);
    expect(ring.latest().buffer).toBe(ring.latest(1).buffer);
  });

  it('forgets when cleared', () => {
    const ring = new Ring(3);
    [1, 2, 3, 4].forEach((value) => ring.push(value));
    ring.clear();
    expect(ring.length).toBe(0);
    ring.push(9);
    expect([...ring.latest()]).toEqual([9]);
  });

  it('refuses a size that holds nothing', () => {
    for (const size of [0, -1, 1.5, NaN]) expect(() => new Ring(size)).toThrow(RangeError);
  });
});
