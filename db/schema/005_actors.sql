-- Who asked for what an event or marker tells. NULL = not known, or the core's own doing. events.client, a number drawn anew for each
-- connection, is 0 from here on.
ALTER TABLE events ADD COLUMN user TEXT;   -- "script" or "device-" and eight digits: the sign-in, the same over connections and restarts
ALTER TABLE events ADD COLUMN role TEXT;   -- viewer, therapist, engineer
ALTER TABLE events ADD COLUMN origin TEXT; -- the protocol: rest, hoist.v1
ALTER TABLE markers ADD COLUMN user TEXT;
ALTER TABLE markers ADD COLUMN role TEXT;
ALTER TABLE markers ADD COLUMN origin TEXT;
