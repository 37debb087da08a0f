// How far a job is, with a button to end it.
import type { Work } from '../link/jobs';
import { t } from '../text/text';
import './form.css';

export function Progress({ work, label }: { work: Work; label: string }) {
  if (!work.busy) return null;
  return (
    <div class="form-buttons" role="status">
      <span>{label}</span>
      <progress value={work.job?.progress ?? 0} max={1} aria-label={label} />
      <button type="button" class="quiet" onClick={work.cancel}>
        {t('common.cancel')}
      </button>
    </div>
  );
}
