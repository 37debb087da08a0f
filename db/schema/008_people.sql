-- Patients whom people manage, their sealed identities, their settings; what people may write about visits.
ALTER TABLE patients ADD COLUMN registered INTEGER NOT NULL DEFAULT 0 CHECK (registered IN (0, 1));  -- 1 = stays without a session
ALTER TABLE patients ADD COLUMN archived INTEGER NOT NULL DEFAULT 0 CHECK (archived IN (0, 1));
ALTER TABLE visits ADD COLUMN visit_note TEXT NOT NULL DEFAULT '';

-- The only place of names: sealed with XChaCha20-Poly1305 under the key of FILE.key (db/store/patient_identity.hpp).
CREATE TABLE patient_identities (
  patient_id INTEGER PRIMARY KEY REFERENCES patients (id) ON DELETE CASCADE,
  key_id BLOB NOT NULL,                      -- 8 bytes that tell one key from another
  sealed BLOB NOT NULL                       -- nonce and ciphertext
) STRICT;

-- A patient's settings under a name. Each saving adds a version; none is changed.
CREATE TABLE profiles (
  id INTEGER PRIMARY KEY AUTOINCREMENT,
  patient_id INTEGER NOT NULL REFERENCES patients (id) ON DELETE CASCADE,
  name TEXT NOT NULL,
  UNIQUE (patient_id, name)
) STRICT;
CREATE TABLE profile_versions (
  profile_id INTEGER NOT NULL REFERENCES profiles (id) ON DELETE CASCADE,
  version INTEGER NOT NULL,
  utc_ns INTEGER NOT NULL,
  actor_id INTEGER REFERENCES actors (id),
  settings TEXT NOT NULL,                    -- JSON: parameter names and values
  PRIMARY KEY (profile_id, version)
) STRICT, WITHOUT ROWID;
