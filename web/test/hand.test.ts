// Every way to let go of what is held, in a browser: the stick of Drive, and the button that releases a stop (H19).
import type { Page } from 'playwright-core';
import { beforeEach, describe, expect, it } from 'vitest';
import { en } from '../src/text/en';
import { releaseHold_ms } from '../src/ui/strip';
import { eachPage, minutes_ms } from '../test-support/browser';
import type { FakeServer } from '../test-support/fake_server.mjs';

const start = eachPage(1024, 768);
let fake: FakeServer;
let page: Page;

interface Sent {
  type: string;
  speed?: number;
  yaw?: number;
  held?: boolean;
}
interface Watched {
  sent: Sent[];
}
beforeEach(async () => {
  ({ fake, page } = await start());
  // What the page sends, in the call that sends it: no answer has to be waited for.
  await page.addInitScript(() => {
    const watched = window as unknown as Watched;
    watched.sent = [];
    const send = WebSocket.prototype.send;
    WebSocket.prototype.send = function (data) {
      const message = JSON.parse(data as string) as Sent;
      watched.sent.push(message);
      // A busy computer answers late, and over a slow link nothing can be held.
      if (message.type === 'ping')
        queueMicrotask(() => this.dispatchEvent(new MessageEvent('message', { data: JSON.stringify({ ...message, type: 'pong' }) })));
      else send.call(this, data);
    };
  });
});

/** Dispatches in the page, and tells which of these messages went during that. */
const during = (
  what: { target: string; event: string; kind?: 'Event' | 'KeyboardEvent' | 'PointerEvent'; init?: object; hidden?: boolean },
  type: string,
) =>
  page.evaluate(
    ({ target, event, kind = 'Event', init = {}, hidden = false, type }) => {
      const targets: Record<string, EventTarget | null> = {
        window,
        document,
        orientation: screen.orientation,
        viewport: window.visualViewport,
      };
      if (hidden) Object.defineProperty(document, 'hidden', { configurable: true, get: () => true });
      const { sent } = window as unknown as Watched;
      const before = sent.length;
      (targets[target] ?? document.querySelector(target))!.dispatchEvent(new window[kind](event, { bubbles: true, cancelable: true, ...init }));
      return sent.slice(before).filter((message) => message.type === type);
    },
    { ...what, type },
  );
type What = Parameters<typeof during>[0];

const ways: [string, What][] = [
  ['the window loses the focus', { target: 'window', event: 'blur' }],
  ['the page is left', { target: 'window', event: 'pagehide' }],
  ['a question opens', { target: 'window', event: 'hoist-dialog' }],
  ['the window changes its size', { target: 'window', event: 'resize' }],
  ['the screen is turned', { target: 'orientation', event: 'change' }],
  ['the page is magnified', { target: 'viewport', event: 'resize' }],
  ['the tab is hidden', { target: 'document', event: 'visibilitychange', hidden: true }],
  ['the tab is frozen', { target: 'document', event: 'freeze' }],
];
const mouse = 1; // the pointerId of the mouse in Chromium
const pointerWays = ['pointerup', 'pointercancel', 'lostpointercapture'];

