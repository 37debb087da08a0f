// Rows of the audit log as sentences. The log holds short codes, the same in every language and for years; people read words.
import { exercises } from '../../contract/exercises.gen';
import { exportFormats } from '../../contract/exports.gen';
import { faults, modes, refusals } from '../../contract/faults.gen';
import { auditActions } from '../../contract/audit.gen';
import { params } from '../../contract/params.gen';
import type { AuditList, Exercise, ReasonCode } from '../../contract/rest.gen';
import { exerciseTitle } from '../../text/exercise';
import { reasonText } from '../../text/server';
import { date, noValue, plain, refusalText, shownAs, t, textOf, withUnit, words } from '../../text/text';
import { size } from './backup';

export type Row = AuditList['items'][number];

/** Names of what a row holds a number or a short name of. */
export interface Names {
  person: (user: string) => string;
  /** Null: deleted since, or not known yet. */
  patient: (id: number) => string | null;
  /** A step of the calibration. */
  step: (name: string) => string | null;
}

/** A row of these is about this patient. */
export function patientOf(row: Row): number | null {
  const found = /(?:^patient |\/patients\/)(\d+)/.exec(subject(row));
  return found === null ? null : Number(found[1]);
}

/** What a row is about, without the protocol over which it came. */
const subject = ({ target }: Row): string => target.replace(/^(?:rest|hoist\.v1|foxglove|rosbridge)(?: |$)/, '');

export const wasDone = ({ result }: Row): boolean => /^(done|2\d\d|304)$/.test(result);

export function sentence(row: Row, names: Names): string {
  const { done, tried } = auditActions[row.action];
  const who = names.person(row.user);
  const fill = (text: string) => text.replace('{what}', what(row, names));
  if (wasDone(row)) return `${who} ${fill(words(done))}.`;
  return t('audit.tried', { who, what: fill(words(tried)) });
}

/** Why it was refused; null for what was done. */
export function refusal(row: Row): string | null {
  if (wasDone(row)) return null;
  const code = row.result.replaceAll('-', '_');
  if (refusals.some(({ name }) => name === code)) return refusalText(code);
  const status: Partial<Record<string, ReasonCode>> = {
    '401': 'no_session',
    '403': 'role',
    '404': 'unknown',
    '409': 'refused',
    '412': 'changed_meanwhile',
    '422': 'invalid',
    '428': 'changed_meanwhile',
    '429': 'too_soon',
    '503': 'busy',
    '507': 'disk_full',
  };
  return reasonText(status[code] ?? code) ?? t('refused.unknown');
}

function what(row: Row, names: Names): string {
  const about = subject(row);
  const last = about.slice(about.lastIndexOf('/') + 1);
  const found = /(?:^session |\/sessions\/)(\d+)/.exec(about);
  const patient = patientOf(row);
  switch (row.action) {
    case 'hand_over':
      return about === '' || about.startsWith('/') || /^client \d+$/.test(about) ? t('audit.otherScreen') : names.person(about);
    case 'add_user':
    case 'change_user':
    case 'user':
    case 'add_token':
    case 'token':
    case 'apply_preset':
      return /\/(?:users|presets)\/([^/]+)/.exec(about)?.[1] ?? (about === '' || about.startsWith('/') ? noValue : about);
    case 'set_tools':
      return t(about === 'on' ? 'audit.on' : 'audit.off');
    case 'start_job':
      return textOf(`audit.job.${about}`) ?? t('audit.job.any');
    case 'begin_calibration':
      return names.step(about) ?? t('nav.calibrate');
    case 'update_firmware':
      return textOf(`health.part.${last}`) ?? t('device.unknown');
    case 'start_motion': {
      const mode = modes.find(({ name }) => name === about);
      return mode ? words(mode.title) : t('audit.motion');
    }
    case 'choose_exercise':
      return exercises.some(({ shape }) => shape === about) ? exerciseTitle(about as Exercise['shape']) : t('exercise.label');
    case 'export_session':
    case 'export_mcap': {
      const name = row.action === 'export_mcap' ? 'mcap' : (/[?&]format=(\w+)/.exec(about)?.[1] ?? 'csv');
      const format = exportFormats.find((one) => one.name === name);
      return t('audit.asFile', { session: t('audit.session', { n: found?.[1] ?? noValue }), format: format ? words(format.title) : name });
    }
    case 'choose_patient':
      if (about === 'nobody') return t('audit.nobody');
      break;
    default:
  }
  if (patient !== null) return t('audit.patient', { code: names.patient(patient) ?? t('audit.deletedPatient') });
  if (found !== null) return t('audit.session', { n: found[1]! });
  return patientActions.test(row.action) ? t('audit.patient', { code: noValue }) : t('audit.session', { n: noValue });
}
const patientActions = /patient|identity|profile/;

