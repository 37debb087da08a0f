// The fast part: the newest record and the path on the floor. Nothing here makes a screen draw; screens ask on each frame.
import { useEffect, useRef, useState } from 'preact/hooks';
import { modes } from '../contract/faults.gen';
import type { SignalName, TickRecord } from '../contract/signals.gen';
import { Ring } from './ring';

/** 60 s at 100 Hz. */
export const historySamples = 6000;
/** A new point of the path each 2 cm: 8000 points are 160 m. */
const pathStep_m = 0.02;
const pathPoints = 8000;
/** A jump this large in one step is a new start mark, not a walk; what was missed meanwhile may have been walked. */
const jump_m = 0.3;
const walked_m_per_tick = 0.01;

export const historySignals = ['time_ns', 'lean_norm', 'turn_norm', 'speed_m_s', 'speed_command_m_s'] as const satisfies readonly SignalName[];

export class Live {
  record: TickRecord | null = null;
  received_ms = 0;
  lost = 0;
  readonly history: Record<(typeof historySignals)[number], Ring>;
  readonly path = { x: new Ring(pathPoints), y: new Ring(pathPoints) };
  /** Rises whenever the path begins anew. */
  pathLife = 0;
  /** Seconds since the present motion began, or how long the last one lasted; NaN before the first. */
  motion_s = NaN;
  private motionBegan_ns: number | null = null;

  constructor() {
    this.history = Object.fromEntries(historySignals.map((name) => [name, new Ring(historySamples)])) as Record<(typeof historySignals)[number], Ring>;
  }

  take(records: readonly TickRecord[], now_ms: number): void {
    for (const record of records) {
      const before = this.record;
      if (before !== null) {
        if (record.tick < before.tick) this.clear(); // the core began anew
        else if (record.tick > before.tick + 1) this.lost += record.tick - before.tick - 1;
      }
      for (const name of historySignals) this.history[name].push(record[name]);
      const step_m = Math.hypot(record.fused_x_m - this.path.x.last, record.fused_y_m - this.path.y.last);
      const missed = before === null ? 0 : Math.max(0, record.tick - before.tick - 1);
      if (step_m > jump_m + missed * walked_m_per_tick) this.clearPath();
      if (this.path.x.length === 0 || step_m >= pathStep_m) {
        this.path.x.push(record.fused_x_m);
        this.path.y.push(record.fused_y_m);
      }
      this.clockMotion(record);
      this.record = record;
    }
    if (records.length > 0) this.received_ms = now_ms;
  }

  private clockMotion(record: TickRecord): void {
    if (modes[record.mode]?.moving === true) {
      this.motionBegan_ns ??= record.time_ns;
      this.motion_s = (record.time_ns - this.motionBegan_ns) / 1e9;
    } else this.motionBegan_ns = null;
  }

  clearPath(): void {
    this.path.x.clear();
    this.path.y.clear();
    this.pathLife++;
  }

  private clear(): void {
    for (const name of historySignals) this.history[name].clear();
    this.clearPath();
    this.motionBegan_ns = null;
    this.motion_s = NaN;
  }
}

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

/** Calls `paint` on every drawn frame while the component is there. */
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

/** A value of the newest record for people to read: renewed `rate_hz` times a second, because faster digits cannot be read. */
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
