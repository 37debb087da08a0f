-- Each layout of columns once, under the hash of its text: a session names its own, and most sessions share one.
ALTER TABLE column_layout RENAME TO column_layout_of_session;
CREATE TABLE column_layout (
  hash INTEGER NOT NULL,                     -- hash_text() of the lines "name, unit, type, decimals" (db/store/column_layouts.hpp)
  position INTEGER NOT NULL,
  name TEXT NOT NULL,
  unit TEXT NOT NULL,
  type TEXT NOT NULL,
  lsb REAL NOT NULL,
  decimals INTEGER NOT NULL CHECK (decimals BETWEEN 0 AND 15),  -- lsb = 10^-decimals
  PRIMARY KEY (hash, position)
) STRICT, WITHOUT ROWID;
ALTER TABLE sessions ADD COLUMN columns_hash INTEGER;  -- column_layout.hash; NULL = the session has no columns
UPDATE sessions SET columns_hash = (
  SELECT hash_text(group_concat(line, char(10))) FROM (
    SELECT name || char(9) || unit || char(9) || type || char(9) || decimals AS line
    FROM column_layout_of_session WHERE session_id = sessions.id ORDER BY position))
WHERE EXISTS (SELECT 1 FROM column_layout_of_session WHERE session_id = sessions.id);
INSERT OR IGNORE INTO column_layout (hash, position, name, unit, type, lsb, decimals)
  SELECT columns_hash, position, name, unit, type, lsb, decimals
  FROM sessions JOIN column_layout_of_session ON session_id = sessions.id ORDER BY sessions.id;
DROP TABLE column_layout_of_session;