/** What changed, in words; null where the sentence says it all. */
export function detail(row: Row): string | null {
  const { action, before, after } = row;
  if (action === 'change_parameters' || action === 'put_parameter') return changes(read(before), read(after));
  if (action === 'set_time') return after === null ? null : date(Number(after));
  if (action === 'set_retention') return rule(read(after));
  if (action === 'acknowledge') return seen(after);
  if (action === 'retention') {
    const told = /^(\d+) sessions?, (\d+) to (\d+)/.exec(after ?? '');
    return told === null ? null : t('audit.deleted', { n: told[1]!, from: told[2]!, to: told[3]! });
  }
  if (action === 'lose_rows') return t('audit.lost', { n: /^\d+/.exec(after ?? '')?.[0] ?? noValue });
  // What `hoist user` on the hoist's own computer did.
  if (after === 'new password') return t('audit.newPassword');
  if (action === 'user' && (after === 'enable' || after === 'disable')) return t(after === 'enable' ? 'audit.unlocked' : 'users.disabled');
  if (/^(add_user|change_user|user|add_token|token)$/.test(action)) {
    const role = (text: string | null) =>
      (text ?? '').replace(/^\w+/, (name) => textOf(`role.${name}`) ?? name).replace('disabled', t('users.disabled'));
    return before === null || before === after ? role(after) || null : `${role(before)} → ${role(after)}`;
  }
  const parts = /^(\d+) of (\d+) bytes in (\d+) parts?$/.exec(after ?? '');
  if (parts !== null)
    return Number(parts[3]) === 1
      ? size(Number(parts[1]))
      : t('audit.parts', { got: size(Number(parts[1])), of: size(Number(parts[2])), n: parts[3]! });
  return null;
}

function read(text: string | null): Readonly<Record<string, unknown>> {
  try {
    const value: unknown = JSON.parse(text ?? '{}');
    return typeof value === 'object' && value !== null ? (value as Record<string, unknown>) : {};
  } catch {
    return {}; // cut: a text of the log has at most 500 bytes
  }
}

function changes(before: Readonly<Record<string, unknown>>, after: Readonly<Record<string, unknown>>): string | null {
  const rows = Object.entries(after).map(([name, value]) => {
    const info = params.find((row) => row.name === name);
    if (info === undefined) return t('audit.unknownSetting');
    const show = shownAs(info.name, info.unit);
    const number = (si: unknown) => (typeof si === 'number' ? plain(si * show.factor) : noValue);
    return `${words(info.title)} ${number(before[name])} → ${withUnit(number(value), show.unit)}`;
  });
  return rows.length === 0 ? null : rows.join(', ');
}

function rule(value: Readonly<Record<string, unknown>>): string {
  const parts = [
    typeof value['days'] === 'number' ? t('audit.days', { n: value['days'] }) : null,
    typeof value['disk_percent'] === 'number' ? t('audit.share', { n: value['disk_percent'] }) : null,
  ].filter((part) => part !== null);
  return parts.length === 0 ? t('retention.off') : parts.join(', ');
}

function seen(text: string | null): string | null {
  try {
    const names: unknown = JSON.parse(text ?? 'null');
    if (!Array.isArray(names)) return null;
    const told = names.map((name) => faults.find((row) => row.name === name)).filter((row) => row !== undefined);
    return told.length === 0 ? null : told.map((row) => words(row.text)).join(' ');
  } catch {
    return null;
  }
}
