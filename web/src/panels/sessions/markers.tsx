// The marks of a session: what kind, when, what was written; changed and deleted for what was shown.
import { useState } from 'preact/hooks';
import type { MarkerKind, MarkerPatch, MarkerRow } from '../../contract/rest.gen';
import { notify } from '../../link/console';
import type { Query } from '../../link/query';
import { rest, type Problem } from '../../link/rest';
import { useStore } from '../../link/store';
import { duration, t } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { FormButtons } from '../../ui/form_buttons';
import { RehearsalItems, rehearsalTitle } from '../../ui/rehearsal';
import { readDuration } from './model';
import '../../ui/rows.css';

const kinds: readonly MarkerKind[] = ['note', 'help', 'stumble', 'rest', 'good'];
const textMost = 500;

interface Props {
  session: number;
  asked: Query<{ items: readonly MarkerRow[] }>;
}

export function Markers({ session, asked }: Props) {
  const role = useStore((s) => s.role);
  const [open, setOpen] = useState<number | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const items = asked.value?.items ?? [];
  if (items.length === 0) return null;

  /** What was changed meanwhile is shown beside the refusal. */
  const settle = (refused: Problem | null): boolean => {
    setProblem(refused);
    asked.retry();
    if (refused !== null) return false;
    setOpen(null);
    return true;
  };
  const change = async (marker: MarkerRow, body: MarkerPatch) => {
    const path = { id: session, number: marker.number };
    const answer = await rest('PATCH /api/v1/sessions/{id}/markers/{number}', { path, body, etag: marker.etag });
    if (settle(answer.ok ? null : answer.problem)) notify('info', 'sessions.saved');
  };
  const remove = async (marker: MarkerRow) => {
    const path = { id: session, number: marker.number };
    const answer = await rest('DELETE /api/v1/sessions/{id}/markers/{number}', { path, etag: marker.etag });
    if (settle(answer.ok ? null : answer.problem)) notify('info', 'marker.deleted');
  };
  return (
    <section class="card session-markers">
      <h2>{t('sessions.markers')}</h2>
      <Trouble problem={problem} />
      <ul class="rows">
        {items.map((marker) => (
          <li key={marker.number} class={open === marker.number || marker.rehearsal !== null ? 'wide' : undefined}>
            <div class="row-text">
              <strong>{title(marker)}</strong>
              <span>
                <span class="num">{duration(marker.time_s)}</span>
                {marker.actor === null ? '' : ` · ${marker.actor.user}`}
              </span>
            </div>
            {marker.rehearsal !== null ? (
              <RehearsalItems result={marker.rehearsal} />
            ) : open === marker.number ? (
              <Edit
                key={marker.etag}
                marker={marker}
                save={(patch) => void change(marker, patch)}
                remove={() => void remove(marker)}
                close={() => setOpen(null)}
              />
            ) : role === 'viewer' ? null : (
              <div class="row-buttons">
                <button
                  type="button"
                  class="plain"
                  aria-label={`${t('common.edit')}: ${title(marker)}, ${duration(marker.time_s)}`}
                  onClick={() => {
                    setProblem(null);
                    setOpen(marker.number);
                  }}
                >
                  {t('common.edit')}
                </button>
              </div>
            )}
          </li>
        ))}
      </ul>
    </section>
  );
}

/** A mark set with a button has the button's word as its text. */
function title({ kind, text, rehearsal }: MarkerRow): string {
  if (rehearsal !== null) return `${t('rehearse.label')}: ${rehearsalTitle(rehearsal.rehearsal)}`;
  const word = t(`marker.${kind}`);
  if (text === '' || text === word) return word;
  return kind === 'note' ? text : `${word} · ${text}`;
}

interface EditProps {
  marker: MarkerRow;
  save: (patch: MarkerPatch) => void;
  remove: () => void;
  close: () => void;
}

function Edit({ marker, save, remove, close }: EditProps) {
  const [kind, setKind] = useState<MarkerKind>(marker.kind);
  const [text, setText] = useState(marker.text);
  const [time, setTime] = useState(duration(marker.time_s));
  const moved = time !== duration(marker.time_s);
  const time_s = readDuration(time);
  const patch: MarkerPatch = {
    ...(kind === marker.kind ? {} : { kind }),
    ...(text === marker.text ? {} : { text }),
    ...(moved && time_s !== null ? { time_s } : {}),
  };
  const missing = moved && time_s === null ? [t('marker.time')] : [];
  const ready = Object.keys(patch).length > 0 && missing.length === 0;
  return (
    <Form label={t('common.edit')} onSend={() => (ready ? save(patch) : undefined)}>
      <label class="field">
        <span>{t('marker.kind')}</span>
        <select value={kind} onChange={(event) => setKind(event.currentTarget.value as MarkerKind)}>
          {kinds.map((one) => (
            <option key={one} value={one}>
              {t(`marker.${one}`)}
            </option>
          ))}
        </select>
      </label>
      <Field label={t('marker.text')} hint={t('marker.textHint')} value={text} most={textMost} onValue={setText} />
      <Field label={t('marker.time')} hint={t('marker.timeHint')} value={time} onValue={setTime} />
      <FormButtons missing={missing} ready={ready} close={close}>
        <button type="button" class="plain last" onClick={remove}>
          {t('marker.delete')}
        </button>
      </FormButtons>
    </Form>
  );
}
