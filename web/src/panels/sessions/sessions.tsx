// Recorded sessions: the list, and one session with its figures, path, course, note and export.
import type { ComponentType } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';
import { signals, type SignalName } from '../../contract/signals.gen';
import { notify } from '../../link/console';
import { rest, type Problem } from '../../link/rest';
import type { Exercise } from '../../contract/messages.gen';
import { useStore } from '../../link/store';
import { useSettings } from '../../text/settings';
import { date, degrees, duration, fixed, refusalText, t, words } from '../../text/text';
import { fit, patternPoints, type Point } from '../../ui/geometry';
import { drawFloor } from '../../ui/floor_view';
import { eventText } from '../health/health';
import type { Panel } from '../panel';
import { curveChoices, pathOf, story, type Metrics, type Samples, type Session, type SessionEvents, type SessionPage } from './model';

/** A deleted session can be taken back this long; only then is the server asked. */
const undoDelete_ms = 6000;
const pathRuns = 2000;
const curveRuns = 800;
const curvesMost = 4;
const pageSize = 50;
const eventsShown = 200;

const problemText = (problem: Problem) => (problem.refusals.length > 0 ? problem.refusals.map(refusalText).join(' ') : problem.detail || t('sessions.failed'));

function exerciseName(exercise: Exercise | null): string {
  return exercise === null ? t('exercise.free') : t(`exercise.${exercise.shape}`);
}

function SessionsView() {
  useSettings();
  const [items, setItems] = useState<Session[] | null>(null);
  const [next, setNext] = useState<string | null>(null);
  const [search, setSearch] = useState('');
  const [chosen, setChosen] = useState<number | null>(null);
  const [error, setError] = useState<string | null>(null);
  const [leaving, setLeaving] = useState<{ id: number; timer: number } | null>(null);
  const recording = useStore((s) => s.recording.state + String(s.recording.session));

  const load = async (cursor: string | null) => {
    const query = new URLSearchParams({ limit: String(pageSize) });
    if (cursor !== null) query.set('cursor', cursor);
    if (search.trim() !== '') query.set('q', search.trim());
    const answer = await rest<SessionPage>('GET', `/sessions?${query.toString()}`);
    if (!answer.ok) {
      setError(problemText(answer.problem));
      return;
    }
    setError(null);
    setItems((before) => (cursor === null ? answer.value.items : [...(before ?? []), ...answer.value.items]));
    setNext(answer.value.next ?? null);
  };
  useEffect(() => {
    const timer = window.setTimeout(() => void load(null), search === '' ? 0 : 250);
    return () => window.clearTimeout(timer);
  }, [search, recording]);

  // Leaving the page means that the deletion stands: the undo was there to be tapped.
  const pending = useRef<{ id: number; timer: number } | null>(null);
  pending.current = leaving;
  useEffect(() => () => void (pending.current !== null && (window.clearTimeout(pending.current.timer), rest('DELETE', `/sessions/${pending.current.id}`))), []);

  const remove = (id: number) => {
    if (leaving !== null) return;
    setChosen(null);
    const timer = window.setTimeout(() => {
      setLeaving(null);
      void rest('DELETE', `/sessions/${id}`).then((answer) => {
        if (answer.ok) notify('info', t('sessions.deleted', { n: id }), true);
        else setError(problemText(answer.problem));
        void load(null);
      });
    }, undoDelete_ms);
    setLeaving({ id, timer });
  };
  const keep = () => {
    if (leaving !== null) window.clearTimeout(leaving.timer);
    setLeaving(null);
  };

  const shown = (items ?? []).filter((item) => item.id !== leaving?.id);
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
            <span>{t('sessions.deleting', { n: leaving.id })}</span>
            <button type="button" class="quiet" onClick={keep}>
              {t('common.undo')}
            </button>
          </div>
        ) : null}
        {error !== null ? (
          <p class="tune-error" role="alert">
            {error}{' '}
            <button type="button" class="quiet" onClick={() => void load(null)}>
              {t('common.retry')}
            </button>
          </p>
        ) : null}
        {items === null && error === null ? <p class="hint">{t('common.loading')}</p> : null}
        {items !== null && shown.length === 0 ? <p class="hint">{t(search === '' ? 'sessions.empty' : 'sessions.none')}</p> : null}
        <ul>
          {shown.map((item) => (
            <li key={item.id}>
              <button type="button" class="session-item" aria-current={item.id === chosen} onClick={() => setChosen(item.id)}>
                <strong>{date(item.started_utc_ms)}</strong>
                <span class="num">{item.recording ? t('sessions.running') : duration(item.duration_s)}</span>
                <span>
                  {exerciseName(item.exercise)}
                  {item.subject ? ` · ${item.subject}` : ''}
                </span>
                {item.simulated ? <small>{t('sessions.simulated')}</small> : <small />}
              </button>
            </li>
          ))}
        </ul>
        {next !== null ? (
          <button type="button" class="plain" onClick={() => void load(next)}>
            {t('sessions.next')}
          </button>
        ) : null}
      </section>
      {chosen === null ? (
        <section class="card session-none">
          <p class="hint">{t('sessions.choose')}</p>
        </section>
      ) : (
        <Detail key={chosen} id={chosen} onBack={() => setChosen(null)} onDelete={() => remove(chosen)} onChange={() => void load(null)} />
      )}
    </div>
  );
}

