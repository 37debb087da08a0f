// Clinical tasks: choose one, adjust it, say who leads, start. Where the hoist leads, hold-to-run is here; the patient leads on Walk, the
// therapist drives on Drive, both with the line on the floor view.
import { useEffect, useRef, useState } from 'preact/hooks';
import { chooseTask, ensureLease, notify, requestGuided, requestMode } from '../../link/console';
import { live, useFrame } from '../../link/live';
import { useQuery } from '../../link/query';
import { useReadiness } from '../../link/readiness';
import { rest, wholeList, type Problem } from '../../link/rest';
import type { Reply } from '../../link/socket';
import { figure, moving, store, useStore } from '../../link/store';
import { useTopic } from '../../link/wants';
import { addressOf, go } from '../../router';
import type { Line, Task } from '../../contract/rest.gen';
import { exerciseRow } from '../../text/exercise';
import { useSettings } from '../../text/settings';
import { tasks as texts } from '../../text/tasks';
import { addTexts, degrees, duration, fixed, t, words } from '../../text/text';
import { Trouble } from '../../ui/field';
import { FloorView } from '../../ui/floor_view';
import { floorSpace, polesOf } from '../../ui/geometry';
import { HoldToGo } from '../../ui/hold_to_go';
import { ownPath } from '../../ui/own_line';
import { Reading } from '../../ui/reading';
import { Refusal, StartBlockers, useRequest } from '../../ui/refusal';
import { lockedText, SlowLink } from '../../ui/slow_link';
import { StartEnd } from '../../ui/start_end';
import { TaskStrip } from '../../ui/task_strip';
import { beginOf, isChanged, type Drawing } from './draft';
import { LineEditor } from './line_editor';
import {
  adjustable,
  curveSpeed_m_s,
  duration_s,
  exerciseOf,
  hasLaps,
  isChosen,
  length_m,
  pathOf,
  planOf,
  requestOf,
  speeds,
  stepped,
  withinCap,
  type Lead,
  type Plan,
} from './plan';
import { Stepper } from './stepper';
import './exercises.css';

addTexts(texts);

/** Kept while the console is open, also across screens. */
let kept: Plan | null = null;
/** The line that is being drawn, until it is saved or cancelled. */
let drawing: Drawing | null = null;

/** Time to take a cancelled drawing back. */
const undoCancel_ms = 6000;

function Direction({ plan, change }: { plan: Plan; change: (part: Partial<Plan>) => void }) {
  // An eight begins with the right loop, every other figure turns left.
  const eight = plan.task.line === 'eight';
  const label = t(eight ? 'guided.firstLoop' : 'guided.side2');
  return (
    <div class="stepper">
      <span class="stepper-label">{label}</span>
      <div class="choice" role="radiogroup" aria-label={label}>
        {([false, true] as const).map((right) => (
          <button
            key={String(right)}
            type="button"
            role="radio"
            aria-checked={(plan.clockwise !== eight) === right}
            onClick={() => change({ clockwise: right !== eight })}
          >
            {t(right ? 'guided.right' : 'guided.left')}
          </button>
        ))}
      </div>
    </div>
  );
}

function Goal({ plan, change }: { plan: Plan; change: (part: Partial<Plan>) => void }) {
  const { by, goal } = plan.task.ends;
  if (!adjustable(goal) || (by === 'distance' && !hasLaps(plan))) return null;
  const [label, text] =
    by === 'time'
      ? [t('task.time'), `${duration(plan.goal)} min`]
      : by === 'back'
        ? [t('task.away'), `${fixed(plan.goal, 1)} m`]
        : [t('guided.laps'), fixed(plan.goal, 0)];
  return <Stepper label={label} text={text} range={goal} value={plan.goal} step={(by) => change({ goal: stepped(goal, plan.goal, by) })} />;
}

