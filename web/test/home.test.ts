// Patients: the search, and choosing one in a browser with the stand-in server.
import type { Page } from 'playwright-core';
import { beforeEach, describe, expect, it } from 'vitest';
import { dayOf, exists, found, isCode, match } from '../src/panels/home/model';
import type { SessionList, VisitList } from '../src/contract/rest.gen';
import { en } from '../src/text/en';
import { eachPage, minutes_ms } from '../test-support/browser';
import type { FakeServer } from '../test-support/fake_server.mjs';

const codes = (typed: string, all: string[]) =>
  found(
    all.map((code) => ({ code })),
    typed,
  ).map(({ code }) => code);

describe('the search for a code', () => {
  it('finds every code by each of its parts, written in any way', () => {
    for (const code of ['P-017', 'K-07', 'A 3/12', 'Ö-9'])
      for (let from = 0; from < code.length; from++)
        for (let to = from + 1; to <= code.length; to++) {
          const part = code.slice(from, to);
          expect(match(code, part), part).not.toBeNull();
          expect(match(code, part.toLocaleLowerCase()), part).not.toBeNull();
        }
    expect(match('P-017', 'p017')).toBe(0);
  });

  it('puts the same before what begins or ends so, and that before what contains it', () => {
    expect(codes('017', ['X-0179', 'P-017', '017', 'Q-9-017-2'])).toEqual(['017', 'P-017', 'X-0179', 'Q-9-017-2']);
    expect(codes('', ['b', 'a']), 'without a search the order stays').toEqual(['b', 'a']);
    expect(codes('zz', ['a', 'b'])).toEqual([]);
  });

  it('takes only exactly the same code for the same patient', () => {
    expect(exists([{ code: 'P-017' }], '017')).toBe(false);
    expect(exists([{ code: 'P-017' }], ' p-017 ')).toBe(true);
  });

  it('offers a new patient only for what the server takes as a code', () => {
    for (const code of ['P-017', ' mül_3.b ', 'Ž1', '7', 'x'.repeat(32)]) expect(isCode(code), code).toBe(true);
    for (const code of ['', 'Anna Novak', 'P/17', '100%', '-1', '.x', '5€', 'x'.repeat(33)]) expect(isCode(code), code).toBe(false);
  });

  it('writes days as the server does', () => {
    expect(dayOf(new Date(2026, 0, 5, 23, 59))).toBe('2026-01-05');
  });
});

