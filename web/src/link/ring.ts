// A ring of numbers kept twice (at i and i + capacity), so that the newest values are always one contiguous subarray.
export class Ring {
  private readonly data: Float64Array;
  private next = 0;
  private filled = 0;

  constructor(readonly capacity: number) {
    if (!Number.isInteger(capacity) || capacity < 1) throw new RangeError('a ring holds at least one value');
    this.data = new Float64Array(2 * capacity);
  }

  get length(): number {
    return this.filled;
  }

  push(value: number): void {
    this.data[this.next] = value;
    this.data[this.next + this.capacity] = value;
    this.next = (this.next + 1) % this.capacity;
    if (this.filled < this.capacity) this.filled++;
  }

  clear(): void {
    this.next = 0;
    this.filled = 0;
  }

  /** The newest `count` values, oldest first. A view: valid until the next push. */
  latest(count: number = this.filled): Float64Array {
    const wanted = Math.max(0, Math.min(Math.floor(count), this.filled));
    const end = this.next + this.capacity;
    return this.data.subarray(end - wanted, end);
  }

  /** The newest value, or NaN when empty. */
  get last(): number {
    return this.filled === 0 ? NaN : this.data[this.next + this.capacity - 1]!;
  }
}
