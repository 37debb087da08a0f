// The model of a line that is being drawn: its geometry against known truth, what is wrong with it, where its points go.
import { describe, expect, it } from 'vitest';
import {
  draftOf,
  edgeAt,
  emptyDraft,
  judge,
  moved,
  nextPoint,
  onFloor,
  ownOf,
  pointsMost,
  requestOfDraft,
  steppedRadius,
  without,
  withPoint,
  type Draft,
} from '../src/panels/exercises/draft';
import { exercises, usualOwnLine } from '../src/contract/exercises.gen';
import { en } from '../src/text/en';
import { tasks } from '../src/text/tasks';
import { ownPath } from '../src/ui/own_line';
import { eachPage, minutes_ms } from '../test-support/browser';

const room = { along_m: 6, across_m: 6 };
const square: Draft = {
  name: 'Hall',
  closed: true,
  corner_radius_m: 0,
  points: [
    { x: -1.5, y: -1.5 },
    { x: 1.5, y: -1.5 },
    { x: 1.5, y: 1.5 },
    { x: -1.5, y: 1.5 },
  ],
};

describe('an own line', () => {
  it('has the length and curves of the figure that it is', () => {
    const sharp = judge(square, room);
    expect([sharp.length_m, sharp.tightest_m]).toEqual([12, 0]);
    const round = judge({ ...square, corner_radius_m: 0.5 }, room);
    expect(round.length_m).toBeCloseTo(12 - (8 - 2 * Math.PI) * 0.5, 9);
    expect(round.tightest_m).toBeCloseTo(0.5, 9);
    // A radius that no side has room for becomes half of the side: a circle.
    const circle = judge({ ...square, corner_radius_m: 3 }, room);
    expect(circle.length_m).toBeCloseTo(3 * Math.PI, 9);
    expect(circle.points.every(({ x, y }) => Math.abs(Math.hypot(x, y) - 1.5) < 1e-9)).toBe(true);
    const way = judge({ ...square, closed: false, points: square.points.slice(0, 2) }, room);
    expect([way.length_m, way.tightest_m]).toEqual([3, null]);
  });
  it('is as long as the hoist says', () => {
    expect(ownPath(usualOwnLine).length_m).toBeCloseTo(exercises.find(({ shape }) => shape === 'own')!.usual_length_m, 3);
  });
  it('says what is wrong before it is saved', () => {
    expect(judge(emptyDraft, room).wrong).toBe('few');
    expect(judge({ ...square, points: square.points.slice(0, 2) }, room).wrong).toBe('few');
    expect(judge(square, room).wrong).toBeNull();
    // The last straight of a round line counts, the same of an open one does not.
    const near = moved(square, 3, { x: -1.5, y: -1.4 });
    expect([judge(near, room).wrong, judge(near, room).near]).toEqual(['near', [4, 1]]);
    expect(judge({ ...near, closed: false }, room).wrong).toBeNull();
  });
  it('fits a floor that leaves the hoist its room', () => {
    expect(judge(square, room).fits).toBe(true);
    expect(judge(square, { along_m: 4.5, across_m: 4.5 }).fits).toBe(true);
    expect(judge(square, { along_m: 4.3, across_m: 6 }).fits).toBe(false);
    // Round corners are what is walked, not the points.
    const diamond = { ...square, points: [0, 1, 2, 3].map((i) => ({ x: [2.4, 0, -2.4, 0][i]!, y: [0, 2.4, 0, -2.4][i]! })) };
    expect([judge(diamond, room).fits, judge({ ...diamond, corner_radius_m: 1 }, room).fits]).toEqual([false, true]);
  });
  it('becomes what is saved, and is drawn on from it', () => {
    const asked = requestOfDraft({ ...square, name: ' Hall ', corner_radius_m: 0.5 });
    expect(asked).toEqual({ name: 'Hall', exercise: { ...ownOf(square), corner_radius_m: 0.5 } });
    expect(ownOf(square)).not.toHaveProperty('corner_radius_m');
    const line = { id: 1, version: 1, saved_utc_ms: 0, length_m: 12, etag: 'a', ...asked };
    expect(draftOf(line)).toEqual({ ...square, corner_radius_m: 0.5 });
  });
});

describe('points', () => {
  it('lie on the grid and on the floor', () => {
    expect(onFloor({ x: 1.234, y: -9 }, room)).toEqual({ x: 1.2, y: -3 });
  });
  it('are put between two others where they are on the line', () => {
    expect(edgeAt(square, { x: 0, y: -1.4 }, 0.2)).toBe(1);
    expect(edgeAt(square, { x: -1.5, y: 0 }, 0.2)).toBe(4);
    expect(edgeAt({ ...square, closed: false }, { x: -1.5, y: 0 }, 0.2)).toBeNull();
    expect(edgeAt(square, { x: 0, y: 0 }, 0.2)).toBeNull();
    expect(withPoint(square, { x: 0, y: -1.5 }, 1).points.map(({ x }) => x)).toEqual([-1.5, 0, 1.5, 1.5, -1.5]);
    expect(without(square, 1).points).toHaveLength(3);
  });
  it('come one after the other without a hand, never on the last one, and not without end', () => {
    let draft = emptyDraft;
    for (let i = 0; i < pointsMost + 3; i++) draft = withPoint(draft, nextPoint(draft, room));
    expect(draft.points).toHaveLength(pointsMost);
    expect(judge(draft, room).wrong).toBeNull();
    expect(draft.points.every(({ x, y }) => Math.abs(x) <= 3 && Math.abs(y) <= 3)).toBe(true);
  });
  it('have corners that are sharp or can be walked', () => {
    expect([steppedRadius(0, 1), steppedRadius(0.3, -1), steppedRadius(0.5, 1), steppedRadius(3, 1), steppedRadius(0, -1)]).toEqual([
      0.3, 0, 0.6, 3, 0,
    ]);
  });
});

