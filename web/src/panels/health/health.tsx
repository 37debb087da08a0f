// Whether everything answers: parts, loop, bus, power, this console, and what happened lately.
import type { TickRecord } from '../../contract/signals.gen';
import { useQuery } from '../../link/query';
import { fetchHealth } from '../../link/console';
import { live, useReading } from '../../link/live';
import { batteries, useReadiness } from '../../link/readiness';
import { useStore, type Emergency, type LogLine, type State } from '../../link/store';
import type { TextKey } from '../../text/en';
import { reasonText } from '../../text/server';
import { useSettings } from '../../text/settings';
import { duration, fixed, t, textOf, words } from '../../text/text';
import { emergencyInfo, hex } from '../../ui/device';
import { eventText } from '../../ui/event_text';
import { Scroll } from '../../ui/scroll';
import { Line } from './line';
import { Loop } from './loop';
import { nodeView, partNames, tick_ms, type NodeView } from './nodes';
import './health.css';

const bumperKeys: readonly TextKey[] = ['health.bumper.front', 'health.bumper.rear', 'health.bumper.left', 'health.bumper.right'];

const stateWords = {
  works: 'health.works',
  losing: 'health.losing',
  reports: 'health.reports',
  waiting: 'health.waiting',
  silent: 'health.silent',
  never: 'health.silent',
} as const satisfies Record<NodeView['state'], TextKey>;

function detailOf(view: NodeView): string {
  if (view.state === 'never') return t('health.never');
  const words: string[] = [];
  if (view.state === 'silent' || view.state === 'waiting')
    words.push(view.age_ms === null ? t('health.silentLong') : t('health.silentFor', { s: fixed(view.age_ms / 1000, 1) }));
  else words.push(t('health.lastMessage', { ms: fixed(view.age_ms === null ? null : view.age_ms + tick_ms, 0) }));
  if (view.lostLately > 0) words.push(t('health.lostLately', { n: view.lostLately }));
  else if (view.lostAll > 0) words.push(t('health.lostAll', { n: view.lostAll }));
  return words.join(' · ');
}

/** No recent message: the state is unknown, and the last one must not look current. */
function UnknownPart({ name }: { name: NodeView['name'] }) {
  return (
    <li class="part">
      <span class="part-name">{t(`health.part.${name}` as TextKey)}</span>
      <span class="part-state">{t('health.unknown')}</span>
      <span class="part-detail">–</span>
    </li>
  );
}

function Part({ view }: { view: NodeView }) {
  const info = view.emergency === 0 ? null : emergencyInfo(view.emergency);
  return (
    <li class={`part ${view.state === 'works' ? 'good' : 'bad'}`}>
      <span class="part-name">{t(`health.part.${view.name}` as TextKey)}</span>
      <strong class="part-state">{t(stateWords[view.state])}</strong>
      <span class="part-detail num">{detailOf(view)}</span>
      {info === null ? null : (
        <span class="part-emergency">
          {words(info.text)}.{' '}
          <span class="hint">
            {words(info.detail)} ({hex(view.emergency)})
          </span>
        </span>
      )}
    </li>
  );
}

const wireKeys: readonly TextKey[] = ['health.bus.active', 'health.bus.warning', 'health.bus.passive', 'health.bus.off'];

/** From this share of the limit on, the bar warns. */
const loadNearLimit = 0.9;