function Settings({ plan, change, speedMost_m_s }: { plan: Plan; change: (part: Partial<Plan>) => void; speedMost_m_s: number }) {
  const { task } = plan;
  const row = exerciseRow(exerciseOf(plan).shape);
  const speedRange = { ...speeds, most: Math.max(speeds.least, Math.min(speeds.most, speedMost_m_s)) };
  return (
    <div class="guided-settings">
      {row.sizes
        .filter(({ name }) => task.sizes[name] !== undefined)
        .map(({ name, title }) => (
          <Stepper
            key={name}
            label={words(title)}
            text={
              plan.sizes[name] === 0
                ? t('guided.sharp')
                : `${fixed(plan.sizes[name], task.sizes[name]!.step < 0.1 || task.sizes[name]!.step === 0.25 ? 2 : 1)} m`
            }
            range={task.sizes[name]!}
            value={plan.sizes[name]!}
            step={(by) => change({ sizes: { ...plan.sizes, [name]: stepped(task.sizes[name]!, plan.sizes[name]!, by) } })}
          />
        ))}
      <Goal plan={plan} change={change} />
      {row.turned ? <Direction plan={plan} change={change} /> : null}
      {plan.lead === 'guided' ? (
        <Stepper
          label={t('guided.speed')}
          text={`${fixed(plan.speed_m_s, 2)} m/s`}
          range={speedRange}
          value={plan.speed_m_s}
          step={(by) => change({ speed_m_s: stepped(speedRange, plan.speed_m_s, by) })}
        />
      ) : null}
      <Stepper
        label={t('task.repetitions')}
        text={fixed(plan.repetitions, 0)}
        range={task.repetitions}
        value={plan.repetitions}
        step={(by) => change({ repetitions: stepped(task.repetitions, plan.repetitions, by) })}
      />
      <Stepper
        label={t('task.rest')}
        text={`${duration(plan.rest_s)} min`}
        range={task.rest_s}
        value={plan.rest_s}
        step={(by) => change({ rest_s: stepped(task.rest_s, plan.rest_s, by) })}
      />
    </div>
  );
}

function Progress() {
  const bar = useRef<HTMLDivElement>(null);
  useTopic('exercise', 20);
  useFrame(() => {
    const sample = live.with('exercise');
    const done = sample === null || sample.guided_phase === 0 ? 0 : sample.guided_progress_norm;
    if (bar.current) bar.current.style.transform = `scaleX(${Math.max(0, Math.min(1, done)).toFixed(4)})`;
  });
  return (
    <div class="guided-progress" role="img" aria-label={t('guided.progress')}>
      <div ref={bar} class="guided-done" />
    </div>
  );
}

function Led() {
  return (
    <div class="readings guided-readings">
      <Reading label={t('guided.remaining')} unit="m" topic="exercise" read={(r) => fixed(r.guided_remaining_m, 1)} />
      <Reading label={t('walk.speed')} unit="m/s" topic="motion" read={(r) => fixed(r.speed_m_s, 2)} />
      <Reading label={t('guided.offLine')} unit="cm" topic="exercise" read={(r) => fixed(Math.abs(r.guided_cross_track_m) * 100, 0)} />
      <Reading label={t('walk.lean')} topic="posture" read={(r) => degrees((r.left_alpha_rad + r.right_alpha_rad) / 2 - r.base_alpha_rad)} />
      <Reading label={t('walk.stopDistance')} unit="cm" topic="motion" read={(r) => fixed(Math.ceil(r.stop_distance_m * 100), 0)} />
    </div>
  );
}

/** Floor and time that the line takes. */
function Needs({ plan, yawLimit_rad_s }: { plan: Plan; yawLimit_rad_s: number }) {
  if (plan.task.line === null) return <p class="guided-needs">{t('task.noLine')}</p>;
  const exercise = exerciseOf(plan);
  const space = floorSpace(exercise);
  const [pole] = polesOf(exercise);
  const curve = plan.lead === 'guided' ? curveSpeed_m_s(plan, yawLimit_rad_s) : null;
  return (
    <p class="guided-needs">
      <strong>{t('guided.needs', { along: fixed(space.along_m, 1), across: fixed(space.across_m, 1) })}</strong>{' '}
      {exercise.shape === 'own' ? t('line.long', { length: fixed(ownPath(exercise).length_m, 1) }) : null}
      {plan.lead === 'guided' ? t('guided.takes', { length: fixed(length_m(plan), 1), time: duration(duration_s(plan, yawLimit_rad_s)) }) : null}
      {pole === undefined
        ? ''
        : ` ${t(pole.y > 0 ? 'guided.polesLeft' : 'guided.polesRight', { ahead: fixed(pole.x, 2), aside: fixed(Math.abs(pole.y), 2) })}`}
      {curve === null ? '' : ` ${t('guided.slower', { speed: fixed(curve, 2) })}`}
    </p>
  );
}

