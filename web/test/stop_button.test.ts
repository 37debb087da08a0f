import { describe, expect, it } from 'vitest';
import { en } from '../src/text/en';
import { intoView } from '../src/ui/stop_button';
import { eachPage, minutes_ms } from '../test-support/browser';

describe('STOP', () => {
  const page = { scale: 1, offsetLeft: 0, offsetTop: 0, width: 390, height: 844 };
  const edge = { right: 14, bottom: 12 };
  const box = { right: 390 - 14, bottom: 844 - 12 };

  it('is not touched as long as the whole page is seen', () => {
    expect(intoView(box, edge, page)).toBe('');
  });

  it('keeps its place on the screen and its size when the page is drawn larger', () => {
    const view = { scale: 2, offsetLeft: 50, offsetTop: 100, width: 195, height: 422 };
    const [, x, y, scale] = /translate\((.+)px, (.+)px\) scale\((.+)\)/.exec(intoView(box, edge, view))!.map(Number);
    // On the screen: as far from the corner of what is seen as before.
    expect((view.offsetLeft + view.width - (box.right + x!)) * view.scale).toBeCloseTo(edge.right, 1);
    expect((view.offsetTop + view.height - (box.bottom + y!)) * view.scale).toBeCloseTo(edge.bottom, 1);
    expect(scale! * view.scale).toBeCloseTo(1, 4);
  });

  it('rises above a keyboard on the screen', () => {
    expect(intoView(box, edge, { ...page, height: 500 })).toBe('translate(0.0px, -344.0px) scale(1.0000)');
  });
});

describe('a check box', { timeout: minutes_ms }, () => {
  const start = eachPage(1024, 768);
  it('is toggled by Enter, and Space in it is STOP', async () => {
    const { fake, page } = await start();
    await page.goto(`${fake.url}#/settings/tools`);
    const box = page.getByLabel(en['tools.allow']);
    await box.focus();
    await page.keyboard.press('Enter');
    await expect.poll(() => box.isChecked()).toBe(true);
    const stops = () => fake.hoist.commands.filter(({ type }) => type === 'stop').length;
    expect(stops()).toBe(0);
    await box.focus();
    await page.keyboard.press('Space');
    await expect.poll(stops).toBeGreaterThan(0);
    await expect.poll(() => box.isChecked()).toBe(true);
  });
});
