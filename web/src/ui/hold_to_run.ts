// The hold-to-run rules, independent of screens: while held, a command is sent 25 times a second; on any release three zeros are sent at
// once, then nothing. Server and hoist also stop by timeout: this is only the fastest way.

export const send_hz = 25;
export const sendEach_ms = 1000 / send_hz;
export const zerosOnRelease = 3;
/** Dead zone around the middle, since a resting thumb moves slightly. */
export const deadZone_norm = 0.12;

/** Shares of the allowed speeds: forwards and to the left positive. */
export interface Wish {
  speed: number;
  yaw: number;
}
export type Send = (speed: number, yaw: number, held: boolean) => void;
export interface Timers {
  every(call: () => void, each_ms: number): number;
  cancel(timer: number): void;
}

/** Takes the dead zone out and keeps the rest continuous; anything not finite is zero. */
export function shape(value: number): number {
  if (!Number.isFinite(value)) return 0;
  const size = Math.min(1, Math.abs(value));
  if (size <= deadZone_norm) return 0;
  return (Math.sign(value) * (size - deadZone_norm)) / (1 - deadZone_norm);
}

export class HoldToRun {
  private timer: number | null = null;
  private speed = 0;
  private yaw = 0;

  constructor(
    private readonly send: Send,
    private readonly timers: Timers,
  ) {}

  get held(): boolean {
    return this.timer !== null;
  }

  /** Pressed: sends at once and then at a steady rate. */
  press(speed: number, yaw: number): void {
    this.speed = shape(speed);
    this.yaw = shape(yaw);
    if (this.timer !== null) return;
    this.send(this.speed, this.yaw, true);
    this.timer = this.timers.every(() => this.send(this.speed, this.yaw, true), sendEach_ms);
  }

  /** Changes the command; no effect unless held. */
  move(speed: number, yaw: number): void {
    if (this.timer === null) return;
    this.speed = shape(speed);
    this.yaw = shape(yaw);
  }

  /** Release, for any reason. Safe to call at any time, repeatedly. */
  release(): void {
    if (this.timer === null) return;
    this.timers.cancel(this.timer);
    this.timer = null;
    this.speed = 0;
    this.yaw = 0;
    for (let i = 0; i < zerosOnRelease; i++) this.send(0, 0, false);
  }
}

export const driveKeys: Record<string, Wish> = {
  ArrowUp: { speed: 1, yaw: 0 },
  KeyW: { speed: 1, yaw: 0 },
  ArrowDown: { speed: -1, yaw: 0 },
  KeyS: { speed: -1, yaw: 0 },
  ArrowLeft: { speed: 0, yaw: 1 },
  KeyA: { speed: 0, yaw: 1 },
  ArrowRight: { speed: 0, yaw: -1 },
  KeyD: { speed: 0, yaw: -1 },
};

/** Combined command of the pressed keys; opposite keys cancel. */
export function keysWish(pressed: Iterable<string>, keys: Record<string, Wish> = driveKeys): Wish {
  let speed = 0;
  let yaw = 0;
  for (const key of pressed) {
    speed += keys[key]?.speed ?? 0;
    yaw += keys[key]?.yaw ?? 0;
  }
  return { speed: Math.max(-1, Math.min(1, speed)), yaw: Math.max(-1, Math.min(1, yaw)) };
}

/** Cmd or the Windows key is pressed: macOS does not report the release of keys held with it. */
export const takesKeys = ({ key, metaKey }: { key: string; metaKey: boolean }): boolean => metaKey || key === 'Meta' || key === 'OS';
