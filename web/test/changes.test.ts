// What was changed, set back or written by two people at once, in a browser with the stand-in server.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, describe, expect, it } from 'vitest';
import type { Trend } from '../src/contract/rest.gen';
import { en } from '../src/text/en';
import { openBuiltConsole, type BuiltConsole } from '../test-support/browser';
import { startFakeServer, type FakeServer } from '../test-support/fake_server.mjs';

const minutes_ms = 120_000;
let built: BuiltConsole;
let fake: FakeServer;
let page: Page;

beforeAll(async () => {
  built = await openBuiltConsole();
}, minutes_ms);
afterAll(() => built?.close());
beforeEach(async () => {
  fake = await startFakeServer({ dist: built.folder });
  page = await built.browser.newPage({ viewport: { width: 1280, height: 800 }, locale: 'en' });
});
afterEach(async () => {
  await page?.close();
  await fake?.close();
});
const open = async (hash: string) => {
  await page.goto(`${fake.url}#/${hash}`);
  await page.locator('.mode-standby').waitFor();
};

describe('the history on Tune', { timeout: minutes_ms }, () => {
  it('names each change with who and how, and sets a value back by one tap', async () => {
    await open('tune');
    const history = page.locator('.tune-history');
    expect(await history.locator('li').count(), 'closed: the settings come first').toBe(0);
    await history.locator('summary').click();
    await history.locator('li').first().waitFor();
    const first = await history.locator('li').first().textContent();
    expect(first).toContain('50 units → 42 units');
    expect(first).toContain('berg');
    expect(first).toContain('“With brace”');
    const row = history.locator('li', { has: page.locator('.row-buttons') }).first();
    const wanted = /Back to (.*)/.exec((await row.locator('button').textContent())!)![1]!;
    const before = await history.locator('li').count();
    await row.locator('button').click();
    await expect.poll(() => history.locator('li').count(), { timeout: 10_000 }).toBe(before + 1);
    expect(await history.locator('li').first().textContent(), 'the newest change').toContain(`→ ${wanted}`);
  });
});

describe('a value that is typed on Tune', { timeout: minutes_ms }, () => {
  it.each([
    ['9999', 'Build-up strength: The value is outside its range. Allowed:'],
    ['abc', `Build-up strength: ${en['tune.number']}`],
    ['1,000', `Build-up strength: ${en['tune.number']}`],
  ])('and cannot be set is told also after leaving the screen: %s', async (text, told) => {
    await open('tune');
    await page.locator('input[name=lean_gain_filtered_units]').fill(text);
    await page.goto(`${fake.url}#/health`);
    await page.locator('.notice.warning', { hasText: told }).waitFor();
  });
});

describe('a slider on Tune', { timeout: minutes_ms }, () => {
  const sent = () => fake.hoist.commands.filter(({ type }) => type === 'set').length;
  const field = () => page.locator('input[name=lean_gain_filtered_units]').inputValue();

  it.each([
    [390, 844],
    [1024, 768],
  ])('changes nothing when a swipe over it scrolls the page of %i x %i', async (width, height) => {
    await page.close();
    page = await built.browser.newPage({ viewport: { width, height }, locale: 'en', hasTouch: true, isMobile: true });
    await open('tune');
    await page.locator('input[name=lean_gain_filtered_units]').fill('51'); // typed, and not entered
    const slider = page.locator('.tune-slider input').first();
    await slider.scrollIntoViewIfNeeded();
    const { x, y, width: wide, height: high } = (await slider.boundingBox())!;
    const devtools = await page.context().newCDPSession(page);
    const touch = (type: 'touchStart' | 'touchMove' | 'touchEnd', up?: number) =>
      devtools.send('Input.dispatchTouchEvent', { type, touchPoints: up === undefined ? [] : [{ x: x + 0.9 * wide, y: y + high / 2 - up, id: 1 }] });
    const scrolled = () => page.evaluate(() => document.querySelector('main')!.scrollTop);
    const before = await scrolled();
    await touch('touchStart', 0);
    for (let up = 14; up <= 168; up += 14) await touch('touchMove', up);
    await touch('touchEnd');
    await expect.poll(scrolled).toBeGreaterThan(before + 50);
    await page.waitForTimeout(500);
    expect(sent()).toBe(0);
    expect([await slider.inputValue(), await field()]).toEqual(['50', '51']);
  });

  it('applies its value when it is let go, and after keys', async () => {
    await open('tune');
    const slider = page.locator('.tune-slider input').first();
    const { x, y, width, height } = (await slider.boundingBox())!;
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + 0.75 * width, y - 60, { steps: 5 }); // the hand leaves the slider
    await page.waitForTimeout(500);
    expect(sent(), 'held').toBe(0);
    await page.mouse.up();
    await expect.poll(sent).toBe(1);
    const drawn = Number(await field());
    expect(drawn).toBeGreaterThan(60);
    const begun_ms = Date.now();
    for (let i = 0; i < 3; i++) await page.keyboard.press('ArrowLeft');
    // Together, unless a busy machine pauses between them.
    const together = Date.now() - begun_ms < 200;
    await expect.poll(sent).toBeGreaterThan(1);
    await page.waitForTimeout(500);
    if (together) expect(sent()).toBe(2);
    await expect.poll(async () => Number(await field())).toBeLessThan(drawn);
  });
});

