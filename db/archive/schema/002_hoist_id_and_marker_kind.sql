-- The hoist that recorded the session, as in its own file; NULL = recorded before hoists had an id. `device` is only a name.
ALTER TABLE sessions ADD COLUMN hoist_id text;
-- As in a hoist's own file; NULL = a plain note.
ALTER TABLE markers ADD COLUMN kind text;