const leadTitle = { user: 'task.patient', remote: 'task.therapist', guided: 'task.hoist' } as const satisfies Record<Lead, string>;

interface Choices {
  /** Without the one of own lines. */
  tasks: readonly Task[];
  ownTask: Task | undefined;
  lines: readonly Line[];
}

/** Each task and each own line by a text of its own. */
const keyOf = ({ task, own }: Pick<Plan, 'task' | 'own'>): string => (own === null ? task.name : `${task.name} ${own.id}`);

function Choice({ choices, plan, led, choose }: { choices: Choices; plan: Plan; led: boolean; choose: (plan: Plan) => void }) {
  const { tasks, ownTask, lines } = choices;
  const pick = (key: string) => {
    const own = lines.find((line) => ownTask !== undefined && keyOf({ task: ownTask, own: line }) === key);
    const task = own === undefined ? tasks.find(({ name }) => name === key) : ownTask;
    if (task !== undefined) choose(planOf(task, plan, own));
  };
  return (
    <>
      <label class="field task-field">
        <span>{t('task.label')}</span>
        <select value={keyOf(plan)} disabled={led} onChange={(event) => pick(event.currentTarget.value)}>
          {tasks.map(({ name, title }) => (
            <option key={name} value={name}>
              {words(title)}
            </option>
          ))}
          {ownTask === undefined || lines.length === 0 ? null : (
            <optgroup label={t('line.all')}>
              {lines.map((line) => (
                <option key={line.id} value={keyOf({ task: ownTask, own: line })}>
                  {line.name}
                </option>
              ))}
            </optgroup>
          )}
        </select>
      </label>
      <div class="choice" role="radiogroup" aria-label={t('task.leads')}>
        {(['user', 'remote', 'guided'] as const).map((lead) => (
          <button
            key={lead}
            type="button"
            role="radio"
            aria-checked={plan.lead === lead}
            disabled={led || !plan.task.leads.includes(lead)}
            onClick={() => choose({ ...plan, lead })}
          >
            {t(leadTitle[lead])}
          </button>
        ))}
      </div>
    </>
  );
}

/** Draw a line; change or delete the chosen one. */
function LineButtons({ own, edit, deleted }: { own: Line | null; edit: (line: Line | null) => void; deleted: () => void }) {
  const { may } = useReadiness();
  const role = useStore((s) => s.role);
  const [sure, setSure] = useState(false);
  const [problem, setProblem] = useState<Problem | null>(null);
  if (role === 'viewer') return null;
  const remove = async (line: Line) => {
    const answer = await rest('DELETE /api/v1/lines/{id}', { path: { id: line.id }, etag: line.etag });
    setProblem(answer.ok ? null : answer.problem);
    setSure(false);
    if (!answer.ok) return;
    notify('info', t('line.deleted', { name: line.name }), true);
    deleted();
  };
  if (own !== null && sure)
    return (
      <div class="line-buttons" role="group" aria-label={t('line.delete')}>
        <span>{t('line.sure', { name: own.name })}</span>
        <button type="button" class="plain" disabled={!may} onClick={() => void remove(own)}>
          {t('line.delete')}
        </button>
        <button type="button" class="quiet" onClick={() => setSure(false)}>
          {t('common.cancel')}
        </button>
      </div>
    );
  return (
    <>
      <div class="line-buttons">
        <button type="button" class="plain" onClick={() => edit(null)}>
          {t('line.draw')}
        </button>
        {own === null ? null : (
          <>
            <button type="button" class="plain" onClick={() => edit(own)}>
              {t('line.change')}
            </button>
            <button type="button" class="quiet" onClick={() => setSure(true)}>
              {t('line.delete')}
            </button>
          </>
        )}
      </div>
      <Trouble problem={problem} />
    </>
  );
}

