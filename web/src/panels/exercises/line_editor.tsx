// Draws an own line: points on the floor, open or round, with corners that can be walked; says how long it is and whether it fits; saves it.
import { useEffect, useRef, useState } from 'preact/hooks';
import type { Line } from '../../contract/rest.gen';
import { notify } from '../../link/console';
import { rest, type Problem } from '../../link/rest';
import { useSettings } from '../../text/settings';
import { fixed, t } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { FormButtons } from '../../ui/form_buttons';
import { radioKeys } from '../../ui/radio_keys';
import {
  corners,
  floorSide,
  grid_m,
  judge,
  moved,
  nextPoint,
  onFloor,
  pointsMost,
  requestOfDraft,
  steppedRadius,
  without,
  withPoint,
  type Draft,
  type Floor,
  type Judged,
} from './draft';
import { keepFloor, keptFloor } from './floor';
import { LinePlan } from './line_plan';
import { stepped } from './plan';
import { Stepper } from './stepper';
import './line_editor.css';

const nameMost = 64;

/** Floor that holds a line from before. */
function floorFor(draft: Draft): Floor {
  const kept = keptFloor();
  const side = (value: number, reach: readonly number[]) => Math.max(value, ...reach.map((at) => Math.ceil(4 * Math.abs(at)) / 2));
  return {
    along_m: side(
      kept.along_m,
      draft.points.map(({ x }) => x),
    ),
    across_m: side(
      kept.across_m,
      draft.points.map(({ y }) => y),
    ),
  };
}

const curveText = (tightest_m: number | null) =>
  tightest_m === null ? t('line.straight') : tightest_m === 0 ? t('guided.sharp') : `${fixed(tightest_m, 2)} m`;

function Verdict({ draft, judged }: { draft: Draft; judged: Judged }) {
  if (judged.wrong === 'few') return <p class="hint">{t(draft.closed ? 'line.fewClosed' : 'line.few')}</p>;
  if (judged.near !== null)
    return (
      <p class="form-error" role="alert">
        {t('line.near', { a: judged.near[0], b: judged.near[1] })}
      </p>
    );
  return <p class={judged.fits ? 'line-fits' : 'form-error'}>{t(judged.fits ? 'line.fits' : 'line.fitsNot')}</p>;
}

