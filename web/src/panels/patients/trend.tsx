// How a patient's figures went over the sessions. Recordings of a simulated hoist are not among them.
import { useState } from 'preact/hooks';
import { metricGroups, metrics, type MetricInfo, type MetricKey } from '../../contract/metrics.gen';
import { useQuery } from '../../link/query';
import { rest } from '../../link/rest';
import { addressOf } from '../../router';
import { exerciseRow, exerciseTitle } from '../../text/exercise';
import { reasonText } from '../../text/server';
import { tasks as texts } from '../../text/tasks';
import { addTexts, dayText, duration, fixed, plain, t, withUnit, words } from '../../text/text';
import { ownPath } from '../../ui/own_line';
import { Trouble } from '../../ui/field';
import { useTaskTitles } from '../../ui/task_titles';
import { changeOf, pointsOf, runsOf, spanOf, walkedOf, type TrendChange, type TrendPoint, type Walked } from './trend_model';
import './trend.css';

addTexts(texts);

const sessionsMost = 50;
const askFor = (id: number, query: { limit: number; comparable_to?: number }) => rest('GET /api/v1/patients/{id}/trend', { path: { id }, query });

export function TrendCard({ patient, again }: { patient: number; again: string }) {
  const asked = useQuery(() => askFor(patient, { limit: sessionsMost }), [patient, again]);
  const [key, setKey] = useState<MetricKey>('walking_speed_m_s');
  const [chosen, setChosen] = useState<string | null>(null);
  const items = asked.value?.items ?? [];
  const titleOf = useTaskTitles();
  const kinds = walkedOf(items);
  const walked = chosen !== null && kinds.has(chosen) ? chosen : ([...kinds.keys()][0] ?? '');
  const figure = metrics.find((one) => one.key === key)!;
  // One page holds walks of all kinds; with more of them, those like the newest of the chosen kind are asked for, beside the first.
  const newest = asked.value?.next == null ? undefined : kinds.get(walked)?.session;
  const alike = useQuery(newest === undefined ? null : () => askFor(patient, { limit: sessionsMost - 1, comparable_to: newest }), [
    patient,
    again,
    newest,
  ]);
  const told = alike.value?.items[0]?.session === newest ? (alike.value ?? asked.value) : asked.value;
  const points = pointsOf([...(told?.items ?? []), ...(told?.firsts ?? [])], walked, key);
  const change = changeOf(told?.changes ?? [], walked, key);
  const left = asked.value?.simulated_left_out ?? 0;
  return (
    <section class="card trend">
      <h2>{t('trend.title')}</h2>
      <Trouble problem={asked.problem} retry={asked.retry} />
      {asked.value === null && asked.problem === null ? <p class="hint">{t('common.loading')}</p> : null}
      {asked.value !== null && items.length === 0 ? <p class="hint">{t('trend.none')}</p> : null}
      {items.length > 0 ? (
        <>
          <div class="trend-choice">
            <label class="field">
              <span>{t('trend.figure')}</span>
              <select value={key} onChange={(event) => setKey(event.currentTarget.value as MetricKey)}>
                {metricGroups.map((group) => (
                  <optgroup key={group.name} label={words(group.title)}>
                    {metrics
                      .filter((one) => one.group === group.name)
                      .map((one) => (
                        <option key={one.key} value={one.key}>
                          {words(one.title)}
                        </option>
                      ))}
                  </optgroup>
                ))}
              </select>
            </label>
            <label class="field">
              <span>{t('exercise.label')}</span>
              <select value={walked} onChange={(event) => setChosen(event.currentTarget.value)}>
                {[...kinds].map(([name, one]) => (
                  <option key={name} value={name}>
                    {walkedText(one, titleOf)}
                  </option>
                ))}
              </select>
            </label>
          </div>
          <Plot points={points} figure={figure} />
          <Change change={change} points={points} figure={figure} />
          <Learnt change={change} figure={figure} />
          <Gaps points={points} figure={figure} />
        </>
      ) : null}
      {left > 0 ? <p class="hint">{t(left === 1 ? 'trend.simulatedOne' : 'trend.simulated', { n: left })}</p> : null}
    </section>
  );
}

