// The dead-man as a button: the hoist goes while it is held. Every way of losing the finger, the page or the screen lets go.
import { useEffect, useRef, useState } from 'preact/hooks';
import { drive } from '../link/console';
import { HoldToRun } from '../panels/drive/joystick';
import { t } from '../text/text';
import { isTyping } from './stop_button';

const keys = new Set(['ArrowUp', 'KeyW']);
const browserTimers = {
  every: (call: () => void, each_ms: number) => window.setInterval(call, each_ms),
  cancel: (timer: number) => window.clearInterval(timer),
};

export function HoldToGo({ active, locked }: { active: boolean; locked: string }) {
  const pointer = useRef<number | null>(null);
  const key = useRef<string | null>(null);
  const [held, setHeld] = useState(false);
  const hold = useRef<HoldToRun | null>(null);
  // Where to go is the exercise's matter: the stick stays in its middle.
  hold.current ??= new HoldToRun((_speed, _yaw, isHeld) => void drive(0, 0, isHeld), browserTimers);

  const press = () => {
    hold.current?.press(0, 0);
    setHeld(true);
  };
  const release = () => {
    pointer.current = null;
    key.current = null;
    hold.current?.release();
    setHeld(false);
  };

  useEffect(() => {
    if (!active) {
      release();
      return;
    }
    const down = (event: KeyboardEvent) => {
      if (!keys.has(event.code) || event.ctrlKey || event.altKey || event.metaKey || isTyping(event.target)) return;
      event.preventDefault();
      if (event.repeat || pointer.current !== null || key.current !== null) return;
      key.current = event.code;
      press();
    };
    const up = (event: KeyboardEvent) => {
      if (event.code === key.current) release();
    };
    const hidden = () => {
      if (document.hidden) release();
    };
    window.addEventListener('keydown', down);
    window.addEventListener('keyup', up);
    window.addEventListener('blur', release);
    window.addEventListener('pagehide', release);
    document.addEventListener('visibilitychange', hidden);
    document.addEventListener('freeze', release);
    window.addEventListener('hoist-dialog', release);
    return () => {
      window.removeEventListener('keydown', down);
      window.removeEventListener('keyup', up);
      window.removeEventListener('blur', release);
      window.removeEventListener('pagehide', release);
      document.removeEventListener('visibilitychange', hidden);
      document.removeEventListener('freeze', release);
      window.removeEventListener('hoist-dialog', release);
      // No lostpointercapture comes when the button itself goes away.
      release();
    };
  }, [active]);

  return (
    <button
      type="button"
      class={active ? (held ? 'go active held' : 'go active') : 'go'}
      aria-disabled={!active}
      aria-pressed={held}
      onPointerDown={(event) => {
        if (!active || pointer.current !== null || key.current !== null || event.button !== 0) return;
        event.preventDefault();
        event.currentTarget.setPointerCapture(event.pointerId);
        pointer.current = event.pointerId;
        press();
      }}
      onPointerUp={(event) => event.pointerId === pointer.current && release()}
      onPointerCancel={(event) => event.pointerId === pointer.current && release()}
      onLostPointerCapture={(event) => event.pointerId === pointer.current && release()}
      onContextMenu={(event) => event.preventDefault()}
    >
      {active ? t(held ? 'guided.held' : 'guided.hold') : locked}
    </button>
  );
}
