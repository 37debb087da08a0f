-- What each control step was given beside the frames of bus_chunks, and the core's memory now and then: with both, and a program of the same
-- build (sessions.core_version, layout_hash), the session can be run again.
CREATE TABLE journal_chunks (
  id INTEGER PRIMARY KEY,
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  first_step INTEGER NOT NULL,               -- steps count from the core's start
  steps INTEGER NOT NULL,
  body BLOB NOT NULL,
  UNIQUE (session_id, first_step)
) STRICT;

CREATE TABLE core_images (
  id INTEGER PRIMARY KEY,
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  step INTEGER NOT NULL,                     -- the step that comes next
  tick INTEGER NOT NULL,
  bytes INTEGER NOT NULL,                    -- of the core's memory; the body is packed
  body BLOB NOT NULL,
  UNIQUE (session_id, step)
) STRICT;
