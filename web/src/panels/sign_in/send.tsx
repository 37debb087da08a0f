// What signing in and the first set-up share: limits of the fields, and the button that sends.
import { useState } from 'preact/hooks';
import type { Problem } from '../../link/rest';
import { t } from '../../text/text';
import { Trouble } from '../../ui/field';
import { useWait } from '../../ui/wait';

export const nameMost = 32;
export const passwordMost = 128;

export function useSending(send: () => Promise<Problem | null>) {
  const [problem, setProblem] = useState<Problem | null>(null);
  const [busy, setBusy] = useState(false);
  const wait_s = useWait(problem);
  const go = async () => {
    if (busy || wait_s > 0) return;
    setBusy(true);
    const answer = await send();
    setBusy(false);
    setProblem(answer);
  };
  return { problem, busy, wait_s, go };
}

/** The button that sends, with what is wrong above it; while the server asks to wait it counts down. */
export function Send({
  sending,
  label,
  ready,
  back,
}: {
  sending: ReturnType<typeof useSending>;
  label: string;
  ready: boolean;
  back: (() => void) | null;
}) {
  return (
    <>
      <Trouble problem={sending.problem} />
      <div class="form-buttons">
        <button type="submit" class="big primary" disabled={!ready || sending.busy || sending.wait_s > 0}>
          {sending.wait_s > 0 ? <span class="num">{t('signin.wait', { s: sending.wait_s })}</span> : label}
        </button>
        {back !== null ? (
          <button type="button" class="quiet" onClick={back}>
            {t('common.cancel')}
          </button>
        ) : null}
      </div>
    </>
  );
}
