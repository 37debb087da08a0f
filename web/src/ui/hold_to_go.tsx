// Hold-to-run as a button: the hoist moves while it is held. The exercise steers, so the stick stays neutral.
import { t } from '../text/text';
import { useHand } from './hand';
import './hold_to_go.css';

const middle = { speed: 0, yaw: 0 };
const grip = { keys: { ArrowUp: middle, KeyW: middle }, wish: () => middle };

export function HoldToGo({ active, locked }: { active: boolean; locked: string }) {
  const { held, handlers } = useHand(active, grip);
  return (
    <button type="button" class={active ? (held ? 'go active held' : 'go active') : 'go'} aria-disabled={!active} aria-pressed={held} {...handlers}>
      {active ? t(held ? 'guided.held' : 'guided.hold') : locked}
    </button>
  );
}
