// Recorded sessions: the list, and one session with its figures, path, course, note and export.
import { useEffect, useRef, useState } from 'preact/hooks';
import { exportFormats, type ExportFormat } from '../../contract/exports.gen';
import type { SignalName } from '../../contract/signals.gen';
import { useQuery, type Query } from '../../link/query';
import { notify } from '../../link/console';
import { address, rest, wholeList, type Answer, type Problem } from '../../link/rest';
import type { Exercise, Metrics, Samples, Session, SessionList, SessionPatch } from '../../contract/rest.gen';
import { useReadiness } from '../../link/readiness';
import { useStore } from '../../link/store';
import { problemText, reasonText } from '../../text/server';
import { useSettings } from '../../text/settings';
import { date, degrees, duration, fixed, t, words } from '../../text/text';
import { fit, patternPoints, polesOf, type Point } from '../../ui/geometry';
import { drawFloor } from '../../ui/floor_view';
import { WatchOnly } from '../../ui/refusal';
import { Scroll } from '../../ui/scroll';
import { useTaskTitles } from '../../ui/task_titles';
import { TextField } from '../../ui/text_field';
import { walkName } from '../../ui/walk_name';
import { eventText } from '../../ui/event_text';
import { Lazy, LoadFailed, useLazy } from '../../ui/lazy';
import { addressOf, go } from '../../router';
import type { PanelProps } from '../panel';
import { AllFigures } from './all_figures';
import { curves } from './curves';
import { ExportMany } from './export_many';
import { Markers } from './markers';
import { continued, pathOf, refreshed, story } from './model';
import '../../ui/reading.css';
import './sessions.css';

/** Time for Undo; then the server deletes. */
const undoDelete_ms = 6000;
const pathRuns = 2000;
const curveRuns = 800;
const curvesMost = 4;
const pageSize = 50;
/** Events that are drawn until all are asked for. */
const eventsFirst = 200;
/** Pause in typing before the search is sent. */
const typing_ms = 250;

/** Longest text that the server accepts. */
const subjectMost = 64;
const noteMost = 500;
const notFound = 404;
/** Someone else has changed it since it was read. */
const outdated = 412;
/** Columns that a session does not have are refused with this; anything else is a failure. */
const unprocessable = 422;

const samplesOf = (id: number, columns: string, points: number) =>
  rest('GET /api/v1/sessions/{id}/samples', { path: { id }, query: { columns, points } });

/** The list, newest first. It grows at its end and keeps its position when newer ones come. */
function useSessionList(search: string, recording: string) {
  const [sought, setSought] = useState(search);
  const [list, setList] = useState<{ sought: string; page: SessionList } | null>(null);
  const [olderProblem, setOlderProblem] = useState<Problem | null>(null);
  const [waits, setWaits] = useState(false); // older ones are being loaded
  useEffect(() => {
    const timer = window.setTimeout(() => setSought(search), search === '' ? 0 : typing_ms);
    return () => window.clearTimeout(timer);
  }, [search]);
  const ask = async (cursor: string | null): Promise<Answer<{ sought: string; page: SessionList }>> => {
    const query = { limit: pageSize, cursor: cursor ?? undefined, q: sought === '' ? undefined : sought };
    const answer = await rest('GET /api/v1/sessions', { query });
    return answer.ok ? { ok: true, value: { sought, page: answer.value } } : answer;
  };
  const newest = useQuery(() => ask(null), [sought, recording]);
  useEffect(() => {
    const came = newest.value;
    if (came === null) return;
    setOlderProblem(null);
    setList((before) => (before?.sought === came.sought ? { ...came, page: refreshed(before.page, came.page) } : came));
  }, [newest.value]);
  const older = async () => {
    setWaits(true);
    const answer = await ask(list?.page.next ?? null);
    setWaits(false);
    setOlderProblem(answer.ok ? null : answer.problem);
    if (answer.ok)
      setList((before) => (before?.sought === answer.value.sought ? { ...before, page: continued(before.page, answer.value.page) } : before));
  };
  return { list, problem: newest.problem ?? olderProblem, waits, again: newest.retry, older };
}

