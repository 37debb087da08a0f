import type { ComponentType } from 'preact';
import type { TextKey } from '../text/en';
import type { IconName } from '../ui/icons';
import type { Lazy } from '../ui/lazy';

export interface PanelProps {
  /** What the address names behind the screen, see router.ts. */
  part: string | null;
}

/** One screen: its address (#/id), its name and picture in the menu, and what it draws, which is loaded when it is first looked at. */
export interface Panel {
  id: string;
  title: TextKey;
  icon: IconName;
  /** Shows values of this moment: grey when they are old. */
  live: boolean;
  view: Lazy<ComponentType<PanelProps>>;
}
