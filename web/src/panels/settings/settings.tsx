// Settings of the device and of the person at it: a list of parts, one of them open.
import { useStore } from '../../link/store';
import { addressOf } from '../../router';
import { useSettings } from '../../text/settings';
import { t } from '../../text/text';
import type { PanelProps } from '../panel';
import { sectionsOf } from './sections';
import '../../ui/rows.css';
import './settings.css';

export function SettingsView({ part }: PanelProps) {
  useSettings();
  const role = useStore((s) => s.role);
  const open = sectionsOf(role);
  const section = open.find((one) => one.id === part) ?? open[0];
  return (
    <div class={part === null ? 'settings' : 'settings one'}>
      <ul class="settings-list">
        {open.map((one) => (
          <li key={one.id}>
            <a href={addressOf('settings', one.id)} aria-current={one === section ? 'true' : undefined}>
              {t(one.title)}
            </a>
          </li>
        ))}
      </ul>
      {section === undefined ? (
        <section class="card">
          <p class="hint">{t('settings.none')}</p>
        </section>
      ) : (
        <div class="settings-part">
          <a class="quiet settings-back" href={addressOf('settings')}>
            ‹ {t('nav.settings')}
          </a>
          <section.view />
        </div>
      )}
    </div>
  );
}
