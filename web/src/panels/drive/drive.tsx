// The therapist drives: take control, hold the joystick, let go to stop.
import { useEffect, useRef, useState } from 'preact/hooks';
import { drive, everyTick, notify, requestMode, setParameters } from '../../link/console';
import type { Reply } from '../../link/socket';
import type { Exercise } from '../../contract/messages.gen';
import { useStore } from '../../link/store';
import { useSettings } from '../../text/settings';
import { fixed, t, toDegrees } from '../../text/text';
import { FloorView } from '../../ui/floor_view';
import { Reading } from '../../ui/reading';
import { Refusal, reasons } from '../../ui/refusal';
import { isTyping } from '../../ui/stop_button';
import type { Panel } from '../panel';
import { driveKeys, HoldToRun, keysWish } from './joystick';

const limits = [
  { key: 'drive.slow', speed_m_s: 0.15 },
  { key: 'drive.medium', speed_m_s: 0.3 },
  { key: 'drive.fast', speed_m_s: 0.6 },
] as const;
const free: Exercise = { shape: 'free' };
/** From here on driving is called slow, and is refused: design page, remote commands. */
const slow_s = 0.08;
const tooSlow_s = 0.3;

const browserTimers = {
  every: (call: () => void, each_ms: number) => window.setInterval(call, each_ms),
  cancel: (timer: number) => window.clearInterval(timer),
};

/** The pad. Inert unless `active`; every way of losing the finger, the page or the screen lets go. */
function Joystick({ active }: { active: boolean }) {
  const pad = useRef<HTMLDivElement>(null);
  const knob = useRef<HTMLDivElement>(null);
  const pointer = useRef<number | null>(null);
  const keys = useRef(new Set<string>());
  const [held, setHeld] = useState(false);
  const hold = useRef<HoldToRun | null>(null);
  hold.current ??= new HoldToRun((speed, yaw, isHeld) => void drive(speed, yaw, isHeld), browserTimers);

  const show = (speed: number, yaw: number) => {
    const radius = (pad.current?.clientWidth ?? 0) * 0.34;
    if (knob.current) knob.current.style.transform = `translate(${(-yaw * radius).toFixed(1)}px, ${(-speed * radius).toFixed(1)}px)`;
  };
  const release = () => {
    pointer.current = null;
    keys.current.clear();
    hold.current?.release();
    show(0, 0);
    setHeld(false);
  };
  const wish = (event: PointerEvent) => {
    const box = pad.current!.getBoundingClientRect();
    const radius = box.width * 0.34;
    let yaw = -(event.clientX - box.left - box.width / 2) / radius;
    let speed = -(event.clientY - box.top - box.height / 2) / radius;
    const size = Math.hypot(yaw, speed);
    if (size > 1) {
      yaw /= size;
      speed /= size;
    }
    return { speed, yaw };
  };
  const byKeys = () => {
    if (keys.current.size === 0) return release();
    const { speed, yaw } = keysWish(keys.current);
    if (hold.current!.held) hold.current!.move(speed, yaw);
    else hold.current!.press(speed, yaw);
    show(speed, yaw);
    setHeld(true);
  };

  useEffect(() => {
    if (!active) {
      release();
      return;
    }
    const down = (event: KeyboardEvent) => {
      if (!(event.code in driveKeys) || event.ctrlKey || event.altKey || event.metaKey || isTyping(event.target)) return;
      event.preventDefault();
      if (event.repeat || pointer.current !== null) return;
      keys.current.add(event.code);
      byKeys();
    };
    const up = (event: KeyboardEvent) => {
      if (keys.current.delete(event.code)) byKeys();
    };
    const hidden = () => {
      if (document.hidden) release();
    };
    window.addEventListener('keydown', down);
    window.addEventListener('keyup', up);
    window.addEventListener('blur', release);
    window.addEventListener('pagehide', release);
    document.addEventListener('visibilitychange', hidden);
    document.addEventListener('freeze', release);
    window.addEventListener('hoist-dialog', release);
    return () => {
      window.removeEventListener('keydown', down);
      window.removeEventListener('keyup', up);
      window.removeEventListener('blur', release);
      window.removeEventListener('pagehide', release);
      document.removeEventListener('visibilitychange', hidden);
      document.removeEventListener('freeze', release);
      window.removeEventListener('hoist-dialog', release);
      // No lostpointercapture comes when the pad itself goes away.
      release();
    };
  }, [active]);

  return (
    <div
      ref={pad}
      class={active ? (held ? 'pad active held' : 'pad active') : 'pad'}
      role="application"
      aria-label={t('drive.stick')}
      aria-disabled={!active}
      tabIndex={0}
      onPointerDown={(event) => {
        if (!active || pointer.current !== null || event.button !== 0) return;
        event.preventDefault();
        pad.current!.setPointerCapture(event.pointerId);
        pointer.current = event.pointerId;
        keys.current.clear();
        const { speed, yaw } = wish(event);
        hold.current!.press(speed, yaw);
        hold.current!.move(speed, yaw);
        show(speed, yaw);
        setHeld(true);
      }}
      onPointerMove={(event) => {
        if (event.pointerId !== pointer.current) return;
        const { speed, yaw } = wish(event);
        hold.current!.move(speed, yaw);
        show(speed, yaw);
      }}
      onPointerUp={(event) => event.pointerId === pointer.current && release()}
      onPointerCancel={(event) => event.pointerId === pointer.current && release()}
      onLostPointerCapture={(event) => event.pointerId === pointer.current && release()}
      onContextMenu={(event) => event.preventDefault()}
    >
      <svg viewBox="-100 -100 200 200" aria-hidden="true">
        <circle class="pad-ring" r="96" />
        <circle class="pad-middle" r="9" />
        <path class="pad-arrow" d="M0-84-10-70H10zM0 84-10 70H10zM-84 0-70-10V10zM84 0 70-10V10z" />
      </svg>
      <div ref={knob} class="knob" />
      <span class="pad-text">{active ? (held ? t('drive.held') : t('drive.hold')) : t('drive.locked')}</span>
    </div>
  );
}

