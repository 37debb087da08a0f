import type { ComponentType } from 'preact';
import type { TextKey } from '../text/en';
import type { IconName } from '../ui/icons';

/** One screen: its address (#/id), its name and picture in the menu, and what it draws. */
export interface Panel {
  id: string;
  title: TextKey;
  icon: IconName;
  /** Shows values of this moment: grey when they are old. */
  live: boolean;
  View: ComponentType;
}
