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

const builds: Words = { en: 'Its parts are of different software versions: switch the hoist off and on.', de: 'Seine Teile haben verschiedene Softwarestände: Gerät aus- und einschalten.' };
const noLink: Words = { en: 'The console server cannot reach the control program.', de: 'Der Konsolenserver erreicht das Steuerprogramm nicht.' };

/** By the server's words; a # stands for any number, a * at the end for any rest. */
export const serverSentences: Readonly<Record<string, Words>> = {
  // The core behind the server.
  'The control core is not connected.': noCore,
  'The core does not answer.': noCore,
  'The control core has not taken the last commands yet.': tryAgain,
  // Why it is not connected: stands below "the control computer does not answer".
  'the control core is attached, but publishes nothing': { en: 'The control program is running but sends no values.', de: 'Das Steuerprogramm läuft, sendet aber keine Werte.' },
  'the core does not answer': { en: 'The control program is running but gives no reply.', de: 'Das Steuerprogramm läuft, reagiert aber nicht.' },
  'the core has gone away': { en: 'The control program has ended.', de: 'Das Steuerprogramm wurde beendet.' },
  'no core listens on *': { en: 'The control program is not running.', de: 'Das Steuerprogramm läuft nicht.' },
  'the core refused: another server is attached': { en: 'Another console server is connected to it.', de: 'Ein anderer Konsolenserver ist damit verbunden.' },
  'the core refused: core and server are different builds*': builds,
  'the core refused: *': { en: 'The control program refused the console server. Call service.', de: 'Das Steuerprogramm weist den Konsolenserver ab. Service rufen.' },
  'core and server are different builds*': builds,
  'the hand-over has the wrong size: different builds': builds,
  "the other side's memory *": builds,
  'the other side *': noLink,
  'the socket path is too long: *': noLink,
  'cannot *': noLink,
  // Who may do what.
  'Your role may not do this.': role,
  'Your role may not do this': role,
  'Not logged in': { en: 'This device is not signed in.', de: 'Dieser Bildschirm ist nicht angemeldet.' },
  // What was sent.
  'A value cannot be used': { en: 'This value cannot be used.', de: 'Dieser Wert ist nicht brauchbar.' },
  'The exercise cannot be used.': { en: 'The hoist cannot walk this exercise.', de: 'Diese Übung kann das Gerät nicht fahren.' },
  'The measurement cannot be used.': { en: 'This measurement cannot be used.', de: 'Diese Messung ist nicht brauchbar.' },
  'The message cannot be used.': { en: 'This page and the software of the hoist do not match. Load the page again.', de: 'Diese Seite passt nicht zur Software des Geräts. Seite neu laden.' },
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
  'This recording holds more than one walk: it was started anew, or somebody else led.': { en: 'This recording holds more than one walk: it was started anew, or led by someone else.', de: 'Diese Aufzeichnung enthält mehr als einen Weg: Es wurde neu begonnen, oder jemand anderes hat geführt.' },
  "Where on the exercise's path this walk began is not clear.": { en: 'It is not clear where on the exercise this walk began.', de: 'Es ist unklar, an welcher Stelle der Übung dieser Weg begann.' },
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

function known(sentence: string): Words | undefined {
  const key = sentence.trim().replace(/\d+/g, '#');
  for (const rows of [serverSentences, engineSentences]) {
    if (Object.hasOwn(rows, key)) return rows[key];
    const start = Object.keys(rows).find((row) => row.endsWith('*') && key.startsWith(row.slice(0, -1)));
    if (start !== undefined) return rows[start];
  }
  return undefined;
}

/** The first of these sentences that is known, in the chosen language. Unknown ones are shown to English readers only: null means that a
 * general sentence of the caller must do. */
export function serverText(...sentences: readonly (string | null | undefined)[]): string | null {
  const { language } = settings.value;
  for (const sentence of sentences) {
    const words = known(sentence ?? '');
    if (words !== undefined) return words[language];
  }
  return language === 'en' ? (sentences.find((sentence) => sentence) ?? null) : null;
}
