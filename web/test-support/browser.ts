// The console as built, and a browser to open it in, for the tests of one file.
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { chromium, type Browser } from 'playwright-core';
import { build } from 'vite';

export interface BuiltConsole {
  /** Folder with the static files. */
  folder: string;
  browser: Browser;
  close: () => Promise<void>;
}

export async function openBuiltConsole(): Promise<BuiltConsole> {
  const folder = mkdtempSync(`${tmpdir()}/hoist-console-`);
  await build({ logLevel: 'silent', build: { outDir: folder, emptyOutDir: true } });
  const browser = await chromium.launch({
    executablePath: process.env.CHROME_PATH ?? '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-gpu', '--no-first-run'],
  });
  const close = async () => {
    await browser.close();
    rmSync(folder, { recursive: true, force: true });
  };
  return { folder, browser, close };
}
