import { describe, expect, it } from 'vitest';
import { panelOf, panels } from '../src/panels/index';
import { addressOf, readAddress } from '../src/router';

describe('an address', () => {
  it('names a screen and perhaps a part of it', () => {
    expect(readAddress('#/walk')).toEqual({ screen: 'walk', part: null });
    expect(readAddress('#/sessions/17')).toEqual({ screen: 'sessions', part: '17' });
    expect(readAddress('#/sessions/17?from=mail')).toEqual({ screen: 'sessions', part: '17' });
    for (const part of ['zero', 'a/b', 'ü %']) expect(readAddress(addressOf('calibrate', part))).toEqual({ screen: 'calibrate', part });
    expect(addressOf('walk')).toBe('#/walk');
  });

  it('that is none, or that is damaged, leads to the first screen', () => {
    for (const hash of ['', '#', '#/', '#/nothing', '#walk', '#/%E0%A4%A', '#/constructor'])
      expect(panelOf(readAddress(hash).screen), hash).toBe(panels[0]);
  });
});