function DriveView() {
  useSettings();
  const mode = useStore((s) => s.mode);
  const link = useStore((s) => s.link);
  const mine = useStore((s) => s.lease.mine);
  const data = useStore((s) => s.data);
  const rtt_s = useStore((s) => s.rtt_s);
  const limit_m_s = useStore((s) => s.parameters.remote_speed_m_s_max ?? 0);
  const exercise = useStore((s) => s.exercise);
  const [busy, setBusy] = useState(false);
  const [reply, setReply] = useState<Reply | null>(null);
  const driving = mode === 'remote';
  const moving = driving || mode === 'user';
  const tooSlow = rtt_s !== null && rtt_s > tooSlow_s;
  const active = driving && mine && link === 'open' && data !== 'gone' && !tooSlow;

  useEffect(() => {
    if (driving) setReply(null);
  }, [driving]);
  useEffect(() => {
    if (!active) return;
    everyTick(true);
    return () => void everyTick(false);
  }, [active]);

  const run = async (action: () => Promise<Reply>) => {
    setBusy(true);
    const answer = await action();
    setBusy(false);
    setReply(answer.ok || answer.refusals[0] === 'kept' ? null : answer);
  };
  const choose = async (speed_m_s: number) => {
    const answer = await setParameters({ remote_speed_m_s_max: speed_m_s });
    if (!answer.ok && answer.refusals[0] !== 'kept') notify('warning', reasons(answer).join(' '), true);
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
              disabled={link !== 'open'}
              onClick={() => void choose(limit.speed_m_s)}
            >
              {t(limit.key)} <small>{fixed(limit.speed_m_s, 2)} m/s</small>
            </button>
          ))}
        </div>
        {moving ? (
          <button type="button" class="big" disabled={busy || link !== 'open'} onClick={() => void run(() => requestMode('standby'))}>
            {driving ? t('drive.end') : t('walk.end')}
          </button>
        ) : (
          <button type="button" class="big primary" disabled={busy || link !== 'open'} onClick={() => void run(() => requestMode('remote', free))}>
            {busy ? t('walk.starting') : t('drive.take')}
          </button>
        )}
      </div>
      <Refusal reply={reply} onClose={() => setReply(null)} />
      {rtt_s !== null && rtt_s > slow_s && link === 'open' ? (
        <div class="blockers" role="status">
          {t(tooSlow ? 'drive.tooSlow' : 'drive.slowLink', { n: fixed(rtt_s * 1000, 0) })}
        </div>
      ) : null}
      <div class="drive-body">
        <section class="card stick-card">
          <Joystick active={active} />
          <p class="hint">{t('drive.keys')}</p>
        </section>
        <section class="card floor-card drive-floor">
          <FloorView exercise={driving ? free : exercise} />
          <div class="readings">
            <Reading label={t('walk.speed')} unit="m/s" read={(r) => fixed(r.speed_m_s, 2)} />
            <Reading label={t('walk.stopDistance')} unit="cm" rate_hz={4} read={(r) => fixed(Math.ceil(r.stop_distance_m * 100), 0)} />
            <Reading label={t('drive.turnRate')} unit="°/s" read={(r) => fixed(toDegrees(r.yaw_rate_rad_s), 0)} />
            <Reading label={t('drive.heading')} unit="°" read={(r) => fixed(toDegrees(Math.atan2(Math.sin(r.fused_psi_rad), Math.cos(r.fused_psi_rad))), 0)} />
            <Reading label={t('walk.distance')} unit="m" read={(r) => fixed(r.distance_m, 1)} />
          </div>
        </section>
      </div>
    </div>
  );
}

export const drivePanel: Panel = { id: 'drive', title: 'nav.drive', icon: 'drive', live: true, View: DriveView };
