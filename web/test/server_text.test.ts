// The server's answers are shown by code; its sentences are never parsed.
import { readdirSync, readFileSync } from 'node:fs';
import { beforeEach, describe, expect, it } from 'vitest';
import { reasons as rows } from '../src/contract/messages.gen';
import type { ReasonCode } from '../src/contract/rest.gen';
import { en } from '../src/text/en';
import { problemText, reasonText } from '../src/text/server';
import { settings } from '../src/text/settings';
import { reasons } from '../src/ui/refusal';

beforeEach(() => settings.set({ language: 'en' }));

const sources = (folder: string) =>
  readdirSync(folder, { recursive: true, encoding: 'utf8' })
    .filter((file) => /\.(cpp|tsx?)$/.test(file))
    .map((file) => readFileSync(`${folder}/${file}`, 'utf8'))
    .join('\n');

describe('the table of reasons', () => {
  it('has words in both languages', () => {
    for (const [code, text] of Object.entries(rows)) {
      expect(text.en, code).toMatch(/\.$/);
      expect(text.de, code).toMatch(/\.$/);
      expect(text.de, code).not.toBe(text.en);
    }
  });

  it('has every code that the figures of a session give', () => {
    const { enum: codes } = (
      JSON.parse(readFileSync('../server/contract/openapi.gen.json', 'utf8')) as {
        components: { schemas: { NoFigure: { enum: string[] } } };
      }
    ).components.schemas.NoFigure;
    expect(codes.filter((code) => reasonText(code) === null)).toEqual([]);
  });

  it('has the problems of the routes that this console asks', () => {
    const names = [...sources('../server/api').matchAll(/name = "([a-z-]+)"/g)].map(([, name]) => name!.replaceAll('-', '_'));
    expect(names).toEqual(expect.arrayContaining(['unknown', 'storage', 'busy', 'disk_full', 'not_now']));
    for (const name of ['unknown', 'storage', 'busy', 'disk_full', 'not_now', 'invalid', 'refused', 'no_core', 'internal', 'role', 'no_session'])
      expect(reasonText(name), name).not.toBeNull();
  });
});

describe('this console', () => {
  it('never looks at a sentence of the server', () => {
    const all = ['ui', 'panels', 'link', 'text'].map((folder) => sources(`src/${folder}`)).join('\n');
    expect(all.match(/\b(reply|answer|problem|message|recording)\??\.(detail|title|reason_if_none)\b/g)).toBeNull();
  });
});

describe('reasons of a refusal', () => {
  const reply = { ok: false, refusals: [], errors: [] };
  it('are never left out', () => {
    expect(reasons(reply)).toEqual([en['refused.unknown']]);
    expect(reasons({ ...reply, reason_code: 'something_new' as ReasonCode })).toEqual([en['refused.unknown']]);
    expect(reasons({ ...reply, refusals: ['link_lost', 'link_lost'] })).toEqual([en['refused.link_lost']]);
  });

  it('are in the language of the reader', () => {
    settings.set({ language: 'de' });
    expect(reasons({ ...reply, reason_code: 'no_core' })).toEqual(['Der Steuerrechner antwortet nicht.']);
    expect(reasons({ ...reply, reason_code: 'measurement', errors: [{ field: 'figure', message: 'must be a number' }] })[0]).toMatch(
      /^Diese Messung/,
    );
    const problem = { status: 422, code: 'invalid', refusals: [], errors: [{ field: 'note', message: 'must be plain text' }], wait_s: null };
    expect(problemText(problem)).toBe('Die Notiz ist zu lang.');
    expect(problemText({ ...problem, code: 'taken', errors: [{ field: 'code', message: 'another patient has this code already' }] })).toBe(
      'Diese Bezeichnung gibt es schon.',
    );
    expect(problemText({ ...problem, errors: [] })).toBe('Dieser Wert ist nicht brauchbar.');
    expect(problemText({ ...problem, code: 'something_new', errors: [] })).toMatch(/abgelehnt/);
  });
});
