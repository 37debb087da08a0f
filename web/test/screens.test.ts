// Every screen in a browser with the stand-in server: keyboard, screen reader, small screen.
import axe from 'axe-core';
import type { Page } from 'playwright-core';
import { afterAll, beforeAll, describe, expect, it } from 'vitest';
import { de } from '../src/text/de';
import { en } from '../src/text/en';
import { minutes_ms, openBuiltConsole, type BuiltConsole } from '../test-support/browser';
import { startFakeServer, type FakeServer } from '../test-support/fake_server.mjs';

const sizes = [
  [1280, 800],
  [1024, 768],
  [390, 844],
  [640, 360],
] as const;
const looks = [
  ['light', 'en'],
  ['dark', 'de'],
] as const;
const screens = [
  'home',
  'walk',
  'drive',
  'exercises',
  'tune',
  'sessions',
  'calibrate',
  'health',
  'patients/5',
  'study',
  'rehearse',
  'settings/me',
  'settings/users',
  'settings/tokens',
  'settings/device',
  'settings/tools',
  'settings/backup',
  'settings/audit',
] as const;

let built: BuiltConsole;
let fake: FakeServer;

beforeAll(async () => {
  built = await openBuiltConsole();
  fake = await startFakeServer({ dist: built.folder });
}, minutes_ms);
afterAll(async () => {
  await built?.close();
  await fake?.close();
});

type Look = readonly ['light' | 'dark', 'en' | 'de'];
async function open([width, height]: readonly [number, number], look: Look, screen: string): Promise<Page> {
  const page = await built.browser.newPage({ viewport: { width, height }, colorScheme: look[0], locale: look[1] });
  await page.goto(`${fake.url}#/${screen}`);
  await page.locator('.mode-standby').waitFor();
  return page;
}

/** The last element of each screen to appear; otherwise the previous or an empty screen would be tested. */
const last: Record<(typeof screens)[number], string> = {
  home: '.home .rows li',
  walk: '.walk-body .reading .num',
  drive: '.drive-body .pad',
  exercises: '.guided-settings .stepper',
  tune: '.tune-row',
  sessions: '.session-item',
  calibrate: '.calibrate-list li',
  health: '.health .part-detail',
  'patients/5': '.patient .rows li',
  study: '.study-drawing img',
  rehearse: '.rehearse-kinds button',
  'settings/me': '.settings-part .form',
  'settings/users': '.settings-part .rows li',
  'settings/tokens': '.settings-part .rows li',
  'settings/device': '.settings-part dl',
  'settings/tools': '.settings-part dl',
  'settings/backup': '.settings-part .rows li',
  'settings/audit': '.settings-part .rows li',
};

/** Enough data that each list scrolls. */
async function fill(page: Page, screen: (typeof screens)[number]): Promise<void> {
  for (let i = 0; i < 16; i++) {
    fake.event('mode_changed', { name: 'standby' });
    fake.event('emergency', { name: 'drive_left', code: 0x8250, item: 0, bits: 0x11, time_ns: (i + 1) * 1e7 }); // equal ones are told once
  }
  await page.goto(`${fake.url}#/${screen}`);
  await page.locator(last[screen]).first().waitFor();
  if (screen === 'sessions') {
    await page.locator('.session-item').first().click();
    await page.locator('.u-wrap').first().waitFor();
  }
  if (screen === 'sessions' || screen === 'health') {
    const scrolling = () => page.locator('.events').evaluateAll((lists) => lists.some((list) => list.scrollHeight > list.clientHeight));
    await expect.poll(scrolling, { timeout: 10_000, message: screen }).toBe(true);
  }
}

const rules = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa'];
const shots = [
  [[1280, 800], looks[0]],
  [[390, 844], looks[1]],
] as [[number, number], Look][];

describe('accessibility', () => {
  it.each(shots)('%j %j: axe finds nothing on any screen', { timeout: minutes_ms }, async (size, look) => {
    const page = await open(size, look, 'walk');
    await page.evaluate(axe.source); // not a script element: the page's content security policy forbids those
    for (const screen of screens) {
      await fill(page, screen);
      const found = await page.evaluate(async (runOnly) => {
        const { violations } = await (window as unknown as { axe: typeof axe }).axe.run({ runOnly });
        return violations.flatMap(({ id, nodes }) => nodes.map((node) => `${id}: ${node.html.slice(0, 160)}`));
      }, rules);
      expect(found, screen).toEqual([]);
    }
    await page.close();
  });
});

