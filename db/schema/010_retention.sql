-- Sessions that are deleted already (no row in `sessions`), whose samples, frames and journal are still to be overwritten, piece by piece.
CREATE TABLE deletions (
  session_id INTEGER PRIMARY KEY
) STRICT;
-- Backups of this file that were written and checked.
CREATE TABLE backups (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  utc_ns INTEGER NOT NULL,
  folder TEXT NOT NULL,
  newest_session INTEGER NOT NULL            -- that had ended
) STRICT;
-- How long sessions are kept: one row.
CREATE TABLE retention (
  id INTEGER PRIMARY KEY CHECK (id = 1),
  months INTEGER CHECK (months BETWEEN 1 AND 240),  -- NULL = for ever
  needs_backup INTEGER NOT NULL CHECK (needs_backup IN (0, 1))
) STRICT;
INSERT INTO retention (id, months, needs_backup) VALUES (1, NULL, 1);
