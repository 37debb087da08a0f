// Calibration step by step: what to do now, whether the hoist is at rest, the result, and old beside new values.
import { useEffect, useState } from 'preact/hooks';
import { params } from '../../contract/params.gen';
import type { Calibration, CalibrationItem, CalibrationMeasure, CalibrationState } from '../../contract/rest.gen';
import { calibrate, calibrateCancel, calibrateMeasure, calibrateUse, notify } from '../../link/console';
import { useQuery } from '../../link/query';
import { useReading } from '../../link/live';
import { rest, type Answer } from '../../link/rest';
import type { Reply } from '../../link/socket';
import { useReadiness } from '../../link/readiness';
import { useStore } from '../../link/store';
import type { TextKey } from '../../text/en';
import { useSettings } from '../../text/settings';
import { date, fixed, noValue, shownAs, t, words, withUnit } from '../../text/text';
import { HoldButton } from '../../ui/hold_button';
import { bringIntoView, Refusal, useRequest, WatchOnly } from '../../ui/refusal';
import { radioKeys } from '../../ui/radio_keys';
import { addressOf, go } from '../../router';
import type { PanelProps } from '../panel';
import { directed, entry, nowKey, phaseNames, resultOf, stepNames, stepsFor, watched, type Now, type StepName } from './model';
import { StepPicture } from './picture';
import './calibrate.css';

const confirmHold_ms = 2000;

/** Starts a step; where the harness must be empty, only after a confirming hold. */
function Begin({
  item,
  label,
  disabled,
  begin,
}: {
  item: CalibrationItem;
  label: string;
  disabled: boolean;
  begin: (harness_empty: boolean) => void;
}) {
  if (item.empty_harness)
    return (
      <HoldButton
        label={t('calibrate.emptyHold')}
        hint={t('calibrate.emptyHint')}
        hold_ms={confirmHold_ms}
        disabled={disabled}
        onDone={() => begin(true)}
      />
    );
  return (
    <button type="button" class="primary big" disabled={disabled} onClick={() => begin(false)}>
      {label}
    </button>
  );
}

/** Live values show a request at most this much later; until then buttons would repeat it. */
const settle_ms = 500;

const unitText = (unit: string): string => (unit === 'turns' ? t('calibrate.turns') : unit);

