// Input of hold-to-run: a finger or keys. Every loss of finger, keys, page or screen counts as release.
import { useEffect, useRef, useState } from 'preact/hooks';
import { drive, everyTick } from '../link/console';
import { HoldToRun, keysWish, takesKeys, type Wish } from './hold_to_run';
import { isTyping } from './stop_button';

const browserTimers = {
  every: (call: () => void, each_ms: number) => window.setInterval(call, each_ms),
  cancel: (timer: number) => window.clearInterval(timer),
};

export interface Grip {
  /** The keys that hold it, and the command of each. */
  keys: Record<string, Wish>;
  /** Command of a finger, by the element's place at the press. */
  wish(event: PointerEvent, box: DOMRect): Wish;
  /** Draws the command; the middle on release. */
  show?(wish: Wish): void;
}

export interface PointerHandlers {
  onPointerDown(event: PointerEvent): void;
  onPointerMove(event: PointerEvent): void;
  onPointerUp(event: PointerEvent): void;
  onPointerCancel(event: PointerEvent): void;
  onLostPointerCapture(event: PointerEvent): void;
  onContextMenu(event: Event): void;
}

/** Inert unless `active`. The handlers belong on the element that is held; a finger takes over from keys. */
export function useHand(active: boolean, grip: Grip): { held: boolean; handlers: PointerHandlers } {
  const pointer = useRef<number | null>(null);
  // Stored at the press: a line of text that appears above moves the element, which must not become a command.
  const box = useRef<DOMRect | null>(null);
  const keys = useRef(new Set<string>());
  const [held, setHeld] = useState(false);
  const hold = useRef<HoldToRun | null>(null);
  hold.current ??= new HoldToRun((speed, yaw, isHeld) => void drive(speed, yaw, isHeld), browserTimers);

  const follow = (wish: Wish) => {
    if (hold.current!.held) hold.current!.move(wish.speed, wish.yaw);
    else hold.current!.press(wish.speed, wish.yaw);
    grip.show?.(wish);
    setHeld(true);
  };
  const release = () => {
    pointer.current = null;
    keys.current.clear();
    hold.current?.release();
    grip.show?.({ speed: 0, yaw: 0 });
    setHeld(false);
  };
  const byKeys = () => (keys.current.size === 0 ? release() : follow(keysWish(keys.current, grip.keys)));
  const lost = (event: PointerEvent) => {
    if (event.pointerId === pointer.current) release();
  };

  useEffect(() => {
    if (!active) {
      release();
      return;
    }
    everyTick(true);
    // Not held. After a gap the core waits for this before it moves again.
    void drive(0, 0, false);
    const down = (event: KeyboardEvent) => {
      if (takesKeys(event)) {
        if (keys.current.size > 0) release();
        return;
      }
      if (!(event.code in grip.keys) || event.ctrlKey || event.altKey || isTyping(event.target)) return;
      event.preventDefault();
      if (event.repeat || pointer.current !== null) return;
      keys.current.add(event.code);
      byKeys();
    };
    const up = (event: KeyboardEvent) => {
      if (keys.current.delete(event.code)) byKeys();
    };
    const hidden = () => {
      if (document.hidden) release();
    };
    const listeners: [EventTarget, string, (event: never) => void][] = [
      [window, 'keydown', down],
      [window, 'keyup', up],
      [window, 'blur', release],
      [window, 'pagehide', release],
      [window, 'hoist-dialog', release],
      // A resized or rotated screen: positions have changed since the press.
      [window, 'resize', release],
      ...(screen.orientation ? [[screen.orientation, 'change', release] as [EventTarget, string, () => void]] : []),
      ...(window.visualViewport ? [[window.visualViewport, 'resize', release] as [EventTarget, string, () => void]] : []),
      [document, 'visibilitychange', hidden],
      [document, 'freeze', release],
    ];
    for (const [target, type, call] of listeners) target.addEventListener(type, call as EventListener);
    return () => {
      for (const [target, type, call] of listeners) target.removeEventListener(type, call as EventListener);
      // No lostpointercapture comes when the element itself goes away.
      release();
      everyTick(false);
    };
  }, [active]);

  return {
    held,
    handlers: {
      onPointerDown: (event) => {
        if (!active || pointer.current !== null || event.button !== 0) return;
        event.preventDefault();
        const element = event.currentTarget as Element;
        element.setPointerCapture(event.pointerId);
        box.current = element.getBoundingClientRect();
        pointer.current = event.pointerId;
        keys.current.clear();
        follow(grip.wish(event, box.current));
      },
      onPointerMove: (event) => {
        if (event.pointerId === pointer.current && box.current) follow(grip.wish(event, box.current));
      },
      onPointerUp: lost,
      onPointerCancel: lost,
      onLostPointerCapture: lost,
      onContextMenu: (event) => event.preventDefault(),
    },
  };
}
