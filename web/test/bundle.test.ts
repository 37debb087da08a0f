// The built page: small enough, in the right pieces, and fit for a strict content security policy. Builds it, because dist/ may be stale.
import { mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { afterAll, beforeAll, describe, expect, it, vi } from 'vitest';
import { build } from 'vite';
import { panels } from '../src/panels/index';

const firstLoad_bytes_max = 70_000;
const screen_bytes_max = 30_000;
/** Driving and stopping must not wait for a file: these modules are in the first load. */
const vital = [
  'ui/stop_button.tsx',
  'ui/strip.tsx',
  'ui/status_bar.tsx',
  'ui/alarms.ts',
  'ui/hand.ts',
  'ui/hold_to_run.ts',
  'ui/hold_button.tsx',
  'ui/hold_to_go.tsx',
  'ui/lazy.tsx',
  'link/console.ts',
  'link/socket.ts',
  'link/live.ts',
  'link/readiness.ts',
  'text/first.ts',
  'contract/faults.gen.ts',
];

interface Chunk {
  source?: string;
  modules: string[];
  imports: string[];
  css: string[];
}
let folder: string;
let files: { name: string; body: Buffer }[];
let chunks: Map<string, Chunk>;

beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), 'hoist-web-'));
  // As it is shipped: with the test runner's own NODE_ENV each element would also carry the name of its file.
  vi.stubEnv('NODE_ENV', 'production');
  const built = await build({ logLevel: 'silent', build: { outDir: folder, emptyOutDir: true } });
  if (!('output' in built)) throw new Error('one build, one output');
  chunks = new Map(
    built.output.flatMap((file) =>
      file.type === 'chunk'
        ? [
            [
              file.fileName,
              {
                source: file.facadeModuleId?.split('/src/')[1],
                modules: file.moduleIds.map((id) => id.split('/src/')[1] ?? id),
                imports: file.imports,
                css: [...((file as { viteMetadata?: { importedCss: Set<string> } }).viteMetadata?.importedCss ?? [])],
              },
            ] as const,
          ]
        : [],
    ),
  );
  files = readdirSync(folder, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => ({ name: join(entry.parentPath, entry.name).slice(folder.length + 1), body: readFileSync(join(entry.parentPath, entry.name)) }));
}, 60_000);
afterAll(() => {
  vi.unstubAllEnvs();
  rmSync(folder, { recursive: true, force: true });
});

/** All static imports of these sources. */
function needed(sources: readonly string[]): Set<string> {
  const all = new Set<string>();
  const add = (name: string) => {
    if (all.has(name)) return;
    all.add(name);
    const chunk = chunks.get(name);
    for (const other of [...(chunk?.imports ?? []), ...(chunk?.css ?? [])]) add(other);
  };
  for (const source of sources) {
    const [name] = [...chunks].find(([, chunk]) => chunk.source === source) ?? [];
    if (name === undefined) throw new Error(`${source} is no file of its own`);
    add(name);
  }
  return all;
}
const weight_bytes = (names: Iterable<string>) =>
  [...names].reduce((sum, name) => sum + gzipSync(files.find((file) => file.name === name)!.body, { level: 9 }).length, 0);
const entry = () => [...chunks].find(([, chunk]) => chunk.modules.includes('main.tsx'))!;
const page = () => new Set(['index.html', ...needed([entry()[1].source!])]);
const screen = (id: string) => `panels/${id}/${id}.tsx`;

describe('the built console', () => {
  it.each([
    ['en', 'home'],
    ['de', 'home'],
    ['en', 'walk'],
    ['de', 'walk'],
  ])('begins with at most 70 kB compressed: page, one language (%s), one screen (%s)', (language, id) => {
    const first = new Set([...page(), ...needed([`text/${language}.ts`, screen(id)])]);
    expect(weight_bytes(first)).toBeGreaterThan(10_000);
    expect(weight_bytes(first)).toBeLessThanOrEqual(firstLoad_bytes_max);
  });

  it.each(panels.map(({ id }) => id))('needs at most 30 kB more for %s', (id) => {
    const here = page();
    const more = [...needed([screen(id)])].filter((name) => !here.has(name));
    expect(more.length).toBeGreaterThan(0);
    expect(weight_bytes(more)).toBeLessThanOrEqual(screen_bytes_max);
  });

  it('loads the chart with its library only for an opened session, at most 30 kB', () => {
    const list = needed([screen('sessions')]);
    const more = [...needed(['panels/sessions/chart.tsx'])].filter((name) => !list.has(name) && !page().has(name));
    expect(weight_bytes(more)).toBeGreaterThan(10_000);
    expect(weight_bytes(more)).toBeLessThanOrEqual(screen_bytes_max);
  });

  it('has STOP, the connection, the alarms and hold-to-run in the page itself', () => {
    const [name, { modules, imports }] = entry();
    const together = [name, ...imports].flatMap((one) => chunks.get(one)!.modules);
    expect(vital.filter((file) => !together.includes(file))).toEqual([]);
    expect(modules).not.toEqual(expect.arrayContaining([expect.stringMatching(/^(panels\/\w+\/|text\/(en|de)\.)/)]));
  });

  it('has no inline script, style or data image, and asks nobody outside for anything', () => {
    const html = files.find((file) => file.name === 'index.html')!.body.toString();
    expect(html).not.toMatch(/<script(?![^>]*\bsrc=)[^>]*>/);
    expect(html).not.toMatch(/<style|\sstyle=|\son\w+=/);
    for (const file of files) {
      const text = file.body.toString();
      const outside = (text.match(/https?:\/\/[\w.-]+/g) ?? []).filter((address) => !address.startsWith('http://www.w3.org'));
      expect(outside, file.name).toEqual([]);
      expect(text, file.name).not.toMatch(/url\(["']?data:/);
    }
  });

  it('does not need eval', () => {
    for (const file of files) if (file.name.endsWith('.js')) expect(file.body.toString(), file.name).not.toMatch(/\beval\(|new Function\(/);
  });
});
