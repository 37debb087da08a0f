// One patient: the identity on request, visits with their sessions, and what becomes of the data. The list is on Home.
import { Fragment } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import type { Patient, Person, Session, VisitRow } from '../../contract/rest.gen';
import { choosePatient, notify } from '../../link/console';
import { useQuery } from '../../link/query';
import { address, rest, wholeList, type Answer, type Problem } from '../../link/rest';
import { useReadiness } from '../../link/readiness';
import { useStore } from '../../link/store';
import { addressOf, go } from '../../router';
import { problemText } from '../../text/server';
import { useSettings } from '../../text/settings';
import { date, dayText, duration, noValue, t } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { FormButtons } from '../../ui/form_buttons';
import { HoldButton } from '../../ui/hold_button';
import { useTaskTitles } from '../../ui/task_titles';
import { TextField } from '../../ui/text_field';
import { walkName } from '../../ui/walk_name';
import type { PanelProps } from '../panel';
import { Profiles } from './profiles';
import { TrendCard } from './trend';
import '../../ui/rows.css';
import './patients.css';

const confirmHold_ms = 2000;
const notFound = 404;
const nameMost = 100;
const noteMost = 500;

export function PatientsView({ part }: PanelProps) {
  useSettings();
  const id = part !== null && /^\d+$/.test(part) ? Number(part) : null;
  useEffect(() => {
    if (id === null) go(addressOf('home'), true);
  }, [id]);
  return id === null ? null : <PatientPage key={id} id={id} />;
}

function PatientPage({ id }: { id: number }) {
  const ready = useReadiness();
  const role = useStore((s) => s.role);
  const chosen = useStore((s) => s.patient);
  const recording = useStore((s) => s.recording.state + String(s.recording.session));
  const asked = useQuery(() => rest('GET /api/v1/patients/{id}', { path: { id } }), [id, recording]);
  const [problem, setProblem] = useState<Problem | null>(null);
  const [busy, setBusy] = useState(false);
  const patient = asked.value;
  const may = ready.may && !busy;
  const act = async (what: () => Promise<Problem | null>) => {
    setBusy(true);
    setProblem(await what());
    setBusy(false);
  };
  const of = (answer: Answer<unknown>): Problem | null => (answer.ok ? (asked.retry(), null) : answer.problem);

  if (patient === null)
    return (
      <section class="card">
        {asked.problem === null ? <p class="hint">{t('common.loading')}</p> : null}
        <Trouble problem={asked.problem} retry={asked.problem?.status === notFound ? undefined : asked.retry} />
        <a class="quiet patient-back" href={addressOf('home')}>
          ‹ {t('patient.back')}
        </a>
      </section>
    );
  const here = chosen?.id === id;
  const archive = (archived: boolean) =>
    void act(async () => of(await rest('PATCH /api/v1/patients/{id}', { path: { id }, body: { archived }, etag: patient.etag })));
  const remove = () =>
    void act(async () => {
      const answer = await rest('DELETE /api/v1/patients/{id}', { path: { id }, etag: patient.etag });
      if (!answer.ok) return answer.problem;
      notify('info', t('patient.deleted', { code: patient.code }), true);
      go(addressOf('home'));
      return null;
    });
  return (
    <div class="patient">
      <section class="card patient-head">
        <a class="quiet patient-back" href={addressOf('home')}>
          ‹ {t('patient.back')}
        </a>
        <h2>{patient.code}</h2>
        {patient.archived ? <span class="hint">{t('patient.archived')}</span> : null}
        <span class="patient-gap" />
        {here ? (
          <span class="hint">{t('home.chosen')}</span>
        ) : (
          <button
            type="button"
            class="plain primary"
            disabled={!may || ready.led || patient.archived}
            onClick={() => void act(() => choosePatient(id))}
          >
            {t('home.choose')}
          </button>
        )}
        <Trouble problem={problem} />
      </section>
      <div class="patient-side">
        <TrendCard patient={id} again={recording} />
        <Visits id={id} again={recording} may={may} />
        <Profiles patient={id} may={may} />
      </div>
      <div class="patient-side">
        {role === 'viewer' ? null : <IdentityCard patient={patient} onChange={asked.retry} />}
        <section class="card patient-end">
          <h2>{t('patient.data')}</h2>
          <p>{t(patient.archived ? 'patient.restoreText' : 'patient.archiveText')}</p>
          <button type="button" class="plain" disabled={!may || here} onClick={() => archive(!patient.archived)}>
            {t(patient.archived ? 'patient.unarchive' : 'patient.archive')}
          </button>
          <p>{t('patient.deleteText', { code: patient.code, visits: patient.visits, sessions: patient.sessions })}</p>
          <HoldButton
            label={t('patient.deleteHold')}
            hint={t('patient.deleteHint')}
            hold_ms={confirmHold_ms}
            disabled={!may || here}
            onDone={remove}
          />
          {here ? <p class="hint">{t('patient.chosenFirst')}</p> : null}
        </section>
      </div>
    </div>
  );
}

