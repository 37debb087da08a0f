-- People, what they are signed in with, and what they did. A file of its own beside the recordings: recordings that are set aside lock nobody out.
-- Files in this folder are only ever added: user_version counts them. Times are seconds since 1970-01-01 UTC unless the name says otherwise.

CREATE TABLE users (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  name TEXT NOT NULL UNIQUE,                 -- for signing in: a-z, 0-9, . _ -
  display_name TEXT NOT NULL,                -- as screens show it
  role TEXT NOT NULL CHECK (role IN ('viewer', 'therapist', 'engineer')),
  enabled INTEGER NOT NULL DEFAULT 1 CHECK (enabled IN (0, 1)),
  password_hash TEXT NOT NULL,               -- Argon2id with its salt and limits, as libsodium writes it
  pin_hash TEXT,                             -- the same of the PIN; NULL = none
  created_s INTEGER NOT NULL
) STRICT;

-- Of a secret (a browser's cookie, a script's token) only its SHA-256 is stored.
CREATE TABLE sign_ins (
  secret_sha256 TEXT PRIMARY KEY,
  user_id INTEGER NOT NULL REFERENCES users (id),
  device TEXT NOT NULL,                      -- stays with a browser over sign-ins: who has signed in on it before may use a PIN
  begun_s INTEGER NOT NULL,
  used_s INTEGER NOT NULL,
  ended INTEGER NOT NULL DEFAULT 0 CHECK (ended IN (0, 1))  -- an ended one may still say STOP
) STRICT, WITHOUT ROWID;
CREATE INDEX sign_ins_by_device ON sign_ins (device);

CREATE TABLE tokens (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  secret_sha256 TEXT NOT NULL UNIQUE,
  user_id INTEGER NOT NULL REFERENCES users (id),
  name TEXT NOT NULL,                        -- what it is for
  scope TEXT NOT NULL CHECK (scope IN ('viewer', 'therapist', 'engineer')),
  created_s INTEGER NOT NULL,
  expires_s INTEGER NOT NULL
) STRICT;

-- Who did what. Rows are only added; each holds the digest of the one before, so that a change or a missing row is found.
CREATE TABLE audit (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  utc_ms INTEGER NOT NULL,
  steady_ns INTEGER NOT NULL,                -- of the computer's clock since its start, which nobody sets
  user TEXT NOT NULL,
  role TEXT NOT NULL,
  address TEXT NOT NULL,                     -- of the client
  action TEXT NOT NULL,                      -- name of the route or message
  target TEXT NOT NULL,                      -- what it was about
  before TEXT,
  after TEXT,
  result TEXT NOT NULL,                      -- done, or the reason of the refusal
  previous TEXT NOT NULL,                    -- digest of the row before; 64 zeros in the first one
  digest TEXT NOT NULL
) STRICT;
CREATE TRIGGER audit_keeps_rows BEFORE UPDATE ON audit BEGIN SELECT raise(ABORT, 'the audit log is only added to'); END;
CREATE TRIGGER audit_replaces_none BEFORE INSERT ON audit WHEN EXISTS (SELECT 1 FROM audit WHERE id = NEW.id)
BEGIN SELECT raise(ABORT, 'the audit log is only added to'); END;
CREATE TRIGGER audit_loses_none BEFORE DELETE ON audit BEGIN SELECT raise(ABORT, 'the audit log is only added to'); END;
