// Start and End share one place on the screen. A double tap on End must not start the hoist: Start counts only when it was already shown
// for a while at the press. End always counts.
export const settle_ms = 800;

export class FirmStart {
  private shown_ms = -Infinity;
  private led: boolean | null = null;
  private pressed_ms: number | null = null;

  /** The button's present meaning. */
  show(led: boolean, now_ms: number): void {
    // The first meaning follows no other one.
    if (this.led !== null && this.led !== led) this.shown_ms = now_ms;
    this.led = led;
  }

  /** Start of a press by finger or key. */
  press(now_ms: number): void {
    this.pressed_ms = now_ms;
  }

  /** Whether a click may start. Assistive tools click without a press. */
  counts(now_ms: number): boolean {
    const pressed_ms = this.pressed_ms ?? now_ms;
    this.pressed_ms = null;
    return this.led === false && pressed_ms - this.shown_ms >= settle_ms;
  }
}
