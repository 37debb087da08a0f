// Fields of a form and what is wrong with it, the same on every screen.
import type { ComponentChildren } from 'preact';
import type { Problem } from '../link/rest';
import { problemText } from '../text/server';
import { t } from '../text/text';
import './form.css';

interface FieldProps {
  label: string;
  hint?: string;
  value: string;
  onValue: (text: string) => void;
  type?: 'text' | 'password';
  most?: number;
  /** As HTML's autocomplete; off unless given: this device is used by several people. */
  fill?: 'off' | 'username' | 'current-password' | 'new-password' | 'one-time-code';
  numeric?: boolean;
  focus?: boolean;
  disabled?: boolean;
}

export function Field({
  label,
  hint,
  value,
  onValue,
  type = 'text',
  most,
  fill = 'off',
  numeric = false,
  focus = false,
  disabled = false,
}: FieldProps) {
  return (
    <label class="field">
      <span>
        {label}
        {hint ? <small> · {hint}</small> : null}
      </span>
      <input
        {...({ type } as { type: 'text' })}
        value={value}
        maxLength={most}
        autocomplete={fill}
        autocapitalize="off"
        spellcheck={false}
        inputMode={numeric ? 'numeric' : undefined}
        autoFocus={focus}
        disabled={disabled}
        onInput={(event) => onValue(event.currentTarget.value)}
      />
    </label>
  );
}

/** A form sends on Enter too, and never leaves the page. */
export function Form({ onSend, children, label }: { onSend: () => void; children: ComponentChildren; label?: string }) {
  return (
    <form
      class="form"
      aria-label={label}
      onSubmit={(event) => {
        event.preventDefault();
        onSend();
      }}
    >
      {children}
    </form>
  );
}

/** Why something did not work, in words; `retry` where trying again can help. */
export function Trouble({ problem, retry }: { problem: Problem | null; retry?: () => void }) {
  if (problem === null) return null;
  return (
    <p class="form-error" role="alert">
      {problemText(problem)}{' '}
      {retry ? (
        <button type="button" class="quiet" onClick={retry}>
          {t('common.retry')}
        </button>
      ) : null}
    </p>
  );
}
