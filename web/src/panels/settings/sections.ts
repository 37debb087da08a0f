// The parts of Settings, in their order. To add one: a file beside this one that exports its component, and one row here.
import type { ComponentType } from 'preact';
import type { TextKey } from '../../text/en';
import { BackupSection } from './backup';

export interface Section {
  id: string;
  title: TextKey;
  /** The least role that can use it; others do not see it. */
  role: 'viewer' | 'therapist' | 'engineer';
  view: ComponentType;
}

export const sections: readonly Section[] = [{ id: 'backup', title: 'settings.backup', role: 'engineer', view: BackupSection }];

const ranks = ['viewer', 'therapist', 'engineer'];
export const may = (role: string, least: Section['role']): boolean => ranks.indexOf(role) >= ranks.indexOf(least);
export const sectionsOf = (role: string): readonly Section[] => sections.filter((section) => may(role, section.role));
