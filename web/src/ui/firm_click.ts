// Start and End share one place on the screen. A double tap on End must not start the hoist: Start counts only when it was already shown
// for a while at the press. End always counts.
export const settle_ms = 800;

export class FirmStart {
  private shown_ms = -Infinity;
  private led: boolean | null = null;
  private pressed_ms: number | null = null;

  /** What the button means from now on. */
  show(led: boolean, now_ms: number): void {
    // The first meaning follows no other one.
    if (this.led !== null && this.led !== led) this.shown_ms = now_ms;
    this.led = led;
  }

  /** The finger or the key comes down. */
  press(now_ms: number): void {
    this.pressed_ms = now_ms;
  }

  /** Whether a click that would start may do so. Assistive tools click without a press. */
  counts(now_ms: number): boolean {
    const pressed_ms = this.pressed_ms ?? now_ms;
    this.pressed_ms = null;
    return this.led === false && pressed_ms - this.shown_ms >= settle_ms;
  }
}
