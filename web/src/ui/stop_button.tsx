// The one STOP: on every page, at one place, acting when touched and not when let go, without a question. The space bar does the same.
import { useEffect } from 'preact/hooks';
import { stop } from '../link/console';
import { useStore } from '../link/store';
import { useSettings } from '../text/settings';
import { t } from '../text/text';

/** Where keys write. */
export function isTyping(target: EventTarget | null): boolean {
  if (!(target instanceof HTMLElement)) return false;
  if (target.isContentEditable || target instanceof HTMLTextAreaElement) return true;
  return target instanceof HTMLInputElement && ['text', 'search', 'number', 'email', 'password', 'url', 'tel'].includes(target.type);
}

/** Where a space belongs to what is written. In a number it never does, and whoever has just typed one must still be able to stop. */
function wantsSpace(target: EventTarget | null): boolean {
  return isTyping(target) && !(target instanceof HTMLInputElement && (target.type === 'number' || ['decimal', 'numeric'].includes(target.inputMode)));
}

export function StopButton() {
  useSettings();
  const sending = useStore((s) => s.stopSent);
  useEffect(() => {
    const key = (event: KeyboardEvent) => {
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
