// The control loop: lateness, missed steps, and granted real-time settings. The full picture is for engineers.
import type { TickRecord } from '../../contract/signals.gen';
import { useQuery } from '../../link/query';
import { rest } from '../../link/rest';
import { useStore } from '../../link/store';
import { loop as texts } from '../../text/loop';
import { addTexts, fixed, t } from '../../text/text';
import { columns, columnsOf, heightsOf, placeOf, type LoopReport } from './lateness';
import { Line } from './line';

addTexts(texts);

const askEvery_ms = 2000;
const noCpu = 255;
/** From here on the core counts a step as late. */
const counted_s = 0.002;
/** Two within a second beyond this share of the limit also stop the hoist. */
const lateShare = 1 / 6;

const marks = [
  [1e-6, '1 µs'],
  [1e-5, '10 µs'],
  [1e-4, '100 µs'],
  [1e-3, '1 ms'],
  [1e-2, '10 ms'],
  [1e-1, '100 ms'],
] as const;

function Picture({ report }: { report: LoopReport }) {
  const ever = heightsOf(columnsOf(report.ever));
  const lately = heightsOf(columnsOf(report.lately));
  const bar = (height: number, column: number, kind: string) =>
    height === 0 ? null : <rect key={`${kind} ${column}`} class={kind} x={column * 10 + 1} y={100 - height * 100} width="8" height={height * 100} />;
  return (
    <figure class="lateness">
      <svg viewBox={`0 0 ${columns * 10} 100`} preserveAspectRatio="none" role="img" aria-label={t('loop.picture')}>
        <rect class="lateness-late" x={placeOf(counted_s) * columns * 10} y="0" width={(1 - placeOf(counted_s)) * columns * 10} height="100" />
        {ever.map((height, column) => bar(height, column, 'lateness-ever'))}
        {lately.map((height, column) => bar(height, column, 'lateness-lately'))}
      </svg>
      <div class="lateness-scale num" aria-hidden="true">
        {marks.map(([time_s, text]) => (
          <span key={text} style={{ left: `${placeOf(time_s) * 100}%` }}>
            {text}
          </span>
        ))}
      </div>
      <figcaption class="lateness-key">
        <span class="key-lately">{t('loop.lately')}</span>
        <span class="key-ever">{t('loop.ever')}</span>
        <span class="key-late">{t('loop.counted', { ms: fixed(counted_s * 1e3, 0) })}</span>
      </figcaption>
    </figure>
  );
}

/** First facts to check when steps are late. */
function Granted({ r }: { r: TickRecord | null }) {
  const known = r !== null;
  const priority = known && r.loop_priority > 0;
  const locked = known && r.memory_locked === 1;
  const zero = (value: number | undefined) => (value === undefined || value === 0 ? 'good' : 'bad');
  return (
    <div>
      <Line
        label={t('loop.priority')}
        value={!known ? '–' : priority ? fixed(r.loop_priority, 0) : t('loop.notGranted')}
        state={!known || priority ? 'good' : 'bad'}
      />
      <Line label={t('loop.cpu')} value={!known ? '–' : r.loop_cpu === noCpu ? t('loop.anyCpu') : fixed(r.loop_cpu, 0)} />
      <Line label={t('loop.memory')} value={!known ? '–' : t(locked ? 'loop.locked' : 'loop.notLocked')} state={!known || locked ? 'good' : 'bad'} />
      <Line label={t('loop.pageFaults')} value={fixed(r?.page_faults, 0)} state={zero(r?.page_faults)} />
      <Line label={t('loop.allocations')} value={fixed(r?.allocations, 0)} state={zero(r?.allocations)} />
    </div>
  );
}

export function Loop({ r }: { r: TickRecord | null }) {
  const engineer = useStore((s) => s.role) === 'engineer';
  const open = useStore((s) => s.link === 'open');
  const tooLate_s = useStore((s) => s.parameters.loop_late_s_max) ?? 0.03;
  const told = useQuery(engineer && open ? () => rest('GET /api/v1/loop') : null, [], askEvery_ms).value;
  const report = r === null ? null : told; // an old report must not pass as current
  const ms = (value_s: number | undefined) => `${fixed(value_s === undefined ? undefined : value_s * 1e3, 2)} ms`;
  const short = (
    <div>
      <Line label={t('loop.half')} value={ms(r?.lateness_p50_s)} />
      <Line label={t('loop.most')} value={ms(r?.lateness_p99_s)} />
      <Line label={t('loop.latest')} value={ms(r?.lateness_max_s)} />
      <Line label={t('health.duration')} value={ms(r?.tick_duration_s)} />
      <Line label={t('health.overruns')} value={fixed(r?.overruns, 0)} />
      <Line label={t('loop.missed')} value={fixed(r?.missed_ticks, 0)} />
    </div>
  );
  if (!engineer)
    return (
      <section class="card">
        <h2>{t('health.loop')}</h2>
        {short}
      </section>
    );
  return (
    <section class="card wide">
      <h2>{t('health.loop')}</h2>
      <p class="hint">{t('loop.hint', { two: fixed(tooLate_s * 1e3 * lateShare, 0), one: fixed(tooLate_s * 1e3, 0) })}</p>
      {/* Space is reserved before the first answer, so that nothing jumps. */}
      <Picture report={report ?? { steps: 0, latest_ever_s: 0, longest_step_s: 0, lately: [], ever: [] }} />
      <div class="loop-columns">
        {short}
        <div>
          <Granted r={r} />
          <Line label={t('loop.latestEver')} value={ms(report?.latest_ever_s)} />
        </div>
      </div>
    </section>
  );
}