/** A name is requested only after a press; leaving the page forgets it. */
function IdentityCard({ patient, onChange }: { patient: Patient; onChange: () => void }) {
  const { id, etag, has_identity: stored } = patient;
  const [shown, setShown] = useState(false);
  const asked = useQuery(shown ? () => rest('GET /api/v1/patients/{id}/identity', { path: { id } }) : null, [id]);
  const [draft, setDraft] = useState<Person | null>(null);
  const [problem, setProblem] = useState<Problem | null>(null);
  const known = asked.value;
  const save = async () => {
    if (draft === null) return;
    const body = { name: draft.name.trim(), birth_date: draft.birth_date || null, note: draft.note };
    const answer = await rest('PUT /api/v1/patients/{id}/identity', { path: { id }, body, etag });
    setProblem(answer.ok ? null : answer.problem);
    if (!answer.ok) return;
    setDraft(null);
    asked.retry();
    onChange();
  };
  const set = (change: Partial<Person>) => setDraft((now) => ({ name: '', birth_date: '', note: '', ...now, ...change }));
  return (
    <section class="card">
      <h2>{t('patient.identity')}</h2>
      {!shown ? (
        <div class="form">
          <p class="hint">{t(stored ? 'patient.sealed' : 'patient.unnamed')}</p>
          <button type="button" class="plain" onClick={() => setShown(true)}>
            {t(stored ? 'patient.show' : 'patient.name')}
          </button>
        </div>
      ) : known === null ? (
        <>
          <p class="hint">{asked.problem === null ? t('common.loading') : ''}</p>
          <Trouble problem={asked.problem} retry={asked.retry} />
        </>
      ) : known.state === 'key_missing' || known.state === 'key_foreign' ? (
        <p class="form-error" role="alert">
          {t(`patient.${known.state}`)}
        </p>
      ) : draft === null && known.identity !== null ? (
        <div class="form">
          <dl class="patient-known">
            <dt>{t('patient.fullName')}</dt>
            <dd>{known.identity.name}</dd>
            <dt>{t('patient.birth')}</dt>
            <dd>{dayText(known.identity.birth_date)}</dd>
            <dt>{t('sessions.note')}</dt>
            <dd>{known.identity.note === '' ? noValue : known.identity.note}</dd>
          </dl>
          <div class="form-buttons">
            <button type="button" class="plain" onClick={() => setDraft(known.identity)}>
              {t('common.edit')}
            </button>
            <button type="button" class="quiet" onClick={() => setShown(false)}>
              {t('patient.hide')}
            </button>
          </div>
        </div>
      ) : (
        <Form onSend={() => void save()} label={t('patient.identity')}>
          {known.state === 'damaged' ? (
            <p class="form-error" role="alert">
              {t('patient.damaged')}
            </p>
          ) : null}
          <Field label={t('patient.fullName')} value={draft?.name ?? ''} most={nameMost} onValue={(name) => set({ name })} />
          <label class="field">
            <span>{t('patient.birth')}</span>
            <input type="date" value={draft?.birth_date ?? ''} onInput={(event) => set({ birth_date: event.currentTarget.value })} />
          </label>
          <Field label={t('sessions.note')} value={draft?.note ?? ''} most={noteMost} onValue={(note) => set({ note })} />
          <p class="hint">{t('patient.sealedHint')}</p>
          <Trouble problem={problem} />
          <FormButtons
            missing={(draft?.name ?? '').trim() === '' ? [t('patient.fullName')] : []}
            close={() => {
              setDraft(null);
              if (known.state !== 'readable') setShown(false);
            }}
          />
        </Form>
      )}
    </section>
  );
}

