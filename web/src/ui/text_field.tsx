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
  version,
  onSave,
}: {
  label: string;
  hint?: string;
  value: string;
  most: number;
  disabled?: boolean;
  /** Of the stored text (its ETag). */
  version?: string;
  /** `version`: of what stood there when typing began, so that a text that came meanwhile is not overwritten unseen. */
  onSave: (text: string, version: string | undefined) => Promise<boolean>;
}) {
  const [draft, setDraft] = useState<string | null>(null); // typed text that is not known to be stored
  const typed = useRef<string | null>(null); // the same at once: Enter may come before the field is drawn again
  const sent = useRef<string | null>(null); // a tap on Save leaves the field, too: one request is enough
  const typedOver = useRef<string | undefined>(undefined);
  const changed = draft !== null && draft !== value;
  const save = async () => {
    const text = typed.current;
    if (text === null || text === value || text === sent.current) return;
    sent.current = text;
    const kept = await onSave(text, typedOver.current ?? version);
    sent.current = null;
    // Refused: the person has been told, and the next save is for what is stored now.
    typedOver.current = undefined;
    if (!kept || typed.current !== text) return;
    typed.current = null;
    setDraft(null);
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
          onInput={(event) => {
            if (!changed) typedOver.current = version;
            typed.current = event.currentTarget.value;
            setDraft(typed.current);
          }}
          onBlur={() => void save()}
          onKeyDown={(event) => event.key === 'Enter' && void save()}
        />
        <button type="button" class="plain" disabled={disabled || !changed} onClick={() => void save()}>
          {t('common.save')}
        </button>
      </span>
    </label>
  );
}
