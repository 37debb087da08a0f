// Always visible: what the hoist does, who is in control, how good the link is, whether it records, how full the batteries are.
import { useEffect, useRef, useState } from 'preact/hooks';
import { modes } from '../contract/faults.gen';
import { signOut } from '../link/account';
import { ensureLease, notify, releaseLease } from '../link/console';
import { useReading } from '../link/live';
import { batteries, useReadiness } from '../link/readiness';
import { useStore } from '../link/store';
import { addressOf } from '../router';
import { problemText } from '../text/server';
import { settings, useSettings, type Theme } from '../text/settings';
import { duration, fixed, noValue, t, words } from '../text/text';
import { Icon } from './icons';
import { LanguageChoice } from './language_choice';
import { nameOf } from './lease_ask';
import { tell } from './refusal';
import './status_bar.css';

const themes: readonly { id: Theme; key: 'bar.themeAuto' | 'bar.themeLight' | 'bar.themeDark' }[] = [
  { id: 'auto', key: 'bar.themeAuto' },
  { id: 'light', key: 'bar.themeLight' },
  { id: 'dark', key: 'bar.themeDark' },
];
/** Round-trip limits for a fair and a poor link. */
const fair_s = 0.08;
const poor_s = 0.2;
const sampleRate_hz = 100;
/** A pair of full 12 V lead batteries at rest. */
const full_v = 25.6;

export function StatusBar() {
  useSettings();
  const simulated = useStore((s) => s.simulated);
  return (
    <header class="bar">
      <ModeChip />
      <div class="bar-where">
        {simulated ? <span class="simulation">{t('bar.simulation')}</span> : null}
        <ChosenPatient />
      </div>
      <span class="bar-gap" />
      <Control />
      <LinkQuality />
      <RecordingMark />
      <Battery />
      <DisplayMenu />
    </header>
  );
}

function ModeChip() {
  const mode = useStore((s) => s.mode);
  const { known, lost, old, motion } = useReadiness();
  const row = modes.find((item) => item.name === mode)!;
  return (
    <div class={`mode${lost ? '' : ` mode-${mode}`}${old ? ' old' : ''}`} role="status">
      <strong>{lost ? t('bar.unknown') : words(row.title)}</strong>
      <span>{!known ? noValue : motion === null ? t('bar.old') : t(motion === 'still' ? 'bar.still' : 'bar.moving')}</span>
    </div>
  );
}

/** By code: a name stands on the patient's own page only. */
function ChosenPatient() {
  const patient = useStore((s) => s.patient);
  const known = useStore((s) => s.link === 'open');
  return (
    <a
      class={known ? 'bar-item bar-patient' : 'bar-item bar-patient old'}
      href={addressOf('home')}
      aria-label={`${t('home.patient')}: ${patient?.code ?? t('home.none')}`}
    >
      <span class="bar-label">{t('bar.patient')}</span>
      <span class="bar-value">{patient?.code ?? noValue}</span>
    </a>
  );
}

function Item({ label, value, old, children }: { label: string; value: string; old?: boolean; children?: preact.ComponentChildren }) {
  return (
    <div class={old ? 'bar-item old' : 'bar-item'}>
      <span class="bar-label">{label}</span>
      <span class="bar-value">
        {children}
        <span class="num">{value}</span>
      </span>
    </div>
  );
}

function Control() {
  const { lead, led, may } = useReadiness();
  const mine = lead === 'mine';
  const who = useStore((s) => nameOf(s.lease.actor));
  const free = lead === 'nobody' && led && may;
  const mayGive = mine && !led;
  const value =
    lead === 'other' && who !== null
      ? who
      : lead === null
        ? noValue
        : t(({ mine: 'bar.controlMine', other: 'bar.controlOther', nobody: 'bar.controlNobody' } as const)[lead]);
  return (
    <div class={free || mayGive ? 'bar-item control with-button' : 'bar-item control'}>
      <span class="bar-label">{t('bar.control')}</span>
      <span class="bar-value">{value}</span>
      <button type="button" class="link-button" hidden={!mayGive} aria-label={t('bar.giveBack')} onClick={() => void releaseLease()}>
        {t('bar.giveBackShort')}
      </button>
      {/* Of a hoist that is led, whose console has gone: there is no Start to take control with. */}
      <button
        type="button"
        class="link-button"
        hidden={!free}
        aria-label={`${t('bar.control')}: ${t('lease.take')}`}
        onClick={() => void ensureLease().then(tell)}
      >
        {t('lease.take')}
      </button>
    </div>
  );
}

