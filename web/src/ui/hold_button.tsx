// A button that acts only after being held for a while, against accidental touches.
import { useEffect, useRef, useState } from 'preact/hooks';
import './hold_button.css';

export interface HoldButtonProps {
  label: string;
  hint: string;
  hold_ms: number;
  disabled?: boolean;
  /** Start of the press. */
  onBegin?: () => void;
  onDone: () => void;
}

export function HoldButton({ label, hint, hold_ms, disabled, onBegin, onDone }: HoldButtonProps) {
  const [held, setHeld] = useState(false);
  const timer = useRef<number | null>(null);
  const end = () => {
    if (timer.current !== null) window.clearTimeout(timer.current);
    timer.current = null;
    setHeld(false);
  };
  const begin = () => {
    if (disabled || timer.current !== null) return;
    setHeld(true);
    onBegin?.();
    timer.current = window.setTimeout(() => {
      end();
      onDone();
    }, hold_ms);
  };
  useEffect(() => {
    window.addEventListener('blur', end);
    document.addEventListener('visibilitychange', end);
    return () => {
      window.removeEventListener('blur', end);
      document.removeEventListener('visibilitychange', end);
      if (timer.current !== null) window.clearTimeout(timer.current);
    };
  }, []);
  return (
    <button
      type="button"
      class={held ? 'hold held' : 'hold'}
      title={hint}
      disabled={disabled}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        begin();
      }}
      onPointerUp={end}
      onPointerCancel={end}
      onLostPointerCapture={end}
      onContextMenu={(event) => event.preventDefault()}
      onKeyDown={(event) => {
        if (event.key === 'Enter' && !event.repeat) begin();
      }}
      onKeyUp={end}
      onBlur={end}
    >
      <span class="hold-fill" aria-hidden="true" />
      <span class="hold-label">{label}</span>
    </button>
  );
}
