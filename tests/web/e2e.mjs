// The console in headless Chromium with the real hoist-server, hoist-control and hoist-sim.
//
//   node tests/web/e2e.mjs [--bin build/bin] [--web web/dist] [--json FILE] [--part 1|2] [--only TEXT] [--shots DIR] [--list]
//
// The hoist's motion is read from the simulator, never from the page. Prints `N passed, N failed, N skipped`.
import { existsSync, mkdirSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { browserProgram, drawLess } from '../../web/test-support/headless.mjs';
import { assert, sleep, Stack, until } from './stack.mjs';

const top = fileURLToPath(new URL('../..', import.meta.url));
const option = (name, fallback) => (process.argv.includes(`--${name}`) ? process.argv[process.argv.indexOf(`--${name}`) + 1] : fallback);
const bin = resolve(option('bin', join(top, 'build/bin')));
const web = resolve(option('web', join(top, 'web/dist')));
const report = option('json');
const only = option('only', '');
const part = Number(option('part', '0')); // 0: all
const secondPartFrom = 'STOP stops from every page'; // both take as long
const shots = option('shots');
const programs = ['hoist-sim', 'hoist-control', 'hoist-server'];

/** One lap of the eight with c = 1 m, R = 0.8 m: four straights of 0.6 m and two arcs. */
const lap_m = 4 * 0.6 + 2 * 0.8 * (Math.PI + 2 * Math.asin(0.8));
const stillBelow_m_s = 0.02;
/** In the hoist's time. From 0.65 m/s at 1.0 m/s² a stop takes 0.65 s; the rest is the delay of the command on a busy machine. */
const stopWithin_s = 2.5;
/** Lock-step of simulator and core: each step is a period, also on a busy computer. */
const period_s = 0.01;
/** Browser and server stay in real time, which needs CPU time. A case that failed while the browser was delayed proves nothing: it is tried so
 * often, then skipped with that reason. The C++ tests check the same behaviour in virtual time. */
const attemptsMax = 3;
/** A browser in real time on a shared computer: this many cases of a run may fail once and pass when repeated; they are reported. */
const secondChancesMax = 2;
/** The page sends a command each 40 ms, and the core stops after a quarter of a second without one. A page delayed for this long was near it. */
const browserLate_ms = 150;
/** Loading a page takes longer, and nothing is driven meanwhile. */
const loading_ms = 2000;
/** A delayed browser releases, as it must; the driver presses again, so often. */
const gripsMax = 4;
const goesWithin_ms = 2000;

let stack;
let browser;
let context;
let page;
let pageErrors = []; // of the page itself: always a failure
let complaints = []; // of the browser, mostly about answers of the server
let secondChances = secondChancesMax;
let walked = null; // the recorded walk that later cases look at
let tableJudged = false; // another look at the same recording would find the same
let stopAt = null;
let lateTurns_ms = []; // when the browser was late, since the case began
let drove = false; // a hand held something: only then a late browser ends a motion

const still = async () => Math.abs((await stack.truth()).speed_m_s) < stillBelow_m_s;
const goes = async () => Math.abs((await stack.truth()).speed_m_s) > 0.08;
/** A delayed browser is no excuse: stops are checked in the hoist's time, and the core stops without commands. */
class Unexcused extends Error {}
async function stands(what, within_s = stopWithin_s) {
  const begun = await stack.truth();
  for (let now = begun; Math.abs(now.speed_m_s) >= stillBelow_m_s; now = await stack.truth()) {
    if (now.time_s - begun.time_s > within_s) throw new Unexcused(`${what}: not within ${within_s} s of the hoist's time`);
    await sleep(40);
  }
}
async function staysStill(message) {
  if (!(await still())) throw new Unexcused(message);
}
const modeName = () => page.locator('.mode strong').textContent();
const button = (name) => page.getByRole('button', { name, exact: true });
/** Presses an enabled button; the caller looks up one that changes at the press. */
const press = async (of) => {
  if (await of.isEnabled().catch(() => false)) await of.click({ timeout: 1000 }).catch(() => {});
};
const go = (name) => page.getByRole('navigation', { name: 'Screens' }).getByRole('link', { name }).click();

async function openConsole() {
  page = await context.newPage();
  page.on('pageerror', (error) => pageErrors.push(String(error)));
  page.on('console', (message) => {
    // A lost connection is written to the console by the browser itself; those tests cut it on purpose.
    if (message.type() === 'error' && !/ERR_CONNECTION|WebSocket|503/.test(message.text())) complaints.push(message.text());
  });
  await page.goto(`${stack.origin}/`);
  await until('the page shows live data', async () => (await modeName()) !== 'Starting', 30_000);
}

/** Releases a stop if present, ends motion if any. */
async function toStandby() {
  for (let tries = 0; tries < 50; tries++) {
    const mode = await modeName();
    if (mode === 'Standby') return;
    if (mode === 'Stopped') await holdRelease();
    else if (mode === 'Patient leads' || mode === 'Therapist drives' || mode === 'Exercise') {
      await page.goto(`${stack.origin}/#/walk`);
      await press(button('End')); // a busy page may still show the mode that the press before ended
    }
    await sleep(300);
  }
  throw new Error(`the hoist does not come to standby: ${await modeName()}`);
}
async function holdRelease() {
  const release = page.getByRole('button', { name: 'Hold to release' });
  const box = await release.boundingBox({ timeout: 2000 }).catch(() => null);
  if (box === null) return;
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await sleep(2200);
  await page.mouse.up();
  await sleep(300);
}
/** Starts, trying again while the patient finds the upright posture. Nothing stops a hoist meanwhile, also on a busy computer. */
async function startMotion(panel, name, mode) {
  await page.goto(`${stack.origin}/#/${panel}`);
  await until(
    `"${name}" starts`,
    async () => {
      const now = await modeName();
      if (now === mode) return true;
      if (now === 'Stopped') throw new Unexcused(`"${name}" ended in a stop: ${await page.locator('.strip').textContent()}`);
      await press(button(name));
      await sleep(400);
      return (await modeName()) === mode;
    },
    30_000,
    300,
  );
}
const startWalk = () => startMotion('walk', 'Start walking', 'Patient leads');
const startDrive = () => startMotion('drive', 'Start driving', 'Therapist drives');

/** Pixels of the floor view in the colour of the walked path. */
const pathPixels = () =>
  page.evaluate(() => {
    const canvas = document.querySelector('canvas.floor');
    if (canvas === null) return 0;
    const probe = document.createElement('span');
    probe.style.color = getComputedStyle(canvas).getPropertyValue('--accent');
    document.body.append(probe);
    const [r, g, b] = getComputedStyle(probe).color.match(/\d+/g).map(Number);
    probe.remove();
    const data = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
    let count = 0;
    for (let i = 0; i < data.length; i += 4) if (data[i + 3] > 200 && Math.abs(data[i] - r) + Math.abs(data[i + 1] - g) + Math.abs(data[i + 2] - b) < 30) count++;
    return count;
  });

/** All events of a session, page by page. */
async function eventsOf(id) {
  const events = [];
  for (let cursor = ''; cursor !== null; ) {
    const { items = [], next = null } = (await stack.rest('GET', `/sessions/${id}/events?limit=200&cursor=${cursor}`)).json();
    events.push(...items);
    cursor = next;
  }
  return events;
}
const newestId = async () => (await stack.rest('GET', '/sessions?limit=1')).json().items[0]?.id ?? 0;
/** The session recorded since `before`, once it is closed: three seconds after standstill. */
const recordedSince = (before) =>
  until('the session is closed and in the list', async () => (await stack.rest('GET', '/sessions?limit=5')).json().items.find((item) => item.id > before && !item.recording), 20_000, 250);

/** A walk of `seconds` in the sessions; gives its number there. */
async function walkFor(seconds) {
  await toStandby();
  const before = await newestId();
  await startWalk();
  await until('the hoist moves', goes);
  await sleep(seconds * 1000);
  assert((await modeName()) === 'Patient leads', 'the walk ended by itself');
  await toStandby();
  return (await recordedSince(before)).id;
}

/** Thrown by a case without its precondition; only the previous case can have failed. */
class NothingToJudge extends Error {}
function needWalk() {
  if (walked === null) throw new NothingToJudge('the walk that it looks at was not recorded');
}

/** In the page: reports long delays of its timers, when the browser got no CPU time. */
function watchTurns({ late_ms, loading_ms }) {
  let before_ms = performance.now();
  setInterval(() => {
    const now_ms = performance.now();
    const gap_ms = now_ms - before_ms;
    before_ms = now_ms;
    if (gap_ms > late_ms && now_ms > loading_ms) window.hoistTestLate(gap_ms);
  }, 40);
}

/** A hand on hold-to-run `of` of `mode`. `take` presses, also again; `begin` starts the mode again. */
const pointed = (of, right = 0, up = 0) => {
  const move = async (x = right, y = up, steps = 4) => {
    const box = await page.locator(of).boundingBox();
    await page.mouse.move(box.x + box.width * (0.5 + x), box.y + box.height * (0.5 - y), { steps });
  };
  return {
    of,
    move: () => move(),
    async take() {
      await page.mouse.up();
      await move(0, 0, 1);
      await page.mouse.down();
      await move();
    },
    leave: () => page.mouse.up(),
  };
};
const goButton = { ...pointed('.go'), mode: 'Exercise' };
const driving = { mode: 'Therapist drives', begin: startDrive };
const stick = (right, up) => ({ ...pointed('.pad', right, up), ...driving });
const driveKey = (code) => ({
  of: '.pad',
  async take() {
    await page.keyboard.up(code);
    await page.keyboard.down(code);
  },
  leave: () => page.keyboard.up(code),
  ...driving,
});

/** Whether the core ended the motion by command timeout, as recorded in the session. */
async function endedBySilence() {
  const told = async () => {
    const id = await newestId();
    return (await eventsOf(id)).some((event) => event.kind === 'fault_raised' && event.name === 'remote_command_lost');
  };
  return until('the session says it', told, 5000, 200).catch(() => false);
}

/** Holds until `check`. On a busy computer page or core let go of a hand that still pushes: the page when it finds the link too slow, the core
 * when no wish came for a quarter of a second. Then it takes hold again, but only when one of these was the reason: a page or core that lets go
 * of its own accord is not helped. Letting go is the caller's, who judges it once. */
async function holdUntil(what, hand, check) {
  drove = true;
  let grips = 0;
  let turns = lateTurns_ms.length;
  let taken_ms = performance.now();
  let reason = 'nobody holds it yet';
  await until(
    what,
    async () => {
      const mode = await modeName();
      if (mode !== hand.mode) {
        await hand.leave();
        // At standstill driving ends without an alarm: only the browser shows it.
        const silent = lateTurns_ms.length > turns || (await endedBySilence());
        assert(hand.begin !== undefined && mode === 'Standby' && silent, `${what}: "${hand.mode}" ended by itself, now "${mode}"`);
        reason = 'the core heard nothing from the page';
        await hand.begin();
        return false;
      }
      const held = (await page.locator(`${hand.of}.held`).count()) > 0;
      if (held) {
        if (await check()) return true;
        // The core may have missed the stick in its middle, and waits for it.
        const waits = lateTurns_ms.length > turns && performance.now() - taken_ms > goesWithin_ms && (await still());
        if (!waits) return false;
      }
      if (!held && (await page.locator(`${hand.of}.active`).count()) === 0) {
        reason = 'the page was locked';
        return false;
      }
      if (lateTurns_ms.length > turns) reason ??= `the browser had no turn for ${lateTurns_ms.at(-1).toFixed(0)} ms`;
      assert(reason !== null, `${what}: the page let go by itself`);
      assert(grips < gripsMax, `${what}: held ${grips} times, and let go because ${reason}`);
      if (grips > 0) console.log(`  ${what}: takes hold again, because ${reason}`);
      grips += 1;
      turns = lateTurns_ms.length;
      taken_ms = performance.now();
      reason = null;
      await hand.take();
      return false;
    },
    30_000,
  );
}

/** In the page: it becomes hidden, as with another tab or a dark screen. */
function hidePage() {
  Object.defineProperty(document, 'hidden', { configurable: true, get: () => true });
  document.dispatchEvent(new Event('visibilitychange'));
}
/** In the page: the system cancels the finger's pointer. */
function loseCapture() {
  const pad = document.querySelector('.pad');
  for (let id = 0; id < 100; id += 1) if (pad.hasPointerCapture(id)) pad.releasePointerCapture(id);
}

const cases = {
  async 'the printed link signs this device in, once'() {
    const first = stack.link;
    page = await context.newPage();
    await page.goto(first);
    assert(new URL(page.url()).search === '', 'the token stays in the address');
    await until('live data', async () => (await modeName()) !== 'Starting', 30_000);
    const other = await browser.newContext();
    const answer = await (await other.newPage()).goto(first);
    assert(answer.status() === 401, `a used link answers ${answer.status()}, not 401`);
    const stranger = await other.newPage();
    await stranger.goto(`${stack.origin}/`);
    await until('a stranger sees the set-up, not the hoist', () => stranger.getByRole('heading', { name: 'Set up this device' }).isVisible());
    await other.close();
    await page.close();
    await openConsole();
  },

  async 'a person signs in with a password, and the next time with a PIN; STOP stays on a device that was signed in'() {
    const password = 'a long walk to the sea';
    const added = await stack.rest('POST', '/users', { user: 'berg', display_name: 'Anna Berg', role: 'engineer', password });
    assert([201, 422].includes(added.status), `the account is not added: ${added.text}`); // 422: this is another attempt
    const other = await browser.newContext({ locale: 'en' });
    const screen = await other.newPage();
    await screen.goto(`${stack.origin}/`);
    const press = (name, options) => screen.getByRole('button', { name, exact: true }).click(options);
    await screen.getByLabel('User name').fill('berg');
    await screen.getByLabel('Password').fill('not that one at all');
    await press('Sign in');
    await until('a wrong password is refused in words', () => screen.locator('.form-error').isVisible());
    assert((await screen.locator('.shell').count()) === 0, 'a wrong password opened the console');
    // Right after a failure the server wants a second's pause: the page counts it down.
    await until(
      'the right one opens the console',
      async () => {
        if (await screen.locator('.shell').isVisible()) return true;
        await screen.getByLabel('Password').fill(password, { timeout: 1000 }).catch(() => {});
        await press('Sign in', { timeout: 1000 }).catch(() => {});
        return false;
      },
      20_000,
      400,
    );
    await until('it shows the hoist', async () => ['Standby', 'Stopped'].includes(await screen.locator('.mode strong').textContent()), 20_000);
    await screen.goto(`${stack.origin}/#/settings/me`);
    const pin = screen.getByRole('form', { name: 'PIN' });
    await pin.getByLabel('Present password').fill(password);
    await pin.getByLabel('New PIN').fill('4711');
    await pin.getByRole('button', { name: 'Save' }).click();
    await until('the PIN is set', async () => {
      const [refused] = await pin.locator('.form-error').allTextContents();
      assert(refused === undefined, `the PIN is refused: ${refused}`);
      return screen.getByText('PIN set').first().isVisible();
    });
    await press('Sign out');
    await press('Anna Berg');
    await until('STOP stays', () => screen.locator('.stop').isVisible());
    await screen.getByLabel('PIN').fill('4711');
    await screen.keyboard.press('Enter');
    await until('the console is open again', () => screen.locator('.settings').isVisible(), 20_000);
    await other.close();
  },

  async 'the screens say that this is a simulation'() {
    for (const name of ['Walk', 'Drive', 'Exercises', 'Tune', 'Sessions', 'Calibrate', 'Health']) {
      await go(name);
      assert(await page.getByText('SIMULATION', { exact: true }).first().isVisible(), `no mark on ${name}`);
      const box = await page.getByRole('button', { name: 'STOP' }).boundingBox();
      assert(box !== null && box.width >= 72 && box.height >= 72, `no large STOP on ${name}`);
      stopAt ??= box;
      assert(stopAt.x === box.x && stopAt.y === box.y, `STOP moved on ${name}`);
    }
  },

  async 'Start on Walk: the patient walks the eight, its path draws, the session has figures'() {
    await toStandby();
    const before = await newestId();
    await startWalk();
    await until('the hoist moves', goes);
    const early = await pathPixels();
    const begun = await stack.truth();
    await until('one lap is walked', async () => {
      assert((await modeName()) === 'Patient leads', `the walk ended: ${await page.locator('.strip').textContent()}`);
      return (await stack.truth()).progress_m - begun.progress_m > lap_m;
    }, 150_000, 500);
    if (shots) await page.screenshot({ path: join(shots, 'walk-lap.png') });
    const late = await pathPixels();
    assert(late > early + 500, `the path did not draw: ${early} pixels, then ${late}`);
    await page.getByRole('button', { name: 'Went well' }).click();
    await button('End').click();
    await stands('the hoist stands after End', 6);
    await until('standby', async () => (await modeName()) === 'Standby');
    const session = await recordedSince(before);
    const figures = (await stack.rest('GET', `/sessions/${session.id}/metrics`)).json();
    assert(figures.C > 0.6 && figures.C <= 1, `similarity C = ${figures.C}`);
    assert(figures.J_N > 0 && figures.J_N < 25, `accuracy J_N = ${figures.J_N}`);
    assert(figures.walked_m > 0.9 * lap_m, `walked ${figures.walked_m} m`);
    const marks = (await stack.rest('GET', `/sessions/${session.id}/markers`)).json().items;
    assert(marks.some((mark) => mark.text === 'Went well'), 'the mark is not in the session');
    walked = { id: session.id, figures };
  },

  async 'Sessions shows the walk with its figures, path and course'() {
    needWalk();
    await page.goto(`${stack.origin}/#/sessions`);
    await page.locator('.session-item').first().click();
    await until('the similarity', async () => (await page.locator('.figures').textContent()).includes(walked.figures.C.toFixed(2)));
    await until('the path', async () => (await pathPixels()) > 500);
    await until('the course', () => page.locator('.uplot canvas').isVisible());
    const noteIs = (note) => async () => (await stack.rest('GET', `/sessions/${walked.id}`)).json().note === note;
    await page.getByLabel('Note').fill('half a th');
    await page.reload();
    await until('what was typed when the page went away', noteIs('half a th'));
    await page.locator('.session-item').first().click();
    await page.getByLabel('Note').fill('calm, "=1+1" walk');
    await page.getByRole('button', { name: 'Save' }).last().click();
    await until('the note is kept', noteIs('calm, "=1+1" walk'));
    if (shots) await page.screenshot({ path: join(shots, 'session.png') });
  },

  async 'Sessions opens the report of the walk with the same figures, and a sheet for the patient'() {
    needWalk();
    const speed = `${walked.figures.walking_speed_m_s.toFixed(2)}\u00a0m/s`;
    for (const [link, title] of [
      ['Full report', 'Walk report'],
      ['Patient sheet', 'Your walk'],
    ]) {
      await page.goto(`${stack.origin}/#/sessions/${walked.id}`);
      const [report] = await Promise.all([context.waitForEvent('page'), page.getByRole('link', { name: link }).click()]);
      const refused = [];
      report.on('console', (message) => refused.push(message.text()));
      await report.waitForLoadState();
      assert((await report.locator('h1').textContent()) === title, `the ${link} is called ${await report.locator('h1').textContent()}`);
      assert((await report.locator('main').textContent()).includes(speed), `the ${link} does not show ${speed}`);
      assert(await report.locator('svg').first().isVisible(), `the ${link} does not draw the path`);
      assert((await report.evaluate(() => getComputedStyle(document.body).maxWidth)) !== 'none', `the ${link} has no style`);
      assert(refused.length === 0, `the browser says of the ${link}: ${refused}`);
      if (shots) await report.screenshot({ path: join(shots, `${title.replace(' ', '-')}.png`), fullPage: true });
      await report.close();
    }
  },

  async 'the CSV export has units, a row each 10 ms and no unexplained gap'() {
    const id = walked === null || tableJudged ? await walkFor(22) : walked.id;
    tableJudged = true;
    await page.goto(`${stack.origin}/#/sessions`);
    await page.locator('.session-item').first().click();
    await page.getByLabel('Export as').selectOption({ label: 'Table (CSV)' });
    const [download] = await Promise.all([page.waitForEvent('download'), page.getByRole('link', { name: 'Download' }).click()]);
    assert(/\.csv$/.test(download.suggestedFilename()), `the file is called ${download.suggestedFilename()}`);
    const text = (await stack.rest('GET', `/sessions/${id}/export?format=csv`)).text;
    const lines = text.trimEnd().split(/\r?\n/);
    const comments = lines.filter((line) => line.startsWith('#'));
    const [names, ...rows] = lines.filter((line) => !line.startsWith('#'));
    const columns = names.split(',');
    for (const name of ['utc', 'time_s', 'gap_before', 'tick', 'speed_m_s', 'left_alpha_rad', 'battery_a_v']) assert(columns.includes(name), `no column ${name}`);
    assert(comments.some((line) => line.includes('m/s') && line.includes('rad')), 'no row of units');
    const at = (name) => columns.indexOf(name);
    let before = null;
    for (const row of rows) {
      const cells = row.split(',');
      assert(cells.length === columns.length, `a row has ${cells.length} cells, not ${columns.length}`);
      const tick = Number(cells[at('tick')]);
      if (before !== null && tick !== before.tick + 1) assert(cells[at('gap_before')] === '1', `ticks ${before.tick} to ${tick} are missing without a word`);
      const time_s = Number(cells[at('time_s')]);
      if (before !== null && tick === before.tick + 1) {
        const dt_s = time_s - before.time_s;
        assert(Math.abs(dt_s - period_s) < 1e-5, `tick ${tick} comes ${dt_s} s after the one before`);
      }
      before = { tick, time_s };
    }
    assert(rows.length > 2000, `only ${rows.length} rows`);
  },

  async 'a mark gets another kind and time in its session, and the audit log says so in a sentence'() {
    needWalk();
    const marks = async () => (await stack.rest('GET', `/sessions/${walked.id}/markers`)).json().items;
    const [before] = await marks();
    // An attempt that came to nothing may have changed it; this one moves it further.
    assert(before.kind === 'good' || before.text === 'Left foot', `the mark has the kind ${before.kind}`);
    const to_s = Math.min(4, Math.ceil(before.time_s) - 1);
    await page.goto(`${stack.origin}/#/sessions/${walked.id}`);
    await page.locator('.session-markers li button').first().click();
    const form = page.locator('.session-markers');
    await form.getByLabel('Kind').selectOption('stumble');
    await form.getByLabel('Text').fill('Left foot');
    await form.getByLabel('Time in the session').fill(`0:0${to_s}`);
    await form.getByRole('button', { name: 'Save', exact: true }).click();
    await until('the mark is moved', async () => (await marks())[0].time_s === to_s);
    const [after] = await marks();
    assert(after.kind === 'stumble' && after.text === 'Left foot', `the mark is ${after.kind}, ${after.text}`);
    assert(after.tick < before.tick, `the step stayed ${after.tick}`);
    await until('the page shows it', () => page.getByText('Stumble · Left foot').isVisible());
    await page.goto(`${stack.origin}/#/settings/audit`);
    await until('the sentence', () => page.getByText(`changed a mark in session ${walked.id}.`).first().isVisible());
  },

  async 'a new patient is chosen on Home: the walk appears in the visit of today, under the code in the bar'() {
    await toStandby();
    await page.goto(`${stack.origin}/#/home`);
    const code = `P-${Math.floor(performance.now())}`;
    await page.getByLabel('Search or enter a code').fill(code);
    await button(`New patient with code ${code}`).click();
    await until('the patient is chosen', async () => (await page.locator('.home-code').textContent()) === code);
    const id = await walkFor(4);
    assert((await page.locator('.bar-patient').textContent()).includes(code), 'the code is not in the bar of Walk');
    assert((await stack.rest('GET', `/sessions/${id}`)).json().subject === code, 'the walk is recorded without the code');
    await page.goto(`${stack.origin}/#/home`);
    await page.locator('.home .rows a', { hasText: code }).click();
    await until('the visit has the walk', () => page.locator(`.patient-visit a[href="#/sessions/${id}"]`).isVisible());
    await page.goto(`${stack.origin}/#/home`);
    await button('Deselect patient').click();
    await until('nobody is chosen', () => page.getByText('No patient chosen').isVisible());
  },

  async 'a backup is made beside the recording and put back: what was deleted meanwhile is there again'() {
    const id = walked?.id ?? (await walkFor(6));
    await toStandby();
    await page.goto(`${stack.origin}/#/settings/backup`);
    await button('Back up now').click();
    const row = page.locator('.settings-part .rows li');
    await until('the backup is listed', async () => (await row.count()) === 1, 60_000);
    const [folder] = readdirSync(stack.path('backups'));
    assert(existsSync(stack.path('backups', folder, 'manifest.json')), `no manifest in ${folder}`);
    assert((await stack.rest('DELETE', `/sessions/${id}`)).status === 204, 'the session is not deleted');
    assert((await stack.rest('GET', `/sessions/${id}`)).status === 404, 'the deleted session is still there');
    await button('Restore').click();
    const hold = button('Hold to restore');
    await hold.click();
    await sleep(500);
    assert((await stack.rest('GET', `/sessions/${id}`)).status === 404, 'a tap restored the backup');
    await hold.click({ delay: 2300 });
    await until('the session is there again', async () => (await stack.rest('GET', `/sessions/${id}`)).status === 200, 60_000);
    await until('the page says so', () => page.getByText('Backup restored').first().isVisible());
  },

  async 'Tune: build-up strength changes at once, out of range is refused with the range, the session has the change'() {
    await toStandby();
    const before = await newestId();
    await startWalk();
    await go('Tune');
    const field = page.getByLabel('Build-up strength', { exact: true });
    // Another value than now, also when this is a second attempt.
    const strength = async () => (await stack.rest('GET', '/parameters/lean_gain_filtered_units')).json().value;
    const wanted = (await strength()) === 44 ? 43 : 44;
    await field.fill(String(wanted));
    // Text typed before the answer arrives is kept.
    await field.evaluate((input) => {
      input.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', bubbles: true }));
      input.value = '400';
      input.dispatchEvent(new Event('input', { bubbles: true }));
    });
    await until('the core has the new value', async () => (await strength()) === wanted);
    await sleep(300);
    assert((await field.inputValue()) === '400', 'the answer to one value took away the next, half typed');
    await field.press('Enter');
    await until('the refusal names the range', async () => /0 to 100/.test((await page.locator('.tune-error').first().textContent().catch(() => '')) ?? ''));
    assert((await strength()) === wanted, 'a refused value was taken');
    await field.press('Escape');
    assert((await modeName()) === 'Patient leads', 'tuning ended the walk');
    // What was set in motion is on trial, and would be undone by itself.
    await button('Keep').click();
    await until('the trial is over', async () => !(await page.locator('.trial-bar').isVisible()));
    await toStandby();
    const session = await recordedSince(before);
    const events = await eventsOf(session.id);
    assert(
      events.some((event) => event.kind === 'parameter_changed' && event.name === 'lean_gain_filtered_units' && event.value === wanted),
      'the change is not in the session',
    );
    await page.goto(`${stack.origin}/#/tune`);
    await page.locator('.tune-row', { has: page.getByLabel('Build-up strength', { exact: true }) }).getByRole('button', { name: 'Default' }).click();
    await until('the default is back', async () => (await strength()) === 50);
    // The history names the change of the walk with its session; one tap brings the value back.
    const history = page.locator('.tune-history');
    await history.locator('summary').click();
    const row = history.locator('li', { hasText: `Session ${session.id}` }).first();
    await until('the change is in the history', async () => /Build-up strength/.test((await row.textContent().catch(() => '')) ?? ''), 15_000);
    const back = history.getByRole('button', { name: `Build-up strength: back to ${wanted} units` }).first();
    await until('the default can be taken back', () => back.isVisible(), 15_000);
    await back.click();
    await until('the value is back', async () => (await strength()) === wanted);
    await stack.rest('PUT', '/parameters/lean_gain_filtered_units', { value: 50 });
  },

  async 'the page of the API reads and writes as this browser is signed in, and nothing of it is refused by the policy'() {
    const docs = await context.newPage();
    const errors = [];
    docs.on('console', (message) => message.type() === 'error' && errors.push(message.text()));
    try {
      await docs.goto(`${stack.origin}/api/docs#get_settings`);
      const send = async (operation, fill) => {
        const row = docs.locator(`#${operation}`);
        await row.waitFor();
        if ((await row.getAttribute('open')) === null) await row.locator('> summary').click();
        await row.locator('form').waitFor();
        await fill?.(row);
        await row.getByRole('button', { name: 'Send' }).click();
        await row.locator('.docs-status').waitFor();
        return row.locator('.docs-answer').textContent();
      };
      const read = await send('get_settings');
      const [, tag] = /etag: (".*?")/.exec(read) ?? [];
      assert(/^200/.test(read) && tag !== undefined, `reading: ${read}`);
      const written = await send('change_settings', async (row) => {
        await row.getByLabel(/If-Match/).fill(tag);
        await row.locator('textarea').fill('{"device_name": "Room 3"}');
      });
      assert(/^200/.test(written) && written.includes('Room 3'), `writing: ${written}`);
      assert(errors.length === 0, errors.join('\n'));
    } finally {
      await docs.close();
    }
  },

  async 'Calibrate: the empty struts are zeroed, old and new are shown, and the date is kept'() {
    await toStandby();
    await stack.ask({ op: 'bar', dx_m: 0, yaw_rad: 0 });
    try {
      await go('Calibrate');
      await page.getByRole('button', { name: /^Struts upright/ }).click();
      await until(
        'a result is offered',
        async () => {
          if (await button('Use').isVisible().catch(() => false)) return true;
          const confirm = button('Nobody is strapped in: hold to start');
          if (await confirm.isEnabled({ timeout: 50 }).catch(() => false)) await confirm.click({ delay: 2200 });
          return false;
        },
        30_000,
        500,
      );
      assert((await modeName()) === 'Calibrating', 'the bar above does not say that it is being calibrated');
      await until('six zeros and the neutral stand there, old beside new', async () => (await page.locator('.calibrate-changes tbody tr').count()) === 8);
      assert((await stack.rest('GET', '/parameters/calibrated_zero_s')).json().value === 0, 'it was taken over before anybody agreed');
      await button('Use').click();
      await until('the hoist is on standby again', async () => (await modeName()) === 'Standby');
      const today_s = (await stack.rest('GET', '/parameters/calibrated_zero_s')).json().value;
      assert(Math.abs(today_s - Date.now() / 1000) < 120, `the date kept is ${today_s}`);
      assert(!(await stack.truth()).enabled, 'a drive was switched on');
    } finally {
      // Drives that are still on refuse it; then `recover` does it, and the case reports its own failure.
      await stack.ask({ op: 'strap' }).catch(() => {});
    }
  },

  async 'the joystick moves the hoist; letting go stops it; it goes where it is pushed'() {
    await toStandby();
    await startDrive();
    await holdUntil('the hoist drives forward', stick(0, 0.34), async () => (await stack.truth()).speed_m_s > 0.15);
    const left = stick(-0.3, 0.1);
    await left.move();
    await holdUntil('it turns left', left, async () => (await stack.truth()).yaw_rate_rad_s > 0.1);
    await page.mouse.up();
    await stands('it stands after letting go');
    await holdUntil('it drives backward by key', driveKey('ArrowDown'), async () => (await stack.truth()).speed_m_s < -0.05);
    await page.keyboard.up('ArrowDown');
    await stands('it stands after the key');
    assert((await modeName()) === 'Therapist drives', 'driving ended by itself');
  },

  async 'Exercises: the hoist goes one metre while the button is held, stops when it is let go, and ends by itself'() {
    await toStandby();
    const before = await newestId();
    await page.goto(`${stack.origin}/#/exercises`);
    await page.getByLabel('Task').selectOption('straight');
    await page.getByRole('radio', { name: 'Hoist leads' }).click();
    const less = page.getByRole('button', { name: 'Length: less' });
    while (await less.isEnabled()) await less.click();
    await startMotion('exercises', 'Start the task', 'Exercise');
    const begun = await stack.truth();
    const gone_m = async () => Math.hypot((await stack.truth()).x_m - begun.x_m, (await stack.truth()).y_m - begun.y_m);
    await sleep(400);
    assert(await still(), 'it moves before the button is held');
    await holdUntil('it goes', goButton, goes);
    await page.mouse.up();
    await stands('it stands after letting go');
    assert((await modeName()) === 'Exercise', 'letting go ended the exercise');
    assert((await gone_m()) < 0.9, 'it did not stop on the way');
    await page.keyboard.down('ArrowUp');
    await until(
      'the exercise is over',
      async () => {
        if ((await modeName()) === 'Standby') return true;
        // A briefly slow connection releases, as it must; press again.
        if ((await page.locator('.go.active:not(.held)').count()) > 0) {
          await page.keyboard.up('ArrowUp');
          await page.keyboard.down('ArrowUp');
        }
        return false;
      },
      30_000,
    );
    await page.keyboard.up('ArrowUp');
    assert(Math.abs((await gone_m()) - 1) < 0.05, `it went ${await gone_m()} m`);
    assert((await stack.rest('GET', '/mode')).json().moving === false, 'it still moves');
    const session = await recordedSince(before);
    const events = await eventsOf(session.id);
    assert(events.some((event) => event.kind === 'guided_ended' && event.name === 'finished'), 'the end is not in the session');
    assert(session.exercise.shape === 'straight', 'the session does not know its exercise');
    // A repeated try of this case is the next repetition of the same task.
    assert(session.task?.task === 'straight' && session.task.repetition >= 1 && session.task.repetition <= attemptsMax,
      `the session's task: ${JSON.stringify(session.task)}, ${JSON.stringify(session.exercise)}`);
  },

  async 'Exercises: a line is drawn by hand and by keys, saved, driven as a task, and the session keeps it when it is deleted'() {
    await toStandby();
    // An attempt that came to nothing left its line, and a name is given once.
    for (const { id } of (await stack.rest('GET', '/lines')).json().items) await stack.rest('DELETE', `/lines/${id}`);
    const before = await newestId();
    await page.goto(`${stack.origin}/#/exercises`);
    await page.getByRole('button', { name: 'Draw a line' }).click();
    const box = await page.locator('.line-plan').boundingBox();
    for (const up of [0.75, 0.4]) await page.mouse.click(box.x + box.width / 2, box.y + box.height * up);
    await page.getByRole('button', { name: 'Add a point' }).click();
    // By keys, a grid step each.
    const last = page.locator('.line-point').nth(2);
    const beforeKeys = await last.getAttribute('aria-label');
    await last.focus();
    for (const key of ['ArrowLeft', 'ArrowLeft', 'ArrowDown']) await page.keyboard.press(key);
    assert((await last.getAttribute('aria-label')) !== beforeKeys, 'the keys moved no point');
    await page.getByLabel('Name').fill('Corridor');
    await page.getByRole('button', { name: 'Save' }).click();
    const task = page.getByLabel('Task').locator('option:checked');
    await until('the line is a task', async () => (await task.textContent().catch(() => '')) === 'Corridor');
    const [line] = (await stack.rest('GET', '/lines')).json().items;
    assert(line.name === 'Corridor' && line.exercise.x_m.length === 3 && !line.exercise.closed, `the line: ${JSON.stringify(line)}`);
    assert(await page.getByRole('radio', { name: 'Hoist leads' }).isDisabled(), 'the hoist offers to lead along it');
    await page.getByRole('radio', { name: 'Therapist drives' }).click();
    await startMotion('exercises', 'Start the task', 'Therapist drives');
    await holdUntil('the hoist drives along it', stick(0, 0.34), async () => (await stack.truth()).speed_m_s > 0.15);
    await page.mouse.up();
    await stands('it stands after letting go');
    assert(/Corridor/.test((await page.locator('.task-strip').textContent()) ?? ''), 'Drive does not name the line');
    await toStandby();
    const session = await recordedSince(before);
    assert(session.task?.task === 'own_line' && session.task.line === 'Corridor', `the session's task: ${JSON.stringify(session.task)}`);
    assert(JSON.stringify(session.exercise) === JSON.stringify(line.exercise), `the session's line: ${JSON.stringify(session.exercise)}`);
    await page.goto(`${stack.origin}/#/exercises`);
    await page.getByRole('button', { name: 'Delete' }).click();
    await page.getByRole('group', { name: 'Delete' }).getByRole('button', { name: 'Delete' }).click();
    await until('the line is gone', async () => (await stack.rest('GET', '/lines')).json().items.length === 0);
    const kept = (await stack.rest('GET', `/sessions/${session.id}`)).json();
    assert(JSON.stringify(kept.exercise) === JSON.stringify(line.exercise), 'the session lost its line');
    await stack.rest('PUT', '/task', { task: null });
  },

  async 'losing the focus, leaving the page or closing the tab while driving stops the hoist'() {
    // H19
    for (const way of ['blur', 'hidden', 'capture', 'page', 'close']) {
      await toStandby();
      await startDrive();
      await holdUntil(`it drives (${way})`, stick(0, 0.34), goes);
      if (way === 'blur') await page.evaluate(() => window.dispatchEvent(new Event('blur')));
      else if (way === 'hidden') await page.evaluate(hidePage);
      else if (way === 'capture') {
        await page.evaluate(loseCapture);
        // The browser reports it with the next movement, which must not press again.
        await stick(0, 0.3).move();
      }
      else if (way === 'page') await page.evaluate(() => (location.hash = '#/health'));
      else await page.close();
      await stands(`it stands after ${way}`);
      if (way === 'close') await openConsole();
      else await page.mouse.up();
      await sleep(300);
      await staysStill(`it moved again after ${way}`);
      if (way === 'hidden') await page.evaluate(() => delete document.hidden);
    }
  },

  async 'STOP stops from every page, by one touch or the space bar, and is released by holding'() {
    for (const [name, press] of [['Walk', 'touch'], ['Drive', 'touch'], ['Tune', 'space'], ['Sessions', 'touch'], ['Health', 'space']]) {
      await toStandby();
      await startWalk();
      await until('the patient walks', goes);
      await go(name);
      // Also out of a field in which a number was just typed.
      if (name === 'Tune') await page.getByLabel('Build-up strength', { exact: true }).click();
      if (press === 'space') await page.keyboard.press('Space');
      else {
        const box = await page.getByRole('button', { name: 'STOP' }).boundingBox();
        await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
        // Pressing is enough: the button is not released before the hoist stands.
        await page.mouse.down();
      }
      await stands(`it stands after STOP on ${name}`);
      await page.mouse.up();
      await until('the page says so', async () => (await modeName()) === 'Stopped');
      if (await goes()) throw new Unexcused('it moved again after STOP');
    }
    const release = page.getByRole('button', { name: 'Hold to release' });
    await release.click();
    await sleep(500);
    assert((await modeName()) === 'Stopped', 'a short tap released the stop');
    // A further cause during the press: it is shown, and released only by a later press.
    const box = await release.boundingBox();
    await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
    await page.mouse.down();
    const held_ms = performance.now();
    await stack.ask({ op: 'bumper', which: 'front', pressed: true });
    await until('the core knows the new cause', async () => (await stack.coreStatus()).faults.includes('bumper_pressed'));
    await stack.ask({ op: 'bumper', which: 'front', pressed: false });
    await sleep(2400 - (performance.now() - held_ms));
    await page.mouse.up();
    await until('the page says why not', () => page.getByText('There is a new cause of the stop').first().isVisible());
    assert((await modeName()) === 'Stopped', 'released with a cause that came under the hand');
    await toStandby();
  },

  async 'an alarm sounds at the hoist and on the screen; its sound is paused here, its light is not, and a new alarm sounds'() {
    await toStandby();
    // A page of its own: no finger has touched it yet.
    const fresh = await context.newPage();
    try {
      await fresh.goto(`${stack.origin}/#/home`);
      const sound = fresh.locator('.strip .sound');
      await until('it says that sound is off', async () => (await sound.textContent().catch(() => '')) === 'Sound is off until you tap');
      // Anywhere on the page, by its place: the button goes with the tap.
      await fresh.mouse.click(700, 420);
      await until('sound is on', async () => (await sound.count()) === 0);
      assert((await stack.truth()).buzzer === false, 'the hoist sounds without an alarm');
      await stack.ask({ op: 'bumper', which: 'front', pressed: true });
      await until('the buzzer sounds', async () => (await stack.truth()).buzzer);
      await until('the red light is on', async () => (await stack.truth()).red_light);
      await until('the page offers the pause', async () => (await sound.textContent().catch(() => '')) === 'Pause sound');
      assert(await fresh.locator('.strip.high.flashes').isVisible(), 'the strip does not flash');
      const pause = async () => {
        const box = await sound.boundingBox();
        await fresh.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
        await until('the page says that it is paused', async () => /^Sound paused [12]:/.test(await sound.textContent().catch(() => '')));
      };
      // A server without a turn is an alarm of its own and ends the pause, as it must: then the page says so, and the pause is pressed again.
      const ended = async () => !/^Sound paused/.test(await sound.textContent().catch(() => ''));
      let lit = false;
      const silent = async () => {
        const paused_s = (await stack.truth()).time_s;
        // Longer than the silence between two bursts.
        for (let now = await stack.truth(); now.time_s < paused_s + 5; now = await stack.truth()) {
          if (now.time_s > paused_s + 0.2 && now.buzzer) {
            await until('the page says that the pause has ended: it sounds', ended, 2000);
            return false;
          }
          lit ||= now.red_light;
          await sleep(20);
        }
        return true;
      };
      await until('the sound stays paused', async () => (await pause(), await silent()), 40_000);
      assert(lit, 'the light was paused, too');
      await stack.rest('POST', '/stop');
      await until('a new alarm sounds', async () => (await stack.truth()).buzzer);
      await until('also on the page', async () => (await sound.textContent().catch(() => '')) === 'Pause sound');
    } finally {
      await stack.ask({ op: 'bumper', which: 'front', pressed: false });
      await fresh.close();
    }
    await toStandby();
  },

  async 'each screen receives what it shows, at the rate that it shows it'() {
    const second = await context.newPage();
    let bytes = 0;
    second.on('websocket', (socket) => socket.on('framereceived', ({ payload }) => (bytes += payload.length)));
    // In the hoist's time: simulated time may be slow on a busy computer.
    const perSecond = async () => {
      const [from, begun_s] = [bytes, (await stack.truth()).time_s];
      await sleep(1500);
      return Math.round((bytes - from) / ((await stack.truth()).time_s - begun_s));
    };
    const most = { home: 1000, walk: 4500, drive: 4500, exercises: 4500, tune: 1000, sessions: 1000, calibrate: 1000, health: 4000 };
    try {
      const told = [];
      for (const [screen, most_bytes_s] of Object.entries(most)) {
        await second.goto(`${stack.origin}/#/${screen}`);
        // What a page is told when it connects is no rate.
        const known = async () => (await second.locator('.mode strong').textContent().catch(() => 'Starting')) !== 'Starting';
        await until(`${screen} shows the hoist`, known);
        await sleep(1000);
        const bytes_s = await perSecond();
        told.push(`${screen} ${bytes_s}`);
        assert(bytes_s > 200 && bytes_s < most_bytes_s, `${screen}: ${bytes_s} bytes a second`);
      }
      await second.evaluate(() => (window.hoistTestSocket = new WebSocket(`${location.origin.replace('http', 'ws')}/ws`, 'hoist.v1')));
      await sleep(500);
      const whole = (await perSecond()) - Number(told.at(-1).split(' ')[1]);
      console.log(`        bytes a second: ${told.join(', ')}; a client that chooses nothing: ${whole}`);
    } finally {
      await second.close();
    }
  },
  async 'a killed server: the walk goes on, the console comes back by itself'() {
    await toStandby();
    await startWalk();
    await until('the patient walks at his pace', async () => (await stack.truth()).speed_m_s > 0.2);
    await stack.programs['hoist-server'].kill('SIGKILL');
    await until('the page says that the connection is lost', () => page.getByText('No connection to the hoist').isVisible(), 6000);
    // By the hoist's speed, not by progress along the line: earlier cases left it beside the line, and the patient first walks back to it.
    let way_m = 0;
    for (let look = 0; look < 10; look += 1) {
      await sleep(250);
      const now = await stack.truth();
      assert(now.patient === 'leading', `the walk did not go on: the patient is ${now.patient}`);
      way_m += Math.abs(now.speed_m_s) * 0.25;
    }
    assert(way_m > 0.2, `the walk did not go on: about ${way_m.toFixed(2)} m in 2.5 s`);
    await stack.startServer();
    await until('the console is back', async () => !(await page.getByText('No connection to the hoist').isVisible()) && (await modeName()) === 'Patient leads');
    await toStandby();
    await stands('it stands');
  },

  async 'a killed control core: the wheels stop by themselves, and it comes back on standby'() {
    await toStandby();
    await startWalk();
    await until('the patient walks', goes);
    await stack.programs['hoist-control'].kill('SIGKILL');
    await stands('the wheels stop', 1.5);
    await until('the page says so', () => page.getByText('The control computer does not answer').first().isVisible(), 6000);
    await stack.startControl();
    await until('it is back, and not moving', async () => ['Standby', 'Stopped'].includes(await modeName()));
    await sleep(1000);
    await staysStill('it moved after the restart');
    await toStandby();
    await startWalk();
    await until('and can walk again', goes);
    await toStandby();
  },

  async 'a double tap on End does not start again'() {
    await toStandby();
    await startWalk();
    const box = await button('End').boundingBox();
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    await until('the button means Start', async () => (await button('Start walking').isEnabled().catch(() => false)));
    await page.mouse.click(box.x + box.width / 2, box.y + box.height / 2);
    await sleep(1200);
    assert((await modeName()) === 'Standby', `the second tap led to ${await modeName()}`);
    assert((await page.locator('.refusal').count()) === 0, 'the second tap asked for a start');
    await startWalk();
    await toStandby();
  },

  async 'Start goes on with the walk that was ended; Start again restarts it at the mark'() {
    await toStandby();
    const gone_m = async () => Number(await page.locator('.reading .num').nth(1).textContent());
    await startWalk();
    await until('some way is walked', async () => (await gone_m()) >= 0.8, 30_000);
    await toStandby();
    const ended_m = await gone_m();
    await startWalk();
    await until('it walks on', goes);
    assert((await gone_m()) >= ended_m, `${ended_m} m were walked, and it goes on with ${await gone_m()} m`);
    await toStandby();
    await until('the hoist is put on its mark', () => stack.ask({ op: 'reset' }).then(() => true, () => false));
    const again = page.getByRole('button', { name: /^Start again/ });
    await until('it starts again', async () => {
      await press(again);
      await sleep(400);
      return (await modeName()) === 'Patient leads';
    });
    await until('the hoist moves', goes);
    // Readings are renewed five times a second.
    await until('the way is counted from the mark', async () => (await gone_m()) < ended_m);
    await toStandby();
  },

  async 'a second screen shows the same walk, also loaded in its middle, changes settings and ends it'() {
    await toStandby();
    const second = await context.newPage();
    const seen = (of) => of.evaluate(() => ({ chosen: document.querySelector('[role=radio][aria-checked=true]')?.textContent, time: document.querySelectorAll('.reading .num')[2]?.textContent }));
    const seconds = ({ time }) => (time ?? '').split(':').reduce((sum, part) => 60 * sum + Number(part), 0);
    try {
      await second.goto(`${stack.origin}/#/walk`);
      await page.goto(`${stack.origin}/#/walk`);
      await page.getByRole('radio', { name: 'Square', exact: true }).click();
      await until('the second screen shows the choice', async () => (await seen(second)).chosen === 'Square');
      await page.getByRole('radio', { name: 'Figure of eight', exact: true }).click();
      await until('and the next one', async () => (await seen(second)).chosen === 'Figure of eight');
      await startWalk();
      await until('the hoist moves', goes);
      // Of the hoist's time, which is slow on a busy computer.
      await until('it has walked for 3 s', async () => seconds(await seen(page)) >= 3, 30_000);
      await second.reload();
      await until('the reloaded screen is live', async () => (await second.locator('.mode strong').textContent()) === 'Patient leads');
      // A screen that counts from its own start stays 3 s behind.
      await until('both screens show the same walk', async () => {
        const [one, two] = [await seen(page), await seen(second)];
        return one.chosen === two.chosen && Math.abs(seconds(one) - seconds(two)) <= 1;
      });
      await second.goto(`${stack.origin}/#/drive`);
      await second.getByRole('radio', { name: /^Slow/ }).click();
      await until('the limit is in force', async () => (await stack.rest('GET', '/parameters/remote_speed_m_s_max')).json().value === 0.15);
      assert((await second.locator('.dialog').count()) === 0, 'a setting asked to take over');
      if (shots) await second.screenshot({ path: join(shots, 'second-drive.png') });
      await second.getByRole('button', { name: 'End', exact: true }).click();
      await stands('it stands after End on the second screen', 6);
      assert((await second.locator('.dialog').count()) === 0, 'End asked to take over');
      await until('standby', async () => (await modeName()) === 'Standby');
      // Control is taken over at standstill, and the screen that lost it says so.
      await second.goto(`${stack.origin}/#/walk`);
      await until('a start is possible', () => second.getByRole('button', { name: 'Start walking' }).isEnabled());
      await second.getByRole('button', { name: 'Start walking' }).click();
      await second.getByRole('button', { name: 'Take over', exact: true }).click();
      await until('the first screen says that it lost control', () => page.getByText('Another screen took over control.').isVisible());
      if (shots) await page.screenshot({ path: join(shots, 'taken-over.png') });
    } finally {
      await second.close();
    }
    await toStandby();
  },

  async 'the tablet in control is gone while the patient leads: another one takes control, and the walk goes on'() {
    await toStandby();
    await startWalk();
    await until('the patient walks', goes);
    const second = await context.newPage();
    try {
      await second.goto(`${stack.origin}/#/walk`);
      await until('the second screen shows the walk', async () => (await second.locator('.mode strong').textContent()) === 'Patient leads');
      await page.goto('about:blank');
      await until('the alarm demands it', () => second.getByText('take control on another tablet').isVisible(), 8000);
      if (shots) await second.screenshot({ path: join(shots, 'console-lost.png') });
      await second.getByRole('button', { name: 'Control: Take over' }).click();
      await until('the alarm is over', async () => !(await second.getByText('take control on another tablet').isVisible()));
      assert((await second.locator('.control .bar-value').textContent()) === 'You', 'the second screen does not say that it is in control');
      assert((await second.locator('.mode strong').textContent()) === 'Patient leads', 'the walk ended');
      await page.goto(`${stack.origin}/#/walk`);
      await until('the first screen is back', async () => (await modeName()) === 'Patient leads');
      await toStandby();
    } finally {
      await second.close();
    }
    await toStandby();
  },

  async 'a cut bus: no screen claims to know whether the hoist stands, and Start says what to do'() {
    await toStandby();
    await page.goto(`${stack.origin}/#/walk`);
    await stack.ask({ op: 'line', cut: true });
    try {
      await until('the values are called old', async () => (await page.locator('.mode span').textContent()) === 'Old values');
      assert(await page.locator('main.stale').isVisible(), 'the values are not grey');
      if (shots) await page.screenshot({ path: join(shots, 'bus-cut.png') });
      if ((await modeName()) === 'Stopped') await until('Start says what to do', () => page.getByText(/hold .Hold to release. first/).isVisible());
      assert(await button('Start walking').isDisabled(), 'Start is offered');
      assert(!(await page.getByText('Ready.', { exact: true }).isVisible()), 'it says Ready');
    } finally {
      await stack.ask({ op: 'line', cut: false });
    }
    await until('the values are of now', async () => ['Standing still', 'Moving'].includes(await page.locator('.mode span').textContent()), 20_000);
    await toStandby();
  },

  async 'signed out with the page open: STOP stays, and the page says what to do'() {
    await toStandby();
    // A separate page: its browser logs the 401.
    const other = await context.newPage();
    await other.goto(`${stack.origin}/`);
    await until('live data', async () => (await other.locator('.mode strong').textContent()) === 'Standby', 15_000);
    await other.route('**/api/v1/status', (route) => route.fulfill({ status: 401, json: { status: 401 } }));
    await stack.programs['hoist-server'].kill('SIGKILL');
    await until('the strip says so', () => other.getByText('Signed out').isVisible(), 8000);
    assert(await other.getByText('Stop at the hoist itself, or with STOP.').isVisible(), 'it does not say what to do');
    assert(await other.getByRole('button', { name: 'STOP' }).isVisible(), 'no STOP');
    await until('it does not claim to know what the hoist does', async () => (await other.locator('.mode strong').textContent()) === 'Unknown', 3000);
    await stack.startServer();
    await until('it is signed in again', async () => !(await other.getByText('Signed out').isVisible()), 10_000);
    await other.getByRole('button', { name: 'STOP' }).click();
    await until('STOP works', async () => (await other.locator('.mode strong').textContent()) === 'Stopped');
    await other.close();
    await until('the first page is back', async () => (await modeName()) === 'Stopped', 10_000);
    await toStandby();
  },

  async 'the page had nothing to complain about'() {
    const said = [...pageErrors, ...complaints];
    // What it complained about earlier is not this moment's fault.
    if (said.length > 0) throw new Unexcused(said.slice(0, 5).join('\n'));
  },
};

// What is registered elsewhere (control/safety/tests.def) is compared with this list.
if (process.argv.includes('--list')) {
  for (const name of Object.keys(cases)) console.log(name);
  process.exit(0);
}

const tests = [];
const of = (status) => tests.filter((one) => one.status === status);
const all = Object.keys(cases);
const signsIn = all[0], complains = all.at(-1);
// What looks at the recorded walk stands before this case; each part signs in and ends with the complaints.
const secondPart = all.findIndex((name) => name.startsWith(secondPartFrom));
assert(secondPart > 0, `no case begins with "${secondPartFrom}"`);
const inPart = (name, i) => part === 0 || name === signsIn || name === complains || (i < secondPart) === (part === 1);
const names = all.filter((name, i) => inPart(name, i) && name.includes(only));
const skipAll = (reason) => names.forEach((name) => tests.push({ name, status: 'skipped', reason }));
/** Null, or the failure. */
async function attempt(name) {
  try {
    await cases[name]();
    return null;
  } catch (error) {
    return error;
  }
}

/** The delay caused by a busy computer, or null. A case that failed meanwhile proves nothing. */
function tooBusyFor(failure) {
  if (failure instanceof Unexcused || !drove || lateTurns_ms.length === 0) return null;
  return `the browser, which had no turn for ${Math.max(...lateTurns_ms).toFixed(0)} ms`;
}

/** The next case starts from running programs, the patient at the start mark and a fresh page. */
async function recover() {
  await page?.mouse.up().catch(() => {});
  await page?.close().catch(() => {});
  // Stops again and again put the hoist out of service; without a new start the cases that follow could only fail.
  // Out of service outlasts a restart (H22), so the stored stops go, too.
  if ((await stack.coreStatus().catch(() => null))?.mode === 'fault') {
    await stack.programs['hoist-control'].kill('SIGTERM');
    rmSync(stack.path('data', 'parameters.json.stops'), { force: true });
  }
  const start = { 'hoist-sim': () => stack.startSim(), 'hoist-control': () => stack.startControl(), 'hoist-server': () => stack.startServer() };
  for (const program of programs) if (stack.programs[program]?.ended) await start[program]().catch(() => {});
  await openConsole().catch(() => {});
  // Calibrating takes the patient out of the straps, and a case that failed there may not have put him back. Both need drives that are off.
  const fresh = () => stack.ask({ op: 'strap' }).then(() => stack.ask({ op: 'reset' }));
  await fresh().catch(() => toStandby().then(fresh).catch(() => {}));
}

const missing = programs.filter((name) => !existsSync(join(bin, name)));
if (missing.length > 0) skipAll(`${missing.join(', ')} not in ${bin}`);
else if (!existsSync(join(web, 'index.html'))) skipAll(`no built console in ${web}`);
else if (browserProgram === undefined) skipAll('no chromium on this machine');
else {
  const { chromium } = createRequire(join(top, 'web/package.json'))('playwright-core');
  if (shots) mkdirSync(shots, { recursive: true });
  stack = new Stack({ bin, web });
  const quit = () => void stack.stop().finally(() => process.exit(1));
  process.once('SIGINT', quit);
  process.once('SIGTERM', quit);
  try {
    await stack.start();
    browser = await chromium.launch({
      executablePath: stack.politely(browserProgram),
      args: ['--no-sandbox', '--disable-gpu', '--no-first-run', '--disable-background-networking', '--disable-component-update', '--disable-sync'],
    });
    context = await browser.newContext({ viewport: { width: 1280, height: 800 }, locale: 'en-GB', acceptDownloads: true });
    await context.exposeBinding('hoistTestLate', (_, gap_ms) => void lateTurns_ms.push(gap_ms));
    await context.addInitScript(watchTurns, { late_ms: browserLate_ms, loading_ms });
    await context.addInitScript(drawLess);
    // Every run signs in first, also for a single case.
    if (!names.includes(signsIn)) names.unshift(signsIn);
    for (const name of names) {
      const began = performance.now();
      let failure = null;
      let busy = null;
      let unexcused = null;
      // A computer that was too busy for two cases will hardly be better for the others: they get one attempt each.
      let attempts = of('skipped').length < 2 ? attemptsMax : 1;
      for (;;) {
        lateTurns_ms = [];
        drove = false;
        const complaintsBefore = complaints.length;
        failure = await attempt(name);
        busy = failure === null ? null : tooBusyFor(failure);
        attempts -= 1;
        if (failure === null || failure instanceof NothingToJudge) break;
        if (busy !== null) {
          console.log(`busy    ${name}: this computer was too busy for ${busy} (${failure.message})`);
          complaints.length = complaintsBefore;
          if (attempts <= 0) break;
        } else {
          unexcused = failure;
          if (secondChances <= 0) break;
          secondChances -= 1;
          attempts = attemptsMax;
          console.log(`again   ${name}: ${failure.stack}\n${stack.outputs()}`);
        }
        await recover();
      }
      // A real failure is cleared only when the case passes, not when the next attempt is inconclusive.
      if (busy !== null && unexcused !== null) [failure, busy] = [unexcused, null];
      const took = `(${((performance.now() - began) / 1000).toFixed(1)} s)`;
      if (busy !== null || failure instanceof NothingToJudge) {
        const reason = busy === null ? failure.message : `this computer was too busy for ${busy}`;
        tests.push({ name, status: 'skipped', reason });
        console.log(`skipped ${name}: ${reason} ${took}`);
        if (busy !== null) await recover();
        continue;
      }
      tests.push(failure === null ? { name, status: 'passed' } : { name, status: 'failed', reason: failure.message });
      console.log(`${failure === null ? 'passed' : 'FAILED'}  ${name} ${took}`);
      if (failure !== null) {
        console.log(`${failure.stack}\n${stack.outputs()}`);
        if (shots && page && !page.isClosed()) await page.screenshot({ path: join(shots, `failed-${tests.length}.png`) }).catch(() => {});
        await recover();
      }
    }
  } catch (error) {
    console.log(`${error.stack}\n${stack.outputs()}`);
    tests.push({ name: 'the programs and the browser start', status: 'failed', reason: error.message });
  } finally {
    await browser?.close().catch(() => {});
    await stack.stop();
  }
}

for (const one of of('skipped')) console.log(`skipped  ${one.name}: ${one.reason}`);
if (report)
  writeFileSync(
    report,
    JSON.stringify({
      tests,
      passed: of('passed').map((one) => one.name),
      failed: of('failed').map(({ name, reason }) => ({ name, message: reason })),
      skipped: of('skipped').map(({ name, reason }) => ({ name, reason })),
    }),
  );
console.log(`${of('passed').length} passed, ${of('failed').length} failed, ${of('skipped').length} skipped`);
process.exit(of('failed').length > 0 ? 1 : 0);
