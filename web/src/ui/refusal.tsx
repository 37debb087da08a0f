// A refusal: all reasons in words, and what to do.
import { useEffect, useState } from 'preact/hooks';
import { notify } from '../link/console';
import { stillStands, toldFor_ms, useReadiness, type Start } from '../link/readiness';
import type { Reply } from '../link/socket';
import { useStore } from '../link/store';
import { reasonText } from '../text/server';
import { refusalText, t } from '../text/text';
import './refusal.css';

/** Whether to show it. "Already so" is not shown. */
export function refused(answer: Reply): boolean {
  return !answer.ok && answer.refusals[0] !== 'kept';
}

export interface Request {
  busy: boolean;
  /** The last answer, while it is a refusal that is not closed. */
  reply: Reply | null;
  /** Sends and waits; returns success. */
  ask: (what: () => Promise<Reply>) => Promise<boolean>;
  forget: () => void;
}
export function useRequest(): Request {
  const [under_way, setUnderWay] = useState(0);
  const [reply, setReply] = useState<Reply | null>(null);
  const ask = async (what: () => Promise<Reply>) => {
    setUnderWay((n) => n + 1);
    const answer = await what();
    setUnderWay((n) => n - 1);
    setReply(refused(answer) ? answer : null);
    return answer.ok;
  };
  return { busy: under_way > 0, reply, ask, forget: () => setReply(null) };
}

/** As `ref`: what appears comes into view, so that a reason is not below the edge of a phone. */
export const bringIntoView = (shown: Element | null): void => shown?.scrollIntoView({ block: 'nearest' });

/** Tells a refusal at the edge of the screen: for buttons without a place for it. */
export function tell(answer: Reply): void {
  if (refused(answer)) notify('warning', reasons(answer).join(' '), true);
}

/** All reasons in words: refusals by their names, else the code of the answer. */
export function reasons(reply: Reply): string[] {
  if (reply.refusals.length > 0) return [...new Set(reply.refusals.map(refusalText))];
  return [reasonText(reply.reason_code) ?? t('refused.unknown')];
}

export function Refusal({ request: { reply, forget } }: { request: Request }) {
  const [age_ms, setAge] = useState(0);
  useEffect(() => {
    setAge(0);
    const timer = window.setTimeout(() => setAge(toldFor_ms), toldFor_ms);
    return () => window.clearTimeout(timer);
  }, [reply]);
  // It disappears with its reasons and does not return with them: later reasons are shown beside the button.
  const over = useStore((s) => reply !== null && reply.refusals.length > 0 && !reply.refusals.some((reason) => stillStands(reason, s, age_ms)));
  useEffect(() => {
    if (over) forget();
  }, [over]);
  if (reply === null || over) return null;
  return (
    <div ref={bringIntoView} class="refusal" role="alert">
      <div>
        <strong>{t('refused.title')}</strong>
        <ul>
          {reasons(reply).map((text) => (
            <li key={text}>{text}</li>
          ))}
        </ul>
      </div>
      <button type="button" class="quiet" onClick={forget}>
        {t('common.close')}
      </button>
    </div>
  );
}

/** Reasons against starting, beside the button. Hidden while a refusal with the same reasons is open. */
export function StartBlockers({ request, of }: { request: Request; of: Start }) {
  const ready = useReadiness();
  // All controls beside it are off, also while the hoist is led.
  if (ready.start[of].includes('not_allowed')) return <WatchOnly />;
  if (ready.led || request.reply !== null || ready.start[of].length === 0) return null;
  return (
    <div class="blockers" role="status">
      <strong>{t('strip.notReady')}:</strong> {ready.start[of].map(refusalText).join(' ')}
    </div>
  );
}

/** Why the controls of a screen are off for a person who may only watch. */
export function WatchOnly() {
  const role = useStore((s) => s.role);
  if (role !== 'viewer') return null;
  return (
    <div class="blockers" role="status">
      {refusalText('not_allowed')}
    </div>
  );
}
