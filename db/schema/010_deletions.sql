-- Sessions that are deleted already (no row in `sessions`), whose samples, frames and journal are still to be overwritten, piece by piece.
CREATE TABLE deletions (
  session_id INTEGER PRIMARY KEY
) STRICT;
