// Rows of the audit log as sentences: every kind there is, in both languages.
import { readFileSync } from 'node:fs';
import { beforeEach, describe, expect, it } from 'vitest';
import { auditActions } from '../src/contract/audit.gen';
import type { AuditAction } from '../src/contract/rest.gen';
import { detail, patientOf, refusal, sentence, wasDone, type Names, type Row } from '../src/panels/settings/audit_text';
import { settings } from '../src/text/settings';
import { loadLanguage } from '../src/text/text';

const names: Names = {
  person: (user) => ({ berg: 'Anna Berg', kos: 'Miha Kos' })[user] ?? user,
  patient: (id) => (id === 5 ? 'P-017' : null),
  step: (name) => (name === 'track' ? 'Track width' : null),
};
const row = (action: AuditAction, more: Partial<Row> = {}): Row => ({
  id: 1,
  utc_ms: 0,
  steady_ns: 0,
  user: 'berg',
  role: 'therapist',
  address: '10.0.0.7',
  action,
  target: '',
  before: null,
  after: null,
  result: 'done',
  digest: '',
  ...more,
});
const kinds = Object.keys(auditActions) as AuditAction[];

beforeEach(async () => {
  settings.set({ language: 'en' });
  await Promise.all([loadLanguage('en'), loadLanguage('de')]);
});

describe('the audit log', () => {
  it('has words for every kind that the server can write', () => {
    const api = JSON.parse(readFileSync('../server/contract/openapi.gen.json', 'utf8')) as {
      components: { schemas: { AuditAction: { enum: string[] } } };
      paths: Record<string, Record<string, { operationId?: string }>>;
    };
    const told = api.components.schemas.AuditAction.enum;
    expect(kinds.slice().sort()).toEqual(told.slice().sort());
    // Every operation that changes something is one of them.
    const changing = Object.values(api.paths).flatMap((methods) =>
      Object.entries(methods).flatMap(([method, { operationId }]) => (method === 'get' || operationId === undefined ? [] : [operationId])),
    );
    expect(changing.length).toBeGreaterThan(40);
    for (const operation of changing) if (operation !== 'open_ticket') expect(told, operation).toContain(operation);
  });

  it('says each in a whole sentence, without inner names, whatever it was about', () => {
    const targets = [
      '',
      'rest',
      'rest session 17',
      'rest patient 5',
      'rest session 17 marker 3',
      '/api/v1/sessions/17',
      '/api/v1/patients/9/identity',
    ];
    for (const language of ['en', 'de'] as const) {
      settings.set({ language });
      for (const action of kinds)
        for (const result of ['done', 'role', '404', 'changed_meanwhile', 'no-session', 'no_lease'])
          for (const target of targets) {
            const one = row(action, { result, target });
            const text = sentence(one, names);
            expect(text, `${action} ${result} ${target}`).toMatch(/^Anna Berg \S.*[^ .]\.$/);
            expect(text, `${action} ${result} ${target}`).not.toMatch(/[{}_/]|undefined|null|\s{2}|\brest\b/);
            if (!wasDone(one)) expect(refusal(one), `${action} ${result}`).toMatch(/^[A-ZÄÖÜ].*\.$/);
          }
    }
  });

  it('names sessions by number, patients by code, and nobody by a number', () => {
    expect(sentence(row('delete_session', { target: 'rest session 17' }), names)).toBe('Anna Berg deleted session 17.');
    expect(sentence(row('delete_session', { target: '/api/v1/sessions/17', result: '403' }), names)).toBe('Anna Berg tried to delete session 17.');
    expect(sentence(row('delete_patient', { target: 'rest patient 5' }), names)).toBe('Anna Berg deleted patient P-017 with all sessions.');
    expect(sentence(row('delete_patient', { target: 'rest patient 8' }), names)).toBe('Anna Berg deleted patient (deleted) with all sessions.');
    expect(sentence(row('choose_patient', { target: 'hoist.v1 nobody' }), names)).toBe('Anna Berg chose nobody for the hoist.');
    expect(sentence(row('hand_over', { target: 'hoist.v1 kos' }), names)).toBe('Anna Berg gave control to Miha Kos.');
    expect(sentence(row('hand_over', { target: 'rest client 4711' }), names)).toBe('Anna Berg gave control to another screen.');
    expect(sentence(row('export_session', { target: '/api/v1/sessions/3/export?format=mat', result: '206' }), names)).toMatch(
      /^Anna Berg downloaded session 3 as MATLAB/,
    );
    expect(sentence(row('begin_calibration', { target: 'rest track' }), names)).toBe('Anna Berg began to calibrate: Track width.');
    settings.set({ language: 'de' });
    expect(sentence(row('delete_session', { target: 'rest session 17' }), names)).toBe('Anna Berg hat Sitzung 17 gelöscht.');
    expect(sentence(row('delete_session', { target: 'rest session 17', result: 'role' }), names)).toBe('Anna Berg wollte Sitzung 17 löschen.');
    expect(sentence(row('set_tools', { target: 'rest on' }), names)).toBe('Anna Berg hat den Zugang für Foxglove und ROS freigeschaltet.');
    expect(patientOf(row('put_identity', { target: '/api/v1/patients/9/identity' }))).toBe(9);
    expect(patientOf(row('delete_session', { target: 'rest session 9' }))).toBeNull();
  });

  it('says what changed in the words and units of the screens', () => {
    const changed = row('change_parameters', { before: '{"lean_range_rad":0.2}', after: '{"lean_range_rad":0.1}' });
    expect(detail(changed)).toMatch(/11\.46 → 5\.73 ?°$/);
    expect(detail(row('change_parameters', { after: '{"cut": 1, "th' })), 'cut off').toBeNull();
    expect(detail(row('change_user', { before: 'therapist', after: 'viewer, disabled' }))).toBe('Therapist → Viewer, locked');
    expect(detail(row('set_retention', { after: '{"days":400,"disk_percent":null,"needs_backup":true}' }))).toContain('400');
    expect(detail(row('export_mcap', { after: '1630000 of 9000000 bytes in 52 parts' }))).toBe('1.63 MB of 9 MB, in 52 parts');
    expect(detail(row('export_mcap', { after: '9000000 of 9000000 bytes in 1 part' }))).toBe('9 MB');
    expect(detail(row('retention', { after: '12 sessions, 3 to 17' }))).toBe('12 sessions, from 3 to 17');
    expect(detail(row('lose_rows', { after: '3 rows' }))).toBe('Rows lost: 3');
    expect(detail(row('stop'))).toBeNull();
  });
});
