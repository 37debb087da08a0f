// The line under the status bar: the most important alarm with what to do, or in calm times one sentence. Its height never changes.
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { faults, type FaultInfo, type FaultName } from '../contract/faults.gen';
import type { StandingNotice } from '../contract/messages.gen';
import { acknowledge, notify } from '../link/console';
import { stopped, useStore } from '../link/store';
import { useSettings } from '../text/settings';
import { fixed, t, words } from '../text/text';
import { deviceOfCan, deviceOfNode } from './device';
import { HoldButton } from './hold_button';
import { reasons } from './refusal';

type Priority = FaultInfo['priority'] | 'calm';
export interface Alarm {
  id: string;
  priority: Priority;
  text: string;
  action: string;
}
const rank: Record<Priority, number> = { high: 0, medium: 1, low: 2, calm: 3 };
const marks: Record<Priority, string> = { high: '!!!', medium: '!!', low: '!', calm: '' };
export const releaseHold_ms = 2000;

/** The active faults, most important first. */
export function activeFaults(bits: number): FaultInfo[] {
  return faults.filter((fault) => (bits >>> fault.bit) & 1).sort((a, b) => rank[a.priority] - rank[b.priority] || a.bit - b.bit);
}

/** What is wrong with the storage. A file of another program is the reason why nothing is recorded: told once. */
export function storageAlarms(standing: readonly StandingNotice[], recordingFailed: boolean): Alarm[] {
  const alarms = standing.map((notice) => ({ id: notice.name, priority: notice.priority, text: words(notice.text), action: words(notice.action) }));
  if (!recordingFailed || standing.some((notice) => notice.name === 'recordings_foreign')) return alarms;
  return [...alarms, { id: 'recording', priority: 'medium', text: t('strip.recordingFailed'), action: t('strip.recordingFailedAction') }];
}

