// A rehearsal in a browser with the stand-in server: chosen on a simulated hoist, not offered on a real one, its result there and at its session.
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, beforeEach, describe, expect, it } from 'vitest';
import { en } from '../src/text/en';
import { loadLanguage } from '../src/text/text';
import { settings } from '../src/text/settings';
import { rehearse } from '../src/text/rehearse';
import { study } from '../src/text/study';
import { rehearsalSentence, rehearsals } from '../src/ui/rehearsal';
import { minutes_ms, openBuiltConsole, type BuiltConsole } from '../test-support/browser';
import { startFakeServer, type FakeServer } from '../test-support/fake_server.mjs';

const result = {
  rehearsal: 'bumper',
  seed: 7,
  after_s: 12.3,
  items: [
    { check: 'stop', limit_s: 5, seen: 'good', after_s: 1.4 },
    { check: 'look', limit_s: 3, seen: 'wrong', after_s: 0.8 },
    { check: 'zero', limit_s: null, seen: 'missing', after_s: null },
  ],
};

describe('the words of a rehearsal', () => {
  it('are one sentence for each thing looked at, with its time', async () => {
    await loadLanguage('en');
    settings.set({ language: 'en' });
    expect(rehearsalSentence({ check: 'stop', limit_s: 5, seen: 'good', after_s: 1.4 })).toBe('STOP after 1.4 s.');
    expect(rehearsalSentence({ check: 'look', limit_s: 3, seen: 'wrong', after_s: 0.8 })).toBe(
      'Only 0.8 s before the release: look at the patient for 3 s first.',
    );
    expect(rehearsalSentence({ check: 'answer', limit_s: 20, seen: 'missing', after_s: null })).toBe('Nobody answered.');
  });

  it('are in both languages, with the same values', () => {
    const gaps = (text: string) => [...text.matchAll(/\{\w+\}/g)].map(([gap]) => gap).sort();
    for (const part of [rehearse, study])
      for (const [key, german] of Object.entries(part.de)) {
        const english = (part.en as Record<string, string>)[key]!;
        expect(gaps(german), key).toEqual(gaps(english));
        expect(german, key).not.toBe(english);
      }
  });

  it('say everywhere that the hoist is simulated', () => {
    expect(rehearse.en['rehearse.label']).toBe('Rehearsal, simulated hoist');
    expect(rehearse.de['rehearse.label']).toBe('Probe, simuliertes Gerät');
  });
});

describe('rehearsals on the screen', { timeout: minutes_ms }, () => {
  let built: BuiltConsole, fake: FakeServer, page: Page;
  beforeAll(async () => {
    built = await openBuiltConsole();
  }, minutes_ms);
  beforeEach(async () => {
    await page?.close();
    await fake?.close();
    fake = await startFakeServer({ dist: built.folder });
    page = await built.browser.newPage({ locale: 'en' });
    await page.goto(`${fake.url}#/exercises`);
    await page.locator('.mode-standby').waitFor();
  }, minutes_ms);
  afterAll(async () => {
    await page?.close();
    await built?.close();
    await fake?.close();
  });

  it('are chosen, waited for, and told when they are over', async () => {
    await page.getByRole('link', { name: en['nav.rehearse'] }).click();
    await page.getByRole('heading', { name: rehearse.en['rehearse.label'] }).waitFor();
    await page.locator('.rehearse-kinds button').first().waitFor();
    expect(await page.locator('.rehearse-kinds button').count()).toBe(Object.keys(rehearsals).length);
    await page.getByRole('radio', { name: rehearse.en['rehearse.bumper'] }).click();
    await page.getByRole('button', { name: rehearse.en['rehearse.start'] }).click();
    await page.getByText('A bumper touches something: start the walk.').waitFor();
    fake.rehearse({ phase: 'happening' });
    await page.waitForTimeout(1200);
    expect(await page.getByText('A bumper touches something: start the walk.').count(), 'that it has happened is not told').toBe(1);
    fake.rehearse({ phase: 'over', session: 3, result });
    await page.locator('.rehearse-result').waitFor();
    expect(await page.locator('.rehearsal-items li').allTextContents()).toEqual([
      '✓STOP after 1.4 s.',
      '✗Only 0.8 s before the release: look at the patient for 3 s first.',
      '–The neutral posture was not set.',
    ]);
    expect(await page.getByRole('link', { name: rehearse.en['rehearse.toSession'] }).getAttribute('href')).toBe('#/sessions/3');
  });

  it('without a result say why, and can be started again', async () => {
    fake.rehearse({ phase: 'lost', rehearsal: 'trip' });
    await page.goto(`${fake.url}#/rehearse`);
    await page.locator('.rehearse-result', { hasText: rehearse.en['rehearse.lost'] }).waitFor();
    expect(await page.getByRole('link', { name: rehearse.en['rehearse.toSession'] }).count()).toBe(0);
    expect(await page.getByRole('button', { name: rehearse.en['rehearse.start'] }).isEnabled()).toBe(true);
  });

  it('are not offered on a real hoist, and its reason is told', async () => {
    fake.rehearse({ reason_code: 'not_simulated' });
    await page.reload();
    await page.locator('.guided-study').waitFor();
    expect(await page.getByRole('link', { name: en['nav.rehearse'] }).count()).toBe(0);
    await page.goto(`${fake.url}#/rehearse`);
    await page.getByText('Rehearsals need the simulated hoist.').waitFor();
    expect(await page.getByRole('button', { name: rehearse.en['rehearse.start'] }).count()).toBe(0);
  });

  it('stay with their session, and are no note to edit', async () => {
    fake.markRehearsal(result);
    await page.goto(`${fake.url}#/sessions/3`);
    const row = page.locator('.session-markers li', { hasText: `${rehearse.en['rehearse.label']}: ${rehearse.en['rehearse.bumper']}` }).first();
    await row.waitFor();
    expect(await row.locator('.rehearsal-items li').count()).toBe(3);
    expect(await row.getByRole('button').count()).toBe(0);
  });
});
