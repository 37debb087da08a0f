-- Lines on the floor that people have drawn. A session keeps the line that it walked itself (sessions.exercise): none names a row here.
CREATE TABLE lines (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL UNIQUE,
  version INTEGER NOT NULL,                  -- counts the savings
  saved_utc_ns INTEGER NOT NULL,
  exercise TEXT NOT NULL                     -- JSON of the shape own, as in sessions.exercise
) STRICT;
