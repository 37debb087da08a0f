import { readdirSync, readFileSync } from 'node:fs';
import { beforeEach, describe, expect, it } from 'vitest';
import { auditActions } from '../src/contract/audit.gen';
import { faults, modes, refusals } from '../src/contract/faults.gen';
import { eventKinds, nodes } from '../src/contract/messages.gen';
import { params } from '../src/contract/params.gen';
import { groups, niceStep } from '../src/panels/tune/groups';
import { calibrate } from '../src/text/calibrate';
import { de } from '../src/text/de';
import { en } from '../src/text/en';
import { first } from '../src/text/first';
import { settings } from '../src/text/settings';
import { rehearse } from '../src/text/rehearse';
import { loop } from '../src/text/loop';
import { study } from '../src/text/study';
import { tasks } from '../src/text/tasks';
import { date, degrees, duration, fixed, plain, quantity, readNumber, refusalText, shownAs, t, textOf, withUnit } from '../src/text/text';

beforeEach(() => settings.set({ language: 'en' }));

/** With the texts that come with a screen. */
const parts = [calibrate, loop, rehearse, study, tasks];
const all = {
  en: { ...en, ...calibrate.en, ...loop.en, ...rehearse.en, ...study.en, ...tasks.en },
  de: { ...de, ...calibrate.de, ...loop.de, ...rehearse.de, ...study.de, ...tasks.de },
};

describe('the message files', () => {
  it('have the same keys', () => {
    expect(Object.keys(all.de).sort()).toEqual(Object.keys(all.en).sort());
    expect(Object.keys(all.en)).toHaveLength([en, ...parts.map((part) => part.en)].reduce((sum, table) => sum + Object.keys(table).length, 0));
  });

  it('have the same placeholders, and no empty text', () => {
    const places = (text: string) => (text.match(/\{\w+\}/g) ?? []).sort();
    for (const key of Object.keys(all.en) as (keyof typeof all.en)[]) {
      expect(places(all.de[key]), key).toEqual(places(all.en[key]));
      expect(all.en[key].trim(), key).not.toBe('');
      expect(all.de[key].trim(), key).not.toBe('');
    }
  });

  it('are not needed for STOP, nor to say that they cannot be loaded', () => {
    const own = Object.keys(first.en);
    expect(own).toEqual(expect.arrayContaining(['stop.name', 'load.failed', 'load.action', 'load.again']));
    for (const table of [en, de]) expect(Object.keys(table).filter((key) => own.includes(key))).toEqual([]);
    expect(Object.keys(first.de)).toEqual(own);
  });

  it('have no text that no screen uses', () => {
    const source = readdirSync('src', { recursive: true, encoding: 'utf8' })
      .filter((file) => /\.tsx?$/.test(file) && !/^text\/(calibrate|en|de|first|loop|rehearse|study|tasks)/.test(file))
      .map((file) => readFileSync(`src/${file}`, 'utf8'))
      .join('\n');
    // Keys put together at run time: exercise.SHAPE, priority.P, event.KIND, health.part.NODE, refused.NAME, invalid.FIELD,
    // role.R, unit.U, history.how.HOW.
    const whole = ['patient.key_missing', 'patient.key_foreign'];
    const begins = /^(?:exercise|priority|event|health\.part|refused|invalid|role|unit|users\.may|tokens\.scope|audit|marker|history\.how)\./;
    const built = { test: (key: string) => whole.includes(key) || begins.test(key) };
    const unused = [...Object.keys(first.en), ...Object.keys(all.en)].filter((key) => !built.test(key) && !source.includes(`'${key}'`));
    expect(unused).toEqual([]);
  });

  it('show no Greek letters and no inner names to people', () => {
    for (const text of [...Object.values(all.en), ...Object.values(all.de)]) expect(text).not.toMatch(/[α-ωΑ-Ω]|_[a-z]|undefined|null|NaN/);
  });

  it('name STOP in German as its button does, and each concept by one word', () => {
    for (const [key, text] of Object.entries({ ...first.de, ...all.de })) {
      expect(text, key).not.toMatch(/\bSTOP\b/);
      expect(text, key).not.toMatch(/Techniker|Technikkonto|Besuch/);
    }
    const tables = [...faults.flatMap((row) => [row.text, row.action]), ...Object.values(auditActions).flatMap(({ done, tried }) => [done, tried])];
    for (const text of tables) expect(text.de).not.toMatch(/\bSTOP\b|Techniker|Technikkonto|Besuch/);
  });

  it('have words for every event and every node', () => {
    for (const kind of eventKinds) if (kind !== 'none' && kind !== 'command_done') expect(textOf(`event.${kind}`), kind).not.toBeNull();
    for (const node of nodes) if (node.name !== 'core') expect(textOf(`health.part.${node.name}`), node.name).not.toBeNull();
  });
});

