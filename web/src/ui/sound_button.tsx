// The sound of alarms on this screen, and the button for it at the end of the strip: off until a tap, pause, paused.
import { useEffect, useReducer, useRef } from 'preact/hooks';
import type { FaultInfo } from '../contract/faults.gen';
import { notify, pauseAlarm } from '../link/console';
import { useStore } from '../link/store';
import { t } from '../text/text';
import { AlarmSound, type AlarmLevel } from './alarm_sound';
import { Icon } from './icons';
import { OwnPause } from './own_pause';
import { reasons } from './refusal';
import './sound_button.css';

/** What the strip shows, as far as its sound goes. `hoist`: an alarm that sounds at the hoist, too. */
export interface Sounding {
  id: string;
  priority: FaultInfo['priority'] | 'calm';
  hoist: boolean;
}

const levels: readonly (AlarmLevel | null)[] = [null, 'low', 'medium', 'high'];
const rank = (level: AlarmLevel | null) => levels.indexOf(level);
export const louder = (a: AlarmLevel | null, b: AlarmLevel | null): AlarmLevel | null => (rank(a) < rank(b) ? b : a);

/** The most urgent of these that may sound here; the hoist says for its own alarms what sounds (`hoistSound`, value of alarm_sound). */
export function levelOf(alarms: readonly Sounding[], sounding: readonly string[], hoistSound: number): AlarmLevel | null {
  const may = alarms.filter((alarm) => sounding.includes(alarm.id));
  const own = may
    .filter((alarm) => !alarm.hoist)
    .reduce<AlarmLevel | null>((most, alarm) => (alarm.priority === 'calm' ? most : louder(most, alarm.priority)), null);
  return may.some((alarm) => alarm.hoist) ? louder(own, levels[hoistSound] ?? null) : own;
}

const perSecond_ms = 1000;
const clock = (left_s: number) => `${Math.floor(left_s / 60)}:${String(left_s % 60).padStart(2, '0')}`;

/** Outlives the button: who signs in after another person need not tap once more to hear alarms. */
const sound = new AlarmSound(
  () => new AudioContext(),
  { after: (call, delay_ms) => window.setTimeout(call, delay_ms), cancel: (timer) => window.clearTimeout(timer) },
  () => changed(),
);
let changed = () => {};

export function SoundButton({ alarms }: { alarms: readonly Sounding[] }) {
  const [, again] = useReducer((n: number) => n + 1, 0);
  const role = useStore((s) => s.role);
  const hoistSound = useStore((s) => s.alarmSound);
  const hoistPause_s = useStore((s) => s.alarmPause_s);
  const own = useRef(new OwnPause()).current;
  changed = () => again(0);
  // A viewer may not silence the hoist, but this screen.
  const viewer = role === 'viewer';
  const mine = alarms.filter((alarm) => viewer || !alarm.hoist).map((alarm) => alarm.id);
  const now_ms = performance.now();
  const heard = own.sounding(mine, now_ms);
  const others = alarms.filter((alarm) => !viewer && alarm.hoist).map((alarm) => alarm.id);
  const level = levelOf(alarms, [...heard, ...others], hoistSound);
  const left_s = Math.ceil(Math.max(own.left_s(now_ms), alarms.some((alarm) => alarm.hoist) ? hoistPause_s : 0));

  useEffect(() => sound.play(level), [level]);
  useEffect(() => {
    const unlock = () => sound.unlock();
    window.addEventListener('pointerup', unlock, true);
    window.addEventListener('keydown', unlock, true);
    return () => {
      window.removeEventListener('pointerup', unlock, true);
      window.removeEventListener('keydown', unlock, true);
      sound.play(null);
    };
  }, []);
  const counts = left_s > 0;
  useEffect(() => {
    if (!counts) return;
    const timer = window.setInterval(() => again(0), perSecond_ms);
    return () => window.clearInterval(timer);
  }, [counts]);

  const ask = async (paused: boolean) => {
    if (paused) own.begin(mine, performance.now());
    else own.end();
    again(0);
    if (viewer || !(paused ? hoistSound > 0 : hoistPause_s > 0)) return;
    const reply = await pauseAlarm(paused);
    // Its alarms have ended meanwhile: then there is nothing to pause.
    if (!reply.ok && !reply.refusals.includes('out_of_order')) notify('warning', reasons(reply).join(' '), true);
  };

  // The tap itself lets sound begin; the button only says so.
  if (sound.blocked)
    return (
      <button type="button" class="quiet sound" aria-label={t('sound.off')}>
        <Icon name="silent" />
        <span class="sound-words">{t('sound.off')}</span>
      </button>
    );
  if (level !== null)
    return (
      <button type="button" class="quiet sound" aria-label={t('sound.pause')} onClick={() => void ask(true)}>
        <Icon name="sound" />
        <span class="sound-words">{t('sound.pause')}</span>
      </button>
    );
  if (left_s > 0)
    return (
      <button type="button" class="quiet sound" aria-label={t('sound.resume')} onClick={() => void ask(false)}>
        <Icon name="silent" />
        <span class="sound-words">{t('sound.paused')}</span> {clock(left_s)}
      </button>
    );
  return null;
}
