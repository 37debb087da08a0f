import type { Page } from 'playwright-core';
import { describe, expect, it } from 'vitest';
import { emergencies } from '../src/contract/emergencies.gen';
import { codedFaults, faultDetails, faults, speedCauses, type FaultName } from '../src/contract/faults.gen';
import { causeReader, slowerBecause } from '../src/link/speed_cause';
import { de } from '../src/text/de';
import { en } from '../src/text/en';
import { toldFaults } from '../src/ui/alarms';
import { storageAlarms } from '../src/ui/strip';
import { eachPage, minutes_ms } from '../test-support/browser';

const notice = (name: string, priority: 'low' | 'medium') => ({
  name,
  priority,
  text: { en: `${name} text`, de: '' },
  action: { en: `${name} action`, de: '' },
  detail: '',
});

describe('the strip', () => {
  it('shows each standing notice in words, with what to do', () => {
    expect(storageAlarms([notice('settings_not_stored', 'medium')], false)).toEqual([
      { id: 'settings_not_stored', priority: 'medium', text: 'settings_not_stored text', action: 'settings_not_stored action' },
    ]);
    expect(storageAlarms([], false)).toEqual([]);
  });

  it('says once that nothing is recorded', () => {
    expect(storageAlarms([notice('recordings_foreign', 'medium')], true)).toHaveLength(1);
    expect(storageAlarms([notice('recordings_set_aside', 'low')], true).map((alarm) => alarm.id)).toEqual(['recordings_set_aside', 'recording']);
  });

  it('says why the hoist goes slowly while it is led, unless the sentence says so', () => {
    for (const { value, text } of speedCauses) expect(slowerBecause('strip.walking', value)).toEqual(text);
    expect(slowerBecause('strip.walking', 0)).toBeUndefined();
    for (const sentence of ['strip.waits', 'strip.offBumper', 'strip.ready', 'strip.stopped']) expect(slowerBecause(sentence, 4)).toBeUndefined();
  });

  it('keeps a cause for a second, and the newest of two', () => {
    const read = causeReader();
    expect(read({ tick: 1000, speed_cause: 0 })).toBe(0);
    expect(read({ tick: 1001, speed_cause: 5 })).toBe(5);
    expect(read({ tick: 1100, speed_cause: 0 })).toBe(5);
    expect(read({ tick: 1101, speed_cause: 0 })).toBe(0);
    expect(read({ tick: 1102, speed_cause: 6 })).toBe(6);
    expect(read({ tick: 3, speed_cause: 0 })).toBe(0); // another core
  });
});

describe('a lost connection', { timeout: minutes_ms }, () => {
  const start = eachPage(1024, 768);
  it('shows since when there is no answer, and is read aloud once', async () => {
    const { fake, page } = await start();
    await page.goto(fake.url);
    await page.locator('.mode-standby').waitFor();
    await fake.close();
    const alert = page.getByRole('alert');
    for (const s of [2, 3]) {
      await alert.getByText(en['strip.noData'].replace('{s}', String(s))).waitFor();
      const spoken = await alert.ariaSnapshot();
      expect(spoken).toContain(en['strip.lost']);
      expect(spoken).not.toContain(en['strip.noData'].slice(0, 9));
    }
  });
});

interface Alarm {
  name: FaultName;
  code: number;
  words: string;
}
/** The longest that the strip says of the faults of one kind. */
function longest(language: 'en' | 'de', counts: (name: FaultName) => boolean): Alarm {
  const codes = [0, ...emergencies.map((row) => row.code), ...faultDetails.map((row) => row.code)];
  const all = faults
    .filter(({ name }) => counts(name))
    .flatMap(({ name, bit }) =>
      ((codedFaults as readonly string[]).includes(name) ? codes : [0]).map((code): Alarm => {
        const [told] = toldFaults(2 ** bit, 0, { [name]: code });
        return { name, code, words: `${told!.text[language]} ${told!.action[language]}` };
      }),
    );
  return all.reduce((most, one) => (one.words.length > most.words.length ? one : most));
}

/** What is wrong with the strip on this page: a text that is cut or covered, a button that is too small. */
const trouble = (page: Page, sentence: string): Promise<string[]> =>
  page.evaluate((wanted) => {
    const found: string[] = [];
    const strip = document.querySelector('.strip')!;
    const words = strip.querySelector('.strip-words')!;
    const at = (x: number, y: number) => document.elementFromPoint(x, y);
    const inside = (a: DOMRect, b: DOMRect) => a.left >= b.left - 1 && a.right <= b.right + 1 && a.top >= b.top - 1 && a.bottom <= b.bottom + 1;
    const over = (a: DOMRect, b: DOMRect) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
    // First for keys and screen readers, too.
    if (strip.compareDocumentPosition(document.querySelector('main')!) !== Node.DOCUMENT_POSITION_FOLLOWING) found.push('behind the panel');
    if (words.textContent.replace(/\s+/g, ' ').trim() !== wanted) found.push(`says: ${words.textContent}`);
    for (let part = words; part !== strip.parentElement; part = part.parentElement!) {
      const { overflow, textOverflow, webkitLineClamp } = getComputedStyle(part);
      if (overflow !== 'visible' && overflow !== 'auto') found.push(`${part.className}: overflow ${overflow}`);
      if (textOverflow !== 'clip' || webkitLineClamp !== 'none') found.push(`${part.className}: ends in an ellipsis`);
      if (part.clientHeight > 0 && part.scrollHeight > part.clientHeight)
        found.push(`${part.className}: ${part.scrollHeight} in ${part.clientHeight}`);
    }
    const screen = new DOMRect(0, 0, innerWidth, innerHeight);
    const buttons = [...strip.querySelectorAll('button')];
    const lines = document.createRange();
    lines.selectNodeContents(words);
    for (const line of lines.getClientRects()) {
      if (line.width < 1) continue;
      if (!inside(line, strip.getBoundingClientRect()) || !inside(line, screen)) found.push('a line is outside');
      for (const x of [line.left + 2, line.right - 2]) if (!strip.contains(at(x, (line.top + line.bottom) / 2))) found.push('a line is covered');
      if (buttons.some((button) => over(line, button.getBoundingClientRect()))) found.push('a line is on a button');
    }
    for (const button of buttons) {
      const box = button.getBoundingClientRect();
      if (box.width < 44 || box.height < 44) found.push(`${button.className} is ${box.width} x ${box.height}`);
      if (!inside(box, strip.getBoundingClientRect()) || !button.contains(at(box.left + box.width / 2, box.top + box.height / 2)))
        found.push(`${button.className} is not reached`);
    }
    return found;
  }, sentence);

