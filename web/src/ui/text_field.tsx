// A text of what is stored, such as a note.
import { useEffect, useRef, useState } from 'preact/hooks';
import { t } from '../text/text';
import './text_field.css';

/** A text that is saved on leaving the field, since a button is easily forgotten. The button only makes saving visible. */
export function TextField({
  label,
  hint,
  value,
  most,
  disabled = false,
  onSave,
}: {
  label: string;
  hint?: string;
  value: string;
  most: number;
  disabled?: boolean;
  onSave: (text: string) => Promise<boolean>;
}) {
  const [draft, setDraft] = useState<string | null>(null); // typed text that is not known to be stored
  const sent = useRef<string | null>(null); // a tap on Save leaves the field, too: one request is enough
  const changed = draft !== null && draft !== value;
  const save = async () => {
    if (!changed || draft === sent.current) return;
    sent.current = draft;
    const kept = await onSave(draft);
    sent.current = null;
    if (kept) setDraft((now) => (now === draft ? null : now));
  };
  const latest = useRef(save);
  latest.current = save;
  useEffect(() => {
    const leave = () => void latest.current();
    window.addEventListener('pagehide', leave);
    return () => {
      window.removeEventListener('pagehide', leave);
      leave();
    };
  }, []);
  return (
    <label class="text-field">
      <span>
        {label}
        {hint ? <small> · {hint}</small> : null}
      </span>
      <span class="text-field-row">
        <input
          type="text"
          value={draft ?? value}
          maxLength={most}
          disabled={disabled}
          onInput={(event) => setDraft(event.currentTarget.value)}
          onBlur={() => void save()}
          onKeyDown={(event) => event.key === 'Enter' && void save()}
        />
        <button type="button" class="plain" disabled={!changed} onClick={() => void save()}>
          {t('common.save')}
        </button>
      </span>
    </label>
  );
}
