import { describe, expect, it } from 'vitest';
import { modes, refusals } from '../src/contract/faults.gen';
import { batteries, readinessOf, stillStands, toldFor_ms, type Readiness } from '../src/link/readiness';
import { initial, type State } from '../src/link/store';
import { en } from '../src/text/en';
import { settings } from '../src/text/settings';
import { lockedText } from '../src/ui/slow_link';

const bit = (name: string) => 1 << refusals.find((row) => row.name === name)!.bit;
const good: State = { ...initial, link: 'open', everOpen: true, data: 'fresh', coreConnected: true, role: 'therapist', mode: 'standby' };
const mine = { ...initial.lease, epoch: 1, holder: 7, mine: true };
const other = { ...initial.lease, epoch: 1, holder: 8, mine: false };

/** Every combination of what decides: 9 modes, link, age, core, bus, lease, posture, stick, role, delay. */
function* all(): Generator<State> {
  for (const { name: mode } of modes)
    for (const link of ['connecting', 'open', 'lost'] as const)
      for (const data of ['none', 'fresh', 'late', 'gone'] as const)
        for (const coreConnected of [true, false])
          for (const sensed of [true, false])
            for (const lease of [mine, other, initial.lease])
              for (const blockedBits of [0, bit('not_neutral'), bit('stick_not_neutral'), bit('no_lease'), bit('fault_active') | bit('bumper_start')])
                for (const role of ['therapist', 'viewer'])
                  for (const rtt_s of [0.01, 0.5])
                    for (const standingStill of [true, false])
                      yield { ...good, mode, link, data, coreConnected, sensed, lease, blockedBits, role, rtt_s, standingStill };
}

describe('readiness', () => {
  it('never contradicts itself, whatever is combined', () => {
    let count = 0;
    const wrong: unknown[] = [];
    for (const s of all()) {
      count++;
      const r = readinessOf(s);
      const may = r.start.user.length === 0;
      const led = ['user', 'remote', 'guided'].includes(s.mode);
      const cut = s.link !== 'open' || s.data === 'gone' || s.data === 'none' || !s.sensed;
      const holds =
        (r.calm === 'strip.ready') === (may && r.calm === 'strip.ready') && // "Ready." never beside "Not ready yet"
        (!may || r.calm === 'strip.ready') &&
        (r.calm !== 'strip.notReady' || !may) &&
        (!cut || r.old) && // values of a cut chain are grey
        (!(cut && s.sensed === false) || r.motion === null) && // and no text says that it moves or stands
        (!may || (s.mode === 'standby' && s.link === 'open' && r.known && s.role !== 'viewer' && (s.blockedBits & ~bit('no_lease')) === 0)) &&
        (!r.hand || (s.lease.mine && s.link === 'open' && r.known && s.rtt_s! < 0.3 && (s.mode === 'remote' || s.mode === 'guided'))) &&
        (!r.stopped || r.start.user.length > 0) &&
        r.led === led &&
        r.may === (s.link === 'open' && s.role !== 'viewer') &&
        r.end === (s.link === 'open' && r.known && s.role !== 'viewer') && // anyone ends a motion
        !(r.known && r.lost);
      if (!holds) wrong.push({ s, r });
    }
    expect(count).toBe(9 * 3 * 4 * 2 * 2 * 3 * 5 * 2 * 2 * 2);
    expect(wrong.slice(0, 1)).toEqual([]);
  });

  it.each<[string, Partial<State>, string[], string]>([
    ['standing upright', {}, [], 'strip.ready'],
    ['another screen in control: Start asks', { lease: other, blockedBits: 0 }, [], 'strip.ready'],
    ['nobody in control: Start takes it', { blockedBits: bit('no_lease') }, [], 'strip.ready'],
    ['leaning', { blockedBits: bit('not_neutral') }, ['not_neutral'], 'strip.notReady'],
    ['a hand on the stick', { blockedBits: bit('stick_not_neutral') }, ['stick_not_neutral'], 'strip.notReady'],
    ['stopped', { mode: 'protective_stop', blockedBits: bit('fault_active') | bit('not_standby') }, ['release_stop'], 'strip.stopped'],
    ['out of service', { mode: 'fault' }, ['release_stop'], 'strip.stopped'],
    ['calibrating', { mode: 'calibrate' }, ['calibrating'], 'strip.calibrating'],
    ['starting', { mode: 'init' }, ['nodes_missing'], 'strip.starting'],
    ['one node still away', { mode: 'init', silentNodes: 'io' }, ['nodes_missing'], 'strip.waiting'],
    ['walking', { mode: 'user' }, ['not_standby'], 'strip.walking'],
    ['driving', { mode: 'remote', lease: mine }, ['not_standby'], 'strip.driving'],
    ['another screen drives', { mode: 'remote', lease: other }, ['not_standby'], 'strip.drivingOther'],
    ['driving away from a bumper', { mode: 'remote', lease: mine, bumpers: 1 }, ['not_standby'], 'strip.offBumper'],
    ['an exercise', { mode: 'guided', lease: mine }, ['not_standby'], 'strip.guiding'],
    ['an exercise of another screen', { mode: 'guided', lease: other }, ['not_standby'], 'strip.drivingOther'],
    ['an exercise whose patient lags', { mode: 'guided', lease: mine, waits: true }, ['not_standby'], 'strip.waits'],
    ['the same on another screen', { mode: 'guided', lease: other, waits: true }, ['not_standby'], 'strip.waits'],
    ['core away', { coreConnected: false, data: 'gone' }, ['core_gone'], 'strip.connecting'],
    ['server away', { link: 'lost' }, ['link_lost'], 'strip.connecting'],
    ['a viewer', { role: 'viewer' }, ['not_allowed'], 'strip.notReady'],
  ])('%s', (_, change, why, calm) => {
    const r = readinessOf({ ...good, ...change });
    expect(r.start.user).toEqual(why);
    expect(r.calm).toBe(calm);
  });

  it.each<[string, Partial<State>, Partial<Readiness>]>([
    ['at rest', {}, { old: false, motion: 'still', lead: 'nobody', led: false, lost: false, standby: true, end: true, hand: false }],
    [
      'driven from here',
      { mode: 'remote', lease: mine, standingStill: false },
      { motion: 'moving', lead: 'mine', led: true, hand: true, standby: false },
    ],
    ['driven by another screen', { mode: 'remote', lease: other }, { lead: 'other', hand: false, end: true }],
    ['late values', { data: 'late' }, { old: true, known: true, motion: 'still' }],
    ['a lost link', { link: 'lost', data: 'gone' }, { old: true, motion: null, lead: null, lost: true, end: false, standby: false }],
    ['a core that left before it said anything', { data: 'none', coreConnected: false }, { lost: true, known: false, motion: null, standby: false }],
  ])('shows %s as it is', (_, change, shown) => {
    expect(readinessOf({ ...good, ...change })).toMatchObject(shown);
  });

  it('lets the therapist drive away from a bumper that was acknowledged, and nothing else', () => {
    const s = { ...good, blockedBits: bit('bumper_start'), bumpers: 1 };
    expect(readinessOf({ ...s, bumpersHeld: true }).start).toEqual({ user: ['bumper_start'], remote: [], guided: ['bumper_start'] });
    expect(readinessOf({ ...s, bumpersHeld: false }).start.remote).toEqual(['bumper_start']);
  });
});

