-- Every change of a parameter in force, also outside sessions. For parameters that were never changed there is no row.
CREATE TABLE parameter_changes (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  utc_ns INTEGER NOT NULL,
  core_start_time_ns INTEGER NOT NULL,       -- which life of the core …
  time_ns INTEGER NOT NULL,                  -- … and its steady time
  parameter INTEGER NOT NULL,                -- id in params.def
  name TEXT NOT NULL,                        -- as it was then
  value REAL NOT NULL,
  before REAL NOT NULL,
  reason TEXT NOT NULL,                      -- db/store/parameter_log.hpp
  source TEXT,                               -- name of the preset or profile
  actor_id INTEGER REFERENCES actors (id)    -- NULL = the core by itself, or not known
) STRICT;
CREATE INDEX parameter_changes_by_parameter ON parameter_changes (parameter, id);
CREATE INDEX parameter_changes_by_time ON parameter_changes (utc_ns, id);

-- Settings of the server that people change in the console.
CREATE TABLE settings (
  name TEXT PRIMARY KEY,
  value TEXT NOT NULL
) STRICT, WITHOUT ROWID;