describe('the list of sessions', () => {
  it('shows those whose code has what is searched for', { timeout: minutes_ms }, async () => {
    const page = await open([1280, 800], looks[0], 'sessions');
    const shown = () => page.locator('.session-item').count();
    await expect.poll(shown, { timeout: 10_000 }).toBe(3);
    await page.locator('.search').fill('07');
    await expect.poll(shown, { timeout: 10_000 }).toBe(2);
    await page.locator('.search').fill('08');
    await page.getByText(en['sessions.none']).waitFor();
    expect(await shown()).toBe(0);
    await page.close();
  });
});

describe('the session chart', () => {
  it('draws one strip for each unit, with the unit at its axis', { timeout: minutes_ms }, async () => {
    const page = await open([1280, 800], looks[0], 'sessions');
    // Axes are drawn on a canvas: collect its text calls.
    await page.evaluate(() => {
      const drawn: Set<string> = ((window as unknown as { drawn: Set<string> }).drawn = new Set());
      const draw = CanvasRenderingContext2D.prototype.fillText;
      CanvasRenderingContext2D.prototype.fillText = function (text, ...place) {
        drawn.add(text);
        draw.call(this, text, ...place);
      };
    });
    await fill(page, 'sessions');
    expect(await page.locator('.u-wrap').count()).toBe(1);
    await page.locator('.columns .pill', { hasText: 'Turn rate' }).click();
    // uPlot fills the legend of a strip after the strip is in the page.
    const strips = () =>
      page
        .locator('.chart .uplot')
        .evaluateAll((all) => all.map((one) => [...one.querySelectorAll('.u-series th')].slice(1).map((label) => label.textContent)));
    await expect.poll(strips, { timeout: 10_000 }).toEqual([['Speed', 'Commanded speed'], ['Turn rate']]);
    const axes = () =>
      page.evaluate(() => {
        const { drawn } = window as unknown as { drawn: Set<string> };
        return {
          units: ['m/s', '°/s'].filter((unit) => drawn.has(unit)),
          beyond_5: [...drawn].some((text) => /^\d+$/.test(text) && Number(text) > 5),
        };
      });
    // 0.3 rad/s is 17 °/s.
    await expect.poll(axes, { timeout: 10_000 }).toEqual({ units: ['m/s', '°/s'], beyond_5: true });
    await page.close();
  });
});

describe.each(sizes)('a study that was pressed, at %i × %i', (...size) => {
  it('comes into view', { timeout: minutes_ms }, async () => {
    const page = await open(size, looks[1], 'study');
    await page.locator(last.study).first().waitFor();
    await page.locator('.study-list a').first().click();
    const inView = () => page.locator('.study-head h2').evaluate((title) => title.getBoundingClientRect().bottom < innerHeight / 2);
    await expect.poll(inView, { timeout: 10_000 }).toBe(true);
    await page.close();
  });
});

describe.each(sizes)('an alarm on a page that no finger has touched, at %i × %i', (...size) => {
  it('can be read whole', { timeout: minutes_ms }, async () => {
    const page = await open(size, looks[1], 'walk');
    fake.fault('fall_detected');
    fake.hoist.mode = 'protective_stop';
    try {
      await page.locator('.strip.high').waitFor();
      await page.locator('.strip .sound').waitFor();
      const words = page.locator('.strip-words');
      expect(await words.textContent()).toContain('Patienten aufrichten');
      expect(await words.evaluate((element) => element.scrollHeight <= element.clientHeight + 1)).toBe(true);
    } finally {
      fake.hoist.faults = 0;
      fake.hoist.mode = 'standby';
      await page.close();
    }
  });
});

describe.each([
  [1280, 800],
  [1024, 768],
] as const)('where the hoist leads, at %i × %i', (...size) => {
  it('the button to hold is on the screen', { timeout: minutes_ms }, async () => {
    const page = await open(size, looks[1], 'exercises');
    try {
      await page.getByRole('radio', { name: 'Gerät führt' }).click();
      await page.waitForTimeout(500); // the floor is drawn as high as the settings
      await page.getByRole('button', { name: 'Aufgabe beginnen' }).click();
      const hold = page.getByRole('button', { name: de['guided.hold'] });
      await hold.and(page.locator(':enabled')).waitFor();
      const bottom = (one: Element) => one.getBoundingClientRect().bottom;
      const main = await page.locator('main').evaluate(bottom);
      await expect.poll(() => hold.evaluate(bottom)).toBeLessThanOrEqual(main);
    } finally {
      fake.hoist.mode = 'standby';
      await page.close();
    }
  });
});

