// The parts of Settings, in their order. To add one: a file beside this one that exports its component, and one row here.
import type { ComponentType } from 'preact';
import type { TextKey } from '../../text/en';
import { AuditSection } from './audit';
import { BackupSection } from './backup';
import { DeviceSection } from './device';
import { MeSection } from './me';
import { RetentionSection } from './retention';
import { may, type Role } from './roles';
import { TokensSection } from './tokens';
import { ToolsSection } from './tools';
import { UsersSection } from './users';

export interface Section {
  id: string;
  title: TextKey;
  /** The least role that can use it; others do not see it. */
  role: Role;
  view: ComponentType;
}

export const sections: readonly Section[] = [
  { id: 'me', title: 'settings.me', role: 'viewer', view: MeSection },
  { id: 'users', title: 'settings.users', role: 'engineer', view: UsersSection },
  { id: 'tokens', title: 'settings.tokens', role: 'therapist', view: TokensSection },
  { id: 'backup', title: 'settings.backup', role: 'engineer', view: BackupSection },
  { id: 'retention', title: 'settings.retention', role: 'engineer', view: RetentionSection },
  { id: 'device', title: 'settings.device', role: 'viewer', view: DeviceSection },
  { id: 'tools', title: 'settings.tools', role: 'viewer', view: ToolsSection },
  { id: 'audit', title: 'settings.audit', role: 'engineer', view: AuditSection },
];

export const sectionsOf = (role: string): readonly Section[] => sections.filter((section) => may(role, section.role));
