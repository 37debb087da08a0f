// Why the hoist goes more slowly than it is asked to, long enough to be read.
import { speedCauses, type Words } from '../contract/faults.gen';
import type { TickRecord } from '../contract/signals.gen';

/** A limit that the patient's lean meets with every step would flicker: it is shown for a second. */
const shown_ticks = 100;

/** A reader of records that keeps the latest cause for a second; 0 = none. */
export function causeReader(): (record: Pick<TickRecord, 'speed_cause' | 'tick'>) => number {
  let last = { value: 0, tick: 0 };
  return ({ speed_cause: value, tick }) => {
    if (value !== 0) last = { value, tick };
    const age_ticks = tick - last.tick;
    return age_ticks >= 0 && age_ticks < shown_ticks ? last.value : 0;
  };
}

/** Sentences of the strip that leave the cause open. Those for a patient who lags and for a bumper say it themselves. */
const told: readonly string[] = ['strip.walking', 'strip.driving', 'strip.drivingOther', 'strip.guiding'];

/** What to say beside the sentence of calm times. */
export const slowerBecause = (calm: string, cause: number): Words | undefined =>
  told.includes(calm) ? speedCauses.find((row) => row.value === cause)?.text : undefined;