type ChartType = ComponentType<{ samples: Samples; names: readonly SignalName[] }>;

function Detail({ id, onBack, onDelete, onChange }: { id: number; onBack: () => void; onDelete: () => void; onChange: () => void }) {
  const [session, setSession] = useState<Session | null>(null);
  const [metrics, setMetrics] = useState<Metrics | null>(null);
  const [path, setPath] = useState<Samples | null>(null);
  const [samples, setSamples] = useState<Samples | null>(null);
  const [events, setEvents] = useState<SessionEvents | null>(null);
  const [error, setError] = useState<string | null>(null);
  const [names, setNames] = useState<SignalName[]>(['speed_m_s', 'speed_command_m_s']);
  const [ChartView, setChartView] = useState<ChartType | null>(null);

  useEffect(() => {
    void rest<Session>('GET', `/sessions/${id}`).then((answer) => (answer.ok ? setSession(answer.value) : setError(problemText(answer.problem))));
    void rest<Metrics>('GET', `/sessions/${id}/metrics`).then((answer) => answer.ok && setMetrics(answer.value));
    // Sessions from before the slip-repaired track have the encoders' own only.
    const pathFrom = (columns: string) => rest<Samples>('GET', `/sessions/${id}/samples?columns=${columns}&points=${pathRuns}`);
    void pathFrom('fused_x_m,fused_y_m').then(async (fused) => {
      const answer = fused.ok ? fused : await pathFrom('x_m,y_m');
      if (answer.ok) setPath(answer.value);
    });
    void rest<SessionEvents>('GET', `/sessions/${id}/events`).then((answer) => answer.ok && setEvents(answer.value));
    void import('./chart').then((module) => setChartView(() => module.Chart));
  }, [id]);
  useEffect(() => {
    if (names.length === 0) {
      setSamples(null);
      return;
    }
    let wanted = true; // an answer that is overtaken by another choice of curves is of no use
    void rest<Samples>('GET', `/sessions/${id}/samples?columns=${names.join(',')}&points=${curveRuns}`).then((answer) => wanted && answer.ok && setSamples(answer.value));
    return () => {
      wanted = false;
    };
  }, [id, names]);

  const happened = events !== null && session !== null ? story(events, session.started_utc_ms) : [];
  const toggle = (name: SignalName) =>
    setNames((before) => (before.includes(name) ? before.filter((item) => item !== name) : [...before, name].slice(-curvesMost)));
  const save = async (change: Partial<Pick<Session, 'note' | 'subject'>>) => {
    const answer = await rest<Session>('PATCH', `/sessions/${id}`, change);
    if (answer.ok) {
      setSession(answer.value);
      setError(null);
      notify('info', t('sessions.saved'), true);
      onChange();
    } else setError(problemText(answer.problem));
  };

  return (
    <div class="session-detail">
      <section class="card">
        <div class="session-head">
          <button type="button" class="quiet only-narrow" onClick={onBack}>
            ‹ {t('sessions.back')}
          </button>
          <h2>{session === null ? t('sessions.one', { n: id }) : `${date(session.started_utc_ms)} · ${exerciseName(session.exercise)}`}</h2>
          <a class="plain" href={`/api/v1/sessions/${id}/export?format=csv`} download>
            {t('sessions.csv')}
          </a>
          <a class="plain" href={`/api/v1/sessions/${id}/export?format=json`} download>
            {t('sessions.json')}
          </a>
          <button type="button" class="plain last" disabled={session?.recording !== false} onClick={onDelete}>
            {t('sessions.delete')}
          </button>
        </div>
        {error !== null ? (
          <p class="tune-error" role="alert">
            {error}
          </p>
        ) : null}
        <Figures metrics={metrics} />
        {session !== null ? (
          <div class="session-texts">
            <TextField label={t('sessions.subject')} hint={t('sessions.subjectHint')} value={session.subject ?? ''} onSave={(subject) => void save({ subject: subject === '' ? null : subject })} />
            <TextField label={t('sessions.note')} value={session.note} onSave={(note) => void save({ note })} />
          </div>
        ) : null}
      </section>
      <div class="session-pictures">
        <section class="card">
          <h2>{t('sessions.path')}</h2>
          <PathPicture samples={path} exercise={session?.exercise ?? null} />
        </section>
        <section class="card">
          <h2>{t('sessions.curves')}</h2>
          {ChartView !== null && samples !== null ? <ChartView samples={samples} names={names} /> : <div class="chart" />}
          <div class="columns" role="group" aria-label={t('sessions.columns')}>
            {curveChoices.map((name) => (
              <button key={name} type="button" class="pill" aria-pressed={names.includes(name)} onClick={() => toggle(name)}>
                {words(signals.find((signal) => signal.name === name)!.title)}
              </button>
            ))}
          </div>
        </section>
      </div>
      <section class="card">
        <h2>{t('sessions.events')}</h2>
        {happened.length === 0 ? <p class="hint">{t('sessions.eventsNone')}</p> : null}
        <ul class="events">
          {happened
            .slice(0, eventsShown)
            .map((event, index) => (
              <li key={index}>
                <span class="num">{duration(event.time_s)}</span>{' '}
                {eventText(event.kind, event.name, event.value, event.before, event.code)}
              </li>
            ))}
        </ul>
      </section>
    </div>
  );
}

