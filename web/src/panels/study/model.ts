// Numbers of a study as the page shows them.
import type { Study } from '../../contract/rest.gen';

export type Report = Study['report'];
export type StudyTable = Report['tables'][number];
export type StudyRun = Report['runs'][number];

/** Subjects of the paper, and what the server accepts. */
export const paperSubjects = 11;
export const subjectsMost = 99;
export const seedMost = 1_000_000_000;

/** A whole number as a person types it; null for anything else. */
export function readWhole(text: string, least: number, most: number): number | null {
  if (!/^\d{1,10}$/.test(text.trim())) return null;
  const value = Number(text.trim());
  return value >= least && value <= most ? value : null;
}

/** "1", or "3*" for a run that the patient leads, as the paper's tables mark it. */
export const runMark = ({ run, led_by }: StudyRun): string => `${run}${led_by === 'patient' ? '*' : ''}`;

/** The session of a row and run, as far as it is still there. */
export const sessionOf = (study: Study, subject: string, run: number): number | null =>
  study.sessions.find((one) => one.subject === subject && one.run === run)?.session ?? null;
