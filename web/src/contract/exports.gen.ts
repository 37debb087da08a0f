// Made by `deploy/dev gen` from db/export/formats.def; do not edit.

import type { Words } from './rest.gen';

export type ExportFormat =
  | 'csv'
  | 'csv_de'
  | 'events'
  | 'json'
  | 'candump'
  | 'mcap'
  | 'mat'
  | 'sqlite'
  | 'zip';

export interface ExportFormatInfo {
  name: ExportFormat;
  title: Words;
  /** Whether live values can be chosen with `columns`. */
  columns: boolean;
}

export const exportFormats: readonly ExportFormatInfo[] = [
  { name: 'csv', title: { en: 'Table (CSV)', de: 'Tabelle (CSV)' }, columns: true },
  { name: 'csv_de', title: { en: 'Table for German spreadsheets (CSV)', de: 'Tabelle für deutsches Excel (CSV)' }, columns: true },
  { name: 'events', title: { en: 'Events (CSV)', de: 'Ereignisse (CSV)' }, columns: false },
  { name: 'json', title: { en: 'Everything (JSON)', de: 'Alles (JSON)' }, columns: true },
  { name: 'candump', title: { en: 'CAN frames (candump)', de: 'CAN-Nachrichten (candump)' }, columns: false },
  { name: 'mcap', title: { en: 'Robot log (MCAP)', de: 'Roboter-Protokoll (MCAP)' }, columns: true },
  { name: 'mat', title: { en: 'MATLAB, Octave (MAT)', de: 'MATLAB, Octave (MAT)' }, columns: true },
  { name: 'sqlite', title: { en: 'Plain tables (SQLite)', de: 'Einfache Tabellen (SQLite)' }, columns: true },
  { name: 'zip', title: { en: 'All files (ZIP)', de: 'Alle Dateien (ZIP)' }, columns: false },
];
