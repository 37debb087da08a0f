// The frame around every screen: status bar, alarm strip, menu, STOP.
import { useEffect, useRef, useState } from 'preact/hooks';
import { wasSignedIn } from './link/known';
import { askLease, dialogs, takenSeen } from './link/console';
import { useReadiness } from './link/readiness';
import { store, useStore } from './link/store';
import { menu, panelOf, panels } from './panels/index';
import type { Panel } from './panels/panel';
import { addressOf, useAddress } from './router';
import { reasonText } from './text/server';
import { settings, useSettings } from './text/settings';
import { loadLanguage, offerLanguage, t, textOf } from './text/text';
import { Icon } from './ui/icons';
import { Lazy, LoadFailed, Loading, useLazy } from './ui/lazy';
import { LeaseAsk, nameOf } from './ui/lease_ask';
import { Question } from './ui/question';
import { tell } from './ui/refusal';
import { StatusBar } from './ui/status_bar';
import { StopButton } from './ui/stop_button';
import { Strip } from './ui/strip';
import { TrialBar } from './ui/trial_bar';
import './app.css';

/** Texts of this device's language. */
export const firstWords = new Lazy(() => loadLanguage(settings.value.language));

/** Signing in and the first set-up. */
const signIn = new Lazy(async () => (await import('./panels/sign_in/sign_in')).SignInView);

/** STOP and its dependencies are loaded before any other file, and work when another file fails to load. */
export function App() {
  const words = useLazy(firstWords);
  const signedIn = useStore((s) => s.signedIn);
  // Signed out in the middle of a walk, or without being asked, the shell stays and says what to do.
  const gate = !useStore((s) => s.everOpen) && !signedIn;
  const { asking, answer } = useTakeOver();
  const { led } = useReadiness();
  if (words.state === 'ready' && gate) return <Gate />;
  return (
    <div class={`shell${led ? ' led' : ''}${asking ? ' asking' : ''}`}>
      {words.state === 'ready' ? <Strip /> : null}
      {/* While a question is open, neither key nor finger reaches anything else except STOP and the alarms. */}
      <div class="shell-parts" inert={asking}>
        {words.state === 'ready' ? <Shell /> : <main class="main">{words.state === 'failed' ? <LoadFailed /> : null}</main>}
      </div>
      <StopButton />
      {asking ? <TakeOver answer={answer} /> : null}
    </div>
  );
}

/** Not signed in, and nothing shown yet. A device that was ever signed in can still STOP. */
function Gate() {
  return (
    <div class="gate">
      <main>
        <SignIn />
      </main>
      {wasSignedIn() ? <StopButton /> : null}
    </div>
  );
}

function SignIn() {
  const view = useLazy(signIn);
  if (view.state === 'failed') return <LoadFailed />;
  return view.state === 'loading' ? <Loading /> : <view.value />;
}

function Shell() {
  useSettings();
  const { screen, part } = useAddress();
  const panel = panelOf(screen);
  const signedIn = useStore((s) => s.signedIn);
  const stale = useReadiness().old && panel.live;
  const offered = useStore((s) => s.hoistLanguage);
  useEffect(() => offerLanguage(offered), [offered]);
  useEffect(() => {
    document.title = `${t(panel.title)} – ${t('app.title')}`;
  });
  return (
    <>
      <StatusBar />
      <nav class="nav" aria-label={t('nav.label')}>
        {menu.map((item) => (
          <a
            key={item.id}
            href={addressOf(item.id)}
            aria-current={item.id === (panel.under === undefined ? panel.id : panel.under) ? 'page' : undefined}
          >
            <Icon name={item.icon} />
            <span>{t(item.title)}</span>
          </a>
        ))}
      </nav>
      <main class={stale ? 'main stale' : 'main'}>
        <h1 class="visually-hidden">{t(panel.title)}</h1>
        {signedIn ? <Screen key={panel.id} panel={panel} part={part} /> : <SignIn />}
      </main>
      <div class="side-column">
        <div class="side-bars">
          <Taken />
          <LeaseAsk />
          <TrialBar />
        </div>
        <Notices />
      </div>
    </>
  );
}

