// Staff rehearse on the simulated hoist: choose what happens, let the patient walk, read afterwards what was done and when.
import { useState } from 'preact/hooks';
import type { RehearsalKind } from '../../contract/rest.gen';
import { useQuery } from '../../link/query';
import { rest, type Problem } from '../../link/rest';
import { useStore } from '../../link/store';
import { addressOf } from '../../router';
import { reasonText } from '../../text/server';
import { useSettings } from '../../text/settings';
import { t } from '../../text/text';
import { Trouble } from '../../ui/field';
import { RehearsalItems, rehearsalTitle, rehearsals } from '../../ui/rehearsal';
import './rehearse.css';

const look_ms = 1000;

export function RehearseView() {
  useSettings();
  const role = useStore((s) => s.role);
  const asked = useQuery(() => rest('GET /api/v1/rehearsal'), [], look_ms);
  const [problem, setProblem] = useState<Problem | null>(null);
  const [kind, setKind] = useState<RehearsalKind>('trip');
  const state = asked.value;
  const choose = async (rehearsal: RehearsalKind | null) => {
    const answer = await rest('PUT /api/v1/rehearsal', { body: { rehearsal } });
    setProblem(answer.ok ? null : answer.problem);
    asked.retry();
  };
  const under = state?.phase === 'waiting' || state?.phase === 'happening';
  return (
    <div class="rehearse">
      <section class="card">
        <h2>{t('rehearse.label')}</h2>
        <p>{t('rehearse.what')}</p>
        <Trouble problem={problem ?? asked.problem} />
        {state === null ? null : state.reason_code !== null ? (
          <p role="status">{reasonText(state.reason_code)}</p>
        ) : under && state.rehearsal !== null ? (
          <>
            <p role="status">
              <strong>{t('rehearse.waits', { what: rehearsalTitle(state.rehearsal) })}</strong>
            </p>
            <p class="rehearse-buttons">
              <a class="plain primary" href={addressOf('walk')}>
                {t('rehearse.toWalk')}
              </a>
              {role === 'viewer' ? null : (
                <button type="button" class="plain" onClick={() => void choose(null)}>
                  {t('common.cancel')}
                </button>
              )}
            </p>
          </>
        ) : role === 'viewer' ? (
          <p>{reasonText('role')}</p>
        ) : (
          <>
            <div class="rehearse-kinds" role="radiogroup" aria-label={t('rehearse.choose')}>
              {state.kinds.map(({ rehearsal }) => (
                <button key={rehearsal} type="button" role="radio" aria-checked={kind === rehearsal} onClick={() => setKind(rehearsal)}>
                  <strong>{rehearsalTitle(rehearsal)}</strong>
                  <span>{t(rehearsals[rehearsal].what)}</span>
                </button>
              ))}
            </div>
            <button type="button" class="plain primary" onClick={() => void choose(kind)}>
              {t('rehearse.start')}
            </button>
          </>
        )}
      </section>
      {state === null || state.rehearsal === null || (state.phase !== 'over' && state.phase !== 'lost') ? null : (
        <section class="card rehearse-result">
          <h2>{t('rehearse.result', { what: rehearsalTitle(state.rehearsal) })}</h2>
          <p class="hint">{t('rehearse.label')}</p>
          {state.result === null ? <p role="status">{t('rehearse.lost')}</p> : <RehearsalItems result={state.result} />}
          {state.session === null ? null : (
            <a class="plain" href={addressOf('sessions', state.session)}>
              {t('rehearse.toSession')}
            </a>
          )}
        </section>
      )}
    </div>
  );
}
