// The therapist drives: take control, hold the joystick, let go to stop.
import { useEffect, useRef } from 'preact/hooks';
import { requestMode, setParameters } from '../../link/console';
import { live } from '../../link/live';
import { useReadiness } from '../../link/readiness';
import { figure, useStore } from '../../link/store';
import { useSettings } from '../../text/settings';
import { fixed, t, toDegrees } from '../../text/text';
import { FloorView } from '../../ui/floor_view';
import { useHand } from '../../ui/hand';
import { driveKeys, type Wish } from '../../ui/hold_to_run';
import { Reading } from '../../ui/reading';
import { Refusal, StartBlockers, tell, useRequest } from '../../ui/refusal';
import { lockedText, SlowLink } from '../../ui/slow_link';
import { StartEnd } from '../../ui/start_end';
import { TaskStrip } from '../../ui/task_strip';
import './drive.css';

const limits = [
  { key: 'drive.slow', speed_m_s: 0.15 },
  { key: 'drive.medium', speed_m_s: 0.3 },
  { key: 'drive.fast', speed_m_s: 0.6 },
] as const;

const middle: Wish = { speed: 0, yaw: 0 };

/** The pad. Inert unless `active`. */
function Joystick({ active, locked }: { active: boolean; locked: string }) {
  const pad = useRef<HTMLDivElement>(null);
  const knob = useRef<HTMLDivElement>(null);
  const reach_px = (width_px = pad.current?.clientWidth ?? 0) => width_px * 0.34;
  const { held, handlers } = useHand(active, {
    keys: driveKeys,
    wish: (event, box) => {
      if (box.width === 0) return middle;
      const yaw = -(event.clientX - box.left - box.width / 2) / reach_px(box.width);
      const speed = -(event.clientY - box.top - box.height / 2) / reach_px(box.width);
      const size = Math.max(1, Math.hypot(yaw, speed));
      return { speed: speed / size, yaw: yaw / size };
    },
    show: ({ speed, yaw }) => {
      if (knob.current) knob.current.style.transform = `translate(${(-yaw * reach_px()).toFixed(1)}px, ${(-speed * reach_px()).toFixed(1)}px)`;
    },
  });

  return (
    <div
      ref={pad}
      class={active ? (held ? 'pad active held' : 'pad active') : 'pad'}
      role="application"
      aria-label={t('drive.stick')}
      aria-disabled={!active}
      tabIndex={0}
      {...handlers}
    >
      <svg viewBox="-100 -100 200 200" aria-hidden="true">
        <circle class="pad-ring" r="96" />
        <circle class="pad-middle" r="9" />
        <path class="pad-arrow" d="M0-84-10-70H10zM0 84-10 70H10zM-84 0-70-10V10zM84 0 70-10V10z" />
      </svg>
      <div ref={knob} class="knob" />
      <span class="pad-text">{active ? t(held ? 'drive.held' : 'drive.hold') : locked}</span>
    </div>
  );
}

export function DriveView() {
  useSettings();
  const mode = useStore((s) => s.mode);
  const ready = useReadiness();
  const limit_m_s = useStore((s) => s.parameters.remote_speed_m_s_max ?? 0);
  const drawn = useStore(figure);
  const task = useStore((s) => s.task);
  const exercise = useStore((s) => s.exercise);
  const bumpers = useStore((s) => s.bumpers);
  const rtt_s = useStore((s) => s.rtt_s);
  const request = useRequest();
  const driving = mode === 'remote';
  const active = driving && ready.hand;

  useEffect(() => {
    if (driving) request.forget();
  }, [driving]);

  const choose = async (speed_m_s: number) => {
    tell(await setParameters({ remote_speed_m_s_max: speed_m_s }));
  };

  return (
    <div class="drive">
      <div class="walk-controls">
        <div class="choice" role="radiogroup" aria-label={t('drive.limit')}>
          {limits.map((limit) => (
            <button
              key={limit.key}
              type="button"
              role="radio"
              aria-checked={Math.abs(limit_m_s - limit.speed_m_s) < 0.005}
              disabled={!ready.may}
              onClick={() => void choose(limit.speed_m_s)}
            >
              {t(limit.key)} <small>{fixed(limit.speed_m_s, 2)} m/s</small>
            </button>
          ))}
        </div>
        <StartEnd
          request={request}
          of="remote"
          startLabel={t('drive.start')}
          endLabel={t(driving ? 'drive.end' : 'walk.end')}
          // Only a chosen task is driven along its line, and not away from a bumper (decision 72).
          start={() => requestMode('remote', task === null || bumpers !== 0 ? null : exercise)}
        />
      </div>
      <Refusal request={request} />
      <StartBlockers request={request} of="remote" />
      <TaskStrip />
      <div class="drive-body">
        <section class="card stick-card">
          <Joystick active={active} locked={driving ? lockedText(ready, rtt_s) : t('drive.first')} />
          <SlowLink calm={t('drive.keys')} />
        </section>
        <section class="card floor-card drive-floor">
          <FloorView exercise={drawn} />
          <div class="readings">
            <Reading label={t('walk.speed')} unit="m/s" topic="motion" read={(r) => fixed(r.speed_m_s, 2)} />
            <Reading label={t('walk.stopDistance')} unit="cm" topic="motion" read={(r) => fixed(Math.ceil(r.stop_distance_m * 100), 0)} />
            <Reading label={t('drive.turnRate')} unit="°/s" topic="motion" read={(r) => fixed(toDegrees(r.yaw_rate_rad_s), 0)} />
            <Reading
              label={t('drive.heading')}
              unit="°"
              topic="pose"
              read={(r) => fixed(toDegrees(Math.atan2(Math.sin(r.fused_psi_rad), Math.cos(r.fused_psi_rad))), 0)}
            />
            <Reading label={t('walk.distance')} unit="m" topic="motion" read={(r) => fixed(live.walked_m(r), 1)} />
          </div>
        </section>
      </div>
    </div>
  );
}
