// Warns the driver of a slow connection. From a limit on driving is refused, because a release would arrive late.
import { tooSlow, type Readiness } from '../link/readiness';
import { useStore } from '../link/store';
import { fixed, t } from '../text/text';
import './slow_link.css';

/** From here on the connection counts as slow. */
const slow_s = 0.08;

const tooSlowText = (rtt_s: number | null): string => t('drive.tooSlow', { n: fixed((rtt_s ?? 0) * 1000, 0) });

/** Why hold-to-run does nothing while the hoist is led by hand. */
export function lockedText({ reachable, lead }: Readiness, rtt_s: number | null): string {
  if (!reachable) return t('refused.link_lost');
  if (lead !== 'mine') return t(lead === 'other' ? 'guided.other' : 'drive.locked');
  return tooSlow({ rtt_s }) ? tooSlowText(rtt_s) : t('refused.core_gone');
}

/** In the place of a hint below the held control, so that nothing moves under the hand. */
export function SlowLink({ calm }: { calm: string }) {
  const rtt_s = useStore((s) => s.rtt_s);
  const open = useStore((s) => s.link === 'open');
  const said = open && rtt_s !== null && rtt_s > slow_s;
  return (
    <p class={said ? 'hint below-hand said' : 'hint below-hand'} role="status">
      {!said ? calm : tooSlow({ rtt_s }) ? tooSlowText(rtt_s) : t('drive.slowLink', { n: fixed(rtt_s * 1000, 0) })}
    </p>
  );
}
