// The console as built, and a browser to open it in.
import { chromium, type Browser, type Page } from 'playwright-core';
import { afterAll, afterEach, beforeAll, inject } from 'vitest';
import { startFakeServer, type FakeServer } from './fake_server.mjs';
import { browserProgram, drawLess } from './headless.mjs';

/** A browser starts within this time also on a busy machine. */
export const minutes_ms = 120_000;

export interface BuiltConsole {
  /** Folder with the static files. */
  folder: string;
  browser: Browser;
  close: () => Promise<void>;
}

export async function openBuiltConsole(): Promise<BuiltConsole> {
  const browser = await chromium.launch({
    executablePath: browserProgram,
    args: ['--no-sandbox', '--disable-gpu', '--no-first-run'],
  });
  const newPage = browser.newPage.bind(browser);
  browser.newPage = async (options) => {
    const page = await newPage(options);
    await page.addInitScript(drawLess);
    return page;
  };
  return { folder: inject('console'), browser, close: () => browser.close() };
}

/** For the tests of one file: a function that opens a page of this size beside a stand-in server of its own. Both are closed after the test. */
export function eachPage(width: number, height: number) {
  let built: BuiltConsole;
  const open: { close: () => Promise<void> }[] = [];
  beforeAll(async () => {
    built = await openBuiltConsole();
  }, minutes_ms);
  afterEach(async () => {
    for (const one of open.splice(0)) await one.close();
  });
  afterAll(() => built?.close());
  return async (options: Parameters<typeof startFakeServer>[0] = {}, locale = 'en'): Promise<{ fake: FakeServer; page: Page }> => {
    const fake = await startFakeServer({ dist: built.folder, ...options });
    const page = await built.browser.newPage({ viewport: { width, height }, locale });
    open.push(page, fake);
    return { fake, page };
  };
}
