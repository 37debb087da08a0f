// The faults in force as alarms, in display order. The server does the same for /status (server/api/alarms.cpp).
import { endangers, explanations, faultDetails, faults, type FaultInfo, type FaultName, type Words } from '../contract/faults.gen';
import { hasBit } from '../link/bits';
import { emergencyInfo } from './device';

/** Codes of the faults that have one (<name>_code of the record); 0 or missing: no detail. */
export type FaultCodes = Partial<Record<FaultName, number>>;

export interface Told {
  fault: FaultInfo;
  text: Words;
  action: Words;
  /** Its cause; null: it is a cause itself. */
  consequenceOf: FaultName | null;
}

const rank = { high: 0, medium: 1, low: 2 };
const isFault = (name: FaultName) => (fault: FaultInfo) => fault.name === name;

/** The faults of these bits by importance, without regard to which came first. */
export function activeFaults(bits: number): FaultInfo[] {
  return faults.filter((fault) => hasBit(bits, fault.bit)).sort((a, b) => rank[a.priority] - rank[b.priority] || a.bit - b.bit);
}

/** The headline: danger to the patient, then the first fault, then by priority; never a consequence of another one. */
export function headline(left: readonly FaultInfo[], firstBit: number | null): FaultInfo {
  for (const name of endangers) {
    const fault = left.find(isFault(name));
    if (fault) return fault;
  }
  const roots = left.filter((fault) => !explanations.some((row) => row.effect === fault.name && left.some(isFault(row.cause))));
  return roots.find((fault) => fault.bit === firstBit) ?? roots[0] ?? left[0]!;
}

function tell(fault: FaultInfo, codes: FaultCodes, consequenceOf: FaultName | null): Told {
  const code = codes[fault.name] ?? 0;
  const detail = faultDetails.find((row) => row.fault === fault.name && row.code === code);
  if (detail) return { fault, text: detail.text, action: detail.action, consequenceOf };
  if (code === 0 || !fault.name.startsWith('drive_')) return { fault, text: fault.text, action: fault.action, consequenceOf };
  const { text } = emergencyInfo(code);
  return { fault, text: { en: `${fault.text.en}: ${text.en}`, de: `${fault.text.de}: ${text.de}` }, action: fault.action, consequenceOf };
}

/** All of them, each followed by its consequences. `stopCause`: of the record, the first fault of the stop plus one; 0 = none. */
export function toldFaults(bits: number, stopCause = 0, codes: FaultCodes = {}): Told[] {
  const told: Told[] = [];
  let left = activeFaults(bits);
  while (left.length > 0) {
    const cause = headline(left, stopCause > 0 ? stopCause - 1 : null);
    const effects = left.filter((fault) => explanations.some((row) => row.cause === cause.name && row.effect === fault.name));
    told.push(tell(cause, codes, null), ...effects.map((fault) => tell(fault, codes, cause.name)));
    left = left.filter((fault) => fault !== cause && !effects.includes(fault));
  }
  return told;
}
