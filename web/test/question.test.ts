import { describe, expect, it } from 'vitest';
import { askFor_ms, Question } from '../src/ui/question';

describe('a question', () => {
  const make = () => {
    const timers: { call: () => void; after_ms: number }[] = [];
    const shown: boolean[] = [];
    const question = new Question((open) => shown.push(open), {
      once: (call, after_ms) => timers.push({ call, after_ms }) - 1,
      cancel: (timer) => void (timers[timer] = { call: () => {}, after_ms: 0 }),
    });
    return { question, timers, shown };
  };

  it('passes the answer on, once', async () => {
    const { question, shown } = make();
    const asked = question.ask();
    question.answer(true);
    question.answer(false);
    expect(await asked).toBe(true);
    expect(shown).toEqual([true, false]);
  });

  it('is answered with no when nobody answers in time', async () => {
    const { question, timers } = make();
    const asked = question.ask();
    expect(timers[0]!.after_ms).toBe(askFor_ms);
    timers[0]!.call();
    expect(await asked).toBe(false);
  });

  it('is answered with no when a newer one comes; its time does not end the newer one', async () => {
    const { question, timers, shown } = make();
    const first = question.ask();
    const second = question.ask();
    expect(await first).toBe(false);
    expect(shown.at(-1)).toBe(true);
    timers[0]!.call();
    question.answer(true);
    expect(await second).toBe(true);
  });
});
