// Which recorded sessions a job takes: by day, by patient, with or without those of the simulation. The same on every screen that asks.
import type { ComponentChildren } from 'preact';
import { useState } from 'preact/hooks';
import { t } from '../text/text';
import { Field } from './field';
import './session_choice.css';

const codeMost = 64;

interface SessionChoice {
  from: string;
  to: string;
  subject: string;
  simulated: boolean;
}

/** What is chosen, as a job takes it, and the fields to choose it. */
export function useSessionChoice() {
  const [choice, setChoice] = useState<SessionChoice>({ from: '', to: '', subject: '', simulated: false });
  const subject = choice.subject.trim();
  const asked = {
    simulated: choice.simulated,
    ...(choice.from === '' ? {} : { from_day: choice.from }),
    ...(choice.to === '' ? {} : { to_day: choice.to }),
    ...(subject === '' ? {} : { subject }),
  };
  return { asked, choice, change: (part: Partial<SessionChoice>) => setChoice((before) => ({ ...before, ...part })) };
}

interface FieldsProps {
  of: ReturnType<typeof useSessionChoice>;
  disabled: boolean;
  /** Asked between patient and simulation. */
  children?: ComponentChildren;
}

export function SessionChoiceFields({ of: { choice, change }, disabled, children }: FieldsProps) {
  return (
    <>
      <div class="session-days">
        <label class="field">
          <span>{t('exports.from')}</span>
          <input type="date" value={choice.from} disabled={disabled} onInput={(event) => change({ from: event.currentTarget.value })} />
        </label>
        <label class="field">
          <span>{t('exports.to')}</span>
          <input type="date" value={choice.to} disabled={disabled} onInput={(event) => change({ to: event.currentTarget.value })} />
        </label>
      </div>
      <Field
        label={t('sessions.subject')}
        hint={t('exports.all')}
        value={choice.subject}
        most={codeMost}
        disabled={disabled}
        onValue={(subject) => change({ subject })}
      />
      {children}
      <label class="check">
        <input
          type="checkbox"
          checked={choice.simulated}
          disabled={disabled}
          onChange={(event) => change({ simulated: event.currentTarget.checked })}
        />
        <span>{t('exports.simulated')}</span>
      </label>
    </>
  );
}
