// The pause of the sound on this screen: for the alarms shown when it began, and for the time of the hoist's own pause. A new alarm ends it.
import { audioPause_s } from '../contract/faults.gen';

export class OwnPause {
  private ids: ReadonlySet<string> = new Set();
  private until_ms = 0;

  begin(ids: readonly string[], now_ms: number): void {
    this.ids = new Set(ids);
    this.until_ms = now_ms + audioPause_s * 1000;
  }
  end(): void {
    this.ids = new Set();
  }
  /** Which of these alarms may sound. One that ended counts as new when it comes back. */
  sounding(ids: readonly string[], now_ms: number): readonly string[] {
    if (now_ms >= this.until_ms || ids.some((id) => !this.ids.has(id))) this.end();
    else this.ids = new Set(ids);
    return ids.filter((id) => !this.ids.has(id));
  }
  /** Until they sound again, in seconds; 0: no pause. */
  left_s(now_ms: number): number {
    return this.ids.size === 0 ? 0 : Math.max(0, (this.until_ms - now_ms) / 1000);
  }
}