export function SessionsView({ part }: PanelProps) {
  useSettings();
  const titleOf = useTaskTitles();
  const [search, setSearch] = useState('');
  const chosen = part !== null && /^\d+$/.test(part) ? Number(part) : null;
  const [leaving, setLeaving] = useState<number | null>(null); // Undo can still keep it
  const [gone, setGone] = useState<readonly number[]>([]); // being deleted by the server, or deleted
  const role = useStore((s) => s.role);
  const recording = useStore((s) => s.recording.state + String(s.recording.session));
  const { list, problem, waits, again, older } = useSessionList(search.trim(), recording);

  // Six seconds of Undo, then the server deletes. Another Delete, or leaving the screen or the page, confirms at once.
  const pending = useRef<{ id: number; etag: string; timer: number } | null>(null);
  const settle = () => {
    if (pending.current === null) return;
    const { id, etag, timer } = pending.current;
    window.clearTimeout(timer);
    pending.current = null;
    setLeaving(null);
    setGone((before) => [...before, id]);
    void rest('DELETE /api/v1/sessions/{id}', { path: { id }, etag }).then((answer) => {
      if (answer.ok) notify('info', t('sessions.deleted', { n: id }), true);
      else {
        notify('error', problemText(answer.problem), true);
        setGone((before) => before.filter((item) => item !== id));
      }
      again();
    });
  };
  useEffect(() => {
    window.addEventListener('pagehide', settle);
    return () => {
      window.removeEventListener('pagehide', settle);
      settle();
    };
  }, []);
  const remove = (id: number, etag: string) => {
    settle();
    go(addressOf('sessions'), true); // Back must not lead to a deleted session
    pending.current = { id, etag, timer: window.setTimeout(settle, undoDelete_ms) };
    setLeaving(id);
  };
  const keep = () => {
    if (pending.current !== null) window.clearTimeout(pending.current.timer);
    pending.current = null;
    setLeaving(null);
  };

  const next = list?.page.next ?? null;
  const shown = (list?.page.items ?? []).filter((item) => item.id !== leaving && !gone.includes(item.id));
  return (
    <div class={chosen === null ? 'sessions' : 'sessions one'}>
      <section class="card session-list">
        <input
          type="search"
          class="search"
          placeholder={`${t('sessions.search')}: ${t('sessions.subject')}`}
          aria-label={`${t('sessions.search')}: ${t('sessions.subject')}`}
          value={search}
          onInput={(event) => setSearch(event.currentTarget.value)}
        />
        {leaving !== null ? (
          <div class="undo" role="status">
            <span>{t('sessions.deleting', { n: leaving })}</span>
            <button type="button" class="quiet" onClick={keep}>
              {t('common.undo')}
            </button>
          </div>
        ) : null}
        {problem !== null ? (
          <p class="tune-error" role="alert">
            {problemText(problem)}{' '}
            <button type="button" class="quiet" onClick={again}>
              {t('common.retry')}
            </button>
          </p>
        ) : null}
        {list === null && problem === null ? <p class="hint">{t('common.loading')}</p> : null}
        {list !== null && shown.length === 0 ? <p class="hint">{t(list.sought === '' ? 'sessions.empty' : 'sessions.none')}</p> : null}
        <ul>
          {shown.map((item) => (
            <li key={item.id}>
              <button type="button" class="session-item" aria-current={item.id === chosen} onClick={() => go(addressOf('sessions', item.id))}>
                <strong>{date(item.started_utc_ms)}</strong>
                <span class="num">{item.recording ? t('sessions.running') : duration(item.duration_s)}</span>
                <span>
                  {walkName(item, titleOf)}
                  {item.subject ? ` · ${item.subject}` : ''}
                </span>
                {item.study !== null ? (
                  <small>{t('sessions.study', { n: item.study.study, subject: item.study.subject, run: item.study.run })}</small>
                ) : (
                  <small>{item.simulated ? t('sessions.simulated') : ''}</small>
                )}
              </button>
            </li>
          ))}
        </ul>
        {next !== null ? (
          <button type="button" class="plain" disabled={waits} onClick={() => void older()}>
            {t('sessions.next')}
          </button>
        ) : null}
      </section>
      {chosen === null ? (
        <section class="card session-none">
          <p class="hint">{t('sessions.choose')}</p>
          {role === 'viewer' ? null : <ExportMany />}
        </section>
      ) : (
        <Detail key={chosen} id={chosen} onDelete={(etag) => remove(chosen, etag)} onChange={again} />
      )}
    </div>
  );
}

