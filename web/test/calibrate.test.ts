import { describe, expect, it } from 'vitest';
import { entry, nowKey, resultOf, stepNames, stepsFor, watched, type Now } from '../src/panels/calibrate/model';
import type { Calibration, CalibrationItem, CalibrationStep } from '../src/contract/rest.gen';
import { textOf } from '../src/text/text';

const now = (change: Partial<Now>): Now => ({ step: 'zero', phase: 'operator', done_percent: 0, reason: 0, value: 0, ...change });
const step = (name: CalibrationStep, role: CalibrationItem['role']): CalibrationItem => ({
  name,
  role,
  entered: null,
  empty_harness: false,
  title: { en: name, de: name },
  action: { en: '', de: '' },
  done_utc_s: null,
});

describe('the Calibrate screen', () => {
  it('shows a therapist only what is theirs', () => {
    const items = [step('zero', 'therapist'), step('track', 'engineer'), step('bumpers', 'therapist')];
    expect(stepsFor(items, 'therapist').map((item) => item.name)).toEqual(['zero', 'bumpers']);
    expect(stepsFor(items, 'viewer').map((item) => item.name)).toEqual(['zero', 'bumpers']);
    expect(stepsFor(items, 'engineer')).toHaveLength(3);
  });

  it('says at every moment of every step what to do, in words that exist', () => {
    for (const name of stepNames.slice(1))
      for (const phase of ['resting', 'measuring', 'operator', 'result'] as const)
        for (const done_percent of [0, 33, 50, 66, 90]) {
          const key = nowKey(now({ step: name, phase, done_percent }));
          if (phase !== 'operator' || !['zero', 'neutral', 'gyro'].includes(name))
            expect(key === null ? null : textOf(key), `${name} ${phase}`).not.toBeNull();
        }
    expect(nowKey(now({ step: 'bumpers', value: 2 }))).toBe('calibrate.press.left');
    expect(nowKey(now({ step: 'struts', value: 1 }))).toBe('calibrate.now.strutsRight');
    expect(nowKey(now({ step: 'struts', value: 1, phase: 'resting' }))).toBe('calibrate.now.strutsBack');
    const bar = (name: Now['step']) => [0, 33, 66].map((done_percent) => nowKey(now({ step: name, done_percent })));
    expect(bar('strut_length')).toEqual(['calibrate.now.barForward', 'calibrate.now.barFurther', 'calibrate.now.barBack']);
    expect(bar('strut_spacing')).toEqual(['calibrate.now.barLeft', 'calibrate.now.barLeftFurther', 'calibrate.now.barRight']);
    expect(nowKey(now({ phase: 'refused' }))).toBeNull();
  });

  it('has a result only of the step under way, and only when it is one', () => {
    const result = [{ name: 'wheel_radius_m' as const, value: 0.098, before: 0.1 }];
    const table = (under_way: Pick<NonNullable<Calibration['under_way']>, 'step' | 'phase' | 'result'> | null): Calibration => ({
      valid: true,
      items: [],
      reasons: [],
      under_way: under_way === null ? null : { ...under_way, done_percent: 0, value: 0, reason: null },
    });
    expect(resultOf(table({ step: 'zero', phase: 'result', result }), 'zero')).toBe(result);
    expect(resultOf(table({ step: 'zero', phase: 'result', result: [] }), 'zero')).toEqual([]);
    expect(resultOf(table({ step: 'zero', phase: 'measuring', result: [] }), 'zero')).toBeNull();
    expect(resultOf(table({ step: 'gyro', phase: 'result', result }), 'zero')).toBeNull();
    expect(resultOf(table(null), 'zero')).toBeNull();
  });

  it('asks in the units of a tape and sends SI', () => {
    expect(entry('track').factor).toBeCloseTo(2 * Math.PI);
    expect(entry('strut_spacing').factor).toBeCloseTo(Math.PI / 180);
    expect(entry('wheel_radius')).toEqual({ factor: 1, unit: 'm' });
    expect(watched(now({ step: 'track', value: 4 * Math.PI }))?.value).toBeCloseTo(2);
    expect(watched(now({ step: 'square' }))).toBeNull();
  });
});
