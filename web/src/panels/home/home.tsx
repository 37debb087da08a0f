// Where the console begins: the patient of the next walk, those of today, and the search for the others.
import { useEffect, useState } from 'preact/hooks';
import { choosePatient, notify } from '../../link/console';
import { useQuery } from '../../link/query';
import { rest, wholeList, type Problem } from '../../link/rest';
import { useReadiness } from '../../link/readiness';
import { useStore } from '../../link/store';
import { addressOf } from '../../router';
import { useSettings } from '../../text/settings';
import { dayText, t } from '../../text/text';
import { Trouble } from '../../ui/field';
import { Icon } from '../../ui/icons';
import { dayOf, exists, found, isCode, type Patient, type Visit } from './model';
import '../../ui/rows.css';
import './home.css';

/** The most that the server gives at once; a longer list is searched by the server. */
const pageSize = 200;
const codeMost = 64;
const typing_ms = 250;

/** Archived ones are found by their code, and only so: a code that exists must not look free. */
function usePatients(search: string, again: string) {
  const [sought, setSought] = useState('');
  useEffect(() => {
    const timer = window.setTimeout(() => setSought(search), search === '' ? 0 : typing_ms);
    return () => window.clearTimeout(timer);
  }, [search]);
  return useQuery(
    () => rest('GET /api/v1/patients', { query: { limit: pageSize, ...(sought === '' ? { archived: 0 } : { q: sought }) } }),
    [sought, again],
  );
}

/** The day by the hoist's clock, by which visits have theirs: a tablet's clock may be wrong. Null until the hoist has told it. */
function useToday(again: string) {
  const time = useQuery(() => rest('GET /api/v1/time', { query: { client_utc_ms: Date.now() } }), [again]);
  const behind_s = time.value?.client_behind_s ?? 0;
  return { ...time, value: time.value === null ? null : dayOf(new Date(Date.now() + behind_s * 1000)) };
}

