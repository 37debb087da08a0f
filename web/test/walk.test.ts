// Walk, Drive and what a viewer may press, in a browser with the stand-in server.
import type { Page } from 'playwright-core';
import { beforeEach, describe, expect, it } from 'vitest';
import { en } from '../src/text/en';
import { eachPage, minutes_ms } from '../test-support/browser';
import type { FakeServer } from '../test-support/fake_server.mjs';

const start = eachPage(1024, 768);
let fake: FakeServer;
let page: Page;
beforeEach(async () => {
  ({ fake, page } = await start());
});
const open = async (screen: string) => {
  await page.goto(`${fake.url}#/${screen}`);
  await page.locator('.mode-standby').waitFor();
};
const button = (name: string) => page.getByRole('button', { name, exact: true });
const starts = () => fake.hoist.commands.filter(({ type, mode }) => type === 'mode' && mode !== 'standby');

describe('Drive', { timeout: minutes_ms }, () => {
  it.each([
    ['without a task: the exercise stays where it lies', null, 0, null],
    ['away from a bumper, also of a task', 'straight', 1, null],
    ['along the line of a chosen task', 'straight', 0, { shape: 'straight', length_m: 10 }],
  ])('starts %s', async (_, task, bumpers, exercise) => {
    fake.trouble({ bumpers, bumpers_acknowledged: bumpers });
    await open('drive');
    await page.evaluate((body) => fetch('/api/v1/task', { method: 'PUT', body }), JSON.stringify({ task }));
    if (task !== null) await page.locator('.task-strip').waitFor();
    await button(en['drive.start']).click();
    await page.locator('.mode-remote').waitFor();
    expect(starts().map((one) => one.exercise)).toEqual([exercise]);
  });
});

describe('Walk', { timeout: minutes_ms }, () => {
  it('keeps task and size when the exercise that is chosen already is pressed', async () => {
    await open('walk');
    await page.evaluate(() => fetch('/api/v1/task', { method: 'PUT', body: '{"task":"square","sizes":{"side_m":2.5}}' }));
    await page.locator('.task-strip').waitFor();
    const radio = (name: string) => page.getByRole('radio', { name, exact: true });
    await radio('Square').click();
    await radio('Straight').click();
    await page.locator('.task-strip').waitFor({ state: 'detached' });
    const chosen = fake.hoist.commands.filter(({ type }) => type === 'choose').map(({ exercise }) => exercise);
    expect(chosen, 'the other one alone').toMatchObject([{ shape: 'straight' }]);
  });
});

describe('a viewer', { timeout: minutes_ms }, () => {
  const enabled = (within: string) => page.locator(`:is(${within}) :is(button, input):enabled`).allTextContents();
  const reason = () => page.locator('.main .blockers', { hasText: 'Your role may not change this.' });

  it.each([
    ['walk', '.walk-controls, .markers'],
    ['drive', '.walk-controls'],
    ['tune', '.presets, .tune-row'],
    ['calibrate', '.calibrate-guide'],
    ['sessions/3', '.session-texts'],
  ])('can press nothing on %s that is refused, and reads why', async (screen, within) => {
    fake.as('viewer');
    await open(screen);
    await reason().waitFor();
    await page.locator(`:is(${within}) :is(button, input)`).first().waitFor();
    expect(await enabled(within)).toEqual([]);
    if (screen === 'sessions/3') expect(await button(en['sessions.delete']).isDisabled()).toBe(true);
  });

  it('can set no mark during a walk, neither keep nor undo a trial, end no task, and release no stop', async () => {
    fake.as('viewer');
    await open('walk');
    await page.evaluate(() => fetch('/api/v1/task', { method: 'PUT', body: '{"task":"square"}' }));
    await page.locator('.task-strip').waitFor();
    expect(await enabled('.task-strip')).toEqual([]);
    fake.trouble({ settings_trial_s: 12 });
    fake.hoist.mode = 'user';
    await page.locator('.mode-user').waitFor();
    const trial = page.getByRole('region', { name: en['tune.trial.title'] });
    await trial.getByText('Your role may not change this.').waitFor();
    expect(await enabled('.walk-controls, .markers, .trial-buttons')).toEqual([]);
    await reason().waitFor();
    fake.fault('stop_pressed');
    fake.hoist.mode = 'protective_stop';
    await page.locator('.strip .hold').waitFor();
    expect(await page.locator('.strip .hold').isDisabled()).toBe(true);
  });
});
