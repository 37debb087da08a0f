// Plays alarms by Web Audio, in the patterns of the hoist (alarmSignals). Browsers allow sound only after the first tap or key on the page.
import { alarmHarmonics, alarmPitch_hz, alarmSignals, type FaultInfo } from '../contract/faults.gen';

export type AlarmLevel = FaultInfo['priority'];

/** What of an AudioContext is used here, so that tests can stand in for it. */
export type Audio = Pick<
  AudioContext,
  'currentTime' | 'state' | 'resume' | 'createOscillator' | 'createGain' | 'createPeriodicWave' | 'destination'
> & {
  onstatechange: AudioContext['onstatechange'];
};
interface Timers {
  after: (call: () => void, delay_ms: number) => number;
  cancel: (timer: number) => void;
}

/** Share of a pulse in which it rises, and falls (SOURCES 2.5: 10 to 40 %). */
const slope = 0.15;
/** Harmonics within 15 dB of the pitch. */
const strength = 0.6;
const loudness = 0.5;
/** A burst is handed to the audio clock a little before it begins. */
const ahead_s = 0.05;

export class AlarmSound {
  private audio: Audio | null = null;
  private gain: GainNode | null = null;
  private timer: number | null = null;
  private playing: AlarmLevel | null = null;

  constructor(
    private readonly make: () => Audio,
    private readonly timers: Timers,
    private readonly changed: () => void,
  ) {}

  /** Nothing can be heard until somebody taps, or presses a key. */
  get blocked(): boolean {
    return this.audio?.state !== 'running';
  }

  /** To be called from a tap or a key. */
  unlock(): void {
    if (this.audio === null) this.begin();
    if (this.blocked)
      this.audio?.resume().then(
        () => this.started(),
        () => this.changed(),
      );
  }

  /** Sounds this priority from now on; null: silence. The same again goes on as it is. */
  play(level: AlarmLevel | null): void {
    if (level === this.playing) return;
    this.playing = level;
    this.restart();
  }

  private begin(): void {
    const audio = this.make();
    // Pitch and harmonics; the first coefficient is the constant part.
    const partials = [0, 1, ...Array.from({ length: alarmHarmonics }, () => strength)];
    const tone = audio.createOscillator();
    tone.setPeriodicWave(
      audio.createPeriodicWave(
        partials.map(() => 0),
        partials,
      ),
    );
    tone.frequency.value = alarmPitch_hz;
    const gain = audio.createGain();
    gain.gain.value = 0;
    tone.connect(gain);
    gain.connect(audio.destination);
    tone.start();
    // A phone call or the system may take the sound away again.
    audio.onstatechange = () => this.started();
    this.audio = audio;
    this.gain = gain;
  }

  private started(): void {
    this.restart();
    this.changed();
  }

  private restart(): void {
    if (this.timer !== null) this.timers.cancel(this.timer);
    this.timer = null;
    if (this.audio === null || this.gain === null) return;
    this.gain.gain.cancelScheduledValues(this.audio.currentTime);
    this.gain.gain.setValueAtTime(0, this.audio.currentTime);
    if (this.playing !== null && !this.blocked) this.burst(this.playing, this.audio.currentTime + ahead_s);
  }

  private burst(level: AlarmLevel, from_s: number): void {
    const { pulses_ms, pulse_ms, burst_ms } = alarmSignals[level];
    const envelope = this.gain!.gain;
    const slope_s = (slope * pulse_ms) / 1000;
    for (const at_ms of pulses_ms) {
      const begin_s = from_s + at_ms / 1000;
      const end_s = begin_s + pulse_ms / 1000;
      envelope.setValueAtTime(0, begin_s);
      envelope.linearRampToValueAtTime(loudness, begin_s + slope_s);
      envelope.setValueAtTime(loudness, end_s - slope_s);
      envelope.linearRampToValueAtTime(0, end_s);
    }
    const next_s = from_s + burst_ms / 1000;
    this.timer = this.timers.after(
      () => this.burst(level, Math.max(next_s, this.audio!.currentTime)),
      (next_s - ahead_s - this.audio!.currentTime) * 1000,
    );
  }
}