describe('Home', { timeout: minutes_ms }, () => {
  const start = eachPage(1024, 768);
  let fake: FakeServer;
  let page: Page;
  beforeEach(async () => {
    ({ fake, page } = await start());
    await page.goto(fake.url);
    await page.locator('.home .rows li').first().waitFor();
  });
  const rows = () => page.locator('.home .rows strong').allTextContents();
  const choose = (code: string) => page.getByRole('button', { name: en['home.chooseName'].replace('{code}', code) }).click();

  it('is the first screen; the chosen patient stands in the bar of every screen, and of every device', async () => {
    await choose('P-017');
    await page.locator('.home-code', { hasText: 'P-017' }).waitFor();
    await page.goto(`${fake.url}#/tune`);
    await page.locator('.bar-patient', { hasText: 'P-017' }).waitFor();
    const other = await page.context().browser()!.newPage({ locale: 'en' });
    await other.goto(`${fake.url}#/walk`);
    await other.locator('.bar-patient', { hasText: 'P-017' }).waitFor();
    await page.goto(`${fake.url}#/home`);
    await page.getByRole('button', { name: en['home.finish'] }).click();
    await other.locator('.bar-patient', { hasText: '–' }).waitFor();
    await other.close();
  });

  it('goes by the clock of the hoist for what was today, not by that of the tablet', async () => {
    const days_ms = 3 * 86_400_000;
    await page.clock.setFixedTime(Date.now() - days_ms);
    await page.reload();
    await page.locator('.home .rows li', { hasText: 'P-017' }).waitFor();
    await page.getByRole('heading', { name: en['home.today'] }).waitFor({ timeout: 5000 });
    expect((await rows())[0]).toBe('P-017');
  });

  it('never offers a new patient in place of one that exists: 017 shows P-017 first, and the new one below', async () => {
    await page.locator('.home input[type=search]').fill('017');
    await expect.poll(rows, { timeout: 10_000 }).toEqual(['P-017']);
    const offer = page.getByRole('button', { name: en['home.create'].replace('{code}', '017'), exact: true });
    await offer.waitFor();
    const above = (await page.locator('.home .rows li').first().boundingBox())!.y < (await offer.boundingBox())!.y;
    expect(above).toBe(true);
    await page.locator('.home input[type=search]').fill('P-017');
    await expect.poll(() => page.locator('.home-new').count(), { timeout: 10_000 }).toBe(0);
  });

  it('makes a new patient and chooses it at once', async () => {
    await page.locator('.home input[type=search]').fill('Z-99');
    await page.getByRole('button', { name: en['home.create'].replace('{code}', 'Z-99'), exact: true }).click();
    await expect.poll(() => fake.hoist.patient?.code, { timeout: 10_000 }).toBe('Z-99');
    await page.locator('.home-code', { hasText: 'Z-99' }).waitFor();
  });

  it('finds archived patients by their code, marks them, and offers neither to choose them nor their code as new', async () => {
    await page.evaluate(async () => {
      for (const id of [4, 5]) await fetch(`/api/v1/patients/${id}`, { method: 'PATCH', body: '{"archived":true}' });
    });
    await page.reload();
    const row = (code: string) => page.locator('.home .rows li', { hasText: code });
    // With a visit today.
    await row('P-017').getByText(en['patient.archived']).waitFor();
    expect(await row('P-017').getByRole('button').count()).toBe(0);
    expect(await row('K-07').getByRole('button').count()).toBe(1);
    expect(await rows()).not.toContain('P-016');
    await page.locator('.home input[type=search]').fill('p-016');
    await row('P-016').getByText(en['patient.archived']).waitFor();
    expect(await row('P-016').getByRole('button').count()).toBe(0);
    expect(await page.locator('.home-new').count()).toBe(0);
  });

  it('offers to enter a damaged name again', async () => {
    await page.route('**/api/v1/patients/5/identity', (route) =>
      route.request().method() === 'GET' ? route.fulfill({ json: { state: 'damaged', identity: null, etag: 'p5' } }) : route.continue(),
    );
    await page.goto(`${fake.url}#/patients/5`);
    await page.getByRole('button', { name: en['patient.show'] }).click();
    await page.getByText(en['patient.damaged']).waitFor();
    await page.getByLabel(en['patient.fullName']).fill('Erika Muster');
    await page.unroute('**/api/v1/patients/5/identity');
    await page.getByRole('form', { name: en['patient.identity'] }).getByRole('button', { name: en['common.save'] }).click();
    await page.locator('.patient-known', { hasText: 'Erika Muster' }).waitFor();
  });

  it('asks for no name before someone wants to see it, and forgets it on leaving the page', async () => {
    const asked: string[] = [];
    page.on('request', (request) => asked.push(new URL(request.url()).pathname));
    await page.locator('.home a.row-text', { hasText: 'P-017' }).click();
    await page.locator('.patient').waitFor();
    await page.getByRole('button', { name: en['patient.show'] }).waitFor();
    expect(asked.filter((path) => path.endsWith('/identity'))).toEqual([]);
    await page.getByRole('button', { name: en['patient.show'] }).click();
    await page.getByText('Erika Musterfrau').waitFor();
    await page.locator('.bar-patient').click();
    await page.locator('.home').waitFor();
    expect(await page.locator('body').textContent()).not.toContain('Musterfrau');
  });

  it('names walks along a line that staff have drawn by the name of the line', async () => {
    await page.route('**/api/v1/sessions?*', async (route) => {
      const answer = await route.fetch();
      const list = (await answer.json()) as SessionList;
      for (const session of list.items) if (session.task !== null) Object.assign(session.task, { task: 'own_line', line: 'Hall' });
      await route.fulfill({ response: answer, json: list });
    });
    await page.goto(`${fake.url}#/patients/1`);
    await page.locator('.patient .rows li', { hasText: 'Hall, 2/3' }).waitFor();
    await page.locator('.trend select').nth(1).waitFor();
    expect(await page.locator('.trend select').nth(1).textContent()).toMatch(/Hall, \d+\.\d\d.m/);
  });

  it('lists every session of the patient, also behind more than a page of newer ones', async () => {
    const ids = Array.from({ length: 201 }, (_, i) => 300 - i);
    await page.route('**/api/v1/visits?*', async (route) => {
      const answer = await route.fetch();
      const list = (await answer.json()) as VisitList;
      await route.fulfill({ response: answer, json: { ...list, items: [{ ...list.items[0]!, sessions: [...ids].reverse() }] } });
    });
    // As the server: pages of at most 200, newest first, and a code that contains this one is another patient's.
    await page.route('**/api/v1/sessions?*', async (route) => {
      const asked = new URL(route.request().url()).searchParams;
      const answer = await route.fetch({ url: `${fake.url}api/v1/sessions?q=K-07` });
      const [session] = ((await answer.json()) as SessionList).items;
      const all = asked.get('patient') === '1' ? ids : Array.from({ length: 200 }, (_, i) => 600 - i);
      const [first] = asked.has('cursor') ? [200] : [0];
      const items = all.slice(first, first + 200).map((id) => ({ ...session!, id }));
      await route.fulfill({ response: answer, json: { items, next: first + 200 < all.length ? '101' : null, total: all.length } });
    });
    await page.goto(`${fake.url}#/patients/1`);
    const names = page.locator('.patient-visit .rows strong');
    await expect.poll(() => names.count(), { timeout: 10_000 }).toBe(201);
    await expect.poll(() => names.filter({ hasText: /^Session/ }).count(), { timeout: 10_000 }).toBe(0);
  });

  it('deletes a patient only by holding, and never the current one', async () => {
    await page.goto(`${fake.url}#/patients/1`);
    const hold = page.getByRole('button', { name: en['patient.deleteHold'] });
    await hold.click();
    await page.waitForTimeout(100);
    await page.goto(`${fake.url}#/home`);
    await expect.poll(rows, { timeout: 10_000 }).toContain('K-07');
    await choose('K-07');
    await page.locator('.home-code', { hasText: 'K-07' }).waitFor();
    await page.goto(`${fake.url}#/patients/1`);
    expect(await hold.isDisabled()).toBe(true);
    await page.goto(`${fake.url}#/patients/4`);
    await hold.click({ delay: 2300 });
    await page.locator('.home .rows li').first().waitFor();
    expect(await rows()).not.toContain('P-016');
  });
});