export function Strip() {
  useSettings();
  const link = useStore((s) => s.link);
  const signedIn = useStore((s) => s.signedIn);
  const ever = useStore((s) => s.everOpen);
  const data = useStore((s) => s.data);
  const age_s = useStore((s) => s.dataAge_s);
  const core = useStore((s) => s.coreConnected);
  const mode = useStore((s) => s.mode);
  const bits = useStore((s) => s.faultBits);
  const mine = useStore((s) => s.lease.mine);
  const bumpers = useStore((s) => s.bumpers);
  const layout = useStore((s) => s.layoutDiffers);
  const failed = useStore((s) => s.stopFailed);
  const sending = useStore((s) => s.stopSent);
  const recording = useStore((s) => s.recording.state);
  const standing = useStore((s) => s.standing);
  const duplicateId = useStore((s) => s.duplicateId);
  const babblingId = useStore((s) => s.babblingId);
  const [all, setAll] = useState(false);
  const [busy, setBusy] = useState(false);
  // What was shown when the hand went down: something that comes while it rests there is not released with it.
  const seen = useRef<readonly FaultName[]>([]);

  const alarms: Alarm[] = [];
  const add = (id: string, priority: Priority, text: string, action = '') => alarms.push({ id, priority, text, action });
  if (failed) add('stop', 'high', t('stop.failed'));
  if (layout) add('layout', 'high', t('strip.layout'), t('strip.layoutAction'));
  if (!signedIn) add('signedOut', 'high', t('strip.signedOut'), t('strip.signedOutAction'));
  else if (ever && link !== 'open' && data !== 'fresh')
    add('link', 'high', data === 'none' ? t('strip.lost') : `${t('strip.lost')} · ${t('strip.noData', { s: fixed(age_s, 0) })}`, t('strip.lostAction'));
  else if (link === 'open' && core === false) add('core', 'high', t('strip.core'), t('strip.coreAction'));
  else if (link === 'open' && data === 'gone') add('data', 'high', t('strip.noData', { s: fixed(age_s, 0) }), t('strip.lostAction'));
  const device: Partial<Record<FaultName, string | null>> = { node_duplicate: deviceOfNode(duplicateId), node_babbling: deviceOfCan(babblingId) };
  if (data !== 'gone' && data !== 'none')
    for (const fault of activeFaults(bits)) {
      const name = device[fault.name];
      add(fault.name, fault.priority, name ? `${words(fault.text)}: ${name}` : words(fault.text), words(fault.action));
    }
  alarms.push(...storageAlarms(standing, recording === 'failed'));
  alarms.sort((a, b) => rank[a.priority] - rank[b.priority]);

  const calm = sending
    ? t('stop.sending')
    : link !== 'open' || data === 'none'
      ? t('strip.connecting')
      : mode === 'user'
        ? t('strip.walking')
        : mode === 'remote'
          ? t(bumpers !== 0 ? 'strip.offBumper' : mine ? 'strip.driving' : 'strip.drivingOther')
          : mode === 'guided'
            ? t(mine ? 'strip.guiding' : 'strip.drivingOther')
            : mode === 'init'
              ? t('strip.starting')
              : mode === 'calibrate'
                ? t('strip.calibrating')
                : t('strip.ready');
  const first: Alarm = alarms[0] ?? { id: 'calm', priority: 'calm', text: calm, action: '' };
  const more = alarms.slice(1);

  // What to do must be readable to its end, also where the line is too short for it.
  const line = useRef<HTMLSpanElement>(null);
  const [cut, setCut] = useState(false);
  useLayoutEffect(() => {
    const measure = () => setCut(line.current !== null && line.current.scrollHeight > line.current.clientHeight + 1);
    measure();
    window.addEventListener('resize', measure);
    return () => window.removeEventListener('resize', measure);
  }, [first.text, first.action, cut, more.length, mode]);
  // The next alarm begins with its line alone.
  const calmNow = alarms.length === 0;
  useEffect(() => {
    if (calmNow) setAll(false);
  }, [calmNow]);
  const openable = more.length > 0 || (alarms.length > 0 && (cut || all));

  const release = async () => {
    setBusy(true);
    const reply = await acknowledge(seen.current);
    setBusy(false);
    if (reply.ok) notify('info', t('stop.released'), true);
    else if (reply.refusals[0] !== 'kept') notify('warning', reasons(reply).join(' '), true);
  };

  return (
    <div class={`strip ${first.priority}`}>
      <div class="strip-text" role={first.priority === 'high' ? 'alert' : 'status'} aria-live={first.priority === 'high' ? 'assertive' : 'polite'}>
        {first.priority === 'calm' ? null : (
          <span class="strip-mark" role="img" aria-label={t(`priority.${first.priority}`)}>
            {marks[first.priority]}
          </span>
        )}
        <span ref={line} class="strip-words">
          <strong>{first.text}</strong> <span>{first.action}</span>
        </span>
      </div>
      {openable ? (
        <button
          type="button"
          class="quiet"
          aria-expanded={all}
          aria-label={more.length > 0 ? t('strip.others', { n: more.length }) : t('strip.whole')}
          onClick={() => setAll(!all)}
        >
          {more.length > 0 ? `+${more.length}` : '…'}
        </button>
      ) : null}
      {stopped(mode) && link === 'open' ? (
        <HoldButton
          label={t('stop.release')}
          hint={t('stop.releaseHint')}
          hold_ms={releaseHold_ms}
          disabled={busy}
          onBegin={() => {
            seen.current = activeFaults(bits).map((fault) => fault.name);
          }}
          onDone={() => void release()}
        />
      ) : null}
      {all && openable ? (
        <ul class="strip-more card">
          {alarms.map((alarm) => (
            <li key={alarm.id}>
              <strong>
                {marks[alarm.priority]} {alarm.text}
              </strong>{' '}
              {alarm.action}
            </li>
          ))}
        </ul>
      ) : null}
    </div>
  );
}