interface EditorProps {
  /** Null: a new one. */
  line: Line | null;
  begin: Draft;
  /** Called with each change, so that leaving the screen loses nothing. */
  keep: (draft: Draft) => void;
  close: (saved: Line | null) => void;
}
export function LineEditor({ line, begin, keep, close }: EditorProps) {
  useSettings();
  const [draft, setDraft] = useState(begin);
  useEffect(() => keep(draft), [draft]);
  const [past, setPast] = useState<readonly Draft[]>([]);
  const [selected, setSelected] = useState<number | null>(null);
  const [floor, setFloor] = useState<Floor>(() => floorFor(draft));
  const [problem, setProblem] = useState<Problem | null>(null);
  const [busy, setBusy] = useState(false);
  const judged = judge(draft, floor);
  const change = (next: Draft, begins = true) => {
    if (begins) setPast([...past.slice(-50), draft]);
    setDraft(next);
    setProblem(null);
  };
  const undo = () => {
    const before = past.at(-1);
    if (before === undefined) return;
    setPast(past.slice(0, -1));
    setDraft({ ...before, name: draft.name });
    setSelected(null);
  };
  const resize = (part: Partial<Floor>) => setFloor(keepFloor({ ...floor, ...part }));
  const save = async () => {
    setBusy(true);
    const body = requestOfDraft(draft);
    const answer =
      line === null
        ? await rest('POST /api/v1/lines', { body })
        : await rest('PATCH /api/v1/lines/{id}', { path: { id: line.id }, body, etag: line.etag });
    setBusy(false);
    setProblem(answer.ok ? null : answer.problem);
    if (!answer.ok) return;
    notify('info', t('line.saved', { name: answer.value.name }), true);
    close(answer.value);
  };
  const point = selected === null ? undefined : draft.points[selected];
  const shift = (x: number, y: number) => {
    if (selected !== null && point !== undefined) change(moved(draft, selected, onFloor({ x: point.x + x, y: point.y + y }, floor)));
  };
  const add = () => {
    const next = withPoint(draft, nextPoint(draft, floor));
    change(next);
    setSelected(next.points.length - 1);
  };
  // Opened from a button further down the screen.
  const top = useRef<HTMLDivElement>(null);
  useEffect(() => top.current?.scrollIntoView({ block: 'start' }), []);
  return (
    <div class="drive guided" ref={top}>
      <div class="drive-body line-body">
        <section class="card guided-card">
          <Form label={t('line.title')} onSend={() => void save()}>
            <h2>{t('line.title')}</h2>
            <Field
              label={t('line.name')}
              hint={t('line.nameHint')}
              value={draft.name}
              most={nameMost}
              onValue={(name) => setDraft({ ...draft, name })}
            />
            <div class="line-settings">
              <div class="stepper">
                <span class="stepper-label">{t('line.ends')}</span>
                <div class="choice" role="radiogroup" aria-label={t('line.ends')} onKeyDown={radioKeys}>
                  {([false, true] as const).map((closed) => (
                    <button
                      key={String(closed)}
                      type="button"
                      role="radio"
                      aria-checked={draft.closed === closed}
                      onClick={() => change({ ...draft, closed })}
                    >
                      {t(closed ? 'line.closed' : 'line.open')}
                    </button>
                  ))}
                </div>
              </div>
              <Stepper
                label={t('line.corners')}
                text={draft.corner_radius_m === 0 ? t('guided.sharp') : `${fixed(draft.corner_radius_m, 1)} m`}
                range={corners}
                value={draft.corner_radius_m}
                step={(by) => change({ ...draft, corner_radius_m: steppedRadius(draft.corner_radius_m, by) })}
              />
              <Stepper
                label={t('line.floorAlong')}
                text={`${fixed(floor.along_m, 1)} m`}
                range={floorSide}
                value={floor.along_m}
                step={(by) => resize({ along_m: stepped(floorSide, floor.along_m, by) })}
              />
              <Stepper
                label={t('line.floorAcross')}
                text={`${fixed(floor.across_m, 1)} m`}
                range={floorSide}
                value={floor.across_m}
                step={(by) => resize({ across_m: stepped(floorSide, floor.across_m, by) })}
              />
            </div>
            <dl class="line-figures">
              <div>
                <dt>{t('line.length')}</dt>
                <dd class="num">{judged.wrong === 'few' ? '–' : `${fixed(judged.length_m, 1)} m`}</dd>
              </div>
              <div>
                <dt>{t('line.tightest')}</dt>
                <dd class="num">{judged.wrong === 'few' ? '–' : curveText(judged.tightest_m)}</dd>
              </div>
            </dl>
            <Verdict draft={draft} judged={judged} />
            <Trouble problem={problem} />
            <FormButtons
              missing={draft.name.trim() === '' ? [t('line.name')] : []}
              ready={!busy && judged.wrong === null}
              close={() => close(null)}
            />
          </Form>
        </section>
        <section class="card floor-card line-card">
          <LinePlan draft={draft} floor={floor} judged={judged} selected={selected} select={setSelected} change={change} />
          <div class="line-points">
            <button type="button" class="plain" disabled={draft.points.length >= pointsMost} onClick={add}>
              {t('line.add')}
            </button>
            <button
              type="button"
              class="plain"
              disabled={point === undefined}
              onClick={() => {
                change(without(draft, selected!));
                setSelected(null);
              }}
            >
              {t('line.remove')}
            </button>
            <button type="button" class="plain" disabled={past.length === 0} onClick={undo}>
              {t('common.undo')}
            </button>
          </div>
          {point === undefined ? (
            <p class="hint">{t('line.hint')}</p>
          ) : (
            <div class="line-settings">
              <Stepper
                label={t('line.ahead', { n: selected! + 1 })}
                text={`${fixed(point.x, 1)} m`}
                range={{ least: -floor.along_m / 2, most: floor.along_m / 2 }}
                value={point.x}
                step={(by) => shift(by * grid_m, 0)}
              />
              <Stepper
                label={t('line.left', { n: selected! + 1 })}
                text={`${fixed(point.y, 1)} m`}
                range={{ least: -floor.across_m / 2, most: floor.across_m / 2 }}
                value={point.y}
                step={(by) => shift(0, by * grid_m)}
              />
            </div>
          )}
        </section>
      </div>
    </div>
  );
}
