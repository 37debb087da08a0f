// The frame around every screen: status bar, alarm strip, menu, STOP.
import { useEffect, useRef, useState } from 'preact/hooks';
import { dialogs, takenSeen } from './link/console';
import { useReadiness } from './link/readiness';
import { store, useStore } from './link/store';
import { panels } from './panels/index';
import { useSettings } from './text/settings';
import { t, textOf } from './text/text';
import { Icon } from './ui/icons';
import { Question } from './ui/question';
import { StatusBar } from './ui/status_bar';
import { StopButton } from './ui/stop_button';
import { Strip } from './ui/strip';
import { TrialBar } from './ui/trial_bar';

const panelOfAddress = () => panels.find((panel) => `#/${panel.id}` === location.hash.split('?')[0]) ?? panels[0]!;

export function App() {
  useSettings();
  const [panel, setPanel] = useState(panelOfAddress);
  const stale = useReadiness().old && panel.live;
  const signedIn = useStore((s) => s.signedIn);
  const ever = useStore((s) => s.everOpen);
  const { asking, answer } = useTakeOver();
  useEffect(() => {
    const change = () => setPanel(panelOfAddress());
    window.addEventListener('hashchange', change);
    return () => window.removeEventListener('hashchange', change);
  }, []);
  useEffect(() => {
    document.title = `${t(panel.title)} – ${t('app.title')}`;
  });
  // Once it was open, the shell stays, and STOP with it: whoever is signed out in the middle of a walk must still try to stop it.
  if (!signedIn && !ever)
    return (
      <div class="gate">
        <main class="card">
          <h1>{t('gate.title')}</h1>
          <p>{t('gate.text')}</p>
          <button type="button" class="big" onClick={() => location.reload()}>
            {t('common.retry')}
          </button>
        </main>
      </div>
    );
  const { View } = panel;
  return (
    <div class="shell">
      {/* While something is asked, neither key nor finger reaches anything else, STOP excepted. */}
      <div class="shell-parts" inert={asking}>
        <StatusBar />
        <Strip />
        <nav class="nav" aria-label={t('nav.label')}>
          {panels.map((item) => (
            <a key={item.id} href={`#/${item.id}`} aria-current={item.id === panel.id ? 'page' : undefined}>
              <Icon name={item.icon} />
              <span>{t(item.title)}</span>
            </a>
          ))}
        </nav>
        <main class={stale ? 'main stale' : 'main'}>
          <h1 class="visually-hidden">{t(panel.title)}</h1>
          <View key={panel.id} />
        </main>
        <div class="side-column">
          <div class="side-bars">
            <Taken />
            <TrialBar />
          </div>
          <Notices />
        </div>
      </div>
      <StopButton />
      {asking ? <TakeOver answer={answer} /> : null}
    </div>
  );
}

/** Told where control was lost, until it is seen or control is back. */
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
        const text = notice.plain ? notice.text : textOf(notice.text) ?? textOf(`refused.${notice.text}`) ?? textOf('refused.unknown');
        return (
          <div key={notice.id} class={`notice ${notice.level}`}>
            {text}
          </div>
        );
      })}
    </div>
  );
}

const timers = { once: (call: () => void, after_ms: number) => window.setTimeout(call, after_ms), cancel: (timer: number) => window.clearTimeout(timer) };

/** The question before control is taken from somebody else. */
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
  // Whoever was asked about has left or is another one now, or nobody knows.
  useEffect(() => {
    if (holder !== about.current || !connected) answer(false);
  }, [holder, connected]);
  useEffect(() => {
    if (!asking && before.current instanceof HTMLElement) before.current.focus();
  }, [asking]);
  return { asking, answer };
}

/** STOP stays free: the dialog never covers it. */
function TakeOver({ answer }: { answer: (yes: boolean) => void }) {
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    box.current?.querySelector('button')?.focus();
  }, []);
  return (
    <div class="dialog-back" onKeyDown={(event) => event.key === 'Escape' && answer(false)}>
      <div ref={box} class="card dialog" role="dialog" aria-modal="true" aria-labelledby="lease-question">
        <h2 id="lease-question">{t('lease.question')}</h2>
        <p>{t('lease.text')}</p>
        <div class="dialog-buttons">
          <button type="button" class="big" onClick={() => answer(false)}>
            {t('lease.keep')}
          </button>
          <button type="button" class="big primary" onClick={() => answer(true)}>
            {t('lease.take')}
          </button>
        </div>
      </div>
    </div>
  );
}
