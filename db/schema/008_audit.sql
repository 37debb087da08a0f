-- What people asked of the hoist, also while nothing is recorded. Rows are only added. This guards against mistakes, not against a person who
-- may write the file.
CREATE TABLE audit (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  utc_ns INTEGER NOT NULL,                   -- when it was asked
  actor_id INTEGER REFERENCES actors (id),   -- NULL = not known
  action TEXT NOT NULL,                      -- sign_in, take_lease, start, delete_session ... (server/README.md)
  result TEXT NOT NULL,                      -- done, or why not
  session_id INTEGER,                        -- no reference: the row outlives its session
  detail TEXT NOT NULL                       -- JSON; never a patient code
) STRICT;
CREATE TRIGGER audit_keeps_rows BEFORE DELETE ON audit BEGIN SELECT RAISE(ABORT, 'the audit is append-only'); END;
CREATE TRIGGER audit_keeps_values BEFORE UPDATE ON audit BEGIN SELECT RAISE(ABORT, 'the audit is append-only'); END;
-- INSERT OR REPLACE deletes without firing a trigger of DELETE.
CREATE TRIGGER audit_only_adds BEFORE INSERT ON audit WHEN NEW.id IN (SELECT id FROM audit)
  BEGIN SELECT RAISE(ABORT, 'the audit is append-only'); END;
-- An actor's words are part of each row that names it.
CREATE TRIGGER actors_keep_rows BEFORE DELETE ON actors BEGIN SELECT RAISE(ABORT, 'actors stay as they are'); END;
CREATE TRIGGER actors_keep_values BEFORE UPDATE ON actors BEGIN SELECT RAISE(ABORT, 'actors stay as they are'); END;
CREATE TRIGGER actors_only_add BEFORE INSERT ON actors WHEN NEW.id IN (SELECT id FROM actors)
  OR EXISTS (SELECT 1 FROM actors WHERE user = NEW.user AND role = NEW.role AND origin = NEW.origin AND client = NEW.client)
  BEGIN SELECT RAISE(ABORT, 'actors stay as they are'); END;
