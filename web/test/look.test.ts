// Readability and reachability in both themes.
import { readdirSync, readFileSync } from 'node:fs';
import { describe, expect, it } from 'vitest';
import { stepTo } from '../src/ui/radio_keys';

const css = readFileSync('src/style/tokens.css', 'utf8');
const luminance = (hex: string) => {
  const [r = 0, g = 0, b = 0] = [1, 3, 5]
    .map((at) => parseInt(hex.slice(at, at + 2), 16) / 255)
    .map((x) => (x <= 0.03928 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
/** WCAG 2.2, contrast ratio. */
const contrast = (a: string, b: string) => {
  const [light = 0, dark = 0] = [luminance(a), luminance(b)].sort((x, y) => y - x);
  return (light + 0.05) / (dark + 0.05);
};

const themes = [...css.matchAll(/color-scheme: (light|dark);([^}]*)\}/g)].map(([, name, body]) => ({
  name,
  colours: Object.fromEntries([...body!.matchAll(/--([\w-]+): (#[0-9a-f]{6});/g)].map(([, key, value]) => [key!, value!])),
}));

describe('colours', () => {
  it('are defined for light and dark', () => {
    expect(themes.map((theme) => theme.name)).toEqual(['light', 'dark', 'dark']);
    expect(themes[2]!.colours).toEqual(themes[1]!.colours);
  });

  it('keep words readable, also those of old values, and edges visible', () => {
    for (const { name, colours } of themes)
      for (const ground of [colours.card!, colours.paper!, colours['accent-wash']!]) {
        expect(contrast(colours.ink!, ground), `${name} ink`).toBeGreaterThanOrEqual(4.5);
        expect(contrast(colours['ink-soft']!, ground), `${name} soft ink`).toBeGreaterThanOrEqual(4.5);
        if (ground !== colours['accent-wash']) expect(contrast(colours['line-strong']!, ground), `${name} edge`).toBeGreaterThanOrEqual(3);
      }
  });
});

describe('style sheets', () => {
  const sheets = readdirSync('src', { recursive: true, encoding: 'utf8' }).filter((file) => file.endsWith('.css'));

  it('take type, distances and corners from the tokens', () => {
    // Text inside a picture uses the picture's units; sizes above the largest distance are reserved places.
    const largest_px = 24;
    const written: string[] = [];
    for (const file of sheets)
      for (const [, selector, body] of readFileSync(`src/${file}`, 'utf8').matchAll(/([^{}]+)\{([^{}]*)\}/g)) {
        if (/stop-word|p-text/.test(selector!)) continue;
        for (const [line, name, value] of body!.matchAll(
          /^\s*(font|font-size|border-radius|padding[\w-]*|margin[\w-]*|gap|row-gap|column-gap): ([^;]*);/gm,
        ))
          if (!value!.includes('calc') && [...value!.matchAll(/([\d.]+)px/g)].some(([, px]) => name!.startsWith('font') || Number(px) <= largest_px))
            written.push(`${file}:${line}`);
      }
    expect(written).toEqual([]);
  });

  it('use only tokens that exist', () => {
    const all = sheets.map((file) => readFileSync(`src/${file}`, 'utf8')).join('\n');
    const known = new Set([...all.matchAll(/(--[\w-]+):/g)].map(([, name]) => name));
    expect([...all.matchAll(/var\((--[\w-]+)\)/g)].map(([, name]) => name!).filter((name) => !known.has(name))).toEqual([]);
  });

  it('stand beside the component that brings them', () => {
    for (const file of sheets) {
      if (file.startsWith('style/')) continue;
      const importers = readdirSync('src', { recursive: true, encoding: 'utf8' }).filter(
        (source) => /\.tsx?$/.test(source) && readFileSync(`src/${source}`, 'utf8').includes(`/${file.split('/').at(-1)!}'`),
      );
      expect(importers, file).not.toEqual([]);
    }
  });
});

describe('arrow keys among choices', () => {
  it('lead to the next one and around the end', () => {
    expect(stepTo('ArrowRight', 0, 3)).toBe(1);
    expect(stepTo('ArrowDown', 2, 3)).toBe(0);
    expect(stepTo('ArrowLeft', 0, 3)).toBe(2);
    expect(stepTo('ArrowUp', 1, 3)).toBe(0);
  });

  it('leave other keys alone', () => {
    for (const key of [' ', 'Enter', 'Tab', 'a']) expect(stepTo(key, 0, 3)).toBeNull();
    expect(stepTo('ArrowRight', -1, 0)).toBeNull();
  });
});
