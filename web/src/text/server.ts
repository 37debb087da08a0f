// Why the server did not do something, in words: told by its code, never by its sentences.
import { reasons } from '../contract/messages.gen';
import type { ReasonCode } from '../contract/rest.gen';
import type { Problem } from '../link/rest';
import { refusalText, t, textOf, words } from './text';

/** Of a reason_code; null for none, and for one that this page does not know. */
export const reasonText = (code: string | null | undefined): string | null =>
  code && Object.hasOwn(reasons, code) ? words(reasons[code as ReasonCode]) : null;

/** Everything that a problem of a plain request says. A field that has its own words is named by them. */
export function problemText({ refusals, errors, code }: Problem): string {
  if (refusals.length > 0) return refusals.map(refusalText).join(' ');
  const field = errors.map((error) => textOf(`invalid.${error.field}`)).find((text) => text !== null);
  return field ?? reasonText(code) ?? t('refused.unknown');
}
