// A patient's settings under a name: saved from what is in force, compared with it in plain words, applied at standstill.
import { useState } from 'preact/hooks';
import { params } from '../../contract/params.gen';
import type { Profile, ProfileDiff } from '../../contract/rest.gen';
import { notify } from '../../link/console';
import { useQuery } from '../../link/query';
import { rest, type Answer, type Problem } from '../../link/rest';
import { useReadiness } from '../../link/readiness';
import { useStore } from '../../link/store';
import { date, noValue, plain, shownAs, t, withUnit, words } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { FormButtons } from '../../ui/form_buttons';

const nameMost = 64;
const pageSize = 50;

/** A difference in words: what, the value in force, the value of the profile. */
export function difference(item: ProfileDiff['items'][number]): { what: string; from: string; to: string } {
  const row = params.find((one) => one.name === item.name);
  const show = shownAs(item.name, row?.unit ?? '');
  const value = (si: number | null) => (si === null ? noValue : withUnit(plain(si * show.factor), show.unit));
  return { what: row === undefined ? t('profile.unknown') : words(row.title), from: value(item.in_force), to: value(item.profile) };
}

export function Profiles({ patient, may }: { patient: number; may: boolean }) {
  const version = useStore((s) => s.parameterVersion);
  const list = useQuery(() => rest('GET /api/v1/patients/{id}/profiles', { path: { id: patient }, query: { limit: pageSize } }), [patient]);
  const [open, setOpen] = useState<number | null>(null);
  const [name, setName] = useState('');
  const [problem, setProblem] = useState<Problem | null>(null);
  const save = async () => {
    const answer = await rest('POST /api/v1/patients/{id}/profiles', { path: { id: patient }, body: { name: name.trim() } });
    setProblem(answer.ok ? null : answer.problem);
    if (!answer.ok) return;
    setName('');
    list.retry();
  };
  return (
    <section class="card">
      <h2>{t('profile.all')}</h2>
      <p class="hint">{t('profile.hint')}</p>
      <Trouble problem={list.problem} retry={list.retry} />
      <ul class="rows">
        {(list.value?.items ?? []).map((profile) => (
          <li key={profile.id} class={open === profile.id ? 'wide' : undefined}>
            <div class="row-text">
              <strong>{profile.name}</strong>
              <span>{t('profile.saved', { date: date(profile.saved_utc_ms) })}</span>
            </div>
            {open === profile.id ? (
              <Open key={version} profile={profile} may={may} changed={list.retry} close={() => setOpen(null)} />
            ) : (
              <div class="row-buttons">
                <button type="button" class="plain" aria-label={`${t('profile.compare')}: ${profile.name}`} onClick={() => setOpen(profile.id)}>
                  {t('profile.compare')}
                </button>
              </div>
            )}
          </li>
        ))}
      </ul>
      <Form label={t('profile.new')} onSend={() => void save()}>
        <Field label={t('profile.new')} value={name} most={nameMost} onValue={setName} disabled={!may} />
        <Trouble problem={problem} />
        <FormButtons missing={may && name.trim() === '' ? [t('profile.name')] : []} ready={may} />
      </Form>
    </section>
  );
}

/** What would change, with what can be done about it. */
function Open({ profile, may, changed, close }: { profile: Profile; may: boolean; changed: () => void; close: () => void }) {
  const { standby } = useReadiness();
  const diff = useQuery(() => rest('GET /api/v1/profiles/{id}/diff', { path: { id: profile.id } }), [profile.id]);
  const [problem, setProblem] = useState<Problem | null>(null);
  const path = { id: profile.id };
  const act = async (what: Promise<Answer<unknown>>, text: 'profile.applied' | 'profile.updated' | 'profile.deleted') => {
    const answer = await what;
    setProblem(answer.ok ? null : answer.problem);
    if (!answer.ok) return;
    notify('info', text);
    changed();
    close();
  };
  const now = diff.value;
  const unusable = now?.items.some((item) => item.unusable) ?? false;
  return (
    <div class="form">
      <Trouble problem={diff.problem} retry={diff.retry} />
      {now !== null && now.items.length === 0 ? <p>{t('profile.same')}</p> : null}
      {now !== null && now.items.length > 0 ? (
        <table class="profile-diff">
          <thead>
            <tr>
              <th scope="col">{t('profile.setting')}</th>
              <th scope="col">{t('profile.now')}</th>
              <th scope="col">{t('profile.then')}</th>
            </tr>
          </thead>
          <tbody>
            {now.items.map((item) => {
              const { what, from, to } = difference(item);
              return (
                <tr key={item.name}>
                  <th scope="row">{what}</th>
                  <td class="num">{from}</td>
                  <td class="num">{to}</td>
                </tr>
              );
            })}
          </tbody>
        </table>
      ) : null}
      {unusable ? <p class="form-error">{t('profile.unusable')}</p> : null}
      <Trouble problem={problem} />
      <div class="form-buttons">
        <button
          type="button"
          class="plain primary"
          disabled={!may || !standby || unusable || now === null || now.version === null || now.items.length === 0}
          onClick={() => void act(rest('POST /api/v1/profiles/{id}/apply', { path, body: { version: now?.version ?? 0 } }), 'profile.applied')}
        >
          {t('profile.apply')}
        </button>
        <button
          type="button"
          class="plain"
          disabled={!may || now === null || now.items.length === 0}
          onClick={() =>
            void act(rest('PATCH /api/v1/profiles/{id}', { path, body: { from_in_force: true }, etag: profile.etag }), 'profile.updated')
          }
        >
          {t('profile.update')}
        </button>
        <button
          type="button"
          class="quiet"
          disabled={!may}
          onClick={() => void act(rest('DELETE /api/v1/profiles/{id}', { path, etag: profile.etag }), 'profile.deleted')}
        >
          {t('sessions.delete')}
        </button>
        <button type="button" class="quiet" onClick={close}>
          {t('common.close')}
        </button>
      </div>
      {standby ? null : <p class="hint">{t('tune.stopped')}</p>}
    </div>
  );
}
