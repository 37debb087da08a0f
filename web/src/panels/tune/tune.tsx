// Every setting of the table, explained in plain words. A change applies at once; a refusal is shown at the row.
import { useEffect, useRef, useState } from 'preact/hooks';
import { presets, type ParamInfo } from '../../contract/params.gen';
import { applyPreset, notify, setParameters, tryParameters } from '../../link/console';
import type { Reply } from '../../link/socket';
import { useReadiness } from '../../link/readiness';
import { moving, store, useStore } from '../../link/store';
import { useSettings } from '../../text/settings';
import { plain, readNumber, shownAs, t, words, withUnit } from '../../text/text';
import { Refusal, reasons, refused, useRequest, WatchOnly } from '../../ui/refusal';
import { radioKeys } from '../../ui/radio_keys';
import { AdviceCard } from './advice';
import { groups, niceStep, same, type Group } from './groups';
import { HistoryCard } from './history';
import '../../ui/motion.css';
import './tune.css';

/** Shortest interval between values sent by a slider: keys change it quickly. */
const debounce_ms = 200;
/** Length of a trial in motion. */
const trial_s = 20;

/** Sends a value: on trial in motion, permanent at standstill. */
const send = (row: ParamInfo, si: number): Promise<Reply> =>
  moving(store.value.mode) && row.edit === 'live' ? tryParameters({ [row.name]: si }, trial_s) : setParameters({ [row.name]: si });

/** Values that were taken over from advice into the fields, SI units: not in force until a person applies them. */
type Taken = Readonly<Record<string, number>>;

interface RowsProps {
  role: string;
  standby: boolean;
  connected: boolean;
  taken: Taken;
  drop: (name: string) => void;
}