export function HomeView() {
  useSettings();
  const [search, setSearch] = useState('');
  const [problem, setProblem] = useState<Problem | null>(null);
  const [busy, setBusy] = useState(false);
  const ready = useReadiness();
  const chosen = useStore((s) => s.patient);
  const recording = useStore((s) => s.recording.state + String(s.recording.session));
  const again = `${recording} ${chosen?.code ?? ''}`;
  const patients = usePatients(search.trim(), again);
  const visits = useQuery(() => rest('GET /api/v1/visits', { query: { limit: pageSize } }), [again]);
  const today = useToday(again);
  const archived = useQuery(() => wholeList((query) => rest('GET /api/v1/patients', { query: { ...query, archived: 1 } })), [again]);
  const may = ready.may && !ready.led && !busy;

  const act = async (what: () => Promise<Problem | null>) => {
    setBusy(true);
    const wrong = await what();
    setBusy(false);
    setProblem(wrong);
    if (wrong === null) setSearch('');
  };
  const choose = (patient: number | null) => void act(() => choosePatient(patient));
  const create = (code: string) =>
    void act(async () => {
      const answer = await rest('POST /api/v1/patients', { body: { code } });
      if (!answer.ok) return answer.problem;
      notify('info', t('home.created', { code }), true);
      return choosePatient(answer.value.id);
    });

  const of_today = (visits.value?.items ?? []).filter((visit) => visit.day === today.value);
  const seen = found(of_today, search);
  const others = found(
    (patients.value?.items ?? []).filter((patient) => !of_today.some((visit) => visit.patient === patient.id)),
    search,
  );
  const typed = search.trim();
  const asked = [patients, visits, today];
  const loaded = asked.every(({ value }) => value !== null);
  const failed = asked.find((one) => one.problem !== null)?.problem ?? null;
  return (
    <div class="home">
      <section class="card home-chosen" aria-label={t('home.patient')}>
        <h2>{t('home.patient')}</h2>
        {chosen === null ? (
          <>
            <p class="home-code none">{t('home.none')}</p>
            <p class="hint">{t('home.noneHint')}</p>
          </>
        ) : (
          <>
            <p class="home-code">{chosen.code}</p>
            <p class="hint">{t('home.chosenHint')}</p>
          </>
        )}
        <div class="home-ways">
          {(['walk', 'drive', 'exercises'] as const).map((to) => (
            <a key={to} class={to === 'walk' && chosen !== null ? 'plain primary' : 'plain'} href={addressOf(to)}>
              <Icon name={to} />
              {t(`nav.${to}`)}
            </a>
          ))}
        </div>
        {chosen !== null ? (
          <div class="home-more">
            <a class="quiet" href={addressOf('patients', chosen.id)}>
              {t('home.open')}
            </a>
            <button type="button" class="quiet" disabled={!may} onClick={() => choose(null)}>
              {t('home.finish')}
            </button>
          </div>
        ) : null}
      </section>
      <section class="card home-list" aria-label={t('nav.patients')}>
        <input
          type="search"
          placeholder={t('home.search')}
          aria-label={t('home.search')}
          maxLength={codeMost}
          value={search}
          onInput={(event) => setSearch(event.currentTarget.value)}
        />
        <Trouble problem={problem} />
        <Trouble problem={failed} retry={() => asked.forEach((one) => one.retry())} />
        {!loaded && failed === null ? <p class="hint">{t('common.loading')}</p> : null}
        {seen.length > 0 ? <h2>{t('home.today')}</h2> : null}
        <ul class="rows">
          {seen.map((visit) => (
            <Row
              key={visit.patient}
              patient={{ id: visit.patient, code: visit.code }}
              line={sessionsText(visit)}
              here={visit.patient === chosen?.id}
              archived={archived.value?.items.some(({ id }) => id === visit.patient) === true}
              may={may}
              choose={choose}
            />
          ))}
        </ul>
        {others.length > 0 && seen.length > 0 ? <h2>{t('home.others')}</h2> : null}
        <ul class="rows">
          {others.map((patient) => (
            <Row
              key={patient.id}
              patient={patient}
              line={lastText(patient)}
              here={patient.id === chosen?.id}
              archived={patient.archived}
              may={may}
              choose={choose}
            />
          ))}
        </ul>
        {loaded && seen.length + others.length === 0 ? <p class="hint">{t(typed === '' ? 'home.empty' : 'home.notFound')}</p> : null}
        {typed !== '' && loaded && !exists([...of_today, ...(patients.value?.items ?? [])], typed) ? (
          isCode(typed) ? (
            <button type="button" class="plain home-new" disabled={!may} onClick={() => create(typed)}>
              {t('home.create', { code: typed })}
            </button>
          ) : (
            <p class="hint">{t('home.codeRule')}</p>
          )
        ) : null}
        <p class="hint">{t('home.codeHint')}</p>
      </section>
    </div>
  );
}

const count = (one: 'home.session' | 'home.visit', many: 'home.sessions' | 'home.visits', n: number) => t(n === 1 ? one : many, { n });
const sessionsText = (visit: Visit) => count('home.session', 'home.sessions', visit.sessions.length);
const lastText = (patient: Patient) =>
  patient.visits === 0
    ? t('home.new')
    : `${t('home.last', { day: dayText(patient.last_day) })} · ${count('home.visit', 'home.visits', patient.visits)}`;

function Row({
  patient,
  line,
  here,
  archived,
  may,
  choose,
}: {
  patient: { id: number; code: string };
  line: string;
  here: boolean;
  archived: boolean;
  may: boolean;
  choose: (patient: number) => void;
}) {
  return (
    <li aria-current={here}>
      <a class="row-text" href={addressOf('patients', patient.id)}>
        <strong>{patient.code}</strong>
        <span>{line}</span>
      </a>
      <div class="row-buttons">
        {here ? (
          <span class="home-here">{t('home.chosen')}</span>
        ) : archived ? (
          <span class="hint">{t('patient.archived')}</span>
        ) : (
          <button
            type="button"
            class="plain"
            disabled={!may}
            aria-label={t('home.chooseName', { code: patient.code })}
            onClick={() => choose(patient.id)}
          >
            {t('home.choose')}
          </button>
        )}
      </div>
    </li>
  );
}
