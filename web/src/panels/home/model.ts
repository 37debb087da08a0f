// The list of patients on Home: those of today first, then the others; a search finds a code by any part of it.
import type { PatientList, VisitList } from '../../contract/rest.gen';

export type Patient = PatientList['items'][number];
export type Visit = VisitList['items'][number];

/** The local day as the server writes it: YYYY-MM-DD. */
export function dayOf(time: Date): string {
  const two = (n: number) => String(n).padStart(2, '0');
  return `${time.getFullYear()}-${two(time.getMonth() + 1)}-${two(time.getDate())}`;
}

/** Letters and figures only, so that "p017" finds "P-017". */
const bare = (text: string) => text.toLocaleLowerCase().replace(/[^\p{L}\p{N}]/gu, '');

/** How well a code matches what was typed: 0 the same, 1 begins or ends so, 2 contains it; null: not at all. */
export function match(code: string, typed: string): number | null {
  const wanted = bare(typed);
  if (wanted === '') return typed.trim() === '' ? 2 : code.includes(typed.trim()) ? 2 : null;
  const has = bare(code);
  if (has === wanted) return 0;
  if (has.startsWith(wanted) || has.endsWith(wanted)) return 1;
  return has.includes(wanted) ? 2 : null;
}

/** The best matches first, else in the order given. */
export function found<T extends { code: string }>(items: readonly T[], typed: string): T[] {
  return items
    .map((item) => ({ item, rank: match(item.code, typed) }))
    .filter((one): one is { item: T; rank: number } => one.rank !== null)
    .sort((a, b) => a.rank - b.rank)
    .map(({ item }) => item);
}

/** Whether a new patient may have this code: the rule of db/store/patient_code.hpp. */
export const isCode = (typed: string): boolean => /^[\da-zÀ-ÖØ-öø-ſ][\w.À-ÖØ-öø-ſ-]{0,31}$/i.test(typed.trim());

/** Whether this code exists; capital and small letters do not tell codes apart. */
export const exists = (items: readonly { code: string }[], typed: string): boolean => {
  const code = typed.trim().toLowerCase();
  return items.some((item) => item.code.toLowerCase() === code);
};
