// Under the status bar: the most important alarm whole, with what to do, else one sentence (decision 78).
import { useEffect, useRef, useState } from 'preact/hooks';
import { alarmSignals, type FaultInfo, type FaultName } from '../contract/faults.gen';
import type { StandingNotice } from '../contract/rest.gen';
import { acknowledge, notify } from '../link/console';
import { useReadiness } from '../link/readiness';
import { slowerBecause } from '../link/speed_cause';
import { useStore } from '../link/store';
import { useSettings } from '../text/settings';
import { fixed, refusalText, t, textOf, words } from '../text/text';
import { activeFaults, toldFaults, type FaultCodes } from './alarms';
import { deviceOfCan, deviceOfNode } from './device';
import { Scroll } from './scroll';
import { HoldButton } from './hold_button';
import { reasonText } from '../text/server';
import { tell } from './refusal';
import { SoundButton } from './sound_button';
import './strip.css';

type Priority = FaultInfo['priority'] | 'calm';
export interface Alarm {
  id: string;
  priority: Priority;
  text: string;
  action: string;
  /** A consequence, shown under its cause. */
  follows?: boolean;
  /** A fault of the hoist, which sounds there, too. */
  hoist?: boolean;
}
const rank: Record<Priority, number> = { high: 0, medium: 1, low: 2, calm: 3 };
const marks: Record<Priority, string> = { high: '!!!', medium: '!!', low: '!', calm: '' };
export const releaseHold_ms = 2000;

