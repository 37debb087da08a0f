// Settings on trial return by themselves, also during a walk: every screen shows the time left, with buttons to keep or undo.
import { keepSettings, undoSettings } from '../link/console';
import { useReadiness } from '../link/readiness';
import { useStore } from '../link/store';
import { refusalText, t } from '../text/text';
import { Refusal, useRequest } from './refusal';
import './trial_bar.css';

export function TrialBar() {
  const left_s = useStore((s) => s.trial_s);
  const { known, may, reachable } = useReadiness();
  const request = useRequest();
  // The trial also ends while the connection is lost.
  if (left_s <= 0 || !known || !reachable) return null;
  return (
    <div class="trial-bar" role="region" aria-label={t('tune.trial.title')}>
      <p>
        <strong>{t('tune.trial.title')}</strong> <span class="num">{t('tune.trial.left', { n: left_s })}</span>{' '}
        {may ? null : refusalText('not_allowed')}
      </p>
      <div class="trial-buttons">
        <button type="button" class="plain" disabled={!may} onClick={() => void request.ask(undoSettings)}>
          {t('tune.trial.undo')}
        </button>
        <button type="button" class="plain primary" disabled={!may} onClick={() => void request.ask(keepSettings)}>
          {t('tune.trial.keep')}
        </button>
      </div>
      <Refusal request={request} />
    </div>
  );
}