export function ExercisesView() {
  useSettings();
  const asked = useQuery(() => rest('GET /api/v1/tasks'), []);
  const drawn = useQuery(() => wholeList((query) => rest('GET /api/v1/lines', { query })), []);
  const chosen = useStore((s) => s.task);
  const [plan, setPlan] = useState(kept);
  const [editing, setEditing] = useState<Drawing | null>(() => (moving(store.value.mode) ? null : drawing));
  const [cancelled, setCancelled] = useState<Drawing | null>(null);
  useEffect(() => {
    if (cancelled === null) return undefined;
    const timer = window.setTimeout(() => setCancelled(null), undoCancel_ms);
    return () => window.clearTimeout(timer);
  }, [cancelled]);
  const edit = (what: Drawing) => {
    setCancelled(null);
    setEditing(what);
  };
  const all = asked.value?.items ?? [];
  const ownTask = all.find(({ line }) => line === 'own');
  const tasks = all.filter((task) => task !== ownTask);
  const lines = [...(drawn.value?.items ?? [])].sort((a, b) => a.name.localeCompare(b.name));
  const choose = (next: Plan) => setPlan((kept = next));
  const settled = drawn.value !== null || drawn.problem !== null;
  useEffect(() => {
    if (plan !== null || !settled) return;
    // What another screen has chosen comes first.
    const own = chosen?.task === ownTask?.name ? lines.find(({ name }) => name === chosen?.line) : undefined;
    const first = own === undefined ? (tasks.find(({ name }) => name === chosen?.task) ?? tasks[0]) : ownTask;
    if (first !== undefined) choose(planOf(first, undefined, own));
  }, [all.length, settled]);
  useEffect(() => {
    // The chosen line as it is now; the first task instead of one that is gone.
    const own = plan?.own;
    if (plan === null || own === null || own === undefined || drawn.value === null) return;
    const now = lines.find(({ id }) => id === own.id);
    if (now === undefined && tasks[0] !== undefined) choose(planOf(tasks[0], plan));
    else if (now !== undefined && now.etag !== own.etag) choose(planOf(plan.task, plan, now));
  }, [drawn.value]);
  if (editing !== null)
    return (
      <LineEditor
        line={editing.line}
        begin={editing.draft}
        keep={(draft) => {
          const now = { line: editing.line, draft };
          drawing = isChanged(now) ? now : null;
        }}
        close={(saved) => {
          setEditing(null);
          if (saved === null) setCancelled(drawing);
          drawing = null;
          if (saved === null || ownTask === undefined) return;
          choose(planOf(ownTask, plan ?? undefined, saved));
          drawn.retry();
        }}
      />
    );
  if (plan === null)
    return (
      <div class="drive guided">
        <Trouble problem={asked.problem} retry={asked.retry} />
        {asked.problem === null ? <p class="hint">{t('common.loading')}</p> : null}
      </div>
    );
  return (
    <Chosen
      choices={{ tasks: tasks.length > 0 ? tasks : [plan.task], ownTask, lines }}
      plan={plan}
      setPlan={choose}
      edit={(line) => edit(drawing?.line?.id === line?.id ? (drawing ?? beginOf(line)) : beginOf(line))}
      undo={cancelled === null ? null : () => edit(cancelled)}
      deleted={drawn.retry}
    />
  );
}

/** Only a simulated hoist offers it. */
function Rehearse() {
  const asked = useQuery(() => rest('GET /api/v1/rehearsal'), []);
  if (asked.value === null || asked.value.reason_code !== null) return null;
  return (
    <p class="guided-study">
      <a class="plain" href={addressOf('rehearse')}>
        {t('nav.rehearse')}
      </a>{' '}
      <span class="hint">{t('task.rehearseHint')}</span>
    </p>
  );
}