/** Problems of the storage. A file of another program is the cause of "not recording", shown once. */
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
  const bits = useStore((s) => s.faultBits);
  const stopCause = useStore((s) => s.stopCause);
  const cause = useStore((s) => s.speedCause);
  const codes = useStore((s) => s.faultCodes);
  const silent = useStore((s) => s.silentNodes);
  const ready = useReadiness();
  const reason = useStore((s) => s.coreReason);
  const layout = useStore((s) => s.layoutDiffers);
  const failed = useStore((s) => s.stopFailed);
  const sending = useStore((s) => s.stopSent);
  const recording = useStore((s) => s.recording.state);
  const standing = useStore((s) => s.standing);
  const duplicateId = useStore((s) => s.duplicateId);
  const babblingId = useStore((s) => s.babblingId);
  const [all, setAll] = useState(false);
  const [busy, setBusy] = useState(false);
  // The causes shown at the press: a later one is not released with them.
  const seen = useRef<readonly FaultName[]>([]);

  const alarms: Alarm[] = [];
  const add = (id: string, priority: Priority, text: string, action = '', follows = false, hoist = false) =>
    alarms.push({ id, priority, text, action, follows, hoist });
  if (failed) add('stop', 'high', t('stop.failed'));
  if (layout) add('layout', 'high', t('strip.layout'), t('strip.layoutAction'));
  if (!signedIn) add('signedOut', 'high', t('strip.signedOut'), t('strip.signedOutAction'));
  else if (link === 'open' && core === false)
    add('core', 'high', t('strip.core'), [reasonText(reason), t('strip.coreAction')].filter((text) => text !== null).join(' '));
  else if (link === 'open' ? data === 'gone' : ever && data !== 'fresh') add('link', 'high', t('strip.lost'), t('strip.lostAction'));
  const device: Partial<Record<FaultName, string | null>> = { node_duplicate: deviceOfNode(duplicateId), node_babbling: deviceOfCan(babblingId) };
  if (data !== 'gone' && data !== 'none')
    for (const { fault, text, action, consequenceOf } of toldFaults(bits, stopCause, JSON.parse(codes) as FaultCodes)) {
      const name = device[fault.name];
      add(fault.name, fault.priority, name ? `${words(text)}: ${name}` : words(text), words(action), consequenceOf !== null, true);
    }
  for (const alarm of storageAlarms(standing, recording === 'failed')) {
    const lower = alarms.findIndex((other) => !other.follows && rank[other.priority] > rank[alarm.priority]);
    alarms.splice(lower < 0 ? alarms.length : lower, 0, alarm);
  }
  // The first alarm need not have the highest priority; the colour shows that.
  const worst = alarms.reduce<Priority>((most, alarm) => (rank[alarm.priority] < rank[most] ? alarm.priority : most), 'calm');

  const calm = sending
    ? t('stop.sending')
    : t(ready.calm, {
        parts: silent
          .split(' ')
          .map((part) => textOf(`health.part.${part}`))
          .join(', '),
      });
  const slower = slowerBecause(ready.calm, cause);
  const why = sending ? '' : ready.calm === 'strip.notReady' ? refusalText(ready.start.user[0]!) : slower ? words(slower) : '';
  const first: Alarm = alarms[0] ?? { id: 'calm', priority: 'calm', text: calm, action: why };
  const more = alarms.slice(1);
  // Consequences are shown but not counted.
  const others = more.filter((alarm) => !alarm.follows).length;

  // The next alarm begins with its line alone.
  const calmNow = alarms.length === 0;
  useEffect(() => {
    if (calmNow) setAll(false);
  }, [calmNow]);

  const release = async () => {
    setBusy(true);
    const reply = await acknowledge(seen.current);
    setBusy(false);
    if (reply.ok) notify('info', t('stop.released'), true);
    else tell(reply);
  };

  const flash_ms = worst === 'calm' ? 0 : alarmSignals[worst].flash_ms;
  return (
    <div class={flash_ms > 0 ? `strip ${worst} flashes` : `strip ${worst}`} style={{ animationDuration: `${flash_ms}ms` }}>
      {/* First, because on a narrow screen the text flows around them. */}
      <div class="strip-buttons">
        {more.length > 0 ? (
          <button
            type="button"
            class="quiet"
            aria-expanded={all}
            aria-label={others > 0 ? t('strip.others', { n: others }) : t('strip.effects')}
            onClick={() => setAll(!all)}
          >
            {others > 0 ? `+${others}` : '…'}
          </button>
        ) : null}
        <SoundButton alarms={alarms.map(({ id, priority, hoist }) => ({ id, priority, hoist: hoist === true }))} />
        {ready.stopped && ready.reachable ? (
          <HoldButton
            label={t('stop.release')}
            hint={ready.may ? t('stop.releaseHint') : refusalText('not_allowed')}
            hold_ms={releaseHold_ms}
            disabled={busy || !ready.may}
            onBegin={() => {
              seen.current = activeFaults(bits).map((fault) => fault.name);
            }}
            onDone={() => void release()}
          />
        ) : null}
      </div>
      <div class="strip-text" role={worst === 'high' ? 'alert' : 'status'} aria-live={worst === 'high' ? 'assertive' : 'polite'}>
        {first.priority === 'calm' ? null : (
          <span class="strip-mark" role="img" aria-label={t(`priority.${first.priority}`)}>
            {marks[first.priority]}
          </span>
        )}
        <span class="strip-words">
          <strong>{first.text}</strong> {/* Not read aloud: the whole sentence would be read again each second. */}
          {first.id === 'link' && data !== 'none' ? <strong aria-hidden="true">· {t('strip.noData', { s: fixed(age_s, 0) })} </strong> : null}
          <span>{first.action}</span>
        </span>
      </div>
      {all && more.length > 0 ? (
        <Scroll class="strip-more card" label={t('priority.medium')}>
          <ul>
            {alarms.map((alarm) => (
              <li key={alarm.id} class={alarm.follows ? 'follows' : undefined}>
                <strong>
                  {alarm.follows ? '' : marks[alarm.priority]} {alarm.text}
                </strong>{' '}
                {alarm.follows ? '' : alarm.action}
              </li>
            ))}
          </ul>
        </Scroll>
      ) : null}
    </div>
  );
}
