// The buttons under a form: Save, Cancel where it can be closed, and what else it offers at the end of the row; under them what Save still waits for.
import type { ComponentChildren } from 'preact';
import { t } from '../text/text';

interface FormButtonsProps {
  /** Labels of the fields that must be filled in first. Their line stays when there are none, so that nothing moves during typing. */
  missing: readonly string[];
  ready?: boolean;
  close?: () => void;
  children?: ComponentChildren;
}

export function FormButtons({ missing, ready = true, close, children }: FormButtonsProps) {
  return (
    <div class="form-buttons">
      <button type="submit" class="plain primary" disabled={!ready || missing.length > 0}>
        {t('common.save')}
      </button>
      {close === undefined ? null : (
        <button type="button" class="quiet" onClick={close}>
          {t('common.cancel')}
        </button>
      )}
      {children}
      <p class="form-missing" aria-live="polite">
        {missing.length === 0 ? '' : t('common.missing', { fields: missing.join(', ') })}
      </p>
    </div>
  );
}
