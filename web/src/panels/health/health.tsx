// Whether everything answers: parts, loop, bus, power, this console, and what happened lately.
import { faults, modes } from '../../contract/faults.gen';
import { params } from '../../contract/params.gen';
import type { SignalName, TickRecord } from '../../contract/signals.gen';
import { live, useReading } from '../../link/live';
import { useStore, type LogLine } from '../../link/store';
import type { TextKey } from '../../text/en';
import { useSettings } from '../../text/settings';
import { duration, fixed, plain, refusalText, shownAs, t, textOf, words } from '../../text/text';
import type { Panel } from '../panel';

const parts: readonly { key: TextKey; age: SignalName }[] = [
  { key: 'health.part.tilt_left', age: 'tilt_left_age_ticks' },
  { key: 'health.part.tilt_right', age: 'tilt_right_age_ticks' },
  { key: 'health.part.tilt_base', age: 'tilt_base_age_ticks' },
  { key: 'health.part.drive_left', age: 'drive_left_age_ticks' },
  { key: 'health.part.drive_right', age: 'drive_right_age_ticks' },
  { key: 'health.part.io', age: 'io_age_ticks' },
];
const tick_ms = 10;
/** Sensors and drives speak each 10 ms and count as lost after 60 ms; the inputs speak each 20 ms and on change. */
const silent_ticks = 25;
const bumperKeys: readonly TextKey[] = ['health.bumper.front', 'health.bumper.rear', 'health.bumper.left', 'health.bumper.right'];

function Line({ label, value, state }: { label: string; value: string; state?: 'good' | 'bad' }) {
  return (
    <div class="line">
      <span>{label}</span>
      <span class={`num ${state ?? ''}`}>{value}</span>
    </div>
  );
}

/** What an event says, in words. */
export function eventText(kind: string, name: string, value: number | null, before: number | null): string {
  const title = textOf(`event.${kind}`) ?? kind.replaceAll('_', ' ');
  const fault = faults.find((row) => row.name === name);
  const mode = modes.find((row) => row.name === name);
  const param = params.find((row) => row.name === name);
  if (kind === 'parameter_changed' && param) {
    const show = shownAs(param.name, param.unit);
    const number = (si: number | null) => (si === null ? '–' : plain(si * show.factor));
    return `${title}: ${words(param.title)} ${number(before)} → ${number(value)} ${show.unit}`;
  }
  if (kind === 'command_refused' && name !== '') return `${title}: ${refusalText(name)}`;
  if (fault) return `${title}: ${words(fault.text)}`;
  if (mode) return `${title}: ${words(mode.title)}`;
  const part = textOf(`health.part.${name}`);
  if (part !== null) return `${title}: ${part}`;
  if (kind === 'marker' && name !== '') return `${title}: ${name}`;
  return title;
}

function Events({ log }: { log: readonly LogLine[] }) {
  const now_ns = live.record?.time_ns ?? 0;
  const shown = log.filter((line) => line.kind !== 'command_done').slice(-12).reverse();
  if (shown.length === 0) return <p class="hint">{t('health.logNone')}</p>;
  return (
    <ul class="events">
      {shown.map((line, index) => (
        <li key={`${line.time_ns}-${index}`}>
          <span class="num">−{duration((now_ns - line.time_ns) / 1e9)}</span> {eventText(line.kind, line.name, line.value, line.before)}
        </li>
      ))}
    </ul>
  );
}

function HealthView() {
  useSettings();
  const r = useReading((record: TickRecord | null) => record, 2);
  const rtt_s = useStore((s) => s.rtt_s);
  const role = useStore((s) => s.role);
  const version = useStore((s) => s.version);
  const log = useStore((s) => s.log);
  const recording = useStore((s) => s.recording);
  const n = (value: number | undefined, decimals: number, unit: string) => `${fixed(value, decimals)} ${unit}`;
  return (
    <div class="health">
      <section class="card">
        <h2>{t('health.parts')}</h2>
        {parts.map(({ key, age }) => {
          const ticks = r?.[age];
          const good = ticks !== undefined && ticks < silent_ticks;
          return <Line key={key} label={t(key)} value={ticks === undefined ? '–' : good ? `${t('health.answers')} · ${fixed(ticks * tick_ms, 0)} ms` : t('health.silent')} state={good ? 'good' : 'bad'} />;
        })}
        <Line label={t('health.part.server')} value={r?.server_alive === 1 ? t('health.answers') : t('health.silent')} state={r?.server_alive === 1 ? 'good' : 'bad'} />
      </section>
      <section class="card">
        <h2>{t('health.power')}</h2>
        <Line label={t('health.batteryA')} value={n(r?.battery_a_v, 2, 'V')} />
        <Line label={t('health.batteryB')} value={n(r?.battery_b_v, 2, 'V')} />
        <Line label={t('health.supplyLeft')} value={n(r?.left_supply_v, 2, 'V')} />
        <Line label={t('health.supplyRight')} value={n(r?.right_supply_v, 2, 'V')} />
        <Line label={t('health.currentLeft')} value={n(r?.left_current_a, 2, 'A')} />
        <Line label={t('health.currentRight')} value={n(r?.right_current_a, 2, 'A')} />
      </section>
      <section class="card">
        <h2>{t('health.bumpers')}</h2>
        {bumperKeys.map((key, bit) => {
          const pressed = r !== null && ((r.bumpers >>> bit) & 1) === 1;
          return <Line key={key} label={t(key)} value={r === null ? '–' : pressed ? t('health.pressed') : t('health.free')} state={pressed ? 'bad' : 'good'} />;
        })}
      </section>
      <section class="card">
        <h2>{t('health.loop')}</h2>
        <Line label={t('health.lateness')} value={n(r === null ? undefined : r.wake_lateness_s * 1e3, 2, 'ms')} />
        <Line label={t('health.duration')} value={n(r === null ? undefined : r.tick_duration_s * 1e3, 2, 'ms')} />
        <Line label={t('health.overruns')} value={fixed(r?.overruns, 0)} />
        <h2>{t('health.bus')}</h2>
        <Line label={t('health.frames')} value={fixed(r?.bus_frames, 0)} />
        <Line label={t('health.refusedFrames')} value={fixed(r?.bus_refused, 0)} />
        <Line label={t('health.refusedCommands')} value={fixed(r?.commands_refused, 0)} />
      </section>
      <section class="card">
        <h2>{t('health.link')}</h2>
        <Line label={t('health.rtt')} value={n(rtt_s === null ? undefined : rtt_s * 1000, 0, 'ms')} />
        <Line label={t('health.lost')} value={fixed(live.lost, 0)} />
        <Line label={t('health.role')} value={textOf(`role.${role}`) ?? '–'} />
        <Line label={t('health.recording')} value={recording.state === 'recording' ? t('sessions.one', { n: recording.session ?? '–' }) : recording.state === 'failed' ? recording.detail || t('bar.recordingFailed') : t('bar.recordingOff')} />
        <Line label={t('health.version')} value={version || '–'} />
      </section>
      <section class="card wide">
        <h2>{t('health.log')}</h2>
        <Events log={log} />
      </section>
    </div>
  );
}

export const healthPanel: Panel = { id: 'health', title: 'nav.health', icon: 'health', live: true, View: HealthView };
