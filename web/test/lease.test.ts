// Control passes from one screen to another: asked for, kept, handed over at standstill, taken where it is free.
import type { Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, beforeEach, expect, it } from 'vitest';
import { minutes_ms, openBuiltConsole, type BuiltConsole } from '../test-support/browser';
import { startFakeServer, type FakeServer } from '../test-support/fake_server.mjs';

let built: BuiltConsole;
let fake: FakeServer;
const pages: Page[] = [];

beforeAll(async () => {
  built = await openBuiltConsole();
}, minutes_ms);
afterAll(() => built?.close());
beforeEach(async () => {
  fake = await startFakeServer({ dist: built.folder });
});
afterEach(async () => {
  for (const page of pages.splice(0)) await page.close();
  await fake?.close();
});

async function open([width, height]: readonly [number, number], locale: string, screen = 'drive', shown = '.mode-standby'): Promise<Page> {
  const page = await built.browser.newPage({ viewport: { width, height }, locale });
  pages.push(page);
  await page.goto(`${fake.url}#/${screen}`);
  await page.locator(shown).waitFor();
  return page;
}

it(
  'asks the screen in control, which keeps it or hands over',
  async () => {
    const driver = await open([1024, 768], 'en');
    const other = await open([390, 844], 'de');
    const press = async () => {
      const question = other.getByRole('button', { name: 'Anfragen' });
      // A press right after the button was End counts for nothing (firm_click.ts).
      const start = async () => {
        if ((await question.count()) === 0) await other.getByRole('button', { name: 'Fahren starten' }).click();
        return question.count();
      };
      await expect.poll(start, { timeout: 20_000, interval: 300 }).toBe(1);
      await question.click();
    };
    const ask = async () => {
      await press();
      await driver.getByText('Another screen asks for control.').waitFor();
    };
    await driver.getByRole('button', { name: 'Start driving' }).click();
    await driver.locator('.pad.active').waitFor();
    // Control stays when driving ends. Another screen can only end a motion that is led.
    await driver.getByRole('button', { name: 'End driving' }).click();
    await other.getByRole('button', { name: 'Fahren starten' }).waitFor();
    await expect.poll(() => driver.locator('.pad-text').textContent(), { timeout: 10_000 }).toBe('Start driving first');
    const holder = fake.lease.holder;
    fake.refuse('lease_ask', 'core_gone');
    await press();
    await other.locator('.notice.warning', { hasText: 'Der Steuerrechner antwortet nicht.' }).waitFor();
    fake.refuse('', '');
    await ask();
    await driver.getByRole('button', { name: 'Keep', exact: true }).click();
    await other.getByText('Der andere Bildschirm behält die Steuerung.').waitFor();
    expect(fake.lease.holder).toBe(holder);
    await ask();
    const give = driver.getByRole('button', { name: 'Hand over', exact: true });
    await give.click();
    await expect.poll(() => fake.lease.holder).not.toBe(holder);
    await give.waitFor({ state: 'detached' });
    // Given, not taken: no alarm about it.
    expect(await driver.getByText('Another screen took over control.').count()).toBe(0);
  },
  minutes_ms,
);

it(
  'stays with the screen in control, and so does its task, when a start on another screen is cancelled',
  async () => {
    const driver = await open([1024, 768], 'en');
    await driver.getByRole('button', { name: 'Start driving' }).click();
    await driver.locator('.pad.active').waitFor();
    await driver.getByRole('button', { name: 'End driving' }).click();
    await driver.evaluate(() => fetch('/api/v1/task', { method: 'PUT', body: '{"task":"straight"}' }));
    expect(fake.hoist.task?.task).toBe('straight');
    const holder = fake.lease.holder;
    const other = await open([1024, 768], 'de', 'exercises');
    await other.locator('.task-field select').selectOption('square');
    const cancel = other.getByRole('button', { name: 'Abbrechen', exact: true });
    const start = async () => {
      if ((await cancel.count()) === 0) await other.getByRole('button', { name: 'Aufgabe beginnen' }).click();
      return cancel.count();
    };
    await expect.poll(start, { timeout: 20_000, interval: 300 }).toBe(1);
    await cancel.click();
    await cancel.waitFor({ state: 'detached' });
    expect(fake.hoist.task?.task).toBe('straight');
    expect(fake.lease.holder).toBe(holder);
  },
  minutes_ms,
);

it(
  'is taken by one press while the patient leads and its screen has gone; a viewer cannot',
  async () => {
    const driver = await open([1024, 768], 'en', 'walk');
    const other = await open([390, 844], 'de');
    const take = other.getByRole('button', { name: 'Steuerung: Übernehmen' });
    await driver.getByRole('button', { name: 'Start walking' }).click();
    await other.locator('.mode-user').waitFor();
    expect(await take.count(), 'not from a screen that is here').toBe(0);
    await driver.close();
    const nobody = other.locator('.control', { hasText: 'Niemand' }).locator('.bar-value');
    await other.setViewportSize({ width: 1024, height: 768 });
    await expect.poll(() => nobody.evaluate((value) => value.scrollWidth <= value.clientWidth && value.clientWidth > 0)).toBe(true);
    await other.setViewportSize({ width: 390, height: 844 });
    fake.as('viewer');
    const viewer = await open([1024, 768], 'de', 'walk', '.mode-user');
    fake.as('engineer');
    await viewer.locator('.control', { hasText: 'Niemand' }).waitFor();
    expect(await viewer.getByRole('button', { name: 'Steuerung: Übernehmen' }).count()).toBe(0);
    await take.click();
    await other.locator('.control', { hasText: 'Sie' }).waitFor();
    expect(fake.hoist.mode, 'the walk goes on').toBe('user');
    expect(await take.count()).toBe(0);
    await other.getByRole('button', { name: 'Beenden', exact: true }).click();
    await other.locator('.mode-standby').waitFor();
  },
  minutes_ms,
);

it(
  'leaves the alarm readable and its release usable while it asks about taking control',
  async () => {
    const driver = await open([1024, 768], 'en');
    await driver.getByRole('button', { name: 'Start driving' }).click();
    await driver.locator('.pad.active').waitFor();
    fake.fault('patient_hanging');
    fake.hoist.mode = 'protective_stop';
    for (const size of [
      [360, 640],
      [844, 390],
      [512, 384],
      [1024, 768],
    ] as const) {
      const other = await open(size, 'de', 'drive', '.strip .hold');
      await other.locator('.strip .hold').hover();
      await other.mouse.down();
      const question = other.getByRole('dialog');
      await question.waitFor();
      await other.mouse.up();
      const covered = await other.evaluate(() => {
        const dialog = document.querySelector('.dialog')!;
        const below = dialog.getBoundingClientRect().top >= document.querySelector('.strip')!.getBoundingClientRect().bottom;
        const whole = dialog.scrollHeight <= dialog.clientHeight && dialog.getBoundingClientRect().bottom <= innerHeight;
        const hidden = ['.strip-words', '.strip .hold'].filter((name) => {
          const part = document.querySelector(name)!;
          const { left, top } = part.getClientRects()[0]!;
          return part.closest('[inert]') !== null || !part.contains(document.elementFromPoint(left + 4, top + 8));
        });
        return [...hidden, ...(below && whole ? [] : ['dialog'])];
      });
      expect(covered, size.join(' x ')).toEqual([]);
      await question.getByRole('button', { name: 'Abbrechen' }).click();
    }
  },
  minutes_ms,
);
