// The real Foxglove Studio (npm: @foxglove/studio-base) in headless Chromium against the real programs: watching, driving, tuning, a recording.
//
//   node tests/system/studio/studio.mjs [--bin build/bin] [--shots DIR]
//
// The hoist's motion is read from the simulator, never from Studio. Prints `N passed, N failed, N skipped`.
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { extname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { browserProgram } from '../../../web/test-support/headless.mjs';
import { assert, sleep, Stack, until } from '../../web/stack.mjs';

const here = fileURLToPath(new URL('.', import.meta.url));
const top = resolve(here, '../../..');
const option = (name, fallback) => (process.argv.includes(`--${name}`) ? process.argv[process.argv.indexOf(`--${name}`) + 1] : fallback);
const bin = resolve(option('bin', join(top, 'build/bin')));
const shots = option('shots');
const modules = join(here, 'node_modules');
/** Studio draws with software here, and its bundle is 30 MB of script. */
const slow_ms = 90_000;

/** The struts sway with a patient who stands. */
const stillPixels = 400;

let stack;
let page;
let exported = 0; // answers to a part of the file
const errors = [];

const types = { '.js': 'text/javascript', '.html': 'text/html', '.json': 'application/json', '.wasm': 'application/wasm' };
const files = {
  '/studio/': join(here, 'page.html'),
  '/studio/react.js': join(modules, 'react/umd/react.production.min.js'),
  '/studio/react-dom.js': join(modules, 'react-dom/umd/react-dom.production.min.js'),
  '/studio/layout.json': join(top, 'web/public/foxglove-layout.json'),
};

/** Studio's files under the hoist's own origin, so that a recording is fetched with the sign-in of the page. */
async function serveStudio(route) {
  const { pathname } = new URL(route.request().url());
  const path = files[pathname] ?? join(modules, '@foxglove/studio-base', pathname.replace('/studio/', ''));
  if (!existsSync(path)) return route.fulfill({ status: 404, body: '' });
  return route.fulfill({ status: 200, contentType: types[extname(path)] ?? 'application/octet-stream', body: readFileSync(path) });
}

const shot = async (name) => {
  if (shots) await page.screenshot({ path: join(shots, `${name}.png`) });
};
const speed = async () => Math.abs((await stack.truth()).speed_m_s);
const mode = async () => (await stack.coreStatus()).mode;

async function openStudio(query) {
  await page.goto(`${stack.origin}/studio/?${query}`);
  await page.locator('canvas').first().waitFor({ timeout: slow_ms });
}

/** Pixels of the 3-D panel that differ between two pictures of it. */
async function scene() {
  const panel = page.locator('canvas').first();
  return (await panel.screenshot()).toString('base64');
}
const differing = (a, b) =>
  page.evaluate(
    async ([first, second]) => {
      const pixels = async (png) => {
        const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
        const canvas = new OffscreenCanvas(image.width, image.height);
        const context = canvas.getContext('2d');
        context.drawImage(image, 0, 0);
        return context.getImageData(0, 0, image.width, image.height).data;
      };
      const [x, y] = [await pixels(first), await pixels(second)];
      let count = 0;
      for (let i = 0; i < x.length; i += 4) if (Math.abs(x[i] - y[i]) + Math.abs(x[i + 1] - y[i + 1]) + Math.abs(x[i + 2] - y[i + 2]) > 60) count++;
      return count;
    },
    [a, b],
  );

const press = (label) => page.getByRole('button', { name: label, exact: true }).click();
const up = () => page.locator('svg[viewBox="0 0 256 256"] g[role=button]').first();

/** Holds the upper button of Studio's teleop panel while `work` goes on. */
async function holding(work) {
  const box = await up().boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 4);
  await page.mouse.down();
  try {
    return await work();
  } finally {
    await page.mouse.up();
  }
}

