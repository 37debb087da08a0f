// The buttons under a form: Save, Cancel, and what else it offers at the end of the row.
import type { ComponentChildren } from 'preact';
import { t } from '../text/text';

export function FormButtons({ ready, close, children }: { ready: boolean; close: () => void; children?: ComponentChildren }) {
  return (
    <div class="form-buttons">
      <button type="submit" class="plain primary" disabled={!ready}>
        {t('common.save')}
      </button>
      <button type="button" class="quiet" onClick={close}>
        {t('common.cancel')}
      </button>
      {children}
    </div>
  );
}
