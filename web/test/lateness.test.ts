import { describe, expect, it } from 'vitest';
import { columnOf, columns, columnsOf, heightsOf, placeOf } from '../src/panels/health/lateness';

describe('the picture of late steps', () => {
  it('puts every time into a column, earliest first', () => {
    expect(columnOf(0)).toBe(0);
    expect(columnOf(1e-6)).toBe(0);
    expect(columnOf(2e-6)).toBe(1);
    expect(columnOf(1e-3)).toBe(9);
    expect(columnOf(15)).toBe(columns - 1);
  });

  it('loses no step', () => {
    const counts = columnsOf([
      { from_s: 0, to_s: 1e-6, count: 3 },
      { from_s: 1e-4, to_s: 1.2e-4, count: 5 },
      { from_s: 1.2e-4, to_s: 1.5e-4, count: 7 },
      { from_s: 14, to_s: null, count: 1 },
    ]);
    expect(counts.reduce((sum, count) => sum + count, 0)).toBe(16);
    expect(counts[6]).toBe(12);
    expect(counts[columns - 1]).toBe(1);
  });

  it('shows one late step beside a million punctual ones', () => {
    const heights = heightsOf([1_000_000, 0, 1]);
    expect(heights[0]).toBe(1);
    expect(heights[1]).toBe(0);
    expect(heights[2]).toBeGreaterThan(0.04);
    expect(heightsOf([0, 0])).toEqual([0, 0]);
  });

  it('places a time between the edges', () => {
    expect(placeOf(1e-9)).toBe(0);
    expect(placeOf(1e-6)).toBe(0);
    expect(placeOf(100)).toBe(1);
    expect(placeOf(1e-3)).toBeGreaterThan(placeOf(9e-4));
  });
});
