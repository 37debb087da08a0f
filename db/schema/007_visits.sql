-- A visit is what a therapist calls a session: one patient on one day, with several walks. A session without a patient code belongs to no
-- visit: two unknown patients of one day are not one patient.
CREATE TABLE patients (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  code TEXT NOT NULL UNIQUE                  -- pseudonymous, never a name
) STRICT;
CREATE TABLE visits (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  patient_id INTEGER NOT NULL REFERENCES patients (id),
  day TEXT NOT NULL,                         -- YYYY-MM-DD where the recording computer stands
  UNIQUE (patient_id, day)
) STRICT;
ALTER TABLE sessions ADD COLUMN visit_id INTEGER REFERENCES visits (id);
CREATE INDEX sessions_by_visit ON sessions (visit_id);
INSERT OR IGNORE INTO patients (code) SELECT subject FROM sessions WHERE subject IS NOT NULL ORDER BY id;
INSERT OR IGNORE INTO visits (patient_id, day)
  SELECT patients.id, date(started_utc_ns / 1000000000, 'unixepoch', 'localtime')
  FROM sessions JOIN patients ON code = subject ORDER BY sessions.id;
UPDATE sessions SET visit_id = (
  SELECT visits.id FROM visits JOIN patients ON patients.id = patient_id
  WHERE code = subject AND day = date(started_utc_ns / 1000000000, 'unixepoch', 'localtime'))
WHERE subject IS NOT NULL;
DROP INDEX sessions_by_subject;
ALTER TABLE sessions DROP COLUMN subject;
