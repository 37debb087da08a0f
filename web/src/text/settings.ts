// Language and brightness of this device, kept in its browser.
import { useEffect, useReducer } from 'preact/hooks';
import { Store } from '../link/store';

export type Language = 'en' | 'de';
export type Theme = 'auto' | 'light' | 'dark';
export interface Settings {
  language: Language;
  theme: Theme;
}
export const languages: readonly { id: Language; name: string }[] = [
  { id: 'en', name: 'English' },
  { id: 'de', name: 'Deutsch' },
];

const storageKey = 'hoist.settings';
/** A person has chosen the language here; otherwise the hoist's own language goes before the browser's. */
let languageChosen = false;

function load(): Settings {
  const fromBrowser: Language = typeof navigator !== 'undefined' && /^de\b/i.test(navigator.language ?? '') ? 'de' : 'en';
  const fallback: Settings = { language: fromBrowser, theme: 'auto' };
  try {
    const kept = JSON.parse(localStorage.getItem(storageKey) ?? '{}') as Partial<Settings>;
    languageChosen = kept.language === 'en' || kept.language === 'de';
    return {
      language: languageChosen ? kept.language! : fallback.language,
      theme: kept.theme === 'light' || kept.theme === 'dark' ? kept.theme : fallback.theme,
    };
  } catch {
    return fallback; // storage is switched off, or holds something else
  }
}

export const settings = new Store<Settings>(load());

export function applySettings(): void {
  const { language, theme } = settings.value;
  document.documentElement.lang = language;
  if (theme === 'auto') delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  try {
    localStorage.setItem(storageKey, JSON.stringify(languageChosen ? settings.value : { theme }));
  } catch {
    // Then the choice lasts until the page is closed.
  }
}

/** The language that a person wants here, or with `offered` that of the hoist, which counts only until a person has chosen. */
export function setLanguage(language: Language, offered = false): void {
  languageChosen ||= !offered;
  settings.set({ language });
}
export const wantsOffered = (language: Language | null): language is Language =>
  language !== null && !languageChosen && language !== settings.value.language;

/** Renders the component when language or brightness change. */
export function useSettings(): Settings {
  const [, again] = useReducer((n: number) => n + 1, 0);
  useEffect(() => settings.subscribe(() => again(0)), []);
  return settings.value;
}
