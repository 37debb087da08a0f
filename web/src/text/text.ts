// Texts and numbers in the chosen language.
import type { Words } from '../contract/params.gen';
import { refusals } from '../contract/faults.gen';
import type { Table, TextKey } from './en';
import { first } from './first';
import { setLanguage, settings, wantsOffered, type Language } from './settings';

const files: Readonly<Record<Language, () => Promise<Table>>> = {
  en: async () => (await import('./en')).en,
  de: async () => (await import('./de')).de,
};
const tables: Partial<Record<Language, Table>> = {};
type Part = Readonly<Record<Language, Readonly<Record<string, string>>>>;
const parts: Part[] = [first];

/** Texts that come with a screen. */
export function addTexts(part: Part): void {
  if (!parts.includes(part)) parts.push(part);
}

/** Loads the texts of a language, once; rejects when they cannot be loaded. */
export async function loadLanguage(language: Language): Promise<void> {
  tables[language] ??= await files[language]();
}

/** Changes the language once its texts are loaded. False: loading failed, and the language stays. */
export async function chooseLanguage(language: Language, offered = false): Promise<boolean> {
  try {
    await loadLanguage(language);
  } catch {
    return false;
  }
  setLanguage(language, offered);
  return true;
}

/** The hoist's own language, for a browser in which none has been chosen. When it cannot be loaded the present one stays. */
export function offerLanguage(language: Language | null): void {
  if (wantsOffered(language)) void chooseLanguage(language, true);
}

/** The text in the chosen language, whose words must have been loaded unless the key is one of first.ts or of the screen's own. */
export function t(key: TextKey, values: Record<string, string | number> = {}): string {
  return filled(textOf(key) ?? key, values);
}

/** A text with its values in their places. */
export function filled(text: string, values: Record<string, string | number>): string {
  return text.replace(/\{(\w+)\}/g, (whole, name: string) => String(values[name] ?? whole));
}

/** The same for a received key; null for an unknown one. */
export function textOf(key: string): string | null {
  const { language } = settings.value;
  for (const table of [...parts.map((part) => part[language]), tables[language]] as (Readonly<Record<string, string>> | undefined)[])
    if (table !== undefined && Object.hasOwn(table, key)) return table[key]!;
  return null;
}

export const words = (both: Words): string => both[settings.value.language];

export function refusalText(name: string): string {
  const row = refusals.find((refusal) => refusal.name === name);
  return row ? words(row.text) : (textOf(`refused.${name}`) ?? t('refused.unknown'));
}

const locale = () => (settings.value.language === 'de' ? 'de-DE' : 'en-GB');
export const noValue = '–';
const minus = (text: string) => text.replace('-', '−');

/** A number with a fixed count of decimals; a dash for what is not a number. Never "−0.0". */
export function fixed(value: number | null | undefined, decimals: number): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return noValue;
  const zero = Number(value.toFixed(decimals)) === 0 ? 0 : value;
  return minus(
    new Intl.NumberFormat(locale(), { minimumFractionDigits: decimals, maximumFractionDigits: decimals, useGrouping: false }).format(zero),
  );
}

/** A number with up to four significant digits and no idle zeros, for settings. */
export function plain(value: number): string {
  if (!Number.isFinite(value)) return noValue;
  return minus(new Intl.NumberFormat(locale(), { maximumSignificantDigits: 4, useGrouping: false }).format(value));
}

/** A number with its unit; degrees follow without a space, and what is not a number has no unit. */
export const withUnit = (number: string, unit: string): string =>
  number === noValue ? number : unit === '°' || unit === '' ? `${number}${unit}` : `${number} ${unit}`;
export const quantity = (value: number | null | undefined, decimals: number, unit: string): string => withUnit(fixed(value, decimals), unit);

export const toDegrees = (rad: number): number => (rad * 180) / Math.PI;
/** An angle for a screen: degrees with one decimal. */
export const degrees = (rad: number | null | undefined, decimals = 1): string =>
  rad === null || rad === undefined ? noValue : `${fixed(toDegrees(rad), decimals)}°`;

/** Reads what a person typed: comma or point, minus sign of any kind. NaN when it is not a number, or when the language also reads it as
 * thousands: "1.000" in German, "1,000" in English. */
export function readNumber(text: string): number {
  const typed = text.trim().replace('−', '-');
  const thousands = /^[-+]?[1-9]\d?\d?([.,])\d{3}$/.exec(typed)?.[1];
  if (thousands === (settings.value.language === 'de' ? '.' : ',')) return NaN;
  const tidy = typed.replace(',', '.');
  return /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i.test(tidy) ? Number(tidy) : NaN;
}

/** 75 s → 1:15, 3671 s → 1:01:11. Rounded as in the report, so that a figure is the same in both. */
export function duration(seconds: number | null | undefined): string {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return noValue;
  const whole = Math.max(0, Math.round(seconds));
  const two = (n: number) => String(n).padStart(2, '0');
  const hours = Math.floor(whole / 3600);
  return hours > 0 ? `${hours}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)}` : `${Math.floor(whole / 60)}:${two(whole % 60)}`;
}

export function date(utc_ms: number | null | undefined): string {
  if (utc_ms === null || utc_ms === undefined || !Number.isFinite(utc_ms)) return noValue;
  return new Intl.DateTimeFormat(locale(), { dateStyle: 'medium', timeStyle: 'short' }).format(utc_ms);
}

/** A day as the server writes it, YYYY-MM-DD. */
export function dayText(day: string | null | undefined): string {
  const [year = NaN, month = NaN, date_ = NaN] = (day ?? '').split('-').map(Number);
  const noon = new Date(year, month - 1, date_, 12);
  return Number.isFinite(noon.getTime()) ? new Intl.DateTimeFormat(locale(), { dateStyle: 'medium' }).format(noon) : noValue;
}

// ------------------------------------------------------------------------------- settings: SI underneath, degrees on screens
const shares = new Set(['lean_dead_band_norm', 'turn_dead_band_norm', 'speed_cap_norm', 'neutral_start_tolerance_norm']);

/** How a setting is shown: shown value = SI value × factor. */
export function shownAs(name: string, unit: string): { factor: number; unit: string } {
  if (unit === 'rad' || unit.startsWith('rad/')) return { factor: 180 / Math.PI, unit: unit.replace('rad', '°') };
  if (shares.has(name)) return { factor: 100, unit: '%' };
  if (unit === 'units' || unit === 'counts') return { factor: 1, unit: t(`unit.${unit}`) };
  return { factor: 1, unit };
}
