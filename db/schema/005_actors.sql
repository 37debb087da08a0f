-- Who asked for what an event or a marker tells. Earlier events have no actor: the number of a connection, drawn anew each time, named none.
CREATE TABLE actors (
  id INTEGER PRIMARY KEY,
  user TEXT NOT NULL,                        -- the account
  role TEXT NOT NULL,                        -- viewer, therapist, engineer
  origin TEXT NOT NULL,                      -- the protocol: rest, hoist.v1
  client TEXT NOT NULL,                      -- the sign-in, the same over connections and restarts: "script", or "device-" and eight digits
  UNIQUE (user, role, origin, client)
) STRICT;
ALTER TABLE events DROP COLUMN client;
ALTER TABLE events ADD COLUMN actor_id INTEGER REFERENCES actors (id);  -- NULL = not known, or the core's own doing
ALTER TABLE markers ADD COLUMN actor_id INTEGER REFERENCES actors (id);
