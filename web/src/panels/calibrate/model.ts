// State of the Calibrate screen: the table of steps from the server, and the instruction to show.
import type { Calibration, CalibrationItem, CalibrationState, CalibrationStep } from '../../contract/rest.gen';
import { calibrate as texts } from '../../text/calibrate';
import type { TextKey } from '../../text/en';
import { addTexts, readNumber } from '../../text/text';

addTexts(texts);

/** Numbers of the live values, in the order of the contract's table. */
export const stepNames = [
  'none',
  'zero',
  'neutral',
  'gyro',
  'strut_length',
  'strut_spacing',
  'wheel_radius',
  'track',
  'square',
  'encoders',
  'bumpers',
  'struts',
] as const satisfies readonly (CalibrationStep | 'none')[];
export type StepName = (typeof stepNames)[number];
export type Phase = CalibrationState['phase'];
export const phaseNames = ['none', 'resting', 'measuring', 'operator', 'result', 'refused'] as const satisfies readonly Phase[];

export interface Now {
  step: StepName;
  phase: Phase;
  done_percent: number;
  reason: number;
  value: number;
}

/** Values that this step would change, when it has a result. Null: unknown. */
export const resultOf = ({ under_way }: Calibration, step: StepName): CalibrationState['result'] | null =>
  under_way !== null && under_way.step === step && under_way.phase === 'result' ? under_way.result : null;

/** Therapists see their steps; engineers all. */
export const stepsFor = (items: readonly CalibrationItem[], role: string): CalibrationItem[] =>
  items.filter((item) => role === 'engineer' || item.role !== 'engineer');

const bumperKeys: readonly TextKey[] = ['calibrate.press.front', 'calibrate.press.rear', 'calibrate.press.left', 'calibrate.press.right'];

const strutKeys: readonly TextKey[] = ['calibrate.now.strutsForward', 'calibrate.now.strutsRight', 'calibrate.now.strutsLeft'];

/** The present instruction. Null: the step's own text. */
export function nowKey(now: Now): TextKey | null {
  if (now.phase === 'result') return 'calibrate.now.result';
  if (now.phase === 'refused') return null;
  if (now.phase === 'resting') {
    if (now.step === 'struts') return 'calibrate.now.strutsBack';
    return now.step === 'neutral' ? 'calibrate.now.standStill' : 'calibrate.now.rest';
  }
  if (now.phase === 'measuring') return 'calibrate.now.measuring';
  if (now.phase !== 'operator') return null;
  if (now.step === 'bumpers') return bumperKeys[Math.min(3, Math.max(0, Math.round(now.value)))]!;
  if (now.step === 'struts') return strutKeys[Math.min(2, Math.max(0, Math.round(now.value)))]!;
  if (now.step === 'encoders') return now.done_percent < 50 ? 'calibrate.now.pushForward' : 'calibrate.now.turnLeft';
  const second = now.done_percent >= 50;
  // A bar is held at three places: two forward, the last one backward.
  const further = now.done_percent > 0;
  switch (now.step) {
    case 'strut_length':
      return second ? 'calibrate.now.barBack' : further ? 'calibrate.now.barFurther' : 'calibrate.now.barForward';
    case 'strut_spacing':
      return second ? 'calibrate.now.barRight' : further ? 'calibrate.now.barLeftFurther' : 'calibrate.now.barLeft';
    case 'wheel_radius':
      return second ? 'calibrate.now.pushBack' : 'calibrate.now.pushAhead';
    case 'track':
      return second ? 'calibrate.now.spinRight' : 'calibrate.now.spinLeft';
    case 'square':
      return second ? 'calibrate.now.squareRight' : 'calibrate.now.squareLeft';
    default:
      return null;
  }
}

/** Unit of the operator's value: whole turns for a track, degrees for a bar, else metres. Shown × factor = SI. */
export function entry(step: StepName): { factor: number; unit: 'm' | '°' | 'turns' } {
  if (step === 'track') return { factor: 2 * Math.PI, unit: 'turns' };
  if (step === 'strut_spacing') return { factor: Math.PI / 180, unit: '°' };
  return { factor: 1, unit: 'm' };
}

/** A typed size with the direction that is chosen beside it. Those who type a minus for the reverse direction mean the same. NaN: not usable. */
export function directed(text: string, reversed: boolean): number {
  const number = readNumber(text);
  if (reversed) return -Math.abs(number);
  return number >= 0 ? number : NaN;
}

/** The live value of this step, in its shown unit; null without one. */
export function watched(now: Now): { value: number; unit: 'm' | '°' | '°/s' | 'turns' | 'mm'; decimals: number } | null {
  const degrees = (now.value * 180) / Math.PI;
  switch (now.step) {
    case 'zero':
      return { value: degrees, unit: '°', decimals: 2 };
    case 'gyro':
      return { value: degrees, unit: '°/s', decimals: 2 };
    case 'neutral':
      return { value: now.value * 1000, unit: 'mm', decimals: 0 };
    case 'strut_spacing':
      return { value: degrees, unit: '°', decimals: 1 };
    case 'track':
      return { value: now.value / (2 * Math.PI), unit: 'turns', decimals: 2 };
    case 'encoders':
      return now.done_percent < 50 ? { value: now.value, unit: 'm', decimals: 2 } : { value: degrees, unit: '°', decimals: 0 };
    case 'strut_length':
    case 'wheel_radius':
      return { value: now.value, unit: 'm', decimals: 3 };
    default:
      return null;
  }
}
