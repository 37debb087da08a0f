// Access for programs: tokens with a scope and an end.
import { useState } from 'preact/hooks';
import { useQuery } from '../../link/query';
import { rest, wholeList, type Problem } from '../../link/rest';
import { useStore } from '../../link/store';
import { date, t } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { may, roles, type Role } from './roles';
import { FormButtons } from '../../ui/form_buttons';

const lives_days = [7, 30, 90, 365] as const;
const nameMost = 64;

export function TokensSection() {
  const tokens = useQuery(() => wholeList((query) => rest('GET /api/v1/tokens', { query })), []);
  const [adding, setAdding] = useState(false);
  const [secret, setSecret] = useState<string | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const remove = async (id: number, etag: string) => {
    const answer = await rest('DELETE /api/v1/tokens/{id}', { path: { id }, etag });
    setProblem(answer.ok ? null : answer.problem);
    tokens.retry();
  };
  return (
    <section class="card">
      <h2>{t('settings.tokens')}</h2>
      <p class="hint">{t('tokens.hint')}</p>
      <Trouble problem={tokens.problem} retry={tokens.retry} />
      <Trouble problem={problem} />
      {secret !== null ? (
        <div class="settings-secret" role="status">
          <p>{t('tokens.once')}</p>
          <code>{secret}</code>
          <button type="button" class="plain" onClick={() => setSecret(null)}>
            {t('tokens.noted')}
          </button>
        </div>
      ) : null}
      <ul class="rows">
        {(tokens.value?.items ?? []).map((token) => (
          <li key={token.id}>
            <div class="row-text">
              <strong>{token.name}</strong>
              <span>
                {t(`tokens.scope.${token.scope}`)} · {t('tokens.until', { date: date(token.expires_utc_s * 1000) })}
              </span>
              <span>{token.user}</span>
            </div>
            <div class="row-buttons">
              <button
                type="button"
                class="plain"
                aria-label={`${t('tokens.remove')}: ${token.name}`}
                onClick={() => void remove(token.id, token.etag)}
              >
                {t('tokens.remove')}
              </button>
            </div>
          </li>
        ))}
      </ul>
      {adding ? (
        <New
          done={(made) => {
            setAdding(false);
            setSecret(made);
            if (made !== null) tokens.retry();
          }}
        />
      ) : (
        <button type="button" class="plain" disabled={secret !== null} onClick={() => setAdding(true)}>
          {t('tokens.new')}
        </button>
      )}
    </section>
  );
}

function New({ done }: { done: (secret: string | null) => void }) {
  const own = useStore((s) => s.role);
  const [name, setName] = useState('');
  const [scope, setScope] = useState<Role>('viewer');
  const [life_days, setLife] = useState<number>(30);
  const [problem, setProblem] = useState<Problem | null>(null);
  const [busy, setBusy] = useState(false);
  const save = async () => {
    if (busy) return; // a second tap would make a second token, whose secret is never shown
    setBusy(true);
    const answer = await rest('POST /api/v1/tokens', { body: { name: name.trim(), scope, days: life_days } });
    setBusy(false);
    setProblem(answer.ok ? null : answer.problem);
    if (answer.ok) done(answer.value.token);
  };
  return (
    <Form label={t('tokens.new')} onSend={() => void save()}>
      <Field label={t('tokens.name')} value={name} most={nameMost} onValue={setName} />
      <label class="field">
        <span>{t('tokens.scope')}</span>
        <select value={scope} onChange={(event) => setScope(event.currentTarget.value as Role)}>
          {roles
            .filter((one) => may(own, one))
            .map((one) => (
              <option key={one} value={one}>
                {t(`tokens.scope.${one}`)}
              </option>
            ))}
        </select>
      </label>
      <label class="field">
        <span>{t('tokens.life')}</span>
        <select value={String(life_days)} onChange={(event) => setLife(Number(event.currentTarget.value))}>
          {lives_days.map((days) => (
            <option key={days} value={String(days)}>
              {t('tokens.days', { n: days })}
            </option>
          ))}
        </select>
      </label>
      <Trouble problem={problem} />
      <FormButtons missing={name.trim() === '' ? [t('tokens.name')] : []} ready={!busy} close={() => done(null)} />
    </Form>
  );
}
