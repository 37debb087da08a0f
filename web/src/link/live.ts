// The fast part: the newest record and the path on the floor. Nothing here triggers drawing; screens poll on each frame.
import { useEffect, useRef, useState } from 'preact/hooks';
import { modes } from '../contract/faults.gen';
import type { SignalName, TickRecord } from '../contract/signals.gen';
import type { WalkMessage } from '../contract/messages.gen';
import { Ring } from './ring';
import { Trace } from './trace';

/** 60 s at 100 Hz. */
export const historySamples = 6000;

export const historySignals = ['time_ns', 'lean_norm', 'turn_norm', 'speed_m_s', 'speed_command_m_s'] as const satisfies readonly SignalName[];

export class Live {
  record: TickRecord | null = null;
  received_ms = 0;
  lost = 0;
  readonly history: Record<(typeof historySignals)[number], Ring>;
  /** Since the start mark, from the server; extended here. */
  readonly path = new Trace();
  /** Increments whenever the path restarts. */
  pathLife = 0;
  /** Seconds in motion since the start mark; NaN: unknown. */
  motion_s = NaN;
  /** Newest step that the server has counted into path and time. */
  private countedTick = -1;

  constructor() {
    this.history = Object.fromEntries(historySignals.map((name) => [name, new Ring(historySamples)])) as Record<
      (typeof historySignals)[number],
      Ring
    >;
  }

  take(records: readonly TickRecord[], now_ms: number): void {
    for (const record of records) {
      const before = this.record;
      if (before !== null) {
        if (record.tick < before.tick)
          this.clear(); // the core has restarted
        else if (record.tick > before.tick + 1) this.lost += record.tick - before.tick - 1;
      }
      for (const name of historySignals) this.history[name].push(record[name]);
      if (record.tick > this.countedTick) {
        this.path.add(record.fused_x_m, record.fused_y_m);
        if (before !== null && led(before) && led(record)) this.motion_s += (record.time_ns - before.time_ns) / 1e9;
      }
      this.record = record;
    }
    if (records.length > 0) this.received_ms = now_ms;
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
  }

  private clear(): void {
    for (const name of historySignals) this.history[name].clear();
    this.path.clear();
    this.pathLife++;
    this.motion_s = NaN;
    this.countedTick = -1;
  }
}

const led = (record: TickRecord): boolean => modes[record.mode]?.moving === true;

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

/** A readable value of the newest record: updated `rate_hz` times a second, because faster digits cannot be read. */
export function useReading<R>(read: (record: TickRecord | null) => R, rate_hz = 5): R {
  const [value, set] = useState(() => read(live.record));
  const shown_ms = useRef(-Infinity);
  useFrame((now_ms) => {
    if (now_ms - shown_ms.current < 1000 / rate_hz) return;
    shown_ms.current = now_ms;
    set(read(live.record));
  });
  return value;
}
