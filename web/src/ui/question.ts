// A question with an answer that sets something going: it must not outlive its reason. Left alone, overtaken or without its reason it is
// answered with no.
import type { Timers } from './hold_to_run';

export const askFor_ms = 20_000;

export class Question {
  private pending: { resolve: (yes: boolean) => void; timer: number } | null = null;

  constructor(
    private readonly shown: (open: boolean) => void,
    private readonly timers: Pick<Timers, 'cancel'> & { once(call: () => void, after_ms: number): number },
  ) {}

  ask(): Promise<boolean> {
    this.answer(false);
    return new Promise((resolve) => {
      this.pending = { resolve, timer: this.timers.once(() => this.answer(false), askFor_ms) };
      this.shown(true);
    });
  }

  /** No effect without a question. */
  answer(yes: boolean): void {
    if (this.pending === null) return;
    const { resolve, timer } = this.pending;
    this.pending = null;
    this.timers.cancel(timer);
    this.shown(false);
    resolve(yes);
  }
}
