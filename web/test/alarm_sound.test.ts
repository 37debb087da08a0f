import { describe, expect, it } from 'vitest';
import { alarmHarmonics, alarmPitch_hz, alarmSignals, audioPause_s } from '../src/contract/faults.gen';
import { AlarmSound, type Audio } from '../src/ui/alarm_sound';
import { OwnPause } from '../src/ui/own_pause';
import { levelOf } from '../src/ui/sound_button';

/** An AudioContext that keeps what was asked of it. */
class FakeAudio {
  currentTime = 0;
  state: AudioContextState = 'suspended';
  onstatechange: (() => void) | null = null;
  destination = {};
  pitch_hz = 0;
  partials: readonly number[] = [];
  /** Loudness by time, as scheduled and not cancelled. */
  points: { at_s: number; value: number; ramp: boolean }[] = [];
  refuses = false;

  resume() {
    if (this.refuses) return Promise.reject(new Error('not allowed'));
    this.state = 'running';
    return Promise.resolve();
  }
  createPeriodicWave(_real: readonly number[], imag: readonly number[]) {
    this.partials = imag;
    return {};
  }
  createOscillator() {
    const set = (value: number) => (this.pitch_hz = value);
    return {
      frequency: {
        set value(value: number) {
          set(value);
        },
      },
      setPeriodicWave: () => undefined,
      connect: () => undefined,
      start: () => undefined,
    };
  }
  createGain() {
    const add = (value: number, at_s: number, ramp: boolean) => this.points.push({ at_s, value, ramp });
    return {
      connect: () => undefined,
      gain: {
        value: 1,
        setValueAtTime: (value: number, at_s: number) => add(value, at_s, false),
        linearRampToValueAtTime: (value: number, at_s: number) => add(value, at_s, true),
        cancelScheduledValues: (from_s: number) => (this.points = this.points.filter((point) => point.at_s < from_s)),
      },
    };
  }
  /** Beginnings of the pulses, ms after the first. */
  pulses_ms() {
    const begins = this.points.filter((point) => point.ramp && point.value > 0).map((point) => point.at_s);
    return begins.map((at_s) => Math.round((at_s - begins[0]!) * 1000));
  }
}

class FakeTimers {
  calls: { id: number; call: () => void; delay_ms: number }[] = [];
  private id = 0;
  after = (call: () => void, delay_ms: number) => {
    this.calls.push({ id: ++this.id, call, delay_ms });
    return this.id;
  };
  cancel = (id: number) => {
    this.calls = this.calls.filter((entry) => entry.id !== id);
  };
}

const set = () => {
  const audio = new FakeAudio();
  const timers = new FakeTimers();
  let changes = 0;
  const sound = new AlarmSound(
    () => audio as unknown as Audio,
    timers,
    () => ++changes,
  );
  return { audio, timers, sound, changes: () => changes };
};
const settled = () => new Promise<void>((done) => setTimeout(done, 0));