function Row({ row, role, standby, connected, taken: allTaken, drop }: RowsProps & { row: ParamInfo }) {
  const taken = allTaken[row.name] ?? null;
  const value = useStore((s) => s.parameters[row.name] ?? NaN);
  const show = shownAs(row.name, row.unit);
  const toShown = (si: number) => si * show.factor;
  const [draft, setDraft] = useState<string | null>(null); // what is being typed
  const [slide, setSlide] = useState<number | null>(null); // where the slider is held, shown units
  const [error, setError] = useState<string | null>(null);
  const [undo, setUndo] = useState<number | null>(null);
  const [undoing, setUndoing] = useState(false);
  const timer = useRef<number | null>(null);
  const drawn = useRef<number | null>(null); // the slider's value that was not sent yet
  const begun = useRef<number | null>(null); // value in force when the change began: what Undo goes back to
  const touches = useRef(0); // an answer must not overwrite later input

  const here = useRef(true);
  const entered = useRef<string | null>(null); // text that was typed and sent
  const wrong = useRef<string | null>(null);
  /** What is wrong stands at the row, and at the edge of the screen when the row is left. */
  const say = (text: string | null) => {
    wrong.current = text;
    if (here.current) setError(text);
    else if (text !== null) notify('warning', `${words(row.title)}: ${text}`, true);
  };
  // Leaving the screen right after moving a slider or typing still applies the value. The field is left before or after this.
  const leave = useRef(() => {});
  leave.current = () => {
    here.current = false;
    if (drawn.current !== null) void apply(drawn.current);
    else if (draft !== null && draft !== entered.current) enter();
    else say(wrong.current);
  };
  useEffect(() => () => leave.current(), []);
  const lockedByMode = row.edit === 'stopped' && !standby;
  const locked = !connected || lockedByMode || !Number.isFinite(value) || (row.role === 'engineer' && role !== 'engineer') || role === 'viewer';

  const apply = async (si: number): Promise<void> => {
    drop(row.name);
    if (timer.current !== null) window.clearTimeout(timer.current);
    timer.current = null;
    drawn.current = null;
    const before = begun.current ?? value;
    begun.current = null;
    const asked = touches.current;
    const reply = await send(row, si);
    if (reply.ok && !same(before, si)) setUndo(before);
    if (touches.current !== asked) return;
    setSlide(null);
    // Control left where it is: what was typed is not in force, so it must not stand there as if it were.
    setDraft((now) => (refused(reply) ? now : null));
    say(refused(reply) ? why(reply) : null);
  };
  const why = (reply: Reply): string => {
    const field = reply.errors.find((item) => item.field === row.name) ?? reply.errors[0];
    const range =
      field?.min !== undefined && field.max !== undefined
        ? ` ${t('refused.range', { min: plain(toShown(field.min)), max: plain(toShown(field.max)) })} ${show.unit}`
        : '';
    return reasons(reply).join(' ') + range;
  };
  const type = (text: string) => {
    touches.current++;
    drop(row.name);
    setDraft(text);
    say(null);
  };
  const enter = () => {
    if (draft === null || (!here.current && draft === entered.current)) return;
    entered.current = draft;
    const number = readNumber(draft);
    if (!Number.isFinite(number)) {
      say(t('tune.number'));
      return;
    }
    const si = number / show.factor;
    if (same(si, value)) {
      setDraft(null);
      say(null);
    } else void apply(si);
  };
  const draw = (shown: number) => {
    begun.current ??= value;
    touches.current++;
    setSlide(shown);
    // Rounding to the slider's steps must not push an end value out of its range.
    drawn.current = Math.max(row.min, Math.min(row.max, shown / show.factor));
  };
  const release = () => {
    const si = drawn.current;
    if (si === null) return;
    drop(row.name);
    setDraft(null);
    say(null);
    if (timer.current !== null) window.clearTimeout(timer.current);
    timer.current = window.setTimeout(() => void apply(si), debounce_ms);
  };
  /** The browser has taken the touch for scrolling: it has moved the slider to the finger before that. */
  const scrolled = () => {
    if (timer.current !== null) window.clearTimeout(timer.current);
    timer.current = drawn.current = begun.current = null;
    setSlide(null);
  };

  const changed = Number.isFinite(value) && !same(value, row.default);
  const min = toShown(row.min);
  const max = toShown(row.max);
  const defaultShare = (row.default - row.min) / (row.max - row.min);
  const id = `p-${row.name}`;
  return (
    <div class={`tune-row${changed ? ' changed' : ''}${locked ? ' locked' : ''}`}>
      <div class="tune-words">
        <label for={id} class="tune-title">
          {words(row.title)}
        </label>
        <p class="tune-effect" id={`${id}-effect`}>
          {words(row.effect)}
        </p>
        {row.edit === 'stopped' ? <p class={lockedByMode ? 'tune-note now' : 'tune-note'}>{t('tune.stopped')}</p> : null}
        {taken !== null ? (
          <p class="tune-note now" role="status">
            {t('advice.taken', { value: withUnit(plain(toShown(value)), show.unit) })}
          </p>
        ) : null}
        {error !== null ? (
          <p class="tune-error" role="alert" id={`${id}-error`}>
            {error}
          </p>
        ) : null}
      </div>
      <div class="tune-slider">
        <input
          type="range"
          aria-label={t('tune.slider', { name: words(row.title) })}
          min={min}
          max={max}
          step={niceStep(max - min)}
          value={slide ?? (Number.isFinite(value) ? toShown(value) : min)}
          disabled={locked}
          onInput={(event) => draw(Number(event.currentTarget.value))}
          onChange={release}
          onPointerCancel={scrolled}
        />
        <span
          class="tune-default"
          ref={(element) => element?.style.setProperty('--share', String(defaultShare))}
          title={t('tune.default', { value: withUnit(plain(toShown(row.default)), show.unit) })}
        />
        <span class="tune-range num">
          <span>{plain(min)}</span>
          <span>{t('tune.default', { value: withUnit(plain(toShown(row.default)), show.unit) })}</span>
          <span>{plain(max)}</span>
        </span>
      </div>
      <div class="tune-value">
        <input
          id={id}
          type="text"
          inputMode="decimal"
          autocomplete="off"
          class="num"
          name={row.name}
          aria-describedby={error !== null ? `${id}-error ${id}-effect` : `${id}-effect`}
          aria-invalid={error !== null}
          value={slide !== null ? plain(slide) : (draft ?? (Number.isFinite(value) ? plain(toShown(taken ?? value)) : ''))}
          disabled={locked}
          onInput={(event) => type(event.currentTarget.value)}
          onBlur={enter}
          onKeyDown={(event) => {
            if (event.key === 'Enter') {
              if (draft === null && taken !== null) void apply(taken);
              else enter();
            }
            if (event.key === 'Escape') {
              drop(row.name);
              setDraft(null);
              say(null);
            }
          }}
        />
        <span class="tune-unit">{show.unit}</span>
      </div>
      <div class="tune-buttons">
        {taken !== null ? (
          <>
            <button type="button" class="quiet" onClick={() => drop(row.name)}>
              {t('advice.drop')}
            </button>
            <button type="button" class="plain" disabled={locked} onClick={() => void apply(taken)}>
              {t('advice.apply')}
            </button>
          </>
        ) : null}
        <button
          type="button"
          class="quiet"
          hidden={taken !== null}
          disabled={locked || undo === null || undoing}
          onClick={() => {
            if (undo === null) return;
            // Stays until it succeeded: after a refusal it must still be possible to undo.
            setUndoing(true);
            void apply(undo).then(() => setUndoing(false));
          }}
        >
          {t('tune.undo')}
        </button>
        <button type="button" class="quiet" hidden={taken !== null} disabled={locked || !changed} onClick={() => void apply(row.default)}>
          {t('tune.back')}
        </button>
      </div>
    </div>
  );
}