/** Charts are drawn by a library that is larger than the rest of this screen. */
const chart = new Lazy(async () => (await import('./chart')).Chart);

function Detail({ id, onDelete, onChange }: { id: number; onDelete: (etag: string) => void; onChange: () => void }) {
  const { may } = useReadiness();
  const titleOf = useTaskTitles();
  const [error, setError] = useState<string | null>(null);
  const [names, setNames] = useState<SignalName[]>(['speed_m_s', 'speed_command_m_s']);
  const drawn = useLazy(chart);
  const [shown, setShown] = useState(eventsFirst);
  // Right after its end a session is still being closed: it is loaded again when the recording is over.
  const recorded = useStore((s) => s.recording.state === 'recording' && s.recording.session === id);
  const asked = useQuery(() => rest('GET /api/v1/sessions/{id}', { path: { id } }), [id, recorded]);
  const [changed, setChanged] = useState<Session | null>(null); // as the server answered to the last change
  const session = changed ?? asked.value;
  useEffect(() => setChanged(null), [asked.value]);
  const metrics = useQuery(() => rest('GET /api/v1/sessions/{id}/metrics', { path: { id } }), [id, recorded]);
  const path = useQuery(async () => {
    const from = (columns: string) => samplesOf(id, columns, pathRuns);
    const fused = await from('fused_x_m,fused_y_m');
    // Sessions from before the slip-repaired track have the encoders' own only.
    return fused.ok || fused.problem.status !== unprocessable ? fused : from('x_m,y_m');
  }, [id, recorded]);
  const events = useQuery(() => wholeList((query) => rest('GET /api/v1/sessions/{id}/events', { path: { id }, query })), [id, recorded]);
  const markers = useQuery(() => wholeList((query) => rest('GET /api/v1/sessions/{id}/markers', { path: { id }, query })), [id, recorded]);
  const samples = useQuery(
    () => (names.length === 0 ? Promise.resolve<Answer<Samples | null>>({ ok: true, value: null }) : samplesOf(id, names.join(','), curveRuns)),
    [id, recorded, names],
  );

  const all: readonly Query<unknown>[] = [asked, metrics, path, events, markers, samples];
  const unread = all.find((one) => one.problem !== null)?.problem ?? null;
  const retry = () => all.filter((one) => one.problem !== null).forEach((one) => one.retry());
  /** Placeholder while loading or after an error; never the text for "no events". */
  const instead = (one: Query<unknown>) => t(one.problem === null ? 'common.loading' : 'sessions.unread');

  const happened = events.value !== null && markers.value !== null ? story(events.value.items, markers.value.items) : [];
  const toggle = (name: SignalName) =>
    setNames((before) => (before.includes(name) ? before.filter((item) => item !== name) : [...before, name].slice(-curvesMost)));
  const here = useRef(true);
  useEffect(() => () => void (here.current = false), []);
  // One after the other: each is made for what the one before has left.
  const saving = useRef<Promise<unknown>>(Promise.resolve());
  const tag = useRef('');
  useEffect(() => void (tag.current = session?.etag ?? ''), [session]);
  const save = (change: SessionPatch): Promise<boolean> => {
    const saved = saving.current.then(() => saveNow(change));
    saving.current = saved;
    return saved;
  };
  const saveNow = async (change: SessionPatch): Promise<boolean> => {
    const answer = await rest('PATCH /api/v1/sessions/{id}', { path: { id }, body: change, etag: tag.current });
    if (answer.ok) {
      tag.current = answer.value.etag;
      setChanged(answer.value);
      setError(null);
      notify('info', t('sessions.saved'), true);
      onChange();
    } else if (here.current) {
      setError(problemText(answer.problem));
      // What was changed meanwhile is shown beside what was typed.
      if (answer.problem.status === outdated) asked.retry();
    } else notify('error', `${t('sessions.notSaved')} ${problemText(answer.problem)}`, true);
    return answer.ok;
  };

  // An old address, or a session deleted on another screen: nothing to export, read or retry.
  if (session === null && asked.problem?.status === notFound)
    return (
      <div class="session-detail">
        <section class="card">
          <p class="hint" role="alert">
            {problemText(asked.problem)} <a href={addressOf('sessions')}>{t('sessions.back')}</a>
          </p>
        </section>
      </div>
    );

  return (
    <div class="session-detail">
      <section class="card">
        <div class="session-head">
          <a class="quiet only-narrow" href={addressOf('sessions')}>
            ‹ {t('sessions.back')}
          </a>
          <h2>{session === null ? t('sessions.one', { n: id }) : `${date(session.started_utc_ms)} · ${walkName(session, titleOf)}`}</h2>
          <Export id={id} />
          {session?.recording === false ? <Reports id={id} /> : null}
          <button type="button" class="plain last" disabled={session?.recording !== false || !may} onClick={() => onDelete(session!.etag)}>
            {t('sessions.delete')}
          </button>
        </div>
        <WatchOnly />
        {error !== null ? (
          <p class="tune-error" role="alert">
            {t('sessions.notSaved')} {error}
          </p>
        ) : null}
        {unread !== null ? (
          <p class="tune-error" role="alert">
            {problemText(unread)}{' '}
            <button type="button" class="quiet" onClick={retry}>
              {t('common.retry')}
            </button>
          </p>
        ) : null}
        {session?.study ? (
          <p class="hint">
            <a href={addressOf('study', session.study.study)}>
              {t('sessions.study', { n: session.study.study, subject: session.study.subject, run: session.study.run })}
            </a>
          </p>
        ) : null}
        <Figures metrics={metrics.value} />
        {session !== null ? (
          <div class="session-texts">
            <TextField
              label={t('sessions.subject')}
              hint={t('sessions.subjectHint')}
              value={session.subject ?? ''}
              most={subjectMost}
              disabled={!may}
              onSave={(subject) => save({ subject: subject === '' ? null : subject })}
            />
            <TextField label={t('sessions.note')} value={session.note} most={noteMost} disabled={!may} onSave={(note) => save({ note })} />
          </div>
        ) : null}
      </section>
      <div class="session-pictures">
        <section class="card">
          <h2>{t('sessions.path')}</h2>
          {path.value === null ? (
            <p class="floor small hint">{instead(path)}</p>
          ) : (
            <PathPicture samples={path.value} exercise={session?.exercise ?? null} />
          )}
        </section>
        <section class="card">
          <h2>{t('sessions.curves')}</h2>
          {drawn.state === 'failed' ? (
            <LoadFailed />
          ) : drawn.state === 'ready' && samples.value !== null && samples.problem === null ? (
            <drawn.value samples={samples.value} names={names} />
          ) : (
            <p class="chart hint">{names.length === 0 ? '' : instead(samples)}</p>
          )}
          <div class="columns" role="group" aria-label={t('sessions.columns')}>
            {curves.map(({ name, title }) => (
              <button key={name} type="button" class="pill" aria-pressed={names.includes(name)} onClick={() => toggle(name)}>
                {words(title)}
              </button>
            ))}
          </div>
        </section>
      </div>
      <Markers session={id} asked={markers} />
      <section class="card">
        <h2>{t('sessions.events')}</h2>
        {events.value === null || markers.value === null ? (
          <p class="hint">{instead(events.value === null ? events : markers)}</p>
        ) : happened.length === 0 ? (
          <p class="hint">{t('sessions.eventsNone')}</p>
        ) : null}
        <Scroll class="events" label={t('sessions.events')}>
          <ul>
            {happened.slice(0, shown).map((event, index) => (
              <li key={index}>
                <span class="num">{duration(event.time_s)}</span> {eventText(event.kind, event.name, event.value, event.before, event.code)}
              </li>
            ))}
          </ul>
        </Scroll>
        {happened.length > shown ? (
          <button type="button" class="quiet" onClick={() => setShown(Infinity)}>
            {t('sessions.eventsAll', { n: happened.length })}
          </button>
        ) : null}
      </section>
    </div>
  );
}