describe('hold-to-run that does nothing', () => {
  it.each<[string, Partial<State>, string]>([
    ['without a connection', { link: 'lost', lease: other }, en['refused.link_lost']],
    ['led by another screen', { lease: other }, en['guided.other']],
    ['led by no one any more', {}, en['drive.locked']],
    ['over a slow connection', { lease: mine, rtt_s: 0.5 }, en['drive.tooSlow'].replace('{n}', '500')],
    ['without the control computer', { lease: mine, coreConnected: false, data: 'gone' }, en['refused.core_gone']],
  ])('says why %s', (_, change, told) => {
    settings.set({ language: 'en' });
    const s: State = { ...good, mode: 'remote', ...change };
    expect(lockedText(readinessOf(s), s.rtt_s)).toBe(told);
  });
});

describe('a refusal', () => {
  it.each<[string, Partial<State>, Partial<State>]>([
    ['not_neutral', { blockedBits: bit('not_neutral') }, {}],
    ['link_lost', { link: 'lost' }, {}],
    ['not_standby', { mode: 'user' }, {}],
    ['only_when_stopped', { mode: 'user' }, {}],
    ['no_lease', { lease: other }, { lease: mine }],
    ['no_lease', { lease: other }, {}],
  ])('%s stands as long as its reason and no longer', (reason, while_, after) => {
    expect(stillStands(reason, { ...good, ...while_ }, 1e9)).toBe(true);
    expect(stillStands(reason, { ...good, ...after }, 0)).toBe(false);
  });

  it('whose reason no state shows is told for a while; one about a value until it is changed', () => {
    expect(stillStands('no_answer', good, 0)).toBe(true);
    expect(stillStands('no_answer', good, toldFor_ms)).toBe(false);
    expect(stillStands('out_of_range', good, 1e9)).toBe(true);
  });
});

describe('the batteries', () => {
  it('are not known before the input node tells of them; one that is off is', () => {
    expect(batteries(null)).toEqual([NaN, NaN]);
    expect(batteries({ battery_a_v: 0, battery_b_v: 0 })).toEqual([NaN, NaN]);
    expect(batteries({ battery_a_v: 12.5, battery_b_v: 0 })).toEqual([12.5, 0]);
  });
});