function GroupView({ group, ...rest }: RowsProps & { group: Group }) {
  const everyday = group.rows.filter((row) => row.role === 'therapist');
  const deep = group.rows.filter((row) => row.role === 'engineer');
  const rows = (list: ParamInfo[]) => list.map((row) => <Row key={row.name} row={row} {...rest} />);
  return (
    <section class="card tune-group">
      <h2>{t(group.title)}</h2>
      {rows(everyday)}
      {deep.length > 0 ? (
        <details>
          <summary>{t('tune.engineers', { n: deep.length })}</summary>
          {rows(deep)}
        </details>
      ) : null}
    </section>
  );
}

export function TuneView() {
  useSettings();
  const { reachable: connected, may, standby } = useReadiness();
  const role = useStore((s) => s.role);
  const values = useStore((s) => s.parameters);
  const request = useRequest();
  const list = groups();
  const differing = list
    .flatMap((group) => group.rows)
    .filter((row) => values[row.name] !== undefined && !same(values[row.name]!, row.default)).length;
  const inForce = (preset: (typeof presets)[number]) =>
    Object.entries(preset.values).every(([name, value]) => values[name] !== undefined && same(values[name], value));
  const choose = async (preset: (typeof presets)[number]) => {
    if (await request.ask(() => applyPreset(preset.name))) notify('info', t('tune.presetApplied', { name: words(preset.title) }), true);
  };
  const [taken, setTaken] = useState<Taken>({});
  const drop = (name: string) => setTaken((all) => Object.fromEntries(Object.entries(all).filter(([key]) => key !== name)));
  const takeOver = (row: ParamInfo, si: number) => {
    setTaken((all) => ({ ...all, [row.name]: si }));
    const field = document.getElementById(`p-${row.name}`);
    field?.scrollIntoView({ block: 'center' });
    field?.focus({ preventScroll: true });
  };
  const locked = (row: ParamInfo) => !may || (row.edit === 'stopped' && !standby) || (row.role === 'engineer' && role !== 'engineer');
  return (
    <div class="tune">
      <div class="walk-controls">
        <div class="choice presets" role="radiogroup" aria-label={t('tune.preset')} onKeyDown={radioKeys}>
          {presets.map((preset) => (
            <button
              key={preset.name}
              type="button"
              role="radio"
              aria-checked={inForce(preset)}
              disabled={!may || !standby}
              onClick={() => void choose(preset)}
            >
              {words(preset.title)}
              <small>{words(preset.doc)}</small>
            </button>
          ))}
        </div>
        <p class="hint">
          {differing > 0 ? t('tune.changedCount', { n: differing }) : t('tune.allDefault')}
          <br />
          {t('tune.live')}
          {standby ? null : ` ${t('tune.preset')}: ${t('tune.stopped')}`}
        </p>
      </div>
      <Refusal request={request} />
      <WatchOnly />
      <AdviceCard takeOver={takeOver} locked={locked} />
      <HistoryCard send={send} locked={locked} />
      {list.map((group) => (
        <GroupView key={group.title} group={group} role={role} standby={standby} connected={connected} taken={taken} drop={drop} />
      ))}
    </div>
  );
}