describe('the stick', { timeout: minutes_ms }, () => {
  const pad = '.pad';
  const letGo = Array.from({ length: 3 }, (): unknown => expect.objectContaining({ speed: 0, yaw: 0, held: false }));
  const drives = (what: What) => during(what, 'drive');
  const by = (event: string, init: object = {}, pointerId = mouse): What => ({
    target: pad,
    event,
    kind: 'PointerEvent',
    init: { pointerId, ...init },
  });
  const key = (event: string, init: object, target = 'window'): What => ({ target, event, kind: 'KeyboardEvent', init });
  const middle = async () => {
    const box = (await page.locator(pad).boundingBox())!;
    return { x: box.x + box.width / 2, y: box.y + box.height / 2, reach: box.width * 0.34 };
  };
  const newest = () => page.evaluate(() => (window as unknown as Watched).sent.filter(({ type }) => type === 'drive').at(-1) ?? null);
  /** Held forwards by the mouse. */
  const hold = async () => {
    const { x, y, reach } = await middle();
    await page.mouse.move(x, y - reach);
    await page.mouse.down();
    await expect.poll(newest).toMatchObject({ speed: 1, held: true });
  };
  beforeEach(async () => {
    await page.goto(`${fake.url}#/drive`);
    await page.getByRole('button', { name: en['drive.start'], exact: true }).click();
    await page.locator('.pad.active').waitFor();
    // As the keys are listened to, the page says that nothing is held.
    await expect.poll(newest).toMatchObject({ held: false });
  });

  it.each([...ways, ...pointerWays.map((event): [string, What] => [`the browser says ${event}`, by(event)])])('is let go when %s', async (_, way) => {
    await hold();
    expect(await drives(way)).toEqual(letGo);
  });

  it('follows its own finger also beyond its edge, and neither another one nor a key', async () => {
    await hold();
    const other = mouse + 6;
    const box = await middle();
    const behind = { clientX: box.x, clientY: box.y + box.reach, button: 0 };
    // The browser knows no such finger to capture.
    await page.locator(pad).evaluate((element) => (element.setPointerCapture = () => {}));
    // A press or a movement that counted would be sent by the next tick, a release at once.
    for (const event of ['pointerdown', 'pointermove']) expect(await drives(by(event, behind, other))).toEqual([]);
    for (const event of ['pointerup', 'pointercancel', 'lostpointercapture']) expect(await drives(by(event, behind, other))).toEqual([]);
    expect(await drives(key('keydown', { code: 'KeyS', key: 's' }))).toEqual([]);
    const count = await page.evaluate(() => (window as unknown as Watched).sent.length);
    await expect
      .poll(() => page.evaluate((from) => (window as unknown as Watched).sent.slice(from).find(({ type }) => type === 'drive'), count))
      .toMatchObject({
        speed: 1,
        held: true,
      });
    await page.mouse.move(box.x + 3 * box.reach, box.y - box.reach);
    await expect.poll(async () => (await newest())?.yaw ?? 0).toBeLessThan(-0.9);
    await page.mouse.up();
    expect(await newest()).toMatchObject({ speed: 0, yaw: 0, held: false });
  });

  it('is not moved by a letter typed into a field or by a shortcut, and Cmd takes the keys away', async () => {
    await page.evaluate(() => document.body.append(document.createElement('input')));
    const w = { code: 'KeyW', key: 'w' };
    expect(await drives(key('keydown', w, 'body > input'))).toEqual([]);
    for (const held of ['ctrlKey', 'altKey', 'metaKey']) expect(await drives(key('keydown', { ...w, [held]: true }))).toEqual([]);
    expect(await drives(key('keydown', w))).toMatchObject([{ speed: 1, held: true }]);
    expect(await drives(key('keydown', { key: 'Meta', code: 'MetaLeft', metaKey: true }))).toEqual(letGo);
  });
});

describe('the button that releases a stop', { timeout: minutes_ms }, () => {
  const button = '.strip .hold';
  // Control is taken first, in the call in which the press has lasted long enough.
  const released = () => page.evaluate(() => (window as unknown as Watched).sent.some(({ type }) => type === 'lease_take'));
  beforeEach(async () => {
    fake.fault('stop_pressed');
    fake.hoist.mode = 'protective_stop';
    await page.goto(`${fake.url}#/home`);
    await page.locator(button).waitFor();
  });
  const press = async (by: string) => {
    if (by === 'Enter') {
      await page.locator(button).focus();
      await page.keyboard.down('Enter');
    } else {
      await page.locator(button).hover();
      await page.mouse.down();
    }
    await page.locator(`${button}.held`).waitFor();
  };
  const notHeld = () => page.locator(`${button}:not(.held)`).waitFor();

  it.each(['the mouse', 'Enter'])('held by %s releases it', async (by) => {
    await press(by);
    await expect.poll(released, { timeout: minutes_ms }).toBe(true);
  });

  it.each<[string, string, What]>([
    ['the window loses the focus', 'the mouse', { target: 'window', event: 'blur' }],
    ['the tab is hidden', 'the mouse', { target: 'document', event: 'visibilitychange', hidden: true }],
    ...pointerWays.map((event): [string, string, What] => [
      `the browser says ${event}`,
      'the mouse',
      { target: button, event, kind: 'PointerEvent' },
    ]),
    ['the key comes up', 'Enter', { target: button, event: 'keyup', kind: 'KeyboardEvent', init: { key: 'Enter' } }],
    ['it loses the focus', 'Enter', { target: button, event: 'blur', init: { bubbles: false } }],
  ])('is let go when %s', async (_, by, way) => {
    await press(by);
    await during(way, '');
    await notHeld();
    expect(await released()).toBe(false);
  });

  it('releases nothing when it has gone from the screen', async () => {
    await press('the mouse');
    fake.hoist.mode = 'standby';
    await page.locator(button).waitFor({ state: 'detached' });
    // Timers of the page go off in their order: its own would have gone off before this one.
    await page.evaluate((ms) => new Promise((passed) => setTimeout(passed, ms)), releaseHold_ms);
    expect(await released()).toBe(false);
  });
});