function Changes({ list }: { list: CalibrationState['result'] }) {
  if (list.length === 0) return <p>{t('calibrate.checked')}</p>;
  return (
    <table class="calibrate-changes num">
      <thead>
        <tr>
          <th />
          <th>{t('calibrate.old')}</th>
          <th>{t('calibrate.new')}</th>
        </tr>
      </thead>
      <tbody>
        {list.map((change) => {
          const row = params.find((one) => one.name === change.name);
          if (row === undefined) return null;
          const show = shownAs(row.name, row.unit);
          const decimals = row.unit.startsWith('rad') ? 2 : 4;
          return (
            <tr key={change.name}>
              <th scope="row">{words(row.title)}</th>
              <td>{withUnit(fixed(change.before * show.factor, decimals), show.unit)}</td>
              <td>
                <strong>{withUnit(fixed(change.value * show.factor, decimals), show.unit)}</strong>
              </td>
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}

/** One length or angle entered by the operator. */
function Measure(field: { label: string; name: string; unit: string; value: string; onValue: (value: string) => void }) {
  return (
    <label>
      <span>{field.label}</span>
      <span class="calibrate-field">
        <input
          name={field.name}
          type="text"
          inputMode="decimal"
          autocomplete="off"
          class="num"
          value={field.value}
          onInput={(event) => field.onValue(event.currentTarget.value)}
        />
        <span>{field.unit}</span>
      </span>
    </label>
  );
}

/** A choice of two directions, so that no minus sign is needed: the number keys of a phone have none. */
function Direction({
  label,
  names,
  value,
  onValue,
}: {
  label: string;
  names: readonly [TextKey, TextKey];
  value: boolean;
  onValue: (reversed: boolean) => void;
}) {
  return (
    <div class="choice" role="radiogroup" aria-label={label} onKeyDown={radioKeys}>
      {names.map((name, i) => (
        <button key={name} type="button" role="radio" aria-checked={value === (i === 1)} onClick={() => onValue(i === 1)}>
          {t(name)}
        </button>
      ))}
    </div>
  );
}

interface Off {
  text: string;
  reversed: boolean;
}
const nothing: Off = { text: '', reversed: false };

/** How far off the shown place a square ended, along one axis. */
function OffPlace({
  name,
  names,
  labels,
  off,
  onOff,
}: {
  name: string;
  names: readonly [TextKey, TextKey];
  labels: readonly [TextKey, TextKey];
  off: Off;
  onOff: (off: Off) => void;
}) {
  const label = t(labels[off.reversed ? 1 : 0]);
  return (
    <div class="calibrate-off">
      <Measure label={label} name={name} unit="cm" value={off.text} onValue={(text) => onOff({ ...off, text })} />
      <Direction label={label} names={names} value={off.reversed} onValue={(reversed) => onOff({ ...off, reversed })} />
    </div>
  );
}

/** Input of a measured value. */
function Entry({
  step,
  second,
  busy,
  onMeasure,
}: {
  step: StepName;
  second: boolean;
  busy: boolean;
  onMeasure: (message: CalibrationMeasure) => Promise<boolean>;
}) {
  const [figure, setFigure] = useState('');
  const [x, setX] = useState(nothing);
  const [y, setY] = useState(nothing);
  const [back, setBack] = useState(second);
  useEffect(() => setBack(second), [second]);
  const { factor, unit } = entry(step);
  const square = step === 'square';
  const measured = directed(figure, back);
  const [x_cm, y_cm] = [x, y].map(({ text, reversed }) => directed(text, reversed)) as [number, number];
  const unclear = [figure, x.text, y.text].some((text, i) => text.trim() !== '' && Number.isNaN([measured, x_cm, y_cm][i]));
  const ready = (square ? [measured, x_cm, y_cm] : [measured]).every((value) => Number.isFinite(value)) && measured !== 0;
  const turns = step === 'strut_spacing' || step === 'track' || square;
  const send = async () => {
    const message: CalibrationMeasure = square
      ? { figure: Math.abs(measured), x_m: x_cm / 100, y_m: y_cm / 100, turning: back ? 'right' : 'left' }
      : { figure: measured * factor };
    if (!(await onMeasure(message))) return;
    // The next measurement has another distance, which must be entered again.
    setFigure('');
    setX(nothing);
    setY(nothing);
  };
  return (
    <form
      class="calibrate-entry"
      onSubmit={(event) => {
        event.preventDefault();
        if (ready && !busy) void send();
      }}
    >
      <Direction
        label={t('calibrate.direction')}
        names={turns ? ['calibrate.left', 'calibrate.right'] : ['calibrate.forward', 'calibrate.backward']}
        value={back}
        onValue={setBack}
      />
      <Measure label={t(square ? 'calibrate.side' : 'calibrate.measured')} name="figure" unit={unitText(unit)} value={figure} onValue={setFigure} />
      {square ? (
        <>
          <OffPlace name="x" names={['calibrate.front', 'calibrate.rear']} labels={['calibrate.ahead', 'calibrate.behind']} off={x} onOff={setX} />
          <OffPlace name="y" names={['calibrate.left', 'calibrate.right']} labels={['calibrate.leftOf', 'calibrate.rightOf']} off={y} onOff={setY} />
        </>
      ) : null}
      <button type="submit" class="primary big" disabled={!ready || busy}>
        {t('calibrate.measure')}
      </button>
      {unclear ? (
        <p ref={bringIntoView} class="form-error" role="alert">
          {t('tune.number')}
        </p>
      ) : null}
    </form>
  );
}

function Guide({
  item,
  now,
  table,
  simulated,
  connected,
}: {
  item: CalibrationItem;
  now: Now | null;
  table: Calibration;
  simulated: boolean;
  connected: boolean;
}) {
  const { standby, known, lead, may } = useReadiness();
  const silent = !known;
  const request = useRequest();
  const [settling, setSettling] = useState(false);
  // A step belongs to the screen that leads it; taking over would end it.
  const theirs = now !== null && lead !== 'mine';
  const busy = request.busy || settling || !may || theirs;
  const ask = async (what: () => Promise<Reply>): Promise<boolean> => {
    const done = await request.ask(what);
    if (done) {
      setSettling(true);
      window.setTimeout(() => setSettling(false), settle_ms);
    }
    return done;
  };
  const step = item.name;
  const running = now !== null && now.step === step;
  const phase = running ? now.phase : 'none';
  useEffect(request.forget, [step]);
  // Each measurement changes the result, also that of a step that has one already.
  const [measures, setMeasures] = useState(0);
  const read = async (): Promise<Answer<{ after: number; table: Calibration }>> => {
    const answer = await rest('GET /api/v1/calibration');
    return answer.ok ? { ok: true, value: { after: measures, table: answer.value } } : answer;
  };
  const found = useQuery(phase === 'result' && connected ? read : null, [step, measures]);
  // Null until the values are on screen: a result can be used only after it has been shown.
  const changes = found.value === null || found.value.after !== measures ? null : resultOf(found.value.table, step);
  const failed = found.problem !== null || (found.value?.after === measures && changes === null);

  const use = async () => {
    if (await ask(calibrateUse)) notify('info', t('calibrate.used', { name: words(item.title) }), true);
  };
  const measure = async (message: CalibrationMeasure): Promise<boolean> => {
    const done = await ask(() => calibrateMeasure(message));
    if (done) setMeasures((n) => n + 1);
    return done;
  };
  const begin = (harness_empty: boolean) => void ask(() => calibrate(step, harness_empty));
  const key = running ? nowKey(now) : null;
  const reason = running && now.reason > 0 ? table.reasons[now.reason - 1] : undefined;
  const shown = running ? watched(now) : null;
  const still = phase === 'measuring' || phase === 'result';
  const second = running && now.done_percent >= 50;
  return (
    <section class="card calibrate-guide">
      <h2>{words(item.title)}</h2>
      <div class={changes !== null && changes.length > 2 ? 'calibrate-step short' : 'calibrate-step'}>
        <StepPicture step={step} part={running && (step === 'bumpers' || step === 'struts') && phase === 'operator' ? Math.round(now.value) : null} />
        <div class="calibrate-words">
          <p class="calibrate-action">{words(item.action)}</p>
          {running ? (
            <>
              {key !== null ? (
                <p class="calibrate-now" role="status" aria-live="polite">
                  {t(key)}
                </p>
              ) : null}
              {reason !== undefined ? (
                <p key={measures} ref={bringIntoView} class="calibrate-reason" role="alert">
                  {words(reason.text)}
                </p>
              ) : null}
              <div class="calibrate-live">
                {phase === 'resting' || phase === 'measuring' ? (
                  <span class={still || silent ? 'calibrate-still' : 'calibrate-still moving'}>
                    {t(silent ? 'health.unknown' : still ? 'calibrate.still' : 'calibrate.moving')}
                  </span>
                ) : null}
                {shown !== null && phase !== 'refused' ? (
                  <span class="num calibrate-value">
                    {silent ? noValue : fixed(shown.value, shown.decimals)} {unitText(shown.unit)}
                  </span>
                ) : null}
                <progress max={100} value={now.done_percent} aria-label={t('calibrate.progress')} />
              </div>
            </>
          ) : (
            <p class="hint">{item.done_utc_s === null ? t('calibrate.never') : t('calibrate.last', { date: date(item.done_utc_s * 1000) })}</p>
          )}
        </div>
      </div>
      {phase !== 'result' ? null : changes !== null ? (
        <Changes list={changes} />
      ) : failed ? (
        <Failed onRetry={found.retry} />
      ) : (
        <p>{t('common.loading')}</p>
      )}
      {running && item.entered !== null && (phase === 'operator' || phase === 'result') ? (
        <details open={phase === 'operator'} class="calibrate-more">
          <summary>{t(phase === 'operator' ? 'calibrate.enter' : 'calibrate.again')}</summary>
          <Entry step={step} second={second} busy={busy} onMeasure={measure} />
        </details>
      ) : null}
      <div class="calibrate-buttons">
        {!running ? <Begin item={item} label={t('calibrate.start')} disabled={busy || (!standby && now === null)} begin={begin} /> : null}
        {phase === 'result' ? (
          <button type="button" class="primary big" disabled={busy || changes === null} onClick={() => void use()}>
            {t(changes === null || changes.length > 0 ? 'calibrate.use' : 'calibrate.note')}
          </button>
        ) : null}
        {phase === 'refused' ? <Begin item={item} label={t('calibrate.repeat')} disabled={busy} begin={begin} /> : null}
        {running ? (
          <button type="button" class="plain big" disabled={busy} onClick={() => void ask(calibrateCancel)}>
            {t(phase === 'result' ? 'calibrate.keep' : 'calibrate.cancel')}
          </button>
        ) : null}
      </div>
      <WatchOnly />
      {theirs && connected ? <p class="hint">{t('calibrate.other')}</p> : null}
      <Refusal request={request} />
      {simulated && step === 'zero' && !running ? <p class="hint">{t('calibrate.simulated')}</p> : null}
    </section>
  );
}

function Failed({ onRetry }: { onRetry: () => void }) {
  return (
    <p class="tune-error" role="alert">
      {t('calibrate.failed')}{' '}
      <button type="button" class="quiet" onClick={onRetry}>
        {t('common.retry')}
      </button>
    </p>
  );
}

export function CalibrateView({ part }: PanelProps) {
  useSettings();
  const role = useStore((s) => s.role);
  const { reachable: connected } = useReadiness();
  const version = useStore((s) => s.parameterVersion);
  const simulated = useStore((s) => s.simulated);
  const text = useReading(
    'calibration',
    (r) =>
      r === null || r.calibration_step === 0
        ? ''
        : [r.calibration_step, r.calibration_phase, r.calibration_done_percent, r.calibration_reason, r.calibration_value].join(' '),
    5,
  );
  const { value: table, problem, retry } = useQuery(() => rest('GET /api/v1/calibration'), [connected, version]);
  if (table === null) return problem !== null ? <Failed onRetry={retry} /> : <p class="hint">{t('common.loading')}</p>;
  const [step = 0, phase = 0, done_percent = 0, reason = 0, value = 0] = text === '' ? [] : text.split(' ').map(Number);
  const now: Now | null = text === '' ? null : { step: stepNames[step] ?? 'none', phase: phaseNames[phase] ?? 'none', done_percent, reason, value };
  const items = stepsFor(table.items, role);
  const item = items.find((one) => one.name === (now?.step ?? part)) ?? items[0];
  return (
    <div class="calibrate">
      <ul class={now === null ? 'calibrate-list' : 'calibrate-list running'}>
        {items.map((one) => (
          <li key={one.name}>
            <button
              type="button"
              aria-current={one === item ? 'true' : undefined}
              disabled={now !== null && one !== item}
              onClick={() => go(addressOf('calibrate', one.name))}
            >
              <span>{words(one.title)}</span>
              <span class={one.done_utc_s === null ? 'calibrate-date never' : 'calibrate-date'}>
                {one.done_utc_s === null ? t('calibrate.never') : date(one.done_utc_s * 1000)}
              </span>
            </button>
          </li>
        ))}
      </ul>
      {item === undefined ? null : <Guide item={item} now={now} table={table} simulated={simulated} connected={connected} />}
    </div>
  );
}
