// The page comes in pieces: what works before a piece has come, and when one does not come.
import type { Page } from 'playwright-core';
import { beforeEach, describe, expect, it } from 'vitest';
import { first } from '../src/text/first';
import { eachPage, minutes_ms } from '../test-support/browser';
import type { FakeServer } from '../test-support/fake_server.mjs';

const start = eachPage(1024, 768);
let fake: FakeServer;
let page: Page;
let asked: string[];

beforeEach(async () => {
  ({ fake, page } = await start({}, 'de'));
  asked = [];
  page.on('request', (request) => asked.push(new URL(request.url()).pathname));
});

/** As after a new build on the server: this page's files no longer exist. */
const without = (name: string) => page.route(new RegExp(`/assets/${name}-`), (route) => route.fulfill({ status: 404, body: '' }));
const stopped = () => fake.hoist.commands.some(({ type }) => type === 'stop');
async function stopActs() {
  await page.getByRole('button', { name: first.de['stop.name'] }).dispatchEvent('pointerdown');
  await expect.poll(stopped, { timeout: 10_000 }).toBe(true);
}

describe('a page in pieces', { timeout: minutes_ms }, () => {
  it('has a STOP that acts before any word has come', async () => {
    await page.route(/\/assets\/de-/, () => {}); // never answered
    await page.goto(fake.url);
    await stopActs();
    expect(await page.locator('.load-failed').count()).toBe(0);
  });

  it('says in the language of this device that its words cannot be loaded, and STOP acts', async () => {
    await without('de');
    await page.goto(fake.url);
    await page.getByText(first.de['load.failed']).waitFor();
    expect(await page.getByRole('button', { name: first.de['load.again'] }).isVisible()).toBe(true);
    await stopActs();
  });

  it.each(['tune', 'sessions', 'health'])('goes on without the screen %s: it says what to do, STOP acts, nothing moves', async (screen) => {
    await without(screen);
    const boxes = () =>
      page.locator('.bar, .strip, .nav, .main, .stop').evaluateAll((all) => all.map((one) => one.getBoundingClientRect().toJSON() as object));
    await page.goto(`${fake.url}#/walk`);
    await page.locator('.mode-standby').waitFor();
    const before = await boxes();
    await page.locator(`.nav a[href="#/${screen}"]`).click();
    await page.locator('.load-failed').waitFor();
    expect(await boxes()).toEqual(before);
    await stopActs();
    await page.locator('.nav a[href="#/walk"]').click();
    await page.locator('.walk-controls').waitFor();
  });

  it('asks for one language, and loads the other screens ahead', async () => {
    await page.goto(`${fake.url}#/walk`);
    await expect
      .poll(() => asked.filter((path) => /\/assets\/(drive|exercises|tune|sessions|calibrate|health)-.*\.js$/.test(path)).length, { timeout: 20_000 })
      .toBe(6);
    expect(asked.filter((path) => /\/assets\/(en|chart)-/.test(path))).toEqual([]);
    await page.locator('.menu-button').click();
    await page.getByRole('radio', { name: 'English' }).click();
    await page.getByRole('link', { name: 'Walk' }).waitFor();
    expect(asked.filter((path) => /\/assets\/en-/.test(path))).toHaveLength(1);
  });

  it('has an address for a session, and Back and Forward follow it', async () => {
    await page.goto(`${fake.url}#/sessions`);
    await page.locator('.session-item').nth(1).click();
    await page.waitForURL(/#\/sessions\/2$/);
    await page.locator('.session-head').waitFor();
    await page.goBack();
    await page.locator('.session-none').waitFor();
    await page.goForward();
    await page.locator('.session-head').waitFor();
    await page.reload();
    await page.locator('.session-item[aria-current=true]').waitFor();
    await page.goto(`${fake.url}#/sessions/4711`);
    await page.getByText('Das gibt es nicht mehr.').first().waitFor();
    expect(await page.locator('.session-detail a[download], .session-detail button').count(), 'nothing that cannot succeed').toBe(0);
    await page.locator('.session-detail a').click();
    await page.waitForURL(/#\/sessions$/);
  });
});
