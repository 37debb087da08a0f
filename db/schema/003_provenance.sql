-- Where a recording comes from. NULL = not known: recorded before these columns were, or a core that does not tell.
ALTER TABLE sessions ADD COLUMN core_version TEXT;  -- of hoist-control; software_version is the recording program's

-- What each node had said of its program on the bus when the session began, as numbers of its objects. NULL = not read.
CREATE TABLE node_programs (
  session_id INTEGER NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  position INTEGER NOT NULL,
  name TEXT NOT NULL,
  product INTEGER,                           -- 1018h:2
  revision INTEGER,                          -- 1018h:3
  version INTEGER,                           -- 2F00h:1, major << 16 | minor << 8 | patch
  crc INTEGER,                               -- 1F56h:1
  PRIMARY KEY (session_id, position)
) STRICT, WITHOUT ROWID;