function Screen({ panel, part }: { panel: Panel; part: string | null }) {
  const view = useLazy(panel.view);
  const live = useStore((s) => s.data === 'fresh');
  // Then the others, one after another: in the middle of a walk no screen should have to wait for a slow or renewed server.
  const ahead = view.state === 'ready' && live;
  useEffect(() => {
    if (ahead) void loadAhead();
  }, [ahead]);
  if (view.state === 'failed') return <LoadFailed />;
  if (view.state === 'loading') return <Loading />;
  return <view.value part={part} />;
}

async function loadAhead(): Promise<void> {
  for (const { view } of panels) await view.start();
}

/** Notice of lost control, until closed or control is back. */
function Taken() {
  const taken = useStore((s) => s.leaseTaken);
  if (!taken) return null;
  return (
    <div class="trial-bar taken" role="alert">
      <p>
        <strong>{t('lease.taken')}</strong> {t('lease.takenAction')}
      </p>
      <div class="trial-buttons">
        <button type="button" class="plain" onClick={takenSeen}>
          {t('common.close')}
        </button>
      </div>
    </div>
  );
}

function Notices() {
  const notices = useStore((s) => s.notices);
  return (
    <div class="notices" role="status" aria-live="polite">
      {[...notices].reverse().map((notice) => {
        const text = notice.plain
          ? notice.text
          : (textOf(notice.text) ?? textOf(`refused.${notice.text}`) ?? reasonText(notice.text) ?? textOf('refused.unknown'));
        return (
          <div key={notice.id} class={`notice ${notice.level}`}>
            {text}
          </div>
        );
      })}
    </div>
  );
}

const timers = {
  once: (call: () => void, after_ms: number) => window.setTimeout(call, after_ms),
  cancel: (timer: number) => window.clearTimeout(timer),
};

/** The question before taking control from another screen. */
function useTakeOver(): { asking: boolean; answer: (yes: boolean) => void } {
  const [asking, setAsking] = useState(false);
  const question = useRef<Question | null>(null);
  question.current ??= new Question(setAsking, timers);
  const answer = (yes: boolean) => question.current!.answer(yes);
  const holder = useStore((s) => s.lease.holder);
  const connected = useStore((s) => s.link === 'open');
  const about = useRef(0);
  const before = useRef<Element | null>(null);
  useEffect(() => {
    dialogs.askTakeOver = () => {
      about.current = store.value.lease.holder;
      before.current = document.activeElement;
      window.dispatchEvent(new Event('hoist-dialog'));
      return question.current!.ask();
    };
    const away = () => answer(false);
    window.addEventListener('hashchange', away);
    return () => window.removeEventListener('hashchange', away);
  }, []);
  // The holder of the lease has changed, or is unknown.
  useEffect(() => {
    if (holder !== about.current || !connected) answer(false);
  }, [holder, connected]);
  useEffect(() => {
    if (!asking && before.current instanceof HTMLElement) before.current.focus();
  }, [asking]);
  return { asking, answer };
}

/** STOP and the alarms stay free: the dialog never covers them. */
function TakeOver({ answer }: { answer: (yes: boolean) => void }) {
  const box = useRef<HTMLDivElement>(null);
  const who = useStore((s) => nameOf(s.lease.actor));
  useEffect(() => {
    box.current?.querySelector('button')?.focus();
  }, []);
  return (
    <div class="dialog-back" onKeyDown={(event) => event.key === 'Escape' && answer(false)}>
      <div ref={box} class="card dialog" role="dialog" aria-modal="true" aria-labelledby="lease-question">
        <h2 id="lease-question">{who === null ? t('lease.question') : t('lease.questionNamed', { who })}</h2>
        <p>{t('lease.text')}</p>
        <div class="dialog-buttons">
          <button type="button" class="big" onClick={() => answer(false)}>
            {t('lease.keep')}
          </button>
          <button
            type="button"
            class="big"
            onClick={() => {
              answer(false);
              void askLease().then(tell);
            }}
          >
            {t('lease.ask')}
          </button>
          <button type="button" class="big primary" onClick={() => answer(true)}>
            {t('lease.take')}
          </button>
        </div>
      </div>
    </div>
  );
}