function TextField({ label, hint, value, onSave }: { label: string; hint?: string; value: string; onSave: (text: string) => void }) {
  const [draft, setDraft] = useState(value);
  const changed = draft !== value;
  return (
    <label class="text-field">
      <span>
        {label}
        {hint ? <small> · {hint}</small> : null}
      </span>
      <span class="text-field-row">
        <input type="text" value={draft} maxLength={500} onInput={(event) => setDraft(event.currentTarget.value)} onKeyDown={(event) => event.key === 'Enter' && changed && onSave(draft)} />
        <button type="button" class="plain" disabled={!changed} onClick={() => onSave(draft)}>
          {t('common.save')}
        </button>
      </span>
    </label>
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
        <Figure label={t('metric.similarity')} symbol="C" value={fixed(m?.C, 2)} help={t('metric.similarityHelp')} />
        <Figure label={t('metric.accuracy')} symbol="J" value={fixed(m?.J_N, 1)} help={t('metric.accuracyHelp')} />
        <Figure label={t('metric.duration')} value={duration(m?.duration_s)} />
        <Figure label={t('metric.distance')} value={`${fixed(m?.distance_m, 1)} m`} />
        <Figure label={t('metric.speed')} value={`${fixed(m?.mean_speed_m_s, 2)} m/s`} />
        <Figure label={t('metric.offPath')} value={`${fixed(m?.rms_position_m == null ? null : m.rms_position_m * 100, 0)} cm`} />
        <Figure label={t('metric.offHeading')} value={degrees(m?.rms_heading_rad, 0)} />
      </div>
      {m ? <p class="hint">{t(m.track === 'fused' ? 'metric.trackFused' : 'metric.trackEncoders')}</p> : null}
      {m?.reason_if_none ? <p class="hint">{t('metric.none')}: {m.reason_if_none}</p> : null}
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
      const { x, y } = samples === null ? { x: [], y: [] } : pathOf(samples);
      const points: Point[] = [...pattern, ...x.map((value, i) => ({ x: value, y: y[i]! }))];
      drawFloor(canvas.current, { pattern, x, y, pose: null }, fit(points, canvas.current.clientWidth, canvas.current.clientHeight));
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

export const sessionsPanel: Panel = { id: 'sessions', title: 'nav.sessions', icon: 'sessions', live: false, View: SessionsView };