/** Of a task with a goal that is chosen. */
function goalTexts(ends: Walked['ends']): string[] {
  if (ends === null) return [];
  const { by, goal } = ends;
  if (by === 'time') return [`${duration(goal)} min`];
  if (by === 'back') return [withUnit(plain(goal), 'm')];
  return by === 'distance' && goal !== 1 ? [t('task.laps', { n: goal })] : [];
}

/** "Square, 3.2 m, left, 2 laps": the task or exercise with its sizes, direction and goal, since each is another one. */
export function walkedText({ exercise, task, ends, line }: Walked, titleOf: (task: string) => string): string {
  if (exercise?.shape === 'own')
    return [line ?? exerciseTitle('own'), withUnit(fixed(ownPath(exercise).length_m, 2), 'm'), ...goalTexts(ends)].join(', ');
  const sizes = Object.entries(exercise ?? {}).flatMap(([name, value]) =>
    name.endsWith('_m') && typeof value === 'number' && value > 0 ? [withUnit(plain(value), 'm')] : [],
  );
  const shape = exercise?.shape ?? 'free';
  const clockwise = exercise !== null && 'clockwise' in exercise && exercise.clockwise === true;
  // An eight begins with the right loop, every other figure turns left.
  const side = exerciseRow(shape).turned ? [t(clockwise === (shape === 'eight') ? 'guided.left' : 'guided.right')] : [];
  return [task === null ? exerciseTitle(shape) : titleOf(task), ...sizes, ...side, ...goalTexts(ends)].join(', ');
}

/** A value in the figure's screen unit, as everywhere. */
const textOf = ({ unit, factor, digits }: MetricInfo, value: number) => withUnit(fixed(value * factor, digits), unit);

const width = 440;
const height = 190;
const edge = { left: 48, right: 10, top: 10, bottom: 26 };

function Plot({ points, figure }: { points: readonly TrendPoint[]; figure: MetricInfo }) {
  const span = spanOf(points);
  if (span === null) return <p class="hint">{t('trend.noValue')}</p>;
  const inner = { width: width - edge.left - edge.right, height: height - edge.top - edge.bottom };
  const x = (i: number) => edge.left + (points.length === 1 ? inner.width / 2 : (i / (points.length - 1)) * inner.width);
  const y = (value: number) => edge.top + (1 - (value - span.low) / (span.high - span.low)) * inner.height;
  const values = points.flatMap(({ value }) => (value === null ? [] : [value]));
  const marks = [...new Set([Math.min(...values), Math.max(...values)])];
  return (
    <svg class="trend-plot" viewBox={`0 0 ${width} ${height}`} role="group" aria-label={t('trend.picture', { what: words(figure.title) })}>
      {marks.map((value) => (
        <g key={value}>
          <line class="trend-grid" x1={edge.left} x2={width - edge.right} y1={y(value)} y2={y(value)} />
          <text class="p-text" x={edge.left - 5} y={y(value) + 4} text-anchor="end">
            {fixed(value * figure.factor, figure.digits)}
          </text>
        </g>
      ))}
      {figure.unit === '' ? null : (
        <text class="p-text" x={edge.left - 5} y={height - 6} text-anchor="end">
          {figure.unit}
        </text>
      )}
      {runsOf(points).map((run) => (
        <polyline key={run[0]} class="trend-line" points={run.map((i) => `${x(i)},${y(points[i]!.value!)}`).join(' ')} />
      ))}
      {points.map(({ item, value }, i) => (
        <a
          key={item.session}
          href={addressOf('sessions', item.session)}
          aria-label={`${dayText(item.day)}: ${value === null ? t('trend.gap') : textOf(figure, value)}`}
        >
          {value === null ? (
            <path class="trend-gap" d={`M${x(i) - 4} ${height - edge.bottom - 4}l8 -8m0 8l-8 -8`} />
          ) : (
            <circle class="trend-point" cx={x(i)} cy={y(value)} r="4" />
          )}
          <rect class="trend-touch" x={x(i) - 12} y={edge.top} width="24" height={inner.height} />
        </a>
      ))}
      <text class="p-text" x={edge.left} y={height - 6}>
        {dayText(points[0]?.item.day)}
      </text>
      {points.length > 1 ? (
        <text class="p-text" x={width - edge.right} y={height - 6} text-anchor="end">
          {dayText(points.at(-1)?.item.day)}
        </text>
      ) : null}
    </svg>
  );
}

