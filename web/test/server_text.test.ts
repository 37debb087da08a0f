import { existsSync, readdirSync, readFileSync } from 'node:fs';
import { beforeEach, describe, expect, it } from 'vitest';
import { en } from '../src/text/en';
import { engineSentences, serverSentences, serverText } from '../src/text/server';
import { settings } from '../src/text/settings';
import { reasons } from '../src/ui/refusal';

beforeEach(() => settings.set({ language: 'en' }));

const sources = ['../server', '../db', '../control'].filter((folder) => existsSync(folder));
const texts = () =>
  sources
    .flatMap((folder) => readdirSync(folder, { recursive: true, encoding: 'utf8' }).map((file) => `${folder}/${file}`))
    .filter((file) => /\.(cpp|hpp)$/.test(file))
    .map((file) => readFileSync(file, 'utf8'))
    .join('\n');

/** `the core refused:` and what follows it are two literals, joined where they are said. */
const said = (all: string, key: string) => key.replace(/^the core refused: (?=[^*])/, '').split(/[#*]/, 1).every((start) => all.includes(`"${start}`) || all.includes(start));

describe('sentences of the server', () => {
  it('are all said by it still, letter by letter', () => {
    expect(sources).toHaveLength(3);
    const all = texts();
    // Numbers are put in where a # stands: the words before the first one must be there.
    for (const key of Object.keys(serverSentences)) expect(said(all, key), key).toBe(true);
  });

  it('have words in both languages', () => {
    for (const [key, words] of [...Object.entries(serverSentences), ...Object.entries(engineSentences)]) {
      expect(words.en, key).not.toBe('');
      expect(words.de, key).not.toBe('');
      expect(words.de, key).not.toBe(words.en);
    }
  });

  it('are known whatever numbers stand in them', () => {
    expect(serverText('there is no session 4711')).toBe('This session is no longer there.');
    settings.set({ language: 'de' });
    expect(serverText('session 12 is being recorded: end it first')).toBe('Diese Sitzung wird noch aufgezeichnet.');
  });

  it('tell each reason why the core is not connected', () => {
    settings.set({ language: 'de' });
    const link = ['server_link.cpp', 'segment.cpp'].map((file) => readFileSync(`../control/publish/${file}`, 'utf8')).join('\n');
    const desk = /string_view CoreDesk::problem[^}]*/.exec(readFileSync('../server/link/core_desk.cpp', 'utf8'))![0];
    const sentences = [...`${link}\n${desk}`.matchAll(/(?:error_? = |return |kSilent = |last_error\(|string\(|[?:] )(?:std::string\()?"([^"\n]{9,})"/g)].map(([, text]) => text!);
    expect(sentences.length).toBeGreaterThan(12);
    for (const sentence of sentences) expect(serverText(`${sentence}x`) ?? serverText(sentence), sentence).not.toBeNull();
    for (const text of ['the core refused: another server is attached', 'the core refused: the server runs as another user']) expect(serverText(text), text).toMatch(/Konsolenserver/);
  });

  it('that are not known are shown to English readers only', () => {
    expect(serverText('Something new', 'The recorder is busy')).toMatch(/^Busy just now/);
    expect(serverText('', undefined, 'Something new')).toBe('Something new');
    settings.set({ language: 'de' });
    expect(serverText('Something new')).toBeNull();
    expect(serverText('database or disk is full')).toBe('Der Speicher ist voll.');
  });
});

describe('reasons of a refusal', () => {
  const reply = { ok: false, refusals: [], errors: [] };
  it('are never left out', () => {
    expect(reasons(reply)).toEqual([en['refused.unknown']]);
    expect(reasons({ ...reply, refusals: ['link_lost', 'link_lost'] })).toEqual([en['refused.link_lost']]);
  });

  it('are in the language of the reader', () => {
    settings.set({ language: 'de' });
    expect(reasons({ ...reply, detail: 'The control core is not connected.' })).toEqual(['Der Steuerrechner antwortet nicht.']);
    expect(reasons({ ...reply, detail: 'The measurement cannot be used.', errors: [{ field: 'figure', message: 'must be a number' }] })[0]).toMatch(/^Diese Messung/);
    for (const detail of ['A new sentence.', '']) expect(reasons({ ...reply, detail })[0]).toMatch(/abgelehnt/);
  });
});
