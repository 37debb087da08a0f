-- Studies that this computer has walked with virtual subjects, their drawings, and which sessions are theirs.
CREATE TABLE studies (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  made_utc_ns INTEGER NOT NULL,
  report TEXT                                -- JSON as `hoist study --json` writes it; NULL = its sessions are still being put in
) STRICT;
CREATE TABLE study_drawings (
  study_id INTEGER NOT NULL REFERENCES studies (id) ON DELETE CASCADE,
  name TEXT NOT NULL,
  svg TEXT NOT NULL,
  PRIMARY KEY (study_id, name)
) STRICT, WITHOUT ROWID;
-- A virtual subject is no patient: such a session belongs to no visit.
CREATE TABLE study_runs (
  session_id INTEGER PRIMARY KEY REFERENCES sessions (id) ON DELETE CASCADE,
  study_id INTEGER NOT NULL REFERENCES studies (id) ON DELETE CASCADE,
  subject TEXT NOT NULL,                     -- "S01" …
  run INTEGER NOT NULL                       -- its number in the protocol
) STRICT;
CREATE INDEX runs_by_study ON study_runs (study_id);
