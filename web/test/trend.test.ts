// A patient's figures over the sessions: what is compared, and where the line breaks.
import { describe, expect, it } from 'vitest';
import { settings } from '../src/text/settings';
import { walkedText } from '../src/panels/patients/trend';
import { changeOf, pointsOf, runsOf, spanOf, walkedKey, walkedOf, type TrendChange, type TrendItem } from '../src/panels/patients/trend_model';

const eight = { shape: 'eight', c_m: 1, radius_m: 0.8 } as const;
const square = { shape: 'square', side_m: 3.2 } as const;
const item = (session: number, C: number | null, exercise: TrendItem['exercise'] = eight): TrendItem => ({
  session,
  visit: 1,
  day: '2026-11-24',
  started_utc_ms: session,
  exercise,
  task: null,
  ends: null,
  line: null,
  figures: { C } as TrendItem['figures'],
  reasons: {},
  reason_code: C === null ? 'too_short' : null,
});
// Newest first, as the server gives them.
const of = (exercise: TrendItem['exercise'], task: string | null = null, ends: TrendItem['ends'] = null) => walkedKey({ exercise, task, ends });
const items = [item(6, 0.9), item(5, 0.8), item(4, null), item(3, 0.7, square), item(2, 0.6), item(1, 0.5)];

describe('a trend', () => {
  it('compares walks of one exercise only, oldest first', () => {
    expect([...walkedOf(items).keys()]).toEqual([of(eight), of(square)]);
    expect(pointsOf(items, of(eight), 'C').map(({ item: { session } }) => session)).toEqual([1, 2, 4, 5, 6]);
    expect(of(null)).toBe(of({ shape: 'free' }));
    expect(of(null, 'walk_6min')).not.toBe(of(null, 'walk_2min'));
    expect(pointsOf([{ ...items[0]!, task: 'eight' }, ...items], of(eight, 'eight'), 'C')).toHaveLength(1);
  });

  it('keeps own lines apart by their points, each by its newest name', () => {
    const along = (x_m: number[], line: string): TrendItem => ({
      ...item(1, 0.5, { shape: 'own', closed: false, x_m, y_m: [0, 0] }),
      task: 'own_line',
      line,
    });
    const walked = walkedOf([along([0, 4], 'First floor'), along([0, 5], 'Garden'), along([0, 4], 'Hall')]);
    expect([...walked.values()].map(({ line }) => line)).toEqual(['First floor', 'Garden']);
  });

  it('tells a change of the chosen exercise and figure only', () => {
    const change = (figure: string, exercise: TrendItem['exercise'], last: number) =>
      ({ figure, exercise, task: null, ends: null, last }) as TrendChange;
    const changes = [change('C', eight, 1), change('C', square, 2), change('J_N', eight, 3)];
    expect(changeOf(changes, of(square), 'C')?.last).toBe(2);
    expect(changeOf(changes, of(eight), 'J_N')?.last).toBe(3);
    expect(changeOf(changes, of(eight, 'eight'), 'C')).toBeNull();
  });

  it('breaks its line at a session without the figure', () => {
    expect(runsOf(pointsOf(items, of(eight), 'C'))).toEqual([
      [0, 1],
      [3, 4],
    ]);
    const unreadable = [item(2, 0.5), { ...item(1, 0.5), figures: null }];
    expect(pointsOf(unreadable, of(eight), 'C').map(({ value }) => value)).toEqual([null, 0.5]);
  });

  it('names what is compared so that no two read the same', () => {
    settings.set({ language: 'en' });
    const text = (exercise: TrendItem['exercise']) =>
      walkedText({ exercise, task: null, ends: null, line: null }, (task) => task).replaceAll('\u00a0', ' ');
    expect(text(square)).toBe('Square, 3.2 m, left');
    expect(text({ ...square, side_m: 3.25, clockwise: true })).toBe('Square, 3.25 m, right');
    // Its first loop is the right one.
    expect([text(eight), text({ ...eight, clockwise: true })]).toEqual(['Figure of eight, 1 m, 0.8 m, right', 'Figure of eight, 1 m, 0.8 m, left']);
    expect([text({ shape: 'straight', length_m: 10 }), text(null)]).toEqual(['Straight, 10 m', 'Free']);
  });

  it('keeps goals of one task apart, and tells each in both languages', () => {
    const to = (by: 'time' | 'back' | 'distance' | 'hand', goal: number) => ({ by, goal, edge_m: 0 });
    const walked = (by: 'time' | 'back' | 'distance' | 'hand', goal: number, exercise: TrendItem['exercise'] = null): TrendItem => ({
      ...item(1, goal, exercise),
      task: 'a task',
      ends: to(by, goal),
    });
    const both = [walked('time', 360), walked('time', 120)];
    const short = of(null, 'a task', to('time', 120));
    expect([...walkedOf(both).keys()]).toEqual([of(null, 'a task', to('time', 360)), short]);
    expect(pointsOf(both, short, 'C').map(({ value }) => value)).toEqual([120]);
    const changes = both.map(({ exercise, task, ends }, last) => ({ figure: 'C', exercise, task, ends, last }) as TrendChange);
    expect(changeOf(changes, short, 'C')?.last).toBe(1);
    const texts = (...items: TrendItem[]) => items.map((one) => walkedText(one, (task) => task).replaceAll('\u00a0', ' '));
    settings.set({ language: 'en' });
    expect(texts(...both)).toEqual(['a task, 6:00 min', 'a task, 2:00 min']);
    expect(texts(walked('back', 3), walked('back', 3.5))).toEqual(['a task, 3 m', 'a task, 3.5 m']);
    expect(texts(walked('distance', 1, square), walked('distance', 3, square))).toEqual(['a task, 3.2 m, left', 'a task, 3.2 m, left, 3 laps']);
    expect(texts(walked('hand', 0))).toEqual(['a task']);
    const own = { shape: 'own', closed: true, x_m: [0, 4, 4], y_m: [0, 0, 4] } as const;
    settings.set({ language: 'de' });
    expect(texts(walked('back', 3.5), walked('distance', 3, own))[0]).toBe('a task, 3,5 m');
    expect(texts(walked('distance', 3, own))[0]).toMatch(/ m, 3 Runden$/);
  });

  it('leaves room around its values, also around a single one', () => {
    const span = spanOf(pointsOf(items, of(eight), 'C'))!;
    expect(span.low).toBeCloseTo(0.46);
    expect(span.high).toBeCloseTo(0.94);
    const one = spanOf([{ item: items[0]!, value: 0 }])!;
    expect(one.high).toBeGreaterThan(one.low);
    expect(spanOf([{ item: items[0]!, value: null }])).toBeNull();
  });
});
