// Sentences that the server writes in English, in the language of the person who reads them. Where the server names its refusals, those
// are told, by texts of the contract. What is left are the sentences below, known by their words, because a problem carries nothing else that is stable.
import type { Words } from '../contract/params.gen';
import { settings } from './settings';

const noCore: Words = { en: 'The control computer does not answer.', de: 'Der Steuerrechner antwortet nicht.' };
const tryAgain: Words = { en: 'Busy just now. Try again in a moment.', de: 'Gerade beschäftigt. Gleich noch einmal versuchen.' };
const noSession: Words = { en: 'This session is no longer there.', de: 'Diese Sitzung gibt es nicht mehr.' };
const diskFull: Words = { en: 'The storage is full.', de: 'Der Speicher ist voll.' };
const storage: Words = { en: 'The storage does not answer. Call service if it stays so.', de: 'Der Speicher antwortet nicht. Bleibt es so, Service rufen.' };
const role: Words = { en: 'Your role may not do this.', de: 'Ihre Rolle darf das nicht.' };
const recorded: Words = { en: 'This session is still being recorded.', de: 'Diese Sitzung wird noch aufgezeichnet.' };
const notRecorded: Words = { en: 'Nothing is being recorded.', de: 'Es läuft keine Aufnahme.' };

/** By the server's words; a # stands for any number. */
export const serverSentences: Readonly<Record<string, Words>> = {
  // The core behind the server.
  'The control core is not connected.': noCore,
  'The core does not answer.': noCore,
  'The control core has not taken the last commands yet.': tryAgain,
  // Who may do what.
  'Your role may not do this.': role,
  'Your role may not do this': role,
  'Not logged in': { en: 'This device is not signed in.', de: 'Dieses Gerät ist nicht angemeldet.' },
  // What was sent.
  'A value cannot be used': { en: 'This value cannot be used.', de: 'Dieser Wert ist nicht brauchbar.' },
  'The exercise cannot be used.': { en: 'The hoist cannot walk this exercise.', de: 'Diese Übung kann die Hilfe nicht fahren.' },
  'The measurement cannot be used.': { en: 'This measurement cannot be used.', de: 'Diese Messung ist nicht brauchbar.' },
  'The message cannot be used.': { en: 'This page and the software of the hoist do not match. Load the page again.', de: 'Diese Seite passt nicht zur Software der Hilfe. Seite neu laden.' },
  // Sessions, their texts and their recording.
  'There is no such session': noSession,
  'there is no session #': noSession,
  'session # is being recorded: end it first': recorded,
  'This session is not being recorded.': notRecorded,
  'Nothing is being recorded.': notRecorded,
  'subject must be a code of # to # bytes in one line': { en: 'The patient code is too long.', de: 'Das Patientenkürzel ist zu lang.' },
  'note must be plain text of at most # bytes': { en: 'The note is too long.', de: 'Die Notiz ist zu lang.' },
  'The recorder is busy.': tryAgain,
  'The recorder is busy': tryAgain,
  'The database does not answer': storage,
  'The database cannot be opened': storage,
  'Something went wrong in the server': { en: 'Something went wrong in the server. Call service if it stays so.', de: 'Im Server ging etwas schief. Bleibt es so, Service rufen.' },
  // Why a session has no comparison with a plan.
  'No exercise was chosen.': { en: 'No exercise was chosen.', de: 'Es war keine Übung gewählt.' },
  'Nobody walked in this session.': { en: 'Nobody walked in this session.', de: 'In dieser Sitzung ging niemand.' },
  'Part of this walk is not recorded.': { en: 'Part of this walk is not recorded.', de: 'Ein Teil dieses Wegs ist nicht aufgezeichnet.' },
  'The recorded path cannot be compared with this exercise.': { en: 'The recorded path cannot be compared with this exercise.', de: 'Der aufgezeichnete Weg lässt sich mit dieser Übung nicht vergleichen.' },
  'The walk was too short, or nothing turned in it.': { en: 'The walk was too short, or had no turn in it.', de: 'Der Weg war zu kurz oder hatte keine Drehung.' },
};

/** What the database engine itself says; the server hands it on. */
export const engineSentences: Readonly<Record<string, Words>> = {
  'database or disk is full': diskFull,
  'disk I/O error': storage,
  'attempt to write a readonly database': storage,
  'unable to open database file': storage,
  'database is locked': tryAgain,
  'database disk image is malformed': storage,
  'file is not a database': storage,
};

/** The first of these sentences that is known, in the chosen language. Unknown ones are shown to English readers only: null means that a
 * general sentence of the caller must do. */
export function serverText(...sentences: readonly (string | null | undefined)[]): string | null {
  const { language } = settings.value;
  for (const sentence of sentences) {
    const key = (sentence ?? '').trim().replace(/\d+/g, '#');
    const table = [serverSentences, engineSentences].find((rows) => Object.hasOwn(rows, key));
    if (table !== undefined) return table[key]![language];
  }
  return language === 'en' ? (sentences.find((sentence) => sentence) ?? null) : null;
}
