// The fast part: the newest sample and the path on the floor. Nothing here triggers drawing; screens poll on each frame.
import { useEffect, useRef, useState } from 'preact/hooks';
import { modes } from '../contract/faults.gen';
import type { GapMessage, WalkMessage } from '../contract/messages.gen';
import type { TopicName } from '../contract/rest.gen';
import type { Sample, SampleOf } from './frame';
import { Trace } from './trace';
import { useTopic, type Rate } from './wants';

export class Live {
  /** Newest sample, with the values of `topics`. */
  record: Sample | null = null;
  /** Newest step that was shown or named as missing. */
  newestTick = -1;
  private topics: readonly TopicName[] = [];
  received_ms = 0;
  /** Samples that the server named as missing. */
  lost = 0;
  /** Since the start mark, from the server; extended here. */
  readonly path = new Trace();
  /** Increments whenever the path restarts. */
  pathLife = 0;
  /** Seconds in motion since the start mark; NaN: unknown. */
  motion_s = NaN;
  /** Newest step that the server has counted into path and time. */
  private countedTick = -1;
  /** Positions are missing before the next one. */
  private broken = false;

  take(samples: readonly Sample[], topics: readonly TopicName[], now_ms: number): void {
    for (const sample of samples) {
      if (this.record !== null && sample.tick < this.record.tick) this.clear(); // the core has restarted
      if (sample.tick > this.countedTick) this.count(this.record, sample);
      this.record = sample;
      this.newestTick = sample.tick;
    }
    this.topics = topics;
    if (samples.length > 0) this.received_ms = now_ms;
  }

  /** Distance since the start mark. Before the first motion it is none: until the next start the hoist still counts the walk of another patient. */
  walked_m(record: { distance_m: number }): number {
    return this.motion_s === 0 ? 0 : record.distance_m;
  }

  /** The newest sample, unless it lacks a topic: a screen that has just opened waits for its first one. */
  with<T extends TopicName>(...wanted: readonly T[]): SampleOf<T> | null {
    if (this.topics[0] !== 'all' && wanted.some((topic) => topic !== 'state' && !this.topics.includes(topic))) return null;
    return this.record as SampleOf<T> | null;
  }

  /** Steps that this page will not get: they are no part of the path. */
  takeGap(gap: GapMessage): void {
    this.lost += gap.count ?? 0;
    this.newestTick = Math.max(this.newestTick, gap.to_tick ?? -1);
    if ((gap.to_tick ?? 0) > this.countedTick) this.broken = true;
  }

  private count(before: Sample | null, sample: Sample): void {
    const { fused_x_m, fused_y_m } = sample;
    if (fused_x_m === undefined || fused_y_m === undefined) this.broken = true;
    else {
      if (this.broken) this.path.lift();
      this.broken = false;
      this.path.add(fused_x_m, fused_y_m);
    }
    if (before === null || !led(before)) return;
    // A change of mode is always a sample: what lies between two belongs to the first, but for the step in which the mode has ended.
    const steps = sample.tick - before.tick;
    const counted = sample.tick - Math.max(before.tick, this.countedTick) - (led(sample) ? 0 : 1);
    if (steps > 0) this.motion_s += ((sample.time_ns - before.time_ns) / 1e9) * (counted / steps);
  }

  /** The server's walk. A server restarted after the start mark knows less than an open page, which then keeps its own. */
  takeWalk(walk: WalkMessage): void {
    if (this.record !== null && walk.tick !== null && walk.tick < this.record.tick) {
      this.clear(); // of another core
      this.record = null;
    }
    if (walk.mark === null && this.path.x.length > 0) return;
    this.path.set(walk.x_m, walk.y_m, walk.step_m);
    this.pathLife++;
    this.motion_s = walk.motion_s ?? NaN;
    this.countedTick = walk.tick ?? -1;
    this.broken = false;
  }

  private clear(): void {
    this.path.clear();
    this.broken = false;
    this.pathLife++;
    this.motion_s = NaN;
    this.countedTick = -1;
  }
}

const led = (record: Sample): boolean => modes[record.mode]?.moving === true;

export const live = new Live();

// ------------------------------------------------------------------ drawing, at most 30 times a second and never while hidden
const frame_ms = 1000 / 30 - 4;
const painters = new Set<(now_ms: number) => void>();
let drawn_ms = -Infinity;
let asked = false;

function ask(): void {
  if (asked || painters.size === 0) return;
  asked = true;
  requestAnimationFrame((now_ms) => {
    asked = false;
    if (now_ms - drawn_ms >= frame_ms && !document.hidden) {
      drawn_ms = now_ms;
      for (const paint of painters) paint(now_ms);
    }
    ask();
  });
}

/** Calls `paint` on every drawn frame while the component is mounted. */
export function useFrame(paint: (now_ms: number) => void): void {
  const latest = useRef(paint);
  latest.current = paint;
  useEffect(() => {
    const call = (now_ms: number) => latest.current(now_ms);
    painters.add(call);
    ask();
    return () => {
      painters.delete(call);
    };
  }, []);
}

/** A readable value of the newest sample: updated `rate_hz` times a second, because faster digits cannot be read. */
export function useReading<T extends TopicName, R>(topic: T, read: (sample: SampleOf<T> | null) => R, rate_hz: Rate = 5): R {
  useTopic(topic, rate_hz);
  const [value, set] = useState(() => read(live.with(topic)));
  const shown_ms = useRef(-Infinity);
  useFrame((now_ms) => {
    if (now_ms - shown_ms.current < 1000 / rate_hz) return;
    shown_ms.current = now_ms;
    set(read(live.with(topic)));
  });
  return value;
}