describe.each([
  [360, 640],
  [390, 844],
  [844, 390],
  [768, 1024],
  [1024, 768],
  [1280, 800],
])('an alarm at %i × %i', { timeout: minutes_ms }, (width, height) => {
  const start = eachPage(width, height);
  it.each(['en', 'de'] as const)('says whole what to do, and moves nothing while a therapist drives (%s)', async (language) => {
    const table = language === 'de' ? de : en;
    const { fake, page } = await start({}, language);
    page.setDefaultTimeout(5000);
    await page.goto(`${fake.url}#/drive`);
    await page.locator('.mode-standby').waitFor();
    const place = (part: string) => page.locator(part).evaluate((one) => JSON.stringify(one.getBoundingClientRect()));
    const priority = (name: FaultName) => faults.find((row) => row.name === name)!.priority;
    const coded = longest(language, (name) => (codedFaults as readonly string[]).includes(name));
    const cases: Alarm[][] = [
      [coded],
      [longest(language, (name) => priority(name) === 'high')],
      [longest(language, (name) => priority(name) !== 'high')],
    ];
    cases.push([coded, longest(language, (name) => name === 'battery_uneven')]);
    for (const alarms of cases) {
      const raise = () => {
        fake.trouble(Object.fromEntries(alarms.map(({ name, code }) => [`${name}_code`, code])));
        for (const { name } of alarms) fake.fault(name);
      };
      const what = `${alarms.map(({ name }) => name).join(' ')} at ${width} x ${height}`;
      const shown = page.locator('.strip-words', { hasText: alarms[0]!.words.slice(-20) });

      // In the hand.
      const led = async () => {
        const button = page.getByRole('button', { name: table['drive.start'] });
        await button.click({ timeout: 300 }).catch(() => null); // not right after End (firm_click.ts)
        return page.locator('.pad.active').count();
      };
      await expect.poll(led, { timeout: 10_000, interval: 300 }).toBe(1);
      await page.locator('.pad').hover();
      await page.mouse.down();
      await page.locator('.pad.held').waitFor();
      const before = await place('.pad');
      raise();
      await shown.waitFor();
      expect(await trouble(page, alarms[0]!.words), `driving, ${what}`).toEqual([]);
      expect(await place('.pad'), `driving, ${what}`).toBe(before);
      const [alarm, pad] = [await page.locator('.strip').boundingBox(), await page.locator('.pad').boundingBox()];
      expect(alarm!.y + alarm!.height, `driving, ${what}`).toBeLessThanOrEqual(pad!.y);
      // With letters so large that the text needs more than the row.
      const letters = (size: string) =>
        page.locator('.strip-words').evaluate((words, given) => void ((words as HTMLElement).style.fontSize = given), size);
      await letters('28px');
      expect(await trouble(page, alarms[0]!.words), `large letters, ${what}`).toEqual([]);
      expect(await place('.pad'), `large letters, ${what}`).toBe(before);
      await letters('');
      expect(await page.locator('.pad.held').count()).toBe(1);
      await page.mouse.up();
      await page.getByRole('button', { name: table['drive.end'] }).click({ trial: true, timeout: 2000 });

      // Stopped, with the button to release it.
      fake.hoist.mode = 'protective_stop';
      await page.locator('.strip .hold').waitFor();
      expect(await trouble(page, alarms[0]!.words), `stopped, ${what}`).toEqual([]);
      const [strip, main] = [await page.locator('.strip').boundingBox(), await page.locator('.main').boundingBox()];
      expect(strip!.y + strip!.height, `stopped, ${what}`).toBeLessThanOrEqual(main!.y);
      // Also beside the buttons the text is no narrow column.
      expect(strip!.height, `stopped, ${what}`).toBeLessThanOrEqual(110);

      fake.hoist.mode = 'standby';
      await page.locator('.strip .hold').waitFor({ state: 'detached' });
      expect(await trouble(page, alarms[0]!.words), `standing, ${what}`).toEqual([]);
      fake.hoist.faults = 0;
      await page.locator('.strip.calm').waitFor();
    }
  });
});