describe.each([
  [390, 844],
  [360, 640],
  [360, 700],
  [360, 760],
  [844, 390],
  [512, 384],
  [1024, 768],
] as const)('at %i × %i', (...size) => {
  it.each(looks)('the whole joystick and End are on the screen when driving begins (%s, %s)', { timeout: minutes_ms }, async (...look) => {
    const page = await open(size, look, 'drive');
    const table = look[1] === 'de' ? de : en;
    const box = (one: Element) => {
      const { top, bottom, width } = one.getBoundingClientRect();
      return { top, bottom, width };
    };
    try {
      await page.getByRole('button', { name: table['drive.start'] }).click();
      await page.locator('.pad.active').waitFor();
      for (const part of [page.locator('.pad'), page.getByRole('button', { name: table['drive.end'] })]) {
        const inside = async () => {
          const [main, one] = [await page.locator('main').evaluate(box), await part.evaluate(box)];
          return one.top >= main.top && one.bottom <= main.bottom && one.width >= 120;
        };
        await expect.poll(inside).toBe(true);
      }
    } finally {
      fake.hoist.mode = 'standby';
      await page.close();
    }
  });
  it('it is there also with a task', { timeout: minutes_ms }, async () => {
    const page = await open(size, looks[1], 'drive');
    try {
      await page.evaluate(() => fetch('/api/v1/task', { method: 'PUT', body: '{"task":"walk_10m"}' }));
      await page.locator('.task-strip').waitFor();
      await page.getByRole('button', { name: de['drive.start'] }).click();
      await page.locator('.pad.active').waitFor();
      await page.locator('.task-strip').getByText(de['task.leaveLater']).waitFor();
      // Also with the longest word about the task, which is there for a moment when an interrupted one goes on.
      for (const word of [de['task.broken'], de['task.next'], de['task.ready']]) {
        const [pad, main] = await page.locator('.task-strip .num').evaluate((phase, text) => {
          phase.textContent = text;
          const box = (place: string) => document.querySelector(place)!.getBoundingClientRect();
          return [box('.pad'), box('main')];
        }, word);
        expect(pad.top, word).toBeGreaterThanOrEqual(main.top);
        expect(pad.bottom, word).toBeLessThanOrEqual(main.bottom);
        expect(pad.width).toBeGreaterThanOrEqual(150);
      }
    } finally {
      fake.hoist.task = null;
      fake.hoist.mode = 'standby';
      await page.close();
    }
  });
});

describe('the longest words of buttons', () => {
  it.each([
    [[360, 640], '.nav a', 0],
    [[390, 844], '.nav a', 0],
    [[1024, 768], '.markers button', 4],
  ] as const)('at %j are apart in %s', { timeout: minutes_ms }, async (size, place, inside_px) => {
    const page = await open(size, looks[1], 'walk');
    await page.locator(last.walk).first().waitFor();
    const close = await page.evaluate(
      ([buttons, inside]) => {
        const boxes = [...document.querySelectorAll(`${buttons}, .stop`)].map((button) => {
          const text = document.createRange();
          text.selectNodeContents(button.querySelector('span') ?? button);
          const { left, right, top, bottom } = button.matches('.stop') ? button.getBoundingClientRect() : text.getBoundingClientRect();
          const edge = button.getBoundingClientRect();
          return {
            name: button.textContent,
            left,
            right,
            top,
            bottom,
            out: !button.matches('.stop') && (left < edge.left + inside || right > edge.right - inside),
          };
        });
        const near = (a: (typeof boxes)[number], b: (typeof boxes)[number]) =>
          a.left < b.right + 3 && b.left < a.right + 3 && a.top < b.bottom && b.top < a.bottom;
        const pairs = boxes.flatMap((a, i) => boxes.slice(i + 1).map((b) => [a, b] as const)).filter(([a, b]) => near(a, b));
        return [...pairs.map(([a, b]) => `${a.name} at ${b.name}`), ...boxes.filter(({ out }) => out).map(({ name }) => name)];
      },
      [place, inside_px] as const,
    );
    expect(close).toEqual([]);
    await page.close();
  });
});