/** The session as a file, in one of the contract's formats. In German, German spreadsheets come first. */
function Export({ id }: { id: number }) {
  const { language } = useSettings();
  const [chosen, setChosen] = useState<ExportFormat | null>(null);
  const format = chosen ?? (language === 'de' ? 'csv_de' : 'csv');
  return (
    <div class="session-export">
      <select aria-label={t('sessions.format')} value={format} onChange={(event) => setChosen(event.currentTarget.value as ExportFormat)}>
        {exportFormats.map(({ name, title }) => (
          <option key={name} value={name}>
            {words(title)}
          </option>
        ))}
      </select>
      <a class="plain" href={address('GET /api/v1/sessions/{id}/export', { path: { id }, query: { format } })} download>
        {t('sessions.export')}
      </a>
    </div>
  );
}

/** The session on paper: pages of the server, which the browser prints. */
function Reports({ id }: { id: number }) {
  const { language } = useSettings();
  const page = (kind: 'patient' | 'full') => address('GET /api/v1/sessions/{id}/report', { path: { id }, query: { kind, language } });
  return (
    <div class="session-export">
      <a class="plain" href={page('patient')} target="_blank" rel="noopener">
        {t('sessions.sheet')}
      </a>
      <a class="plain" href={page('full')} target="_blank" rel="noopener">
        {t('sessions.report')}
      </a>
    </div>
  );
}

