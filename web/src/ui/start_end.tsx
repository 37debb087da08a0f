// The one button that starts a motion and ends it.
import { useRef } from 'preact/hooks';
import { requestMode } from '../link/console';
import type { Reply } from '../link/socket';
import { moving, useStore } from '../link/store';
import { t } from '../text/text';
import { FirmStart } from './firm_click';
import type { Request } from './refusal';

export interface StartEndProps {
  request: Request;
  startLabel: string;
  endLabel: string;
  start: () => Promise<Reply>;
  /** Something else that must be over before a start. Nothing keeps from ending. */
  wait?: boolean;
}

export function StartEnd({ request, startLabel, endLabel, start, wait = false }: StartEndProps) {
  const led = useStore((s) => moving(s.mode));
  const open = useStore((s) => s.link === 'open');
  const firm = useRef(new FirmStart());
  firm.current.show(led, performance.now());
  const click = () => {
    if (led) void request.ask(() => requestMode('standby'));
    else if (firm.current.counts(performance.now())) void request.ask(start);
  };
  return (
    <button
      type="button"
      class={led ? 'big' : 'big primary'}
      disabled={!open || (!led && (request.busy || wait))}
      onPointerDown={() => firm.current.press(performance.now())}
      onKeyDown={(event) => {
        // A held Enter clicks again and again.
        if (event.repeat) event.preventDefault();
        else firm.current.press(performance.now());
      }}
      onClick={click}
    >
      {led ? endLabel : request.busy ? t('walk.starting') : startLabel}
    </button>
  );
}
