// A path of bounded size, by the server's rule (server/state/walk.hpp): a point each `step_m`; when it is full, every second point goes.
export const pointsMost = 2048;
export const firstStep_m = 0.02;

export class Trace {
  x: number[] = [];
  y: number[] = [];
  step_m = firstStep_m;

  set(x: readonly number[], y: readonly number[], step_m: number): void {
    this.x = [...x];
    this.y = [...y];
    this.step_m = step_m;
  }

  clear(): void {
    this.set([], [], firstStep_m);
  }

  /** What follows is not joined to what is there: a point that is none lies between. */
  lift(): void {
    if (this.x.length === 0 || Number.isNaN(this.x.at(-1))) return;
    this.x.push(NaN);
    this.y.push(NaN);
  }

  add(x: number, y: number): void {
    const last = this.x.length - 1;
    if (last >= 0 && Math.hypot(x - this.x[last]!, y - this.y[last]!) < this.step_m) return;
    this.x.push(x);
    this.y.push(y);
    if (this.x.length < pointsMost) return;
    const even = (value: number, i: number) => i % 2 === 0 || Number.isNaN(value);
    this.set(this.x.filter(even), this.y.filter(even), 2 * this.step_m);
  }
}
