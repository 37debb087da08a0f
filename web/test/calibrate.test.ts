import { describe, expect, it } from 'vitest';
import { directed, entry, nowKey, resultOf, stepNames, stepsFor, watched, type Now } from '../src/panels/calibrate/model';
import type { Calibration, CalibrationItem, CalibrationStep } from '../src/contract/rest.gen';
import { calibrate } from '../src/text/calibrate';
import { de } from '../src/text/de';
import { en } from '../src/text/en';
import { textOf } from '../src/text/text';
import { eachPage, minutes_ms } from '../test-support/browser';

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

  it('takes a size with its chosen direction, with or without a minus', () => {
    expect(['2,5', '-2.5', '0'].map((text) => directed(text, true))).toEqual([-2.5, -2.5, -0]);
    expect(['2,5', '0'].map((text) => directed(text, false))).toEqual([2.5, 0]);
    for (const [text, reversed] of [
      ['-2', false],
      ['', true],
      ['far', true],
    ] as const)
      expect(directed(text, reversed), text).toBeNaN();
  });
});

describe('a typed size on a phone', { timeout: minutes_ms }, () => {
  const start = eachPage(360, 640);
  it('brings into view why it is refused', async () => {
    const { fake, page } = await start({}, 'de');
    await page.goto(`${fake.url}#/calibrate/square`);
    await page.locator('.mode-standby').waitFor();
    const words = calibrate.de;
    const seen = async (text: string) => {
      const [box, main] = [await page.locator('main').getByText(text).boundingBox(), await page.locator('main').boundingBox()];
      return box !== null && box.y >= main!.y - 1 && box.y + box.height <= main!.y + main!.height + 1;
    };
    await page.getByRole('button', { name: words['calibrate.start'], exact: true }).click();
    await page.locator('input[name=figure]').fill('1.000');
    await expect.poll(() => seen(de['tune.number'])).toBe(true);
    for (const name of ['figure', 'x', 'y']) await page.locator(`input[name=${name}]`).fill('4');
    fake.refuse('calibrate_measure', 'out_of_order');
    await page.getByRole('button', { name: words['calibrate.measure'], exact: true }).click();
    await expect.poll(() => seen(de['refused.title'])).toBe(true);
  });
});

describe('driven squares', { timeout: minutes_ms }, () => {
  const start = eachPage(1280, 800);
  it('are entered without a minus; each further one shows its result before it can be used', async () => {
    const { fake, page } = await start();
    await page.goto(`${fake.url}#/calibrate/square`);
    await page.locator('.mode-standby').waitFor();
    const words = calibrate.en;
    const press = (name: string) => page.getByRole('button', { name, exact: true }).click();
    const off = (axis: number) => page.locator('.calibrate-off').nth(axis);
    const measure = async () => {
      await page.locator('input[name=figure]').fill('4');
      await page.locator('input[name=x]').fill('3');
      await off(0).getByRole('radio', { name: words['calibrate.rear'] }).click();
      await page.locator('input[name=y]').fill('1.5');
      await press(words['calibrate.measure']);
    };
    await press(words['calibrate.start']);
    // Thousands or thousandths: the step says so, and does not measure.
    await page.locator('input[name=figure]').fill('1,000');
    await page.getByText(en['tune.number']).waitFor();
    expect(await page.getByRole('button', { name: words['calibrate.measure'], exact: true }).isDisabled()).toBe(true);
    await measure();
    expect(await page.getByText(en['tune.number']).count()).toBe(0);
    await page.getByText(words['calibrate.now.squareRight']).waitFor();
    await measure();
    const sent = fake.hoist.commands.filter(({ type }) => type === 'calibrate_measure');
    const square = { figure: 4, x_m: -0.03, y_m: 0.015 };
    expect(sent).toMatchObject([
      { ...square, turning: 'left' },
      { ...square, turning: 'right' },
    ]);
    const found = page.locator('.calibrate-changes td strong');
    await page.getByText('0.6800 m').waitFor();
    await page.getByText(words['calibrate.again']).click();
    await measure();
    await page.getByText('0.6810 m').waitFor();
    expect(await found.allTextContents()).toEqual(['0.6810 m']);
    await press(words['calibrate.use']);
    await page.locator('.mode-standby').waitFor();
  });
});
