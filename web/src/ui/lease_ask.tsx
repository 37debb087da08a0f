// Another client asks for control: the holder hands over, at standstill, or keeps it.
import type { Actor } from '../contract/rest.gen';
import { handOver, keepLease } from '../link/console';
import { useReadiness } from '../link/readiness';
import { useStore } from '../link/store';
import { t } from '../text/text';
import { tell } from './refusal';

/** The person by name; `local` uses the computer itself, and the name says nothing. */
export function nameOf(actor: Actor | null): string | null {
  if (actor === null || actor.user === 'local') return null;
  return actor.origin === 'rehearsal' ? t('rehearse.asker') : (actor.name ?? actor.user);
}

export function LeaseAsk() {
  const ask = useStore((s) => (s.lease.mine ? s.lease.asking[0] : undefined));
  const { motion } = useReadiness();
  if (ask === undefined) return null;
  const give = async () => {
    tell(await handOver(ask.client));
  };
  return (
    <div class="trial-bar asked" role="alert">
      <p>
        <strong>{t('lease.asks', { who: nameOf(ask.actor) ?? t('lease.otherScreen') })}</strong> {t('lease.asksText')}
      </p>
      <div class="trial-buttons">
        <button type="button" class="plain primary" disabled={motion !== 'still'} onClick={() => void give()}>
          {t('lease.handOver')}
        </button>
        <button type="button" class="plain" onClick={() => void keepLease()}>
          {t('lease.keepMine')}
        </button>
      </div>
    </div>
  );
}
