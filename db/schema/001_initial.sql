-- Sessions and everything recorded in them. Files in this folder are only ever added: a database knows by user_version how many it has seen.

CREATE TABLE sessions (
  id INTEGER PRIMARY KEY AUTOINCREMENT,      -- never reused, also not after a deletion: people write it on paper
  subject TEXT,                              -- pseudonymous code
  started_utc_ns INTEGER NOT NULL,           -- wall clock …
  start_time_ns INTEGER NOT NULL,            -- … at this moment of the core's steady clock
  core_start_time_ns INTEGER NOT NULL,       -- which life of the core
  simulated INTEGER NOT NULL CHECK (simulated IN (0, 1)),
  layout_hash INTEGER NOT NULL,
  software_version TEXT NOT NULL,
  note TEXT NOT NULL,
  exercise TEXT,                             -- JSON: shape and sizes
  ended_utc_ns INTEGER,
  close_reason TEXT,
  sample_count INTEGER,                      -- these three are filled when the session is closed
  first_time_ns INTEGER,
  last_time_ns INTEGER,
  folded INTEGER NOT NULL DEFAULT 0 CHECK (folded IN (0, 1)),
  CHECK ((ended_utc_ns IS NULL) = (close_reason IS NULL))
) STRICT;
CREATE INDEX sessions_by_subject ON sessions (subject, id);

-- The columns as they were when the session was recorded, so that it stays readable when the table of signals changes.
CREATE TABLE column_layout (
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  position INTEGER NOT NULL,
  name TEXT NOT NULL,
  unit TEXT NOT NULL,
  type TEXT NOT NULL,
  lsb REAL NOT NULL,
  decimals INTEGER NOT NULL CHECK (decimals BETWEEN 0 AND 15),  -- lsb = 10^-decimals
  PRIMARY KEY (session_id, position)
) STRICT, WITHOUT ROWID;

-- Runs of samples. The directory comes before the body, so that an overview reads the row without the body's pages.
CREATE TABLE chunks (
  id INTEGER PRIMARY KEY,
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  first_tick INTEGER NOT NULL,
  last_tick INTEGER NOT NULL,
  first_time_ns INTEGER NOT NULL,
  last_time_ns INTEGER NOT NULL,
  samples INTEGER NOT NULL,
  directory BLOB NOT NULL,
  body BLOB NOT NULL,
  UNIQUE (session_id, first_tick)
) STRICT;

-- Raw CAN frames, numbered through the session.
CREATE TABLE bus_chunks (
  id INTEGER PRIMARY KEY,
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  first_frame INTEGER NOT NULL,
  frames INTEGER NOT NULL,
  first_time_ns INTEGER NOT NULL,
  last_time_ns INTEGER NOT NULL,
  body BLOB NOT NULL,
  UNIQUE (session_id, first_frame)
) STRICT;

CREATE TABLE gaps (
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  number INTEGER NOT NULL,
  stream TEXT NOT NULL CHECK (stream IN ('ticks', 'events', 'bus')),
  from_tick INTEGER NOT NULL,
  to_tick INTEGER NOT NULL CHECK (to_tick >= from_tick),
  reason TEXT NOT NULL,
  PRIMARY KEY (session_id, number)
) STRICT, WITHOUT ROWID;

CREATE TABLE events (
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  number INTEGER NOT NULL,
  tick INTEGER NOT NULL,
  time_ns INTEGER NOT NULL,
  kind INTEGER NOT NULL,
  kind_name TEXT NOT NULL,
  code INTEGER NOT NULL,
  bits INTEGER NOT NULL,
  item INTEGER NOT NULL,
  value REAL,                                -- NULL when it was not a number
  before REAL,
  request_id INTEGER NOT NULL,
  client INTEGER NOT NULL,
  name TEXT NOT NULL,                        -- what code or item meant on that day
  PRIMARY KEY (session_id, number)
) STRICT, WITHOUT ROWID;

CREATE TABLE markers (
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  number INTEGER NOT NULL,
  tick INTEGER NOT NULL,
  utc_ns INTEGER NOT NULL,
  text TEXT NOT NULL,
  PRIMARY KEY (session_id, number)
) STRICT, WITHOUT ROWID;

-- Jumps of the wall clock after the start.
CREATE TABLE utc_anchors (
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  time_ns INTEGER NOT NULL,
  utc_ns INTEGER NOT NULL,
  PRIMARY KEY (session_id, time_ns)
) STRICT, WITHOUT ROWID;

-- In force when the session began; later changes are events.
CREATE TABLE parameters (
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  position INTEGER NOT NULL,
  name TEXT NOT NULL,
  value REAL NOT NULL,
  PRIMARY KEY (session_id, position)
) STRICT, WITHOUT ROWID;