function Bus({ r }: { r: TickRecord | null }) {
  const limit = useStore((s) => s.parameters.bus_load_norm_max) ?? 1;
  const up = r !== null && r.bus_up === 1;
  const load = r?.bus_load_norm ?? 0;
  return (
    <section class="card">
      <h2>{t('health.bus')}</h2>
      <div class="load">
        <div class="load-words">
          <span>{t('health.busLoad')}</span>
          <span class="num">{r === null ? '–' : `${fixed(load * 100, 0)} %`}</span>
        </div>
        <svg class={`load-bar ${load > limit * loadNearLimit ? 'near' : ''}`} viewBox="0 0 100 1" preserveAspectRatio="none" aria-hidden="true">
          <rect width={Math.min(1, load) * 100} height="1" />
        </svg>
      </div>
      <Line
        label={t('health.busConnected')}
        value={r === null ? '–' : t(up ? 'health.busUp' : 'health.busDown')}
        state={r === null || up ? 'good' : 'bad'}
      />
      <Line
        label={t('health.busWire')}
        value={r === null ? '–' : t(wireKeys[r.bus_state] ?? 'health.bus.off')}
        state={r === null || r.bus_state === 0 ? 'good' : 'bad'}
      />
      <Line label={t('health.busRate')} value={r === null ? '–' : t('health.perSecond', { n: r.bus_frames_per_s })} />
      <Line label={t('health.busErrors')} value={fixed(r?.bus_errors, 0)} />
    </section>
  );
}

function BusCounts({ r }: { r: TickRecord | null }) {
  return (
    <section class="card">
      <h2>{t('health.busCounts')}</h2>
      <Line label={t('health.frames')} value={fixed(r?.bus_frames, 0)} />
      <Line label={t('health.refusedFrames')} value={fixed(r?.bus_refused, 0)} />
      <Line label={t('health.busNotSent')} value={fixed(r?.bus_send_refused, 0)} />
      <Line label={t('health.busLostSync')} value={fixed(r?.syncs_lost, 0)} />
      <Line label={t('health.busReopened')} value={fixed(r?.bus_reopened, 0)} />
    </section>
  );
}

function Emergencies({ list }: { list: readonly Emergency[] }) {
  const now_ns = live.record?.time_ns ?? 0;
  const shown = list.slice(-12).reverse();
  if (shown.length === 0) return <p class="hint">{t('health.emergenciesNone')}</p>;
  return (
    <Scroll class="events" label={t('health.emergencies')}>
      <ul>
        {shown.map((item) => {
          const info = emergencyInfo(item.code);
          return (
            <li key={`${item.time_ns} ${item.node} ${item.code}`}>
              <span class="num">−{duration((now_ns - item.time_ns) / 1e9)}</span> {textOf(`health.part.${item.node}`) ?? t('device.unknown')}:{' '}
              {words(info.text)}.
              {item.code === 0 ? null : (
                <span class="hint">
                  {' '}
                  {words(info.detail)} ({hex(item.code)})
                </span>
              )}
            </li>
          );
        })}
      </ul>
    </Scroll>
  );
}

const fileWords = {
  unchecked: 'health.stored.unchecked',
  checking: 'health.stored.checking',
  sound: 'health.stored.sound',
  damaged: 'health.stored.damaged',
} as const satisfies Record<NonNullable<State['recordings']>['state'], TextKey>;

function StoredRecordings({ file }: { file: State['recordings'] }) {
  if (file === null) return <Line label={t('health.stored')} value="–" />;
  const state = file.state === 'damaged' ? 'bad' : file.state === 'sound' ? 'good' : undefined;
  return <Line label={t('health.stored')} value={t(fileWords[file.state], { n: fixed(file.progress * 100, 0) })} state={state} />;
}

function Events({ log }: { log: readonly LogLine[] }) {
  const now_ns = live.record?.time_ns ?? 0;
  const shown = log
    .filter((line) => line.kind !== 'command_done')
    .slice(-12)
    .reverse();
  if (shown.length === 0) return <p class="hint">{t('health.logNone')}</p>;
  return (
    <Scroll class="events" label={t('health.log')}>
      <ul>
        {shown.map((line, index) => (
          <li key={`${line.time_ns}-${index}`}>
            <span class="num">−{duration((now_ns - line.time_ns) / 1e9)}</span> {eventText(line.kind, line.name, line.value, line.before, line.code)}
          </li>
        ))}
      </ul>
    </Scroll>
  );
}