describe('the sound of alarms', () => {
  it('is off until somebody taps, and then plays what it was told', async () => {
    const { audio, timers, sound, changes } = set();
    sound.play('high');
    expect(sound.blocked).toBe(true);
    expect(audio.points).toEqual([]);
    sound.unlock();
    await settled();
    expect(sound.blocked).toBe(false);
    expect(changes()).toBe(1);
    expect(audio.pulses_ms()).toEqual(alarmSignals.high.pulses_ms);
    expect(audio.pitch_hz).toBe(alarmPitch_hz);
    expect(audio.partials).toHaveLength(2 + alarmHarmonics);
    // Each partial within 15 dB of the pitch.
    for (const partial of audio.partials.slice(1)) expect(20 * Math.log10(partial)).toBeGreaterThan(-15);
    expect(timers.calls).toHaveLength(1);
    expect(timers.calls[0]!.delay_ms).toBeCloseTo(alarmSignals.high.burst_ms, 6);
  });

  it.each(['high', 'medium', 'low'] as const)('plays %s in the pattern of the hoist, burst after burst', async (level) => {
    const { audio, timers, sound } = set();
    sound.unlock();
    await settled();
    sound.play(level);
    const { pulses_ms, pulse_ms, burst_ms } = alarmSignals[level];
    expect(audio.pulses_ms()).toEqual(pulses_ms);
    // Silent between the pulses, and for a pulse's length audible.
    const begin_s = audio.points.find((point) => point.value === 0 && point.at_s > 0)!.at_s;
    const ends = audio.points.filter((point) => point.ramp && point.value === 0).map((point) => Math.round((point.at_s - begin_s) * 1000));
    expect(ends).toEqual(pulses_ms.map((at_ms) => at_ms + pulse_ms));
    const before = audio.points.length;
    audio.currentTime = burst_ms / 1000;
    timers.calls[0]!.call();
    const next = audio.points.slice(before).filter((point) => point.ramp && point.value > 0);
    expect(next).toHaveLength(pulses_ms.length);
    expect(Math.round((next[0]!.at_s - audio.points.filter((point) => point.ramp && point.value > 0)[0]!.at_s) * 1000)).toBe(burst_ms);
  });

  it('ends at once, and begins anew with another priority only', async () => {
    const { audio, timers, sound } = set();
    sound.unlock();
    await settled();
    sound.play('medium');
    const points = audio.points.length;
    sound.play('medium');
    expect(audio.points).toHaveLength(points);
    audio.currentTime = 0.1;
    sound.play('high');
    expect(audio.points.filter((point) => point.at_s >= 0.1 && point.ramp && point.value > 0)).toHaveLength(10);
    audio.currentTime = 0.2;
    sound.play(null);
    expect(audio.points.filter((point) => point.at_s > 0.2)).toEqual([]);
    expect(timers.calls).toEqual([]);
  });

  it('says that it is off when the browser or the system takes it away', async () => {
    const { audio, sound, changes } = set();
    audio.refuses = true;
    sound.unlock();
    await settled();
    expect(sound.blocked).toBe(true);
    expect(changes()).toBe(1);
    audio.refuses = false;
    sound.unlock();
    await settled();
    expect(sound.blocked).toBe(false);
    audio.state = 'suspended';
    audio.onstatechange!();
    expect(sound.blocked).toBe(true);
  });
});

describe('the pause on this screen', () => {
  it('is for the alarms that were shown, and ends with a new one or after two minutes', () => {
    const pause = new OwnPause();
    expect(pause.sounding(['link'], 0)).toEqual(['link']);
    pause.begin(['link', 'core'], 0);
    expect(pause.sounding(['link', 'core'], 1000)).toEqual([]);
    expect(pause.left_s(1000)).toBe(audioPause_s - 1);
    // One that ended and came back is new.
    expect(pause.sounding(['link'], 2000)).toEqual([]);
    expect(pause.sounding(['link', 'core'], 3000)).toEqual(['link', 'core']);
    pause.begin(['link'], 0);
    expect(pause.sounding(['link'], audioPause_s * 1000 - 1)).toEqual([]);
    expect(pause.sounding(['link'], audioPause_s * 1000)).toEqual(['link']);
    expect(pause.left_s(audioPause_s * 1000)).toBe(0);
    pause.begin(['link'], 0);
    pause.end();
    expect(pause.sounding(['link'], 1)).toEqual(['link']);
  });
});

describe('what sounds here', () => {
  const hoist = { id: 'fall_detected', priority: 'high', hoist: true } as const;
  const own = { id: 'recording', priority: 'medium', hoist: false } as const;
  it('is what sounds at the hoist, and what only this screen knows', () => {
    expect(levelOf([], [], 3)).toBe(null);
    expect(levelOf([hoist], ['fall_detected'], 3)).toBe('high');
    expect(levelOf([hoist], ['fall_detected'], 0), 'paused at the hoist').toBe(null);
    expect(levelOf([hoist, own], ['fall_detected', 'recording'], 0)).toBe('medium');
    expect(levelOf([hoist, own], ['fall_detected', 'recording'], 3)).toBe('high');
    expect(levelOf([hoist, own], [], 3), 'paused on this screen').toBe(null);
    expect(levelOf([{ id: 'calm', priority: 'calm', hoist: false }], ['calm'], 0)).toBe(null);
  });
});