interface ChosenProps {
  choices: Choices;
  plan: Plan;
  setPlan: (plan: Plan) => void;
  edit: (line: Line | null) => void;
  /** Back to a drawing that was just cancelled. */
  undo: (() => void) | null;
  deleted: () => void;
}
function Chosen({ choices, plan, setPlan, edit, undo, deleted }: ChosenProps) {
  const mode = useStore((s) => s.mode);
  const ready = useReadiness();
  const begun = useStore(figure);
  const chosen = useStore((s) => s.task);
  const exercise = useStore((s) => s.exercise);
  const parameters = useStore((s) => s.parameters);
  const request = useRequest();
  const guided = mode === 'guided';
  const driven = ready.led;
  const rtt_s = useStore((s) => s.rtt_s);
  // The walked path stays until the next choice.
  const [justDone, setJustDone] = useState(false);
  const active = guided && ready.hand;
  const speedMost_m_s = (parameters.speed_m_s_max ?? 0.6) * (parameters.speed_cap_norm ?? 1);
  const yawLimit_rad_s = Math.min(parameters.remote_yaw_rate_rad_s_max ?? 0.5, parameters.yaw_rate_rad_s_max ?? 0.5);

  const choose = (next: Plan) => {
    setPlan(next);
    request.forget();
    setJustDone(false);
  };
  const change = (part: Partial<Plan>) => choose({ ...plan, ...part });
  useEffect(() => {
    if (!guided) return;
    request.forget();
    setJustDone(true);
  }, [guided]);

  // The shown value is the requested one: a choice above the limit in force is disabled until the limit rises.
  const allowed = withinCap(plan, speedMost_m_s);
  const line = useRef({ plan, exercise: exerciseOf(plan) });
  if (line.current.plan !== plan) line.current = { plan, exercise: exerciseOf(plan) };
  const { lead } = plan;

  const start = async (again: boolean): Promise<Reply> => {
    if (!isChosen(plan, chosen, exercise)) {
      // Control first: where it stays with another screen, so does that screen's task.
      const control = await ensureLease();
      if (!control.ok) return control;
      const refused = await chooseTask(requestOf(plan));
      if (refused !== null) return refused;
    }
    if (lead === 'guided') return requestGuided(pathOf(allowed), again);
    const reply = await requestMode(lead, line.current.exercise, again);
    if (reply.ok) go(addressOf(lead === 'user' ? 'walk' : 'drive'));
    return reply;
  };

  return (
    <div class="drive guided">
      <div class="walk-controls task-controls">
        {/* While the hoist leads, the button to hold is on the screen: what cannot be changed then makes room. */}
        {guided ? null : <Choice choices={choices} plan={plan} led={driven} choose={choose} />}
        <StartEnd request={request} of={lead} startLabel={t('task.start')} endLabel={t(guided ? 'guided.end' : 'walk.end')} start={start} />
      </div>
      <Refusal request={request} />
      <StartBlockers request={request} of={lead} />
      <TaskStrip />
      <div class="drive-body">
        <section class="card guided-card">
          <p class="task-instruction">{words(plan.task.instruction)}</p>
          {guided ? <Led /> : <Settings plan={allowed} change={change} speedMost_m_s={speedMost_m_s} />}
          {guided ? null : <Needs plan={allowed} yawLimit_rad_s={yawLimit_rad_s} />}
          {lead === 'guided' || guided ? (
            <>
              <Progress />
              <HoldToGo active={active} locked={guided ? lockedText(ready, rtt_s) : t('guided.locked')} />
              <SlowLink calm={t('guided.hint')} />
            </>
          ) : (
            <p class="hint">{t(lead === 'user' ? 'task.onWalk' : 'task.onDrive')}</p>
          )}
          {plan.own === null ? null : <p class="hint">{t('line.notLed')}</p>}
          {driven || undo === null ? null : (
            <p class="line-buttons" role="status">
              {t('line.cancelled')}
              <button type="button" class="quiet" onClick={undo}>
                {t('common.undo')}
              </button>
            </p>
          )}
          {driven ? null : <LineButtons key={plan.own?.id} own={plan.own} edit={edit} deleted={deleted} />}
        </section>
        <section class="card floor-card">
          <FloorView exercise={driven ? begun : line.current.exercise} planned={!driven && !justDone && plan.task.line !== null} />
        </section>
      </div>
      {driven ? null : <Rehearse />}
      {driven ? null : (
        <p class="guided-study">
          <a class="plain" href={addressOf('study')}>
            {t('nav.study')}
          </a>{' '}
          <span class="hint">{t('study.openHint')}</span>
        </p>
      )}
    </div>
  );
}