/** Newest value against the first one: an arrow only beyond the minimal detectable change, else why there is none. */
function Change({ change, points, figure }: { change: TrendChange | null; points: readonly TrendPoint[]; figure: MetricInfo }) {
  if (change === null) return null;
  const dayOf = (session: number) => dayText(points.find(({ item }) => item.session === session)?.item.day);
  const by = change.last - change.first;
  return (
    <div class="trend-change" role="status">
      {change.reason_code === null ? (
        <strong>
          <span aria-hidden="true">{by > 0 ? '↑' : '↓'}</span>{' '}
          {t(by > 0 ? 'trend.more' : 'trend.less', { by: textOf(figure, Math.abs(by)), day: dayOf(change.first_session) })}
        </strong>
      ) : (
        <span>
          {t('trend.noChange')} {reasonText(change.reason_code)}
        </span>
      )}
      {change.minimal_detectable_change === null ? null : (
        <small>
          {t('trend.minimal', { minimal: textOf(figure, change.minimal_detectable_change) })}{' '}
          {change.source === null || change.whom === null
            ? t('trend.ownRepeats', { n: change.repeats })
            : t('trend.published', { source: change.source, whom: words(change.whom) })}
        </small>
      )}
    </div>
  );
}

/** What practising does within a visit, and what is left of it at the next one (told only where the usual variation is known). */
function Learnt({ change, figure }: { change: TrendChange | null; figure: MetricInfo }) {
  if (change === null) return null;
  const { slope, reason_code: why } = change.learning;
  const kept = keptText(change.retention, figure);
  return (
    <div class="trend-change">
      {slope !== null && why === null ? (
        <strong>
          <span aria-hidden="true">{slope.middle > 0 ? '↑' : '↓'}</span>{' '}
          {t(slope.middle > 0 ? 'trend.slopeMore' : 'trend.slopeLess', { by: textOf(figure, Math.abs(slope.middle)) })}
        </strong>
      ) : (
        <span>
          {t('trend.noSlope')} {reasonText(why)}
        </span>
      )}
      {slope === null ? null : <small>{t('trend.slopeRange', { low: textOf(figure, slope.low), high: textOf(figure, slope.high) })}</small>}
      {kept === null ? null : <small>{kept}</small>}
    </div>
  );
}

function keptText(kept: TrendChange['retention'], figure: MetricInfo): string | null {
  if (kept === null || (kept.reason_code !== null && kept.reason_code !== 'within_noise')) return null;
  if (kept.reason_code === 'within_noise') return t('trend.kept');
  const by = kept.after - kept.before;
  return t(by > 0 ? 'trend.keptMore' : 'trend.keptLess', { by: textOf(figure, Math.abs(by)) });
}

/** Each session without this figure, and why. */
function Gaps({ points, figure }: { points: readonly TrendPoint[]; figure: MetricInfo }) {
  const gaps = points.filter(({ value }) => value === null);
  if (gaps.length === 0) return null;
  const why = ({ item }: TrendPoint) =>
    item.figures === null ? t('trend.unreadable') : (reasonText(item.reasons[figure.key] ?? null) ?? t('trend.undefined'));
  return (
    <>
      <h3>{t('trend.gaps')}</h3>
      <ul class="trend-gaps">
        {gaps.map((point) => (
          <li key={point.item.session}>
            <a href={addressOf('sessions', point.item.session)}>{dayText(point.item.day)}</a>: {why(point)}
          </li>
        ))}
      </ul>
    </>
  );
}