describe('the free floor', { timeout: minutes_ms }, () => {
  const open = eachPage(1280, 800);
  it('is kept in the browser for the next line', async () => {
    const { fake, page } = await open();
    const along = async () => {
      await page.goto(`${fake.url}#/exercises`);
      await page.getByRole('button', { name: tasks.en['line.draw'] }).click();
      return page.getByRole('group', { name: tasks.en['line.floorAlong'] });
    };
    const more = tasks.en['guided.more'].replace('{what}', tasks.en['line.floorAlong']);
    const first = await along();
    await first.getByRole('button', { name: more }).click();
    await first.getByText('6.5 m').waitFor();
    await page.reload();
    await (await along()).getByText('6.5 m').waitFor();
    // What another version or a person has put there is no floor.
    await page.evaluate(() => localStorage.setItem('hoist.floor', '{"along_m": "wide"}'));
    await page.reload();
    await (await along()).getByText('6.0 m').waitFor();
  });
});

describe('a drawing', { timeout: minutes_ms }, () => {
  const open = eachPage(1280, 800);
  const begin = async () => {
    const { fake, page } = await open();
    await page.goto(`${fake.url}#/exercises`);
    await page.getByRole('button', { name: tasks.en['line.draw'] }).click();
    for (let i = 0; i < 2; i++) await page.getByRole('button', { name: tasks.en['line.add'] }).click();
    return { page, points: page.locator('.line-point') };
  };

  it('stays when the screen is left, and after Cancel for as long as Undo is offered', async () => {
    const { page, points } = await begin();
    const name = page.getByLabel(tasks.en['line.name']);
    await name.fill('Corridor');
    await page.locator('.nav a[href="#/walk"]').click();
    await page.locator('.walk-controls').waitFor();
    await page.locator('.nav a[href="#/exercises"]').click();
    await points.first().waitFor();
    expect([await name.inputValue(), await points.count()]).toEqual(['Corridor', 2]);
    await page.getByRole('button', { name: en['common.cancel'] }).click();
    await page.getByText(tasks.en['line.cancelled']).waitFor();
    await page.getByRole('button', { name: en['common.undo'] }).click();
    expect([await name.inputValue(), await points.count()]).toEqual(['Corridor', 2]);
    await page.getByRole('button', { name: en['common.save'] }).click();
    await page.locator('.task-field').waitFor();
    await page.locator('.nav a[href="#/walk"]').click();
    await page.locator('.walk-controls').waitFor();
    await page.locator('.nav a[href="#/exercises"]').click();
    await page.locator('.task-field').waitFor();
    await page.getByRole('button', { name: tasks.en['line.draw'] }).click();
    expect([await name.inputValue(), await points.count()], 'a saved one is over').toEqual(['', 0]);
  });

  it('follows the finger that drags, and no palm beside it', async () => {
    const { page, points } = await begin();
    const at = (await points.first().boundingBox())!;
    const [x, y] = [at.x + at.width / 2, at.y + at.height / 2];
    const label = () => points.first().getAttribute('aria-label');
    const before = await label();
    const palm = (type: string) => page.locator('.line-plan').dispatchEvent(type, { pointerId: 77, clientX: x + 90, clientY: y - 90, bubbles: true });
    await page.mouse.move(x, y);
    await page.mouse.down();
    await palm('pointermove');
    await palm('pointerup');
    expect(await label()).toBe(before);
    await page.mouse.move(x + 60, y);
    await page.mouse.up();
    await expect.poll(label).not.toBe(before);
  });
});

describe('a form', { timeout: minutes_ms }, () => {
  const open = eachPage(1280, 800);
  it('says what Save still waits for, and nothing moves when it has it', async () => {
    const { fake, page } = await open();
    await page.goto(`${fake.url}#/exercises`);
    await page.getByRole('button', { name: tasks.en['line.draw'] }).click();
    const form = page.getByRole('form', { name: tasks.en['line.title'] });
    const save = form.getByRole('button', { name: en['common.save'] });
    const missing = form.getByText(en['common.missing'].replace('{fields}', tasks.en['line.name']));
    await missing.waitFor();
    for (let i = 0; i < 3; i++) await page.getByRole('button', { name: tasks.en['line.add'] }).click();
    expect(await save.isDisabled()).toBe(true);
    const before = await form.boundingBox();
    await form.getByLabel(tasks.en['line.name']).fill('Hall');
    await missing.waitFor({ state: 'detached' });
    expect(await save.isEnabled()).toBe(true);
    expect(await form.boundingBox()).toEqual(before);
  });
});
