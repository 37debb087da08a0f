// GUIDED: the hoist drives a figure while the therapist holds hold-to-run. Choose it, see its floor space, start, hold.
import { useEffect, useRef, useState } from 'preact/hooks';
import { requestGuided } from '../../link/console';
import { live, useFrame } from '../../link/live';
import { useTopic } from '../../link/wants';
import { tooSlow, useReadiness } from '../../link/readiness';
import { figure, useStore } from '../../link/store';
import { useSettings } from '../../text/settings';
import { exerciseTitle, firstSize } from '../../text/exercise';
import { degrees, duration, fixed, t, words } from '../../text/text';
import { FloorView } from '../../ui/floor_view';
import { fit, floorSpace, onScreen, patternPoints } from '../../ui/geometry';
import { HoldToGo } from '../../ui/hold_to_go';
import { Reading } from '../../ui/reading';
import { Refusal, StartBlockers, useRequest } from '../../ui/refusal';
import { addressOf } from '../../router';
import { SlowLink, tooSlowText } from '../../ui/slow_link';
import { StartEnd } from '../../ui/start_end';
import {
  curveSpeed_m_s,
  duration_s,
  exerciseOf,
  firstPlan,
  length_m,
  pathOf,
  shapes,
  sizeOf,
  stepped,
  steps,
  withinCap,
  type Plan,
  type Shape,
} from './plan';
import './exercises.css';

/** Kept while the console is open, also across screens. */
let kept: Plan = firstPlan;

/** Figures are drawn to a common scale: frame size in metres. */
function ShapePicture({ shape }: { shape: Shape }) {
  const size = 40;
  const points = patternPoints(exerciseOf({ ...firstPlan, shape, length_m: 2.6, side_m: 2.2, radius_m: 1.2, eight_m: 0.75 }));
  const frame = fit(points, size, size, 0.2, 1);
  const line = points.map((p) => onScreen(p, frame, size, size)).map(({ left, top }) => `${left.toFixed(1)},${top.toFixed(1)}`);
  return (
    <svg class="shape-picture" viewBox={`0 0 ${size} ${size}`} aria-hidden="true">
      <polyline points={line.join(' ')} />
    </svg>
  );
}

function Stepper({ label, text, by, low, high }: { label: string; text: string; by: (step: 1 | -1) => void; low: boolean; high: boolean }) {
  return (
    <div class="stepper" role="group" aria-label={label}>
      <span class="stepper-label">{label}</span>
      <button type="button" class="plain" aria-label={t('guided.less', { what: label })} disabled={low} onClick={() => by(-1)}>
        −
      </button>
      <span class="stepper-value num">{text}</span>
      <button type="button" class="plain" aria-label={t('guided.more', { what: label })} disabled={high} onClick={() => by(1)}>
        +
      </button>
    </div>
  );
}

function Pair({
  label,
  options,
  chosen,
  choose,
}: {
  label: string;
  options: readonly [string, string];
  chosen: 0 | 1;
  choose: (which: 0 | 1) => void;
}) {
  return (
    <div class="stepper">
      <span class="stepper-label">{label}</span>
      <div class="choice" role="radiogroup" aria-label={label}>
        {options.map((text, which) => (
          <button key={text} type="button" role="radio" aria-checked={which === chosen} onClick={() => choose(which as 0 | 1)}>
            {text}
          </button>
        ))}
      </div>
    </div>
  );
}