function LinkQuality() {
  const link = useStore((s) => s.link);
  const rtt_s = useStore((s) => s.rtt_s);
  const ever = useStore((s) => s.everOpen);
  const grade = link !== 'open' ? 0 : rtt_s === null || rtt_s < fair_s ? 3 : rtt_s < poor_s ? 2 : 1;
  const value =
    link === 'open'
      ? t('bar.milliseconds', { n: rtt_s === null ? '–' : fixed(rtt_s * 1000, 0) })
      : ever
        ? t('bar.linkLost')
        : t('bar.linkConnecting');
  return (
    <Item label={t('bar.link')} value={value}>
      <svg class={`bars grade-${grade}`} viewBox="0 0 18 14" aria-hidden="true">
        <rect x="0" y="9" width="4" height="5" />
        <rect x="7" y="5" width="4" height="9" />
        <rect x="14" y="0" width="4" height="14" />
      </svg>
    </Item>
  );
}

function RecordingMark() {
  const { state, samples, standby } = useStore((s) => s.recording);
  const known = useStore((s) => s.link === 'open');
  if (known && state === 'recording')
    return (
      <Item label={t('bar.recording')} value={standby ? t('bar.standby') : duration(samples / sampleRate_hz)}>
        <span class="dot on" aria-hidden="true" />
      </Item>
    );
  const failed = known && state === 'failed';
  const said = t(!known ? 'bar.unknown' : failed ? 'bar.recordingFailed' : 'bar.recordingOff');
  return (
    <div class="bar-item recording">
      <span class="bar-label">{t('bar.recording')}</span>
      <span class="bar-value" title={said}>
        {known ? <span class={failed ? 'dot failed' : 'dot'} aria-hidden="true" /> : null}
        {failed ? '!' : noValue}
        <span class="visually-hidden">{said}</span>
      </span>
    </div>
  );
}

function Battery() {
  const { old } = useReadiness();
  const empty_v = useStore((s) => s.parameters.battery_empty_v ?? 22);
  const low_v = useStore((s) => s.parameters.battery_low_v ?? 23);
  const volts = useReading('power', (r) => Math.round((batteries(r)[0] + batteries(r)[1]) * 10) / 10, 1);
  const share = Number.isFinite(volts) ? Math.max(0, Math.min(1, (volts - empty_v) / (full_v - empty_v))) : 0;
  return (
    <Item label={t('bar.battery')} value={`${fixed(volts, 1)} V`} old={old}>
      <svg class={volts < low_v ? 'battery low' : 'battery'} viewBox="0 0 26 14" aria-hidden="true">
        <rect class="battery-edge" x="1" y="1" width="21" height="12" rx="2.5" />
        <rect class="battery-edge" x="23" y="5" width="2" height="4" />
        <rect class="battery-fill" x="3" y="3" width={17 * share} height="8" rx="1" />
      </svg>
    </Item>
  );
}

function DisplayMenu() {
  const { theme } = useSettings();
  const [open, setOpen] = useState(false);
  const person = useStore((s) => s.person);
  const account = useStore((s) => s.account);
  const leave = async () => {
    setOpen(false);
    const problem = await signOut();
    if (problem !== null) notify('error', problemText(problem), true);
  };
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    if (!open) return;
    const away = (event: Event) => {
      if (!box.current?.contains(event.target as Node)) setOpen(false);
    };
    const escape = (event: KeyboardEvent) => event.key === 'Escape' && setOpen(false);
    document.addEventListener('pointerdown', away);
    document.addEventListener('keydown', escape);
    return () => {
      document.removeEventListener('pointerdown', away);
      document.removeEventListener('keydown', escape);
    };
  }, [open]);
  return (
    <div class="menu" ref={box}>
      <button type="button" class="menu-button" aria-label={t('bar.settings')} aria-expanded={open} onClick={() => setOpen(!open)}>
        <Icon name="settings" />
      </button>
      {open ? (
        <div class="menu-box card">
          <span class="bar-label">{t('bar.language')}</span>
          <LanguageChoice />
          <span class="bar-label">{t('bar.theme')}</span>
          <div class="choice" role="radiogroup" aria-label={t('bar.theme')}>
            {themes.map((item) => (
              <button key={item.id} type="button" role="radio" aria-checked={item.id === theme} onClick={() => settings.set({ theme: item.id })}>
                {t(item.key)}
              </button>
            ))}
          </div>
          {person !== null ? (
            <p class="menu-person">
              <span class="bar-label">{t('health.role')}</span>
              <strong>{person}</strong>
            </p>
          ) : null}
          {account ? (
            <button type="button" class="plain" onClick={() => void leave()}>
              {t('signin.change')}
            </button>
          ) : null}
          <a class="plain" href={addressOf('settings')} onClick={() => setOpen(false)}>
            {t('nav.settings')}
          </a>
        </div>
      ) : null}
    </div>
  );
}
