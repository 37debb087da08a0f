// The one button that starts a motion and ends it; beside it the one that starts an exercise again.
import { useRef } from 'preact/hooks';
import { live, useReading } from '../link/live';
import { endMotion } from '../link/console';
import { useReadiness, type Start } from '../link/readiness';
import type { Reply } from '../link/socket';
import { t } from '../text/text';
import { FirmStart } from './firm_click';
import type { Request } from './refusal';
import './motion.css';

/** Closer than this to the start mark, continuing and starting again are the same. */
const underWay_m = 0.1;

export interface StartEndProps {
  request: Request;
  /** Which motion it starts. */
  of: Start;
  startLabel: string;
  endLabel: string;
  /** `again`: from the exercise's start mark, where the hoist stands now. Otherwise an interrupted exercise continues. */
  start: (again: boolean) => Promise<Reply>;
  /** Another reason against a start. End is always possible. */
  wait?: boolean;
}

export function StartEnd({ request, of, startLabel, endLabel, start, wait = false }: StartEndProps) {
  const ready = useReadiness();
  const { led } = ready;
  const firm = useRef(new FirmStart());
  firm.current.show(led, performance.now());
  const underWay = useReading('motion', (record) => record !== null && live.walked_m(record) > underWay_m);
  const cannotStart = request.busy || wait || ready.start[of].length > 0;
  const click = (again: boolean) => {
    if (led) void request.ask(endMotion);
    else if (firm.current.counts(performance.now())) void request.ask(() => start(again));
  };
  const pressed = {
    onPointerDown: () => firm.current.press(performance.now()),
    onKeyDown: (event: KeyboardEvent) => {
      // A held Enter clicks again and again.
      if (event.repeat) event.preventDefault();
      else firm.current.press(performance.now());
    },
  };
  return (
    <>
      {of !== 'remote' && (
        <button
          type="button"
          class="plain two-lines"
          disabled={led || !underWay || cannotStart}
          title={t('walk.againHint')}
          onClick={() => click(true)}
          {...pressed}
        >
          {t('walk.again')} <small>{t('walk.againShort')}</small>
        </button>
      )}
      <button type="button" class={led ? 'big' : 'big primary'} disabled={led ? !ready.end : cannotStart} onClick={() => click(false)} {...pressed}>
        {led ? endLabel : request.busy ? t('walk.starting') : startLabel}
      </button>
    </>
  );
}