describe('the status bar', () => {
  it('shows each text and picture whole, on phones and at 200 % zoom', { timeout: minutes_ms }, async () => {
    fake.hoist.patient = { code: 'P-0042-B' };
    const page = await open([1024, 768], looks[1], 'drive');
    const other = await open([1024, 768], looks[1], 'drive');
    try {
      // In control, which has a button in the bar, or controlled by another screen, and recorded in standby: the widest texts.
      await page.getByRole('button', { name: de['drive.start'] }).click();
      await page.locator('.pad.active').waitFor();
      const ended = async () => {
        await page
          .getByRole('button', { name: de['drive.end'] })
          .click({ timeout: 300 })
          .catch(() => null); // not right after Start (firm_click.ts)
        return page.locator('.mode-standby').count();
      };
      await expect.poll(ended, { timeout: 10_000, interval: 300 }).toBe(1);
      await page.locator('.bar', { hasText: de['bar.standby'] }).getByText(de['bar.giveBackShort']).waitFor();
      await other.locator('.bar', { hasText: de['bar.standby'] }).getByText(de['bar.controlOther']).waitFor();
      for (const [width, height] of [...sizes, [1004, 700], [800, 600], [844, 390], [667, 375], [512, 384], [320, 568]] as const) {
        for (const one of [page, other]) await one.setViewportSize({ width, height });
        const troubleOf = (bar: Element) => {
          const parts: { name: string; box: DOMRect }[] = [];
          const add = (name: string, box: DOMRect) => box.width > 1 && parts.push({ name, box });
          for (const picture of bar.querySelectorAll('svg')) add(picture.getAttribute('class')!, picture.getBoundingClientRect());
          const texts = document.createTreeWalker(bar, NodeFilter.SHOW_TEXT);
          while (texts.nextNode()) {
            const range = document.createRange();
            range.selectNodeContents(texts.currentNode);
            add(texts.currentNode.textContent!, range.getBoundingClientRect());
          }
          const { left, top, right, bottom } = bar.getBoundingClientRect();
          const outside = parts.filter(({ box }) => box.left < left || box.right > right || box.top < top - 1 || box.bottom > bottom + 1);
          const over = (a: DOMRect, b: DOMRect) => a.left < b.right && b.left < a.right && a.top < b.bottom - 1 && b.top < a.bottom - 1;
          const pairs = parts.flatMap((a, i) => parts.slice(i + 1).map((b) => [a, b] as const)).filter(([a, b]) => over(a.box, b.box));
          return [...outside.map(({ name }) => name), ...pairs.map(([a, b]) => `${a.name} on ${b.name}`)];
        };
        for (const one of [page, other]) expect(await one.locator('.bar').evaluate(troubleOf), `${width} x ${height}`).toEqual([]);
      }
    } finally {
      fake.hoist.patient = null;
      fake.hoist.mode = 'standby';
      await page.close();
      await other.close();
    }
  });
});

describe.each(sizes)('short messages at %i × %i', (...size) => {
  it('cover nothing and move nothing', { timeout: minutes_ms }, async () => {
    const page = await open(size, looks[1], 'walk');
    const places = () =>
      page.evaluate(() =>
        [...document.querySelectorAll('.bar, .strip, .main, .main button, .reading, .floor, .nav a, .stop')].map((element) => {
          const { left, top, right, bottom } = element.getBoundingClientRect();
          return { what: element.className.toString() || element.textContent, left, top, right, bottom };
        }),
      );
    const before = await places();
    fake.event('guided_ended', { name: 'finished' });
    fake.event('parameters_reverted');
    fake.event('guided_ended', { name: 'off_path' });
    await page.locator('.notice', { hasText: de['guided.off_path'] }).waitFor();
    expect(await places()).toEqual(before);
    const covered = await page.evaluate(() => {
      const main = document.querySelector('.main')!.getBoundingClientRect();
      const shown = document.querySelector('.notices')!.getBoundingClientRect();
      const first = document.querySelector('.notice')!.getBoundingClientRect();
      const over = (a: DOMRect, b: DOMRect) => a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
      const whole = first.bottom <= shown.bottom + 1 && first.top >= shown.top - 1 && first.right <= shown.right + 1;
      const kept = ['.bar', '.strip', '.nav a', '.stop'].filter((name) =>
        [...document.querySelectorAll(name)].some((element) => over(shown, element.getBoundingClientRect())),
      );
      return { whole, main: over(shown, main), kept };
    });
    expect(covered).toEqual({ whole: true, main: false, kept: [] });
    await page.close();
  });
});
