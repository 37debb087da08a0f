import { describe, expect, it, vi } from 'vitest';
import { endangers, explanations, faultDetails, faults, type FaultName } from '../src/contract/faults.gen';
import { toldFaults } from '../src/ui/alarms';

// The table with two faults more, at its last places, as tests/contract/more_faults.def has them.
vi.mock('../src/contract/faults.gen', async (original) => {
  const table = await original<typeof import('../src/contract/faults.gen')>();
  const more = (place: number, name: string) => ({
    ...table.faults[0]!,
    bit: place,
    name: name as FaultName,
    text: { en: `${name} text`, de: `${name} Text` },
  });
  return { ...table, faults: [...table.faults, more(51, 'seat_open'), more(52, 'lamp_broken')] };
});

const bit = (name: FaultName) => faults.find((fault) => fault.name === name)!.bit;
const bits = (...names: FaultName[]) => names.reduce((sum, name) => sum + 2 ** bit(name), 0);
const cause = (name: FaultName) => bit(name) + 1;
const names = (...told: Parameters<typeof toldFaults>) => toldFaults(...told).map(({ fault }) => fault.name);

describe('the order of the alarms', () => {
  const lost: FaultName[] = ['tilt_left_lost', 'tilt_right_lost', 'tilt_base_lost', 'drive_left_lost', 'drive_right_lost', 'io_lost'];

  it('tells a cut bus first, and the lost nodes as its consequences', () => {
    for (const first of [cause('tilt_left_lost'), cause('bus_down'), 0]) {
      const told = toldFaults(bits('bus_down', ...lost), first);
      expect(told[0]).toMatchObject({ fault: { name: 'bus_down' }, consequenceOf: null });
      expect(told.slice(1).map((alarm) => alarm.consequenceOf)).toEqual(Array(6).fill('bus_down'));
    }
  });

  it('tells what endangers the patient before any lost sensor', () => {
    expect(names(bits('tilt_left_lost', 'fall_detected'), cause('tilt_left_lost'))).toEqual(['fall_detected', 'tilt_left_lost']);
    expect(names(bits('tilt_left_lost', 'control_fault'), cause('tilt_left_lost'))).toEqual(['control_fault', 'tilt_left_lost']);
  });

  it('tells what came first before what came after it', () => {
    expect(names(bits('tilt_left_lost', 'tilt_frozen', 'battery_low'), cause('tilt_frozen'))).toEqual([
      'tilt_frozen',
      'tilt_left_lost',
      'battery_low',
    ]);
    expect(names(bits('stop_pressed', 'tilt_left_lost'), cause('stop_pressed'))).toEqual(['stop_pressed', 'tilt_left_lost']);
  });

  it('tells the faults beyond the first 32, alone and beside the others', () => {
    for (const place of [51, 52]) {
      const [told, ...others] = toldFaults(2 ** place);
      expect(others).toEqual([]);
      expect(told!.text.de).toBe(`${place === 51 ? 'seat_open' : 'lamp_broken'} Text`);
    }
    expect(names(bits('bumper_pressed') + 2 ** 51 + 2 ** 52, 53)).toEqual(['lamp_broken', 'bumper_pressed', 'seat_open']);
    expect(names(bits('tilt_left_lost'))).toEqual(['tilt_left_lost']);
  });

  it('loses none, whatever is in force', () => {
    expect(names(0)).toEqual([]);
    const all = 2 ** 53 - 1;
    expect([...names(all, 3)].sort()).toEqual(faults.map((fault) => fault.name).sort());
    expect(names(all).slice(0, 1)).toEqual(endangers.slice(0, 1));
    for (const { cause: why, effect } of explanations) expect(names(bits(why, effect))).toEqual([why, effect]);
  });
});

describe('the words', () => {
  it('say what a fault was about', () => {
    for (const row of faultDetails) {
      const [told] = toldFaults(bits(row.fault), 0, { [row.fault]: row.code });
      expect(told!.text).toEqual(row.text);
      expect(told!.action).toEqual(row.action);
    }
  });

  it('name the emergency of a drive that has no words of its own for it', () => {
    const [told] = toldFaults(bits('drive_left_fault'), 0, { drive_left_fault: 0x5400 });
    expect(told!.text.en).toMatch(/^Left drive reports a fault: .+/);
    expect(toldFaults(bits('drive_left_fault'))[0]!.text.en).toBe('Left drive reports a fault');
  });
});