function Settings({ plan, change, speedMost_m_s }: { plan: Plan; change: (part: Partial<Plan>) => void; speedMost_m_s: number }) {
  const size = sizeOf[plan.shape];
  const most = { ...steps.speed_m_s, most: Math.max(steps.speed_m_s.least, Math.min(steps.speed_m_s.most, speedMost_m_s)) };
  return (
    <div class="guided-settings">
      <Stepper
        label={words(firstSize(plan.shape).title)}
        text={`${fixed(plan[size], 1)} m`}
        low={plan[size] <= steps[size].least}
        high={plan[size] >= steps[size].most}
        by={(by) => change({ [size]: stepped(steps[size], plan[size], by) })}
      />
      <Stepper
        label={t('guided.speed')}
        text={`${fixed(plan.speed_m_s, 2)} m/s`}
        low={plan.speed_m_s <= most.least}
        high={plan.speed_m_s >= most.most - 1e-6}
        by={(by) => change({ speed_m_s: stepped(most, plan.speed_m_s, by) })}
      />
      {plan.shape === 'straight' ? null : (
        <>
          <Stepper
            label={t('guided.laps')}
            text={fixed(plan.laps, 0)}
            low={plan.laps <= steps.laps.least}
            high={plan.laps >= steps.laps.most}
            by={(by) => change({ laps: stepped(steps.laps, plan.laps, by) })}
          />
          <Pair
            label={t(plan.shape === 'eight' ? 'guided.firstLoop' : 'guided.side2')}
            options={[t('guided.left'), t('guided.right')]}
            chosen={(plan.shape === 'eight') === plan.clockwise ? 0 : 1}
            choose={(which) => change({ clockwise: (which === 1) !== (plan.shape === 'eight') })}
          />
        </>
      )}
      {plan.shape === 'square' ? (
        <Pair
          label={t('guided.corners')}
          options={[t('guided.sharp'), t('guided.round')]}
          chosen={plan.round ? 1 : 0}
          choose={(which) => change({ round: which === 1 })}
        />
      ) : null}
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

export function ExercisesView() {
  useSettings();
  const mode = useStore((s) => s.mode);
  const ready = useReadiness();
  const begun = useStore(figure);
  const parameters = useStore((s) => s.parameters);
  const [plan, setPlan] = useState(kept);
  const request = useRequest();
  const guided = mode === 'guided';
  const driven = ready.led;
  const rtt_s = useStore((s) => s.rtt_s);
  const slow = tooSlow({ rtt_s });
  // The driven path stays until the next choice.
  const [justDone, setJustDone] = useState(false);
  const active = guided && ready.hand;
  const speedMost_m_s = (parameters.speed_m_s_max ?? 0.6) * (parameters.speed_cap_norm ?? 1);
  const yawLimit_rad_s = Math.min(parameters.remote_yaw_rate_rad_s_max ?? 0.5, parameters.yaw_rate_rad_s_max ?? 0.5);

  const change = (part: Partial<Plan>) => {
    kept = { ...plan, ...part };
    setPlan(kept);
    request.forget();
    setJustDone(false);
  };
  useEffect(() => {
    if (!guided) return;
    request.forget();
    setJustDone(true);
  }, [guided]);

  const exercise = useRef({ plan, figure: exerciseOf(plan) });
  if (exercise.current.plan !== plan) exercise.current = { plan, figure: exerciseOf(plan) };
  const space = floorSpace(exercise.current.figure);
  // The shown value is the requested one: a choice above the limit in force is disabled until the limit rises.
  const allowed = withinCap(plan, speedMost_m_s);
  const curve = curveSpeed_m_s(allowed, yawLimit_rad_s);

  return (
    <div class="drive guided">
      <div class="walk-controls">
        <div class="choice shapes" role="radiogroup" aria-label={t('exercise.label')}>
          {shapes.map((shape) => (
            <button key={shape} type="button" role="radio" aria-checked={plan.shape === shape} disabled={driven} onClick={() => change({ shape })}>
              <ShapePicture shape={shape} />
              <span>{exerciseTitle(shape)}</span>
            </button>
          ))}
        </div>
        <StartEnd
          request={request}
          of="guided"
          startLabel={t('guided.start')}
          endLabel={t(guided ? 'guided.end' : 'walk.end')}
          start={(again) => requestGuided(pathOf(allowed), again)}
        />
      </div>
      <Refusal request={request} />
      <StartBlockers request={request} of="guided" />
      <div class="drive-body">
        <section class="card guided-card">
          {guided ? (
            <div class="readings guided-readings">
              <Reading label={t('guided.remaining')} unit="m" topic="exercise" read={(r) => fixed(r.guided_remaining_m, 1)} />
              <Reading label={t('walk.speed')} unit="m/s" topic="motion" read={(r) => fixed(r.speed_m_s, 2)} />
              <Reading label={t('guided.offLine')} unit="cm" topic="exercise" read={(r) => fixed(Math.abs(r.guided_cross_track_m) * 100, 0)} />
              <Reading label={t('walk.lean')} topic="posture" read={(r) => degrees((r.left_alpha_rad + r.right_alpha_rad) / 2 - r.base_alpha_rad)} />
              <Reading label={t('walk.stopDistance')} unit="cm" topic="motion" read={(r) => fixed(Math.ceil(r.stop_distance_m * 100), 0)} />
            </div>
          ) : (
            <Settings plan={allowed} change={change} speedMost_m_s={speedMost_m_s} />
          )}
          <p class="guided-needs">
            <strong>{t('guided.needs', { along: fixed(space.along_m, 1), across: fixed(space.across_m, 1) })}</strong>{' '}
            {t('guided.takes', { length: fixed(length_m(allowed), 1), time: duration(duration_s(allowed, yawLimit_rad_s)) })}
            {curve === null ? '' : ` ${t('guided.slower', { speed: fixed(curve, 2) })}`}
          </p>
          <Progress />
          <HoldToGo active={active} locked={guided && slow ? tooSlowText(rtt_s) : t(guided ? 'guided.other' : 'guided.locked')} />
          <SlowLink calm={t('guided.hint')} />
        </section>
        <section class="card floor-card">
          <FloorView exercise={driven ? begun : exercise.current.figure} planned={!driven && !justDone} />
        </section>
      </div>
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
