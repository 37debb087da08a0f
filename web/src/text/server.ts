// Reasons of the server's refusals in words, by code; its sentences are never parsed.
import { reasons } from '../contract/messages.gen';
import type { ReasonCode } from '../contract/rest.gen';
import type { Problem } from '../link/rest';
import { refusalText, t, textOf, words } from './text';

/** Text of a reason_code; null for none or an unknown one. */
export const reasonText = (code: string | null | undefined): string | null =>
  code && Object.hasOwn(reasons, code) ? words(reasons[code as ReasonCode]) : null;

/** All texts of a problem of a plain request. Fields are named by their own texts where they have one. */
export function problemText({ refusals, errors, code }: Problem): string {
  if (refusals.length > 0) return refusals.map(refusalText).join(' ');
  // A code in use is no code against the rules.
  if (code === 'taken') return words(reasons.taken);
  const field = errors.map((error) => textOf(`invalid.${error.field}`)).find((text) => text !== null);
  return field ?? reasonText(code) ?? t('refused.unknown');
}
