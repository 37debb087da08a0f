import type { ComponentType } from 'preact';
import type { TextKey } from '../text/en';
import type { IconName } from '../ui/icons';
import type { Lazy } from '../ui/lazy';

export interface PanelProps {
  /** The part after the screen in the address, see router.ts. */
  part: string | null;
}

/** One screen: its address (#/id), its name and picture in the menu, and its component, loaded on first use. */
export interface Panel {
  id: string;
  title: TextKey;
  icon: IconName;
  /** Shows live values: grey when old. */
  live: boolean;
  view: Lazy<ComponentType<PanelProps>>;
  /** Not in the menu itself: shown under this entry of it, or under none (null). */
  under?: string | null;
}
