// The marks of a recorded session, in a browser with the stand-in server.
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
  await page.goto(`${fake.url}#/sessions/3`);
  await rows().first().waitFor();
});

const rows = () => page.locator('.session-markers li');
const button = (name: string) => page.getByRole('button', { name, exact: true });
const save = () => page.locator('form').getByRole('button', { name: en['common.save'], exact: true });
const edit = (n: number) => rows().nth(n).getByRole('button').click();

describe('events of a session', { timeout: minutes_ms }, () => {
  it('are all shown, also those of later pages and in the list with its marks', async () => {
    const events = page.locator('.events li');
    await expect.poll(() => events.count()).toBe(26);
    await page.goto(`${fake.url}#/sessions/1`);
    await expect.poll(() => events.count()).toBe(200);
    await button(en['sessions.eventsAll'].replace('{n}', '453')).click();
    expect(await events.count()).toBe(453);
    expect(await events.last().textContent()).toContain('1:36');
  });
});

describe('a mark', { timeout: minutes_ms }, () => {
  it('gets another kind, text and time, each by itself', async () => {
    expect(await rows().locator('strong').allTextContents()).toEqual([en['marker.stumble'], 'Held the rail with the left hand', en['marker.help']]);
    await edit(1);
    expect(await save().isDisabled(), 'nothing to save yet').toBe(true);
    await page.getByLabel(en['marker.kind']).selectOption('rest');
    await page.getByLabel(en['marker.time']).fill('soon');
    expect(await save().isDisabled(), 'no time').toBe(true);
    await page.getByLabel(en['marker.time']).fill('1:30');
    await save().click();
    await page.getByText(`${en['marker.rest']} · Held the rail with the left hand`).waitFor();
    await page.getByText('1:30').first().waitFor();
  });

  it('that lies outside the session says so and stays open', async () => {
    await edit(0);
    await page.getByLabel(en['marker.time']).fill('59:00');
    await save().click();
    await page.getByText(en['invalid.time_s']).waitFor();
    expect(await page.getByLabel(en['marker.time']).inputValue()).toBe('59:00');
  });

  it('is deleted, and one that was changed meanwhile is not', async () => {
    await edit(0);
    await button(en['marker.delete']).click();
    await page.getByText(en['marker.deleted']).waitFor();
    await expect.poll(() => rows().count()).toBe(2);
    await edit(0);
    await page.evaluate(() =>
      fetch('/api/v1/sessions/3/markers/1', {
        method: 'PATCH',
        headers: { 'If-Match': '"m1"', 'X-Hoist': '1' },
        body: JSON.stringify({ text: 'Held the rail with both hands' }),
      }),
    );
    await button(en['marker.delete']).click();
    await page.getByText(/Someone else has changed this/).waitFor();
    await rows().getByText('Held the rail with both hands').waitFor();
    expect(await rows().count()).toBe(2);
  });
});
