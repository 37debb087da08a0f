-- Backups of this file that were written and checked. Each holds all sessions that had ended by then.
CREATE TABLE backups (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  utc_ns INTEGER NOT NULL,
  folder TEXT NOT NULL,
  newest_session INTEGER NOT NULL            -- that had ended; none before it was left out
) STRICT;

-- 1 = recorded in standby with a patient chosen: part of a visit, but no walk.
ALTER TABLE sessions ADD COLUMN standby INTEGER NOT NULL DEFAULT 0 CHECK (standby IN (0, 1));
CREATE INDEX walks_by_visit ON sessions (visit_id) WHERE standby = 0;
