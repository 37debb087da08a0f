import { describe, expect, it } from 'vitest';
import { intoView } from '../src/ui/stop_button';

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
