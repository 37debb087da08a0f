// Numbers of a study as the page shows them.
import { describe, expect, it } from 'vitest';
import type { Study } from '../src/contract/rest.gen';
import { readWhole, runMark, sessionOf } from '../src/panels/study/model';

describe('a study', () => {
  it('is asked for with whole numbers in range only', () => {
    expect(readWhole(' 11 ', 1, 99)).toBe(11);
    expect(readWhole('0', 0, 99)).toBe(0);
    for (const text of ['', '0', '100', '1.5', '-1', 'x', '1e3', '99999999999']) expect(readWhole(text, 1, 99), text).toBeNull();
  });

  it('marks the runs that the patient leads, as the paper does', () => {
    expect(runMark({ run: 3, shape: 'eight', led_by: 'patient', injured: false })).toBe('3*');
    expect(runMark({ run: 1, shape: 'square', led_by: 'therapist', injured: false })).toBe('1');
  });

  it('leads to a session of its subject and run while it is there', () => {
    const study = { sessions: [{ session: 7, subject: 'S01', run: 2 }] } as unknown as Study;
    expect(sessionOf(study, 'S01', 2)).toBe(7);
    expect(sessionOf(study, 'S01', 3)).toBeNull();
    expect(sessionOf(study, 'S02', 2)).toBeNull();
  });
});