describe('settings on trial', { timeout: minutes_ms }, () => {
  it('are not counted down once the connection is lost', async () => {
    await open('walk');
    await page.getByRole('button', { name: en['walk.start'] }).click();
    await page.locator('.mode-user').waitFor();
    await page.goto(`${fake.url}#/tune`);
    const field = page.locator('input[name=lean_gain_filtered_units]');
    await field.fill('55');
    await field.press('Enter');
    const trial = page.getByRole('region', { name: en['tune.trial.title'] });
    await trial.waitFor();
    await fake.close();
    await trial.waitFor({ state: 'detached' });
  });
});

describe('the suggestions on Tune', { timeout: minutes_ms }, () => {
  const sent = () => fake.hoist.commands.filter(({ type }) => type === 'set').length;

  it('name value, measure and effect; taking one over changes nothing until a person applies it', async () => {
    await open('tune');
    const advice = page.locator('.tune-advice');
    await advice.locator('summary').click();
    await advice.locator('li').first().waitFor();
    expect(await advice.locator('li').first().textContent()).toContain('5.9 %');
    expect(await advice.locator('li', { hasText: 'can stay' }).locator('button').count()).toBe(0);
    expect(await advice.locator('li', { hasText: 'less than 5 s of turning' }).locator('button').count()).toBe(0);
    await advice.getByRole('button', { name: 'Build-up strength: fill in 62.5 units' }).click();
    const field = page.locator('input[name=lean_gain_filtered_units]');
    expect(await field.inputValue()).toBe('62.5');
    await page.getByText('Suggested, not yet set. Set now: 50 units').waitFor();
    // Leaving the field is not applying.
    await page.locator('input[name=lean_tau_normal_s]').focus();
    await page.waitForTimeout(500);
    expect(sent(), 'nothing was sent').toBe(0);
    await page.getByRole('button', { name: en['advice.apply'] }).click();
    await expect.poll(sent, { timeout: 10_000 }).toBe(1);
    await page.getByText('Suggested, not yet set').waitFor({ state: 'detached' });
    await expect.poll(() => field.inputValue(), { timeout: 10_000 }).toBe('62.5');
    expect(await advice.locator('li', { hasText: 'Build-up strength' }).textContent()).toContain(en['advice.inForce']);
  });

  it('are discarded by one tap', async () => {
    await open('tune');
    await page.locator('.tune-advice summary').click();
    await page.getByRole('button', { name: 'Build-up strength: fill in 62.5 units' }).click();
    await page.getByRole('button', { name: en['advice.drop'] }).click();
    expect(await page.locator('input[name=lean_gain_filtered_units]').inputValue()).toBe('50');
    expect(sent()).toBe(0);
  });
});

