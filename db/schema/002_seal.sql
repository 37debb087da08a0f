-- What tells this file from another under the same name, and how many commits of recordings it has seen (db/store/seal.hpp).
CREATE TABLE seal (
  file_id TEXT NOT NULL,
  commits INTEGER NOT NULL
) STRICT;
INSERT INTO seal (file_id, commits) VALUES (lower(hex(randomblob(8))), 0);