function Figure({ label, value, help, symbol }: { label: string; value: string; help?: string; symbol?: string }) {
  return (
    <div class="reading" title={help}>
      <span class="reading-label">
        {label}
        {symbol ? <small> {symbol}</small> : null}
      </span>
      <span class="reading-value num">{value}</span>
      {help ? <span class="reading-help">{help}</span> : null}
    </div>
  );
}

function Figures({ metrics }: { metrics: Metrics | null }) {
  const m = metrics;
  return (
    <>
      <div class="readings figures">
        <Figure label={t('metric.turning')} symbol="C" value={fixed(m?.C, 2)} help={t('metric.turningHelp')} />
        <Figure label={t('metric.accuracy')} symbol="J" value={fixed(m?.J_N, 1)} help={t('metric.accuracyHelp')} />
        <Figure label={t('metric.duration')} value={duration(m?.motion_s)} />
        <Figure label={t('metric.underWay')} value={duration(m?.under_way_s)} />
        <Figure label={t('metric.distance')} value={`${fixed(m?.walked_m, 1)} m`} />
        <Figure label={t('metric.speed')} value={`${fixed(m?.mean_speed_m_s, 2)} m/s`} />
        <Figure label={t('metric.offPath')} value={`${fixed(m?.rms_position_m == null ? null : m.rms_position_m * 100, 0)} cm`} />
        <Figure label={t('metric.offHeading')} value={degrees(m?.rms_heading_rad, 0)} />
      </div>
      {m && m.missing_s > 0 ? <p class="hint">{t('metric.missing', { s: fixed(m.missing_s, m.missing_s < 10 ? 1 : 0) })}</p> : null}
      {m ? <p class="hint">{t(m.track === 'fused' ? 'metric.trackFused' : 'metric.trackEncoders')}</p> : null}
      {m?.reason_code ? (
        <p class="hint">
          {t('metric.none')}
          {((why) => (why === null ? '.' : `: ${why}`))(reasonText(m.reason_code))}
        </p>
      ) : null}
      {m ? <AllFigures metrics={m} /> : null}
    </>
  );
}

function PathPicture({ samples, exercise }: { samples: Samples | null; exercise: Exercise | null }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const { theme } = useSettings();
  useEffect(() => {
    const draw = () => {
      if (canvas.current === null) return;
      const pattern = exercise === null ? [] : patternPoints(exercise);
      const poles = exercise === null ? [] : polesOf(exercise);
      const { x, y } = samples === null ? { x: [], y: [] } : pathOf(samples);
      const points: Point[] = [...pattern, ...x.map((value, i) => ({ x: value, y: y[i]! }))];
      drawFloor(canvas.current, { pattern, poles, x, y, pose: null }, fit(points, canvas.current.clientWidth, canvas.current.clientHeight));
    };
    draw();
    const watch = new ResizeObserver(draw);
    if (canvas.current !== null) watch.observe(canvas.current);
    const dark = matchMedia('(prefers-color-scheme: dark)');
    dark.addEventListener('change', draw);
    return () => {
      watch.disconnect();
      dark.removeEventListener('change', draw);
    };
  }, [samples, exercise, theme]);
  return <canvas ref={canvas} class="floor small" role="img" aria-label={t('floor.label')} />;
}
