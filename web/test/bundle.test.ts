// The built page: small enough, and fit for a strict content security policy. Builds it, because a stale dist/ proves nothing.
import { mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { afterAll, beforeAll, describe, expect, it, vi } from 'vitest';
import { build } from 'vite';

const firstLoad_bytes_max = 100_000;
let folder: string;
let files: { name: string; body: Buffer }[];

beforeAll(async () => {
  folder = mkdtempSync(join(tmpdir(), 'hoist-web-'));
  // As it is shipped: with the test runner's own NODE_ENV each element would also carry the name of its file.
  vi.stubEnv('NODE_ENV', 'production');
  await build({ logLevel: 'silent', build: { outDir: folder, emptyOutDir: true } });
  files = readdirSync(folder, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile())
    .map((entry) => ({ name: join(entry.parentPath, entry.name).slice(folder.length + 1), body: readFileSync(join(entry.parentPath, entry.name)) }));
}, 60_000);
afterAll(() => {
  vi.unstubAllEnvs();
  rmSync(folder, { recursive: true, force: true });
});

describe('the built console', () => {
  it('is at most 100 kB compressed, everything together', () => {
    const sum = files.reduce((total, file) => total + gzipSync(file.body, { level: 9 }).length, 0);
    expect(sum).toBeGreaterThan(10_000);
    expect(sum).toBeLessThanOrEqual(firstLoad_bytes_max);
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
