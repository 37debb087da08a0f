// The page of the API's routes: what it sends, and that it works in a browser under the console's policy.
import { readFileSync } from 'node:fs';
import axe from 'axe-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { bodyOf, exampleOf, groupsOf, matches, requestOf, type Description, type Route, type Schema } from '../src/docs/model';
import { openBuiltConsole, type BuiltConsole } from '../test-support/browser';
import { startFakeServer, type FakeServer } from '../test-support/fake_server.mjs';

const description = JSON.parse(readFileSync('../server/contract/openapi.gen.json', 'utf8')) as Description;
const routes = [...groupsOf(description).values()].flat();
const route = (operation: string): Route => routes.find((one) => one.operation.operationId === operation)!;
const filled = { inputs: {}, body: null, token: '' };

describe('a request from the form', () => {
  it('is there for every route of the description', () => {
    const all = Object.values(description.paths).flatMap((methods) => Object.keys(methods));
    expect(routes.length).toBe(all.length);
    expect(routes.length).toBeGreaterThan(90);
  });

  it('puts each field where the description says, and leaves empty ones out', () => {
    const inputs = { 'path id': '7/8', 'query limit': '5', 'query cursor': '' };
    expect(requestOf(route('list_profiles'), { ...filled, inputs }).address).toBe('/api/v1/patients/7%2F8/profiles?limit=5');
    const { init } = requestOf(route('change_patient'), { inputs: { 'path id': '7', 'header If-Match': '"ab"' }, body: '{}', token: '' });
    expect(init).toMatchObject({ method: 'PATCH', credentials: 'same-origin', body: '{}' });
    expect(init.headers).toEqual({ 'If-Match': '"ab"', 'X-Hoist': '1', 'Content-Type': 'application/json' });
  });

  it('shows the cookie or the token, never both', () => {
    expect(requestOf(route('get_status'), filled).init.headers).toEqual({});
    const byToken = requestOf(route('stop'), { ...filled, token: 'abc' }).init;
    expect(byToken).toMatchObject({ credentials: 'omit', headers: { Authorization: 'Bearer abc' } });
  });

  it('begins with a body that has what its schema needs', () => {
    const lacks = (schema: Schema, value: unknown): string[] => {
      if (schema.$ref !== undefined) return lacks(description.components.schemas[schema.$ref.replace(/^.*\//, '')]!, value);
      if (schema.anyOf !== undefined) return lacks(schema.anyOf[0]!, value);
      if (typeof value !== 'object' || value === null || Array.isArray(value)) return [];
      const members = value as Record<string, unknown>;
      const missing = (schema.required ?? []).filter((name) => members[name] === undefined);
      return [...missing, ...Object.entries(members).flatMap(([name, member]) => lacks(schema.properties?.[name] ?? {}, member))];
    };
    const bodies = routes.map(({ operation }) => bodyOf(operation)).filter((body) => body?.type === 'application/json');
    expect(bodies.length).toBeGreaterThan(30);
    for (const body of bodies) expect(lacks(body!.schema, exampleOf(body!.schema, description))).toEqual([]);
    expect(exampleOf(bodyOf(route('sign_in').operation)!.schema, description)).toEqual({ user: 'text' });
  });

  it('is found by any of its words', () => {
    expect(routes.filter((one) => matches(one, 'patient trend')).map((one) => one.operation.operationId)).toContain('get_trend');
    expect(routes.filter((one) => matches(one, 'no such thing'))).toEqual([]);
  });
});

describe('the page', () => {
  let built: BuiltConsole;
  let fake: FakeServer;
  beforeAll(async () => {
    built = await openBuiltConsole();
    fake = await startFakeServer({ dist: built.folder });
  }, 120_000);
  afterAll(async () => {
    await built?.close();
    await fake?.close();
  });

  it('tries a route, shows its answer, and has STOP', { timeout: 120_000 }, async () => {
    const page = await built.browser.newPage({ viewport: { width: 390, height: 844 } });
    const complaints: string[] = [];
    page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
    page.on('pageerror', (error) => complaints.push(String(error)));
    await page.goto(`${fake.url}api/docs#get_time`);
    await page.locator('#get_time[open] form').waitFor();
    await page.locator('#get_time input').fill('5');
    await page.locator('#get_time button').click();
    await page.locator('#get_time .docs-status').waitFor();
    expect(await page.locator('#get_time .docs-status').textContent()).toMatch(/^200 · \d+ ms · \/api\/v1\/time\?client_utc_ms=5$/);
    expect(await page.locator('#get_time .docs-answer pre').textContent()).toContain('"kept_by": "operating_system"');
    await page.locator('input[type=search]').fill('create patient');
    await page.locator('#create_patient > summary').click();
    await page.locator('#create_patient textarea').fill('{"code": "P-099"}');
    await page.locator('#create_patient button').click();
    await page.locator('#create_patient .docs-status').waitFor();
    expect(await page.locator('#create_patient .docs-answer').textContent()).toContain('P-099');
    await page.evaluate(axe.source);
    const found = await page.evaluate(async () => {
      const { violations } = await (window as unknown as { axe: typeof axe }).axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'] });
      return violations.flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.html.slice(0, 160)}`));
    });
    expect(found).toEqual([]);
    expect(await page.evaluate(() => document.documentElement.scrollWidth <= window.innerWidth)).toBe(true);
    await page.locator('.docs-stop').dispatchEvent('pointerdown');
    await page.getByText('STOP sent.').waitFor();
    expect(fake.hoist.mode).toBe('protective_stop');
    expect(complaints).toEqual([]);
    await page.close();
  });
});
