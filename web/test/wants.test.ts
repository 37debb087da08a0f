import { describe, expect, it } from 'vitest';
import { Wants } from '../src/link/wants';

describe('what the page asks for', () => {
  it('is what its components show, at the highest rate, and the state always', () => {
    const wants = new Wants();
    expect(wants.choice).toEqual({ topics: ['state'], rate_hz: 5, every_tick: false });
    const end = wants.add('pose', 20);
    wants.add('motion', 1);
    wants.add('pose', 5);
    expect(wants.choice).toEqual({ topics: ['state', 'motion', 'pose'], rate_hz: 20, every_tick: false });
    end();
    expect(wants.choice).toEqual({ topics: ['state', 'motion', 'pose'], rate_hz: 5, every_tick: false });
    const endAll = wants.add('all', 2);
    expect(wants.choice.topics).toEqual(['all']);
    endAll();
    wants.everyTick(true);
    expect(wants.choice).toEqual({ topics: ['state', 'motion', 'pose'], rate_hz: 100, every_tick: true });
  });

  it('is told once for all components of a screen', async () => {
    const wants = new Wants();
    let told = 0;
    wants.onChange(() => told++);
    const end = wants.add('pose', 20);
    wants.add('motion', 5);
    end();
    expect(told).toBe(0);
    await Promise.resolve();
    expect(told).toBe(1);
    wants.everyTick(false);
    await Promise.resolve();
    expect(told).toBe(1);
  });
});
