// The frame around every screen: status bar, alarm strip, menu, STOP.
import { useEffect, useRef, useState } from 'preact/hooks';
import { dialogs } from './link/console';
import { useStore } from './link/store';
import { panels } from './panels/index';
import { useSettings } from './text/settings';
import { t, textOf } from './text/text';
import { Icon } from './ui/icons';
import { StatusBar } from './ui/status_bar';
import { StopButton } from './ui/stop_button';
import { Strip } from './ui/strip';

const panelOfAddress = () => panels.find((panel) => `#/${panel.id}` === location.hash.split('?')[0]) ?? panels[0]!;

export function App() {
  useSettings();
  const [panel, setPanel] = useState(panelOfAddress);
  const stale = useStore((s) => s.data !== 'fresh') && panel.live;
  const signedIn = useStore((s) => s.signedIn);
  useEffect(() => {
    const change = () => setPanel(panelOfAddress());
    window.addEventListener('hashchange', change);
    return () => window.removeEventListener('hashchange', change);
  }, []);
  useEffect(() => {
    document.title = `${t(panel.title)} – ${t('app.title')}`;
  });
  if (!signedIn)
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
      <StopButton />
      <Notices />
      <TakeOver />
    </div>
  );
}

function Notices() {
  const notices = useStore((s) => s.notices);
  return (
    <div class="notices" role="status" aria-live="polite">
      {notices.map((notice) => {
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

/** The question before control is taken from somebody else. STOP stays free: the dialog never covers it. */
function TakeOver() {
  const [answer, setAnswer] = useState<((yes: boolean) => void) | null>(null);
  const box = useRef<HTMLDivElement>(null);
  useEffect(() => {
    dialogs.askTakeOver = () => {
      window.dispatchEvent(new Event('hoist-dialog'));
      return new Promise<boolean>((resolve) => setAnswer(() => resolve));
    };
  }, []);
  useEffect(() => {
    if (answer) box.current?.querySelector('button')?.focus();
  }, [answer]);
  if (answer === null) return null;
  const done = (yes: boolean) => {
    setAnswer(null);
    answer(yes);
  };
  return (
    <div class="dialog-back" onKeyDown={(event) => event.key === 'Escape' && done(false)}>
      <div ref={box} class="card dialog" role="dialog" aria-modal="true" aria-labelledby="lease-question">
        <h2 id="lease-question">{t('lease.question')}</h2>
        <p>{t('lease.text')}</p>
        <div class="dialog-buttons">
          <button type="button" class="big" onClick={() => done(false)}>
            {t('lease.keep')}
          </button>
          <button type="button" class="big primary" onClick={() => done(true)}>
            {t('lease.take')}
          </button>
        </div>
      </div>
    </div>
  );
}
