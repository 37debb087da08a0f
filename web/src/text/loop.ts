// Texts of the control loop's picture. They come with it (panels/health/loop.tsx), which adds them (addTexts).
import type { Language } from './settings';

const en = {
  'loop.hint': 'A hundred steps a second. The hoist stops when two within a second start more than {two} ms late, or one more than {one} ms.',
  'loop.picture': 'How late the steps began',
  'loop.lately': 'Last ten seconds',
  'loop.ever': 'Since the start',
  'loop.counted': 'Late: from {ms} ms on',
  'loop.half': 'Half begin within',
  'loop.most': '99 of 100 begin within',
  'loop.latest': 'Longest delay in ten seconds',
  'loop.latestEver': 'Longest delay since the start',
  'loop.missed': 'Missed steps',
  'loop.priority': 'Real-time priority',
  'loop.notGranted': 'not granted',
  'loop.cpu': 'Own processor core',
  'loop.anyCpu': 'none',
  'loop.memory': 'Memory',
  'loop.locked': 'locked',
  'loop.notLocked': 'not locked',
  'loop.pageFaults': 'Page faults',
  'loop.allocations': 'Memory allocations',
};
export type LoopKey = keyof typeof en;

const de: Record<LoopKey, string> = {
  'loop.hint':
    'Hundert Schritte in der Sekunde. Das Gerät hält an, wenn zwei in einer Sekunde mehr als {two} ms zu spät beginnen oder einer mehr als {one} ms.',
  'loop.picture': 'Wie spät die Schritte begannen',
  'loop.lately': 'Letzte zehn Sekunden',
  'loop.ever': 'Seit dem Start',
  'loop.counted': 'Spät: ab {ms} ms',
  'loop.half': 'Die Hälfte beginnt binnen',
  'loop.most': '99 von 100 beginnen binnen',
  'loop.latest': 'Größte Verspätung in zehn Sekunden',
  'loop.latestEver': 'Größte Verspätung seit dem Start',
  'loop.missed': 'Ausgelassene Schritte',
  'loop.priority': 'Echtzeitpriorität',
  'loop.notGranted': 'nicht gewährt',
  'loop.cpu': 'Eigener Prozessorkern',
  'loop.anyCpu': 'keiner',
  'loop.memory': 'Arbeitsspeicher',
  'loop.locked': 'verriegelt',
  'loop.notLocked': 'nicht verriegelt',
  'loop.pageFaults': 'Seitenfehler',
  'loop.allocations': 'Speicheranforderungen',
};

export const loop: Readonly<Record<Language, Readonly<Record<LoopKey, string>>>> = { en, de };
