import { describe, expect, it } from 'vitest';
import { figure, initial, unknown } from '../src/link/store';

describe('what the hoist does', () => {
  it('is unknown once nothing is heard of it, and not before the first try', () => {
    expect(unknown(initial)).toBe(false);
    expect(unknown({ ...initial, link: 'open', everOpen: true, coreConnected: true })).toBe(false);
    expect(unknown({ ...initial, link: 'open', everOpen: true, coreConnected: false })).toBe(true);
    expect(unknown({ ...initial, link: 'lost', everOpen: true })).toBe(true);
    expect(unknown({ ...initial, link: 'open', everOpen: true, data: 'late' })).toBe(false);
    expect(unknown({ ...initial, link: 'open', everOpen: true, data: 'gone' })).toBe(true);
  });
});

describe('the figure on the floor', () => {
  const square = { shape: 'square', side_m: 3, speed_m_s: 0.3 } as const;
  it('is what the motion began with on whatever screen, on standby the chosen one, and none when nobody knows', () => {
    for (const mode of ['user', 'remote', 'guided'] as const) {
      expect(figure({ ...initial, mode, begun: square })).toBe(square);
      expect(figure({ ...initial, mode, begun: null })).toEqual({ shape: 'free' });
    }
    expect(figure({ ...initial, mode: 'standby', begun: square })).toBe(initial.exercise);
  });
});