export function HealthView() {
  useSettings();
  const newest = useReading('all', (record) => record, 2);
  // Old values are not shown here: "works" and "free" must describe the present.
  const { known, reachable: open } = useReadiness();
  const silent = !known;
  const r = silent ? null : newest;
  const rtt_s = useStore((s) => s.rtt_s);
  const role = useStore((s) => s.role);
  const version = useStore((s) => s.version);
  const log = useStore((s) => s.log);
  const recording = useStore((s) => s.recording);
  const emergencies = useStore((s) => s.emergencies);
  const recordings = useStore((s) => s.recordings);
  useQuery(open ? fetchHealth : null, []);
  const n = (value: number | undefined, decimals: number, unit: string) => `${fixed(value, decimals)} ${unit}`;
  return (
    // It has no focusable content, so this makes it scrollable by keyboard.
    <div class="health" role="region" aria-label={t('nav.health')} tabIndex={0}>
      <section class="card wide">
        <h2>{t('health.parts')}</h2>
        <ul class="parts">
          {partNames.map((name) => (r === null ? <UnknownPart key={name} name={name} /> : <Part key={name} view={nodeView(r, name)} />))}
        </ul>
      </section>
      <section class="card wide">
        <h2>{t('health.emergencies')}</h2>
        <Emergencies list={emergencies} />
      </section>
      <Bus r={r} />
      <BusCounts r={r} />
      <section class="card">
        <h2>{t('health.power')}</h2>
        <Line label={t('health.batteryA')} value={n(batteries(r)[0], 2, 'V')} />
        <Line label={t('health.batteryB')} value={n(batteries(r)[1], 2, 'V')} />
        <Line label={t('health.supplyLeft')} value={n(r?.left_supply_v, 2, 'V')} />
        <Line label={t('health.supplyRight')} value={n(r?.right_supply_v, 2, 'V')} />
        <Line label={t('health.currentLeft')} value={n(r?.left_current_a, 2, 'A')} />
        <Line label={t('health.currentRight')} value={n(r?.right_current_a, 2, 'A')} />
      </section>
      <section class="card">
        <h2>{t('health.bumpers')}</h2>
        {bumperKeys.map((key, bit) => {
          const pressed = r !== null && ((r.bumpers >>> bit) & 1) === 1;
          return (
            <Line
              key={key}
              label={t(key)}
              value={r === null ? '–' : pressed ? t('health.pressed') : t('health.free')}
              state={pressed ? 'bad' : 'good'}
            />
          );
        })}
      </section>
      <section class="card">
        <h2>{t('health.link')}</h2>
        <Line
          label={t('health.part.server')}
          value={r === null ? '–' : t(r.server_alive === 1 ? 'health.answers' : 'health.silent')}
          state={r === null || r.server_alive === 1 ? 'good' : 'bad'}
        />
        <Line label={t('health.rtt')} value={n(rtt_s === null ? undefined : rtt_s * 1000, 0, 'ms')} />
        <Line label={t('health.lost')} value={fixed(live.lost, 0)} />
        <Line label={t('health.refusedCommands')} value={fixed(r?.commands_refused, 0)} />
        <Line label={t('health.role')} value={textOf(`role.${role}`) ?? '–'} />
        <Line
          label={t('health.recording')}
          value={
            silent
              ? '–'
              : recording.state === 'recording'
                ? t('sessions.one', { n: recording.session ?? '–' })
                : recording.state === 'failed'
                  ? (reasonText(recording.reason) ?? t('bar.recordingFailed'))
                  : t('bar.recordingOff')
          }
        />
        <StoredRecordings file={recordings} />
        <Line label={t('health.version')} value={version || '–'} />
      </section>
      <Loop r={r} />
      <section class="card wide">
        <h2>{t('health.log')}</h2>
        <Events log={log} />
      </section>
    </div>
  );
}
