-- Which hoist this file belongs to: one row, written when the file is first opened for recording (db/store/hoist_id.hpp). A backup has none.
CREATE TABLE hoist (
  id TEXT NOT NULL                           -- UUID
) STRICT;
-- The hoist that recorded the session; NULL = recorded before hoists had an id.
ALTER TABLE sessions ADD COLUMN hoist_id TEXT;

-- What kind of moment a marker marks (kMarkerKinds in db/store/session_types.hpp); NULL = a plain note.
ALTER TABLE markers ADD COLUMN kind TEXT;