const cases = {
  async 'Studio connects, and its 3-D view stands still with the hoist'() {
    const token = readFileSync(stack.path('token'), 'utf8').trim();
    const address = `${stack.origin.replace('http', 'ws')}/foxglove?token=${token}`;
    await openStudio(`ds=foxglove-websocket&ds.url=${encodeURIComponent(address)}`);
    await page.getByText('remote_speed_m_s_max', { exact: true }).waitFor({ timeout: slow_ms });
    await sleep(3000); // models and grid
    await shot('connected');
    const before = await scene();
    await sleep(1000);
    const moved = await differing(before, await scene());
    assert(moved < stillPixels, `${moved} pixels change although nothing moves`);
  },
  async 'a parameter edited in Studio is in force'() {
    const row = page.locator('tr', { hasText: 'remote_speed_m_s_max' });
    const value = async () => (await stack.rest('GET', '/parameters')).json().items.find((item) => item.name === 'remote_speed_m_s_max').value;
    const wanted = (await value()) === 0.25 ? 0.22 : 0.25;
    await until(
      'the edit',
      async () => {
        // A row is drawn anew when a value changes.
        await row.locator('textarea').fill(String(wanted), { timeout: 2000 }).catch(() => {});
        await row.hover({ timeout: 2000 }).catch(() => {});
        await row.getByRole('button', { name: 'Submit change' }).click({ timeout: 2000 }).catch(() => {});
        return (await value()) === wanted;
      },
      slow_ms,
      500,
    );
    await shot('parameter');
  },
  async 'the teleop panel drives, the 3-D view follows, letting go stops'() {
    await press('Take control');
    await until('control', async () => (await stack.rest('GET', '/lease')).json().holder !== 0);
    await press('Begin driving');
    await until('the mode', async () => (await mode()) === 'remote');
    const before = await scene();
    const from = await stack.truth();
    await holding(() => until('the hoist drives', async () => (await speed()) > 0.1, 20_000));
    await until('the hoist stands', async () => (await speed()) < 0.02, 5000);
    assert((await mode()) === 'remote', 'letting go has ended driving');
    const driven_m = async () => {
      const { x_m, y_m } = await stack.truth();
      return Math.hypot(x_m - from.x_m, y_m - from.y_m);
    };
    await holding(() => until('half a metre', async () => (await driven_m()) > 0.5, 30_000));
    await until('the hoist stands', async () => (await speed()) < 0.02, 5000);
    await sleep(1000);
    const moved = await differing(before, await scene());
    await shot('driven');
    assert(moved > 4 * stillPixels, `${moved} pixels of the 3-D view have changed`);
  },
  async 'STOP of the layout stops, with the button still held'() {
    await holding(async () => {
      await until('the hoist drives', async () => (await speed()) > 0.1, 20_000);
      // The mouse is busy with the teleop panel: the keyboard presses.
      await page.getByRole('button', { name: 'STOP', exact: true }).focus();
      await page.keyboard.press('Enter');
      await until('it has stopped', async () => (await speed()) < 0.02 && (await mode()) !== 'remote', 5000);
    });
    await shot('stopped');
  },
  async 'a recording opens by its address'() {
    const closed = async () => (await stack.rest('GET', '/sessions')).json().items.find((item) => !item.recording)?.id;
    const id = await until('the recording is closed', closed, 30_000, 500);
    const file = `${stack.origin}/api/v1/sessions/${id}/session.mcap`;
    await openStudio(`ds=remote-file&ds.url=${encodeURIComponent(file)}`);
    await until('parts of the file', () => exported > 0, slow_ms);
    // Its topics and its length are on the page, and no problem is.
    await page.getByText('nav_msgs/msg/Odometry').first().waitFor({ timeout: slow_ms });
    await sleep(3000);
    await shot('recording');
    assert((await page.getByText('END TIME').count()) > 0, 'Studio takes it for a live connection');
  },
};

async function main() {
  const missing = ['hoist-sim', 'hoist-control', 'hoist-server'].filter((name) => !existsSync(join(bin, name)));
  let reason = null;
  if (missing.length > 0) reason = `${missing.join(', ')} not in ${bin}`;
  else if (browserProgram === undefined) reason = 'no chromium on this machine';
  else if (!existsSync(join(modules, 'react'))) reason = 'npm ci has not run in tests/system/studio';
  if (reason !== null) {
    console.log(`skipped  Studio: ${reason}\n0 passed, 0 failed, 1 skipped`);
    return 0;
  }
  const { chromium } = createRequire(join(top, 'web/package.json'))('playwright-core');
  if (shots) mkdirSync(shots, { recursive: true });
  const web = mkdtempSync(join(tmpdir(), 'hoist-studio-'));
  writeFileSync(join(web, 'index.html'), '<!doctype html><title>Hoist</title>');
  stack = new Stack({ bin, web, scenario: 'straight' });
  let browser;
  const results = { passed: 0, failed: 0 };
  try {
    await stack.start();
    assert((await stack.rest('PUT', '/tools', { enabled: true })).status === 200, 'the tools stay closed');
    browser = await chromium.launch({
      executablePath: stack.politely(browserProgram),
      // A page that the test itself delivers comes from no known network: Chromium would keep it from the hoist.
      args: [
        '--no-sandbox',
        '--no-first-run',
        '--enable-unsafe-swiftshader',
        '--use-angle=swiftshader',
        '--disable-features=LocalNetworkAccessChecks,LocalNetworkAccessChecksWebSockets,LocalNetworkAccessForWorkers',
      ],
    });
    const context = await browser.newContext({ viewport: { width: 1400, height: 900 } });
    page = await context.newPage();
    page.on('pageerror', (error) => errors.push(String(error)));
    page.on('response', (answer) => (exported += answer.url().endsWith('/session.mcap') && answer.status() === 206 ? 1 : 0));
    await page.route('**/studio/**', serveStudio);
    await page.goto(stack.link);
    for (const [name, work] of Object.entries(cases)) {
      try {
        await work();
        results.passed++;
        console.log(`passed  ${name}`);
      } catch (error) {
        results.failed++;
        console.log(`FAILED  ${name}: ${error.stack}\n${errors.slice(-5).join('\n')}\n${stack.outputs()}`);
        await shot(`failed-${results.failed}`).catch(() => {});
      }
    }
  } finally {
    await browser?.close().catch(() => {});
    await stack.stop();
    rmSync(web, { recursive: true, force: true });
  }
  console.log(`${results.passed} passed, ${results.failed} failed, 0 skipped`);
  return results.failed > 0 ? 1 : 0;
}

process.exit(await main());