function Visits({ id, again, may }: { id: number; again: string; may: boolean }) {
  const { language } = useSettings();
  const visits = useQuery(() => wholeList((query) => rest('GET /api/v1/visits', { query: { ...query, patient: id } })), [id, again]);
  const sessions = useQuery(() => wholeList((query) => rest('GET /api/v1/sessions', { query: { ...query, patient: id } })), [id, again]);
  const titleOf = useTaskTitles();
  const known = new Map((sessions.value?.items ?? []).map((session) => [session.id, session]));
  return (
    <section class="card">
      <h2>{t('patient.visits')}</h2>
      <Trouble problem={visits.problem ?? sessions.problem} retry={() => [visits, sessions].forEach((one) => one.retry())} />
      {visits.value === null && visits.problem === null ? <p class="hint">{t('common.loading')}</p> : null}
      {visits.value?.items.length === 0 ? <p class="hint">{t('home.new')}</p> : null}
      {(visits.value?.items ?? []).map((visit) => (
        <div key={visit.id} class="patient-visit">
          <div class="visit-head">
            <h3>{dayText(visit.day)}</h3>
            <a
              class="plain"
              href={address('GET /api/v1/visits/{id}/report', { path: { id: visit.id }, query: { language } })}
              target="_blank"
              rel="noopener"
            >
              {t('visit.report')}
            </a>
          </div>
          <VisitNote visit={visit} may={may} onChange={visits.retry} />
          <ul class="rows">
            {visit.sessions.map((session) => (
              <SessionRow key={session} id={session} session={known.get(session) ?? null} titleOf={titleOf} />
            ))}
          </ul>
          {visit.standby.length === 0 ? null : (
            <p class="hint">
              {t('patient.standby')}{' '}
              {visit.standby.map((session, i) => (
                <Fragment key={session}>
                  {i > 0 ? ', ' : ''}
                  <a href={addressOf('sessions', session)}>{t('patient.standbyPart', { n: i + 1 })}</a>
                </Fragment>
              ))}
            </p>
          )}
        </div>
      ))}
    </section>
  );
}

/** What people write about a visit. Saved for the note that was shown: another person's is never overwritten unseen. */
function VisitNote({ visit, may, onChange }: { visit: VisitRow; may: boolean; onChange: () => void }) {
  const role = useStore((s) => s.role);
  const [problem, setProblem] = useState<Problem | null>(null);
  const here = useRef(true);
  useEffect(() => () => void (here.current = false), []);
  const save = async (note: string, etag: string | undefined): Promise<boolean> => {
    const answer = await rest('PATCH /api/v1/visits/{id}', { path: { id: visit.id }, body: { note }, etag: etag ?? visit.etag });
    setProblem(answer.ok ? null : answer.problem);
    if (answer.ok) notify('info', 'sessions.saved');
    else if (!here.current) notify('error', `${t('sessions.notSaved')} ${problemText(answer.problem)}`, true);
    onChange();
    return answer.ok;
  };
  // Not while the connection is lost: what is being typed stays.
  if (role === 'viewer' && visit.note === '') return null;
  return (
    <>
      <TextField label={t('visit.note')} value={visit.note} version={visit.etag} most={noteMost} disabled={!may} onSave={save} />
      <Trouble problem={problem} />
    </>
  );
}

function SessionRow({ id, session, titleOf }: { id: number; session: Session | null; titleOf: (task: string) => string }) {
  const name = session === null ? t('sessions.one', { n: id }) : walkName(session, titleOf);
  return (
    <li>
      <a class="row-text" href={addressOf('sessions', id)}>
        <strong>{name}</strong>
        <span>
          {session === null ? '' : date(session.started_utc_ms)}
          {session?.simulated ? ` · ${t('sessions.simulated')}` : ''}
        </span>
      </a>
      <span class="num hint">{session === null ? '' : session.recording ? t('sessions.running') : duration(session.duration_s)}</span>
    </li>
  );
}