describe('the tables', () => {
  const all = [
    ...faults.flatMap((row) => [row.text, row.action]),
    ...refusals.map((row) => row.text),
    ...modes.map((row) => row.title),
    ...params.flatMap((row) => [row.title, row.effect]),
  ];

  it('have words in both languages', () => {
    for (const text of all) {
      expect(text.en).not.toBe('');
      expect(text.de).not.toBe('');
    }
  });

  it('and the message files call the hoist "Gerät" in German', () => {
    for (const text of [...Object.values(de), ...all.map((row) => row.de)]) expect(text).not.toMatch(/hilfe\b|Apparat/i);
  });

  it('explain every refusal, also one that this page does not know', () => {
    for (const row of refusals) expect(refusalText(row.name)).toBe(row.text.en);
    expect(refusalText('link_lost')).toBe(en['refused.link_lost']);
    expect(refusalText('something_new')).toBe(en['refused.unknown']);
  });
});

describe('numbers', () => {
  it('have a comma in German and a point in English', () => {
    expect(fixed(1.25, 2)).toBe('1.25');
    settings.set({ language: 'de' });
    expect(fixed(1.25, 2)).toBe('1,25');
    expect(plain(1234.5)).toBe('1235');
    expect(plain(0.0125)).toBe('0,0125');
    expect(t('refused.range', { min: plain(0.5), max: plain(60) })).toBe('Erlaubt: 0,5 bis 60');
  });

  it('never show minus zero, NaN or infinity', () => {
    expect(fixed(-0.001, 2)).toBe('0.00');
    expect(fixed(-0.4, 0)).toBe('0');
    expect(fixed(-1.2, 1)).toBe('−1.2');
    for (const value of [NaN, Infinity, -Infinity, null, undefined]) expect(fixed(value, 1)).toBe('–');
  });

  it('show angles in degrees only', () => {
    expect(degrees(Math.PI / 18)).toBe('10.0°');
    expect(degrees(-Math.PI / 180, 0)).toBe('−1°');
    expect(shownAs('lean_range_rad', 'rad')).toMatchObject({ unit: '°' });
    expect(shownAs('fall_rate_rad_s', 'rad/s').unit).toBe('°/s');
    expect(10 / shownAs('lean_range_rad', 'rad').factor).toBeCloseTo(0.174532925, 8);
    for (const row of params) expect(shownAs(row.name, row.unit).unit).not.toMatch(/^rad/);
  });

  it('stand apart from their unit, except from degrees', () => {
    expect(['°', '°/s', 'm', ''].map((unit) => withUnit('3', unit))).toEqual(['3°', '3 °/s', '3 m', '3']);
    expect(quantity(null, 1, 'cm')).toBe('–');
  });

  it('are read as people type them', () => {
    expect(readNumber('1,5')).toBe(1.5);
    expect(readNumber(' 1.5 ')).toBe(1.5);
    expect(readNumber('−3')).toBe(-3);
    expect(readNumber('.5')).toBe(0.5);
    expect(readNumber('1e-3')).toBe(0.001);
    for (const [language, thousands, clear] of [
      ['de', '1.000 −12.345 999.500', { '1,000': 1, '0.125': 0.125, '1000.125': 1000.125, '1.0000': 1, '1.5': 1.5 }],
      ['en', '1,000 -12,345 999,500', { '1.000': 1, '0,125': 0.125, '1000,125': 1000.125, '1,0000': 1, '1,5': 1.5 }],
    ] as const) {
      settings.set({ language });
      for (const text of thousands.split(' ')) expect(readNumber(text), text).toBeNaN();
      for (const [text, number] of Object.entries(clear)) expect(readNumber(text), text).toBe(number);
    }
    for (const text of ['', 'abc', '1,2,3', '1 2', '0x10', 'Infinity', 'NaN', '--1', '.']) expect(readNumber(text), text).toBeNaN();
  });

  it('show durations and dates', () => {
    expect(duration(0)).toBe('0:00');
    expect(duration(75.4)).toBe('1:15');
    expect(duration(11.5)).toBe('0:12');
    expect(duration(3599.6)).toBe('1:00:00');
    expect(duration(3671)).toBe('1:01:11');
    expect(duration(-2)).toBe('0:00');
    expect(duration(undefined)).toBe('–');
    expect(date(NaN)).toBe('–');
  });
});

describe('the tuning page', () => {
  it('shows every parameter once', () => {
    const shown = groups().flatMap((group) => group.rows.map((row) => row.name));
    // Dates of calibrations stand on their own screen.
    expect([...shown].sort()).toEqual(
      params
        .map((row) => row.name)
        .filter((name) => !name.startsWith('calibrated_'))
        .sort(),
    );
  });

  it('moves sliders in steps of 1, 2 or 5', () => {
    for (const row of params) {
      const range = (row.max - row.min) * shownAs(row.name, row.unit).factor;
      const step = niceStep(range);
      const lead = step / 10 ** Math.floor(Math.log10(step) + 1e-9);
      expect(
        [1, 2, 5].some((wanted) => Math.abs(lead - wanted) < 1e-6),
        row.name,
      ).toBe(true);
      expect(range / step).toBeGreaterThan(100);
      expect(range / step).toBeLessThan(450);
    }
  });
});
