import { describe, expect, it } from 'vitest';
import { signals } from '../src/contract/signals.gen';
import { curves, strips } from '../src/panels/sessions/curves';
import type { Session, SessionList } from '../src/contract/rest.gen';
import { continued, refreshed } from '../src/panels/sessions/model';

const session = (id: number): Session => ({
  id,
  subject: null,
  started_utc_ms: id,
  standby: false,
  ended_utc_ms: id + 1,
  close_reason: 'stopped',
  visit: null,
  software_version: '',
  core_version: null,
  layout_hash: '',
  stored_bytes: 1,
  duration_s: 1,
  simulated: true,
  recording: false,
  exercise: null,
  task: null,
  note: '',
  samples: 1,
  gaps: 0,
  etag: '1',
});
const page = (ids: number[], next: number | null): SessionList => ({
  items: ids.map(session),
  next: next === null ? null : String(next),
  total: ids.length,
});
const ids = (one: SessionList) => one.items.map((item) => item.id);

describe('the list of sessions', () => {
  it('grows by older ones, none of them twice', () => {
    const all = continued(page([9, 8], 8), page([8, 7], 7));
    expect(ids(all)).toEqual([9, 8, 7]);
    expect(all.next).toBe('7');
  });

  it('stays as long as it is when a new session comes', () => {
    const all = refreshed(page([9, 8, 7, 6], 6), page([10, 9], 9));
    expect(ids(all)).toEqual([10, 9, 8, 7, 6]);
    expect(all.next).toBe('6');
  });

  it('forgets what has been deleted, and shows what has changed', () => {
    const newest = page([9, 7], 7);
    newest.items[0]!.note = 'new';
    const all = refreshed(page([9, 8, 7, 6], null), newest);
    expect(ids(all)).toEqual([9, 7, 6]);
    expect(all.items[0]!.note).toBe('new');
    expect(all.next).toBeNull();
    expect(ids(refreshed(page([9, 8], 8), page([], null)))).toEqual([]);
    expect(ids(refreshed(page([9, 8, 7, 6], 6), page([9, 8], null)))).toEqual([9, 8]);
  });

  it('restarts where sessions may be missing in between', () => {
    expect(refreshed(page([5, 4], 4), page([20, 19], 19))).toEqual(page([20, 19], 19));
    expect(refreshed(null, page([2, 1], null))).toEqual(page([2, 1], null));
  });
});

describe('the curves of a session', () => {
  it('are called as in the contract', () => {
    for (const { name, unit, title } of curves) expect(signals.find((row) => row.name === name)).toMatchObject({ unit, title });
  });

  it('share a strip only where they have one unit', () => {
    const all = strips(curves.map((curve) => curve.name));
    for (const strip of all) expect(new Set(strip.map((curve) => curve.unit)).size).toBe(1);
    expect(new Set(all.map((strip) => strip[0]!.unit)).size).toBe(all.length);
    expect(all.flat()).toHaveLength(curves.length);
  });
});
