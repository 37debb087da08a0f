// STOP: on every page at the same place, acts on touch, without a question. The space bar does the same, so Enter toggles check boxes.
import { useEffect, useRef } from 'preact/hooks';
import { stop } from '../link/console';
import { useStore } from '../link/store';
import { useSettings } from '../text/settings';
import { t } from '../text/text';
import './stop_button.css';

/** Elements that take text. */
export function isTyping(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target.isContentEditable || target instanceof HTMLTextAreaElement) return true;
  return target instanceof HTMLInputElement && ['text', 'search', 'number', 'email', 'password', 'url', 'tel'].includes(target.type);
}

/** Elements where a space is text. Not in a number field, where the space bar must still stop the hoist. */
function wantsSpace(target: EventTarget | null): boolean {
  return isTyping(target) && !(target instanceof HTMLInputElement && (target.type === 'number' || ['decimal', 'numeric'].includes(target.inputMode)));
}

/** Position of STOP in the corner of the visible area, at constant size: a pinch would move it outside, an on-screen keyboard would cover it. `box`
 * is its place on the page, `edge` its distance from the corner. */
export function intoView(
  box: { right: number; bottom: number },
  edge: { right: number; bottom: number },
  view: { scale: number; offsetLeft: number; offsetTop: number; width: number; height: number },
): string {
  const x = view.offsetLeft + view.width - edge.right / view.scale - box.right;
  const y = view.offsetTop + view.height - edge.bottom / view.scale - box.bottom;
  if (Math.abs(x) < 1 && Math.abs(y) < 1 && Math.abs(view.scale - 1) < 0.01) return '';
  return `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) scale(${(1 / view.scale).toFixed(4)})`;
}

export function StopButton() {
  useSettings();
  const sending = useStore((s) => s.stopSent);
  const button = useRef<HTMLButtonElement>(null);
  useEffect(() => {
    const view = window.visualViewport;
    if (!view) return;
    const follow = () => {
      if (button.current === null) return;
      const { style } = button.current;
      style.transform = '';
      const { right, bottom } = getComputedStyle(button.current);
      style.transform = intoView(button.current.getBoundingClientRect(), { right: parseFloat(right), bottom: parseFloat(bottom) }, view);
    };
    follow();
    for (const [target, type] of [
      [view, 'resize'],
      [view, 'scroll'],
      [window, 'resize'],
    ] as const)
      target.addEventListener(type, follow);
    return () => {
      for (const [target, type] of [
        [view, 'resize'],
        [view, 'scroll'],
        [window, 'resize'],
      ] as const)
        target.removeEventListener(type, follow);
    };
  }, []);
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
      // A check box has no other key than the one that is STOP.
      if (event.key === 'Enter' && event.target instanceof HTMLInputElement && event.target.type === 'checkbox') {
        event.preventDefault();
        if (!event.repeat) event.target.click();
      }
      if (event.code !== 'Space' || wantsSpace(event.target)) return;
      event.preventDefault();
      event.stopPropagation();
      if (!event.repeat) stop();
    };
    const swallow = (event: KeyboardEvent) => {
      // A focused button would also be pressed by the space bar when it comes up.
      if (event.code === 'Space' && !wantsSpace(event.target)) event.preventDefault();
    };
    window.addEventListener('keydown', key, true);
    window.addEventListener('keyup', swallow, true);
    return () => {
      window.removeEventListener('keydown', key, true);
      window.removeEventListener('keyup', swallow, true);
    };
  }, []);
  return (
    <button
      ref={button}
      type="button"
      class={sending ? 'stop sending' : 'stop'}
      aria-label={t('stop.name')}
      title={t('stop.hint')}
      onPointerDown={(event) => {
        event.preventDefault();
        stop();
      }}
      onClick={(event) => {
        // Only the keyboard and assistive tools click without a pointer before it.
        if (event.detail === 0) stop();
      }}
      onContextMenu={(event) => event.preventDefault()}
    >
      <svg viewBox="0 0 100 100" aria-hidden="true">
        <path class="stop-edge" d="M30 1h40l29 29v40L70 99H30L1 70V30z" />
        <path class="stop-face" d="M32 6h36l26 26v36L68 94H32L6 68V32z" />
        <text x="50" y="59" text-anchor="middle" class={t('stop.name').length > 4 ? 'stop-word long' : 'stop-word'}>
          {t('stop.name')}
        </text>
      </svg>
    </button>
  );
}
