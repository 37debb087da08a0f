import { beforeEach, describe, expect, it } from 'vitest';
import { emergencies } from '../src/contract/emergencies.gen';
import { nodes } from '../src/contract/messages.gen';
import { signals, type TickRecord } from '../src/contract/signals.gen';
import { eventText } from '../src/ui/event_text';
import { nodeView, partNames } from '../src/panels/health/nodes';
import { settings } from '../src/text/settings';
import { deviceOfCan, deviceOfNode, emergencyInfo, hex } from '../src/ui/device';

beforeEach(() => settings.set({ language: 'en' }));

const well: Partial<TickRecord> = Object.fromEntries(partNames.map((name) => [`${name}_nmt_state`, 5]));
const record = (change: Partial<TickRecord>): TickRecord => ({
  ...(Object.fromEntries(signals.map((row) => [row.name, 0])) as TickRecord),
  ...well,
  ...change,
});

describe('how a part is doing', () => {
  it('has a row for every node of the bus', () => {
    expect([...partNames].sort()).toEqual(
      nodes
        .map((node) => node.name as string)
        .filter((name) => name !== 'core')
        .sort(),
    );
  });

  it('says that all work', () => {
    for (const name of partNames) expect(nodeView(record({}), name).state).toBe('works');
  });

  it('names the worst of what is wrong', () => {
    expect(nodeView(record({ tilt_left_lost_10s: 3, tilt_left_lost_frames: 8 }), 'tilt_left')).toMatchObject({
      state: 'losing',
      lostLately: 3,
      lostAll: 8,
    });
    expect(nodeView(record({ drive_left_error_register: 1, drive_left_emcy_code: 0x8250, drive_left_lost_10s: 1 }), 'drive_left')).toMatchObject({
      state: 'reports',
      emergency: 0x8250,
    });
    expect(nodeView(record({ io_age_ticks: 255, io_error_register: 1, io_heartbeats_missed: 25 }), 'io')).toMatchObject({
      state: 'silent',
      age_ms: null,
    });
    expect(nodeView(record({ io_age_ticks: 120, io_nmt_state: 127 }), 'io')).toMatchObject({ state: 'waiting', age_ms: 1200 });
    expect(nodeView(record({ io_age_ticks: 255, io_nmt_state: 255, io_heartbeats_missed: 25 }), 'io').state).toBe('never');
  });

  it('accuses no other part', () => {
    const r = record({ tilt_left_lost_10s: 3, drive_left_age_ticks: 255, drive_left_heartbeats_missed: 9 });
    for (const name of ['tilt_right', 'tilt_base', 'drive_right', 'io'] as const) expect(nodeView(r, name).state).toBe('works');
  });

  it('forgets an emergency that has ended', () => {
    expect(nodeView(record({ drive_left_emcy_code: 0x8250 }), 'drive_left')).toMatchObject({ state: 'works', emergency: 0 });
  });
});

describe('devices in words', () => {
  it('by node id', () => {
    expect(deviceOfNode(0)).toBeNull();
    expect(deviceOfNode(null)).toBeNull();
    expect(deviceOfNode(0x12)).toBe('Right strut sensor');
    expect(deviceOfNode(127)).toBe('a second control computer');
    expect(deviceOfNode(55)).toBe('an unknown device');
  });

  it('by CAN id', () => {
    expect(deviceOfCan(null)).toBeNull();
    expect(deviceOfCan(0x292)).toBe('Right strut sensor');
    expect(deviceOfCan(0x001)).toBe('an unknown device');
    expect(deviceOfCan(0x7ff)).toBe('an unknown device');
    expect(deviceOfCan(0x18f00112)).toBe('an unknown device');
  });
});

describe('emergency codes', () => {
  it('have words in both languages, every one of them', () => {
    for (const row of emergencies) for (const text of [row.text.en, row.text.de, row.detail.en, row.detail.de]) expect(text).not.toBe('');
    for (let code = 0; code <= 0xffff; code += 7) expect(emergencyInfo(code)).toBeDefined();
  });

  it('are told by their own row, else by their class', () => {
    expect(emergencyInfo(0x8250).name).toBe('rpdo_timeout');
    expect(emergencyInfo(0x2345).name).toBe('current_class');
    expect(emergencyInfo(0x1234).name).toBe('generic');
    expect(hex(0x8250)).toBe('8250h');
  });

  it('become a sentence of the log', () => {
    expect(eventText('emergency', 'drive_left', null, null, 0x8250)).toBe('Left drive: No more commands: the drive braked by itself');
    settings.set({ language: 'de' });
    expect(eventText('emergency', 'drive_left', null, null, 0)).toBe('Linker Antrieb: Ein Fehler ist vorbei');
  });
});

describe('events of other recording systems and of settings', () => {
  it('say what the line did, and from when on a setting acts', () => {
    expect(eventText('sync_input', 'on', null, null, 1)).toBe('Synchronisation signal: on');
    expect(eventText('parameter_settled', 'lean_gain_direct_units', 4, 3.9)).toMatch(/^Setting in full effect: .+ 4/);
    settings.set({ language: 'de' });
    expect(eventText('sync_input', 'off', null, null, 0)).toBe('Synchronsignal: aus');
  });
});
