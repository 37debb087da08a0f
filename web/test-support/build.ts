// Builds the console once, for all tests that open it.
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { build } from 'vite';
import type { TestProject } from 'vitest/node';

declare module 'vitest' {
  export interface ProvidedContext {
    console: string;
  }
}

export default async function buildConsole(project: TestProject) {
  const folder = mkdtempSync(`${tmpdir()}/hoist-console-`);
  await build({ logLevel: 'silent', build: { outDir: folder, emptyOutDir: true } });
  project.provide('console', folder);
  return () => rmSync(folder, { recursive: true, force: true });
}
