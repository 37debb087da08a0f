// Texts needed before a language file is loaded, or without one: STOP, and what to do then. In the first load, in all languages.
import type { Language } from './settings';

const en = {
  'app.title': 'Hoist',
  'stop.name': 'STOP',
  'stop.hint': 'Stops the hoist at once. Also the space bar.',
  'load.failed': 'This screen could not be loaded.',
  'load.action': 'Load the page again while the hoist stands still. STOP works here, too.',
  'load.again': 'Load again',
};
export type FirstKey = keyof typeof en;

const de: Record<FirstKey, string> = {
  'app.title': 'Hoist',
  'stop.name': 'STOPP',
  'stop.hint': 'Hält das Gerät sofort an. Auch die Leertaste.',
  'load.failed': 'Diese Ansicht konnte nicht geladen werden.',
  'load.action': 'Seite neu laden, während das Gerät steht. STOPP wirkt auch hier.',
  'load.again': 'Neu laden',
};

export const first: Readonly<Record<Language, Readonly<Record<FirstKey, string>>>> = { en, de };