describe('the note of a visit', { timeout: minutes_ms }, () => {
  it('is saved on leaving it, and never over another one unseen', async () => {
    await open('patients/5');
    const note = page.getByLabel(en['visit.note']).first();
    await note.waitFor();
    // The page's own reading after the save is held up, and comes while the next text is typed.
    let read = () => {};
    const held = new Promise<void>((resolve) => (read = resolve));
    await page.route('**/api/v1/visits?*', async (route) => {
      await held;
      await route.continue();
    });
    await note.fill('Walked well');
    await note.press('Enter');
    await page.getByText(en['sessions.saved']).first().waitFor();
    // Meanwhile on another tablet.
    const changed = await page.evaluate(async () => {
      const { etag } = (await (await fetch('/api/v1/visits/12')).json()) as { etag: string };
      return (await fetch('/api/v1/visits/12', { method: 'PATCH', headers: { 'If-Match': `"${etag}"` }, body: '{"note":"Fell asleep"}' })).status;
    });
    expect(changed).toBe(200);
    await note.fill('Walked very well');
    const came = page.waitForResponse((answer) => answer.url().includes('/api/v1/visits?'));
    read();
    await came;
    await page.unroute('**/api/v1/visits?*');
    await note.press('Enter');
    await page.getByText('Someone else has changed this. Look at it again.').waitFor();
    expect(await note.inputValue(), 'what was typed stays').toBe('Walked very well');
    const stored = await page.evaluate(async () => (await (await fetch('/api/v1/visits/12')).json()) as { note: string });
    expect(stored.note).toBe('Fell asleep');
  });
});

describe('the first note of a visit', { timeout: minutes_ms }, () => {
  it('stays while the connection is lost', async () => {
    await open('patients/1');
    const note = page.getByLabel(en['visit.note']).first();
    await note.fill('Walked well');
    await fake.close();
    await page.getByText(en['strip.lost']).first().waitFor();
    expect(await note.isDisabled()).toBe(true);
    expect(await note.inputValue()).toBe('Walked well');
  });

  it('that is refused after the page was left is told', async () => {
    await open('patients/1');
    await page.route('**/api/v1/visits/11', (route) => route.fulfill({ status: 503, json: { type: '/problems/storage', title: '', status: 503 } }));
    await page.getByLabel(en['visit.note']).first().fill('Walked well');
    await page.goto(`${fake.url}#/health`);
    await page.locator('.notice.error', { hasText: en['sessions.notSaved'] }).waitFor();
  });
});

describe('the trend', { timeout: minutes_ms }, () => {
  it('says what is learnt, breaks its line where a value is not valid, says why, and leaves the simulation out', async () => {
    await open('patients/5');
    await page.locator('.trend-plot').waitFor();
    await page.getByText('0.02 m/s more from walk to walk within a visit').waitFor();
    await page.getByText('95 % range: 0.01 m/s to 0.03 m/s.').waitFor();
    await page.getByText(en['trend.kept']).waitFor();
    await page.getByLabel(en['trend.figure']).selectOption({ label: en['metric.turning'] });
    await page.getByText(en['trend.noSlope']).waitFor();
    expect(await page.getByText(en['trend.kept']).count(), 'the usual variation is not known').toBe(0);
    expect(await page.locator('.trend-gap').count()).toBe(2);
    expect(await page.locator('.trend-line').count(), 'before, between and after').toBe(3);
    const gaps = await page.locator('.trend-gaps').textContent();
    expect(gaps).toContain('Part of this walk is not recorded.');
    expect(gaps).toContain(en['trend.unreadable']);
    await page.getByText('2 recordings of the simulation are left out.').waitFor();
  });

  it('is told against the first walk of the same exercise also where a page does not reach it', async () => {
    await page.route('**/trend?*', async (route) => {
      const answer = await route.fetch();
      const whole = (await answer.json()) as Trend;
      const [first] = whole.items.slice(-1).map((item) => ({ ...item, session: 1, day: '2020-01-31' }));
      const changes = whole.changes.map((one) => ({ ...one, first_session: 1, first: one.last - 1, reason_code: null }));
      const alike = route.request().url().includes(`limit=49&comparable_to=${whole.items[0]!.session}`);
      await route.fulfill({ json: alike ? { ...whole, firsts: [first], changes } : { ...whole, next: '5' } });
    });
    await open('patients/5');
    await page.getByText(/more than on .*2020/).waitFor();
    expect(await page.locator('.trend-plot').textContent(), 'it begins there').toMatch(/2020/);
    await page.unroute('**/trend?*');
  });
});
