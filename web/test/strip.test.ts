import { describe, expect, it } from 'vitest';
import { speedCauses } from '../src/contract/faults.gen';
import { causeReader, slowerBecause } from '../src/link/speed_cause';
import { en } from '../src/text/en';
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
