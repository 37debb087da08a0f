// Why something was not done, and what to do: all reasons, in words.
import { useState } from 'preact/hooks';
import { refusals } from '../contract/faults.gen';
import type { Reply } from '../link/socket';
import { useStore } from '../link/store';
import { serverText } from '../text/server';
import { refusalText, t, words } from '../text/text';

/** Whether there is something to say about it. An answer that only tells that all was so already is none. */
export function refused(answer: Reply): boolean {
  return !answer.ok && answer.refusals[0] !== 'kept';
}

export interface Request {
  busy: boolean;
  /** The last answer, while it is a refusal that nobody has closed. */
  reply: Reply | null;
  /** Sends and waits; whether it was done. */
  ask(what: () => Promise<Reply>): Promise<boolean>;
  forget(): void;
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

/** All reasons in words. Refusals have names; what has none is a sentence of the server, which is not always in the reader's language. */
export function reasons(reply: Reply): string[] {
  if (reply.refusals.length > 0) return [...new Set(reply.refusals.map(refusalText))];
  return [serverText(reply.detail, ...reply.errors.map((error) => error.message)) ?? t('refused.unknown')];
}

export function Refusal({ request: { reply, forget } }: { request: Request }) {
  if (reply === null) return null;
  return (
    <div class="refusal" role="alert">
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

/** The reasons that keep the hoist from starting now. Control and standby are no reasons here: Start takes care of the one, the strip shows the
 * other. Hidden while a refusal, which says the same, is open. */
export function StartBlockers({ request }: { request: Request }) {
  const ready = useStore((s) => s.mode === 'standby' && s.link === 'open');
  const bits = useStore((s) => s.blockedBits);
  const blockers = refusals.filter((row) => (bits >>> row.bit) & 1 && row.name !== 'no_lease' && row.name !== 'not_standby' && row.name !== 'stick_not_neutral');
  if (!ready || request.reply !== null || blockers.length === 0) return null;
  return (
    <div class="blockers" role="status">
      <strong>{t('strip.notReady')}:</strong> {blockers.map((row) => words(row.text)).join(' ')}
    </div>
  );
}
