-- The archive of several hoists. Tables and columns are named as in the file of one hoist (db/schema); samples stay the same blobs.
-- Files in this folder are only ever added; archive_schema counts them.
CREATE TABLE patients (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  code text NOT NULL UNIQUE                  -- pseudonymous; the same code on two hoists is the same patient
);
CREATE TABLE visits (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  patient_id bigint NOT NULL REFERENCES patients (id),
  day date NOT NULL,                         -- where the recording computer stood
  UNIQUE (patient_id, day)
);
CREATE TABLE sessions (
  id bigint GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  uuid uuid NOT NULL UNIQUE,                 -- made from the recording's clocks: the same in every copy
  content_sha256 text NOT NULL UNIQUE,       -- over everything that was recorded
  description_sha256 text NOT NULL,          -- over what people may change: note, exercise, patient, markers
  device text NOT NULL,                      -- which hoist
  visit_id bigint REFERENCES visits (id),    -- NULL = recorded without a patient code
  archived timestamptz NOT NULL DEFAULT now(),
  described timestamptz NOT NULL DEFAULT now(),
  started_utc_ns bigint NOT NULL,
  start_time_ns bigint NOT NULL,
  core_start_time_ns bigint NOT NULL,
  simulated bigint NOT NULL,
  layout_hash bigint NOT NULL,
  software_version text NOT NULL,
  core_version text,
  ended_utc_ns bigint NOT NULL,
  close_reason text NOT NULL,
  sample_count bigint,
  first_time_ns bigint,
  last_time_ns bigint,
  columns_hash bigint,
  note text NOT NULL,
  exercise text
);
CREATE INDEX sessions_by_visit ON sessions (visit_id);
-- Sessions that were taken out on purpose: a hoist that still has one does not bring it back.
CREATE TABLE erased_sessions (
  uuid uuid PRIMARY KEY,
  erased timestamptz NOT NULL DEFAULT now()
);
CREATE TABLE column_layout (
  hash bigint NOT NULL,
  position bigint NOT NULL,
  name text NOT NULL,
  unit text NOT NULL,
  type text NOT NULL,
  lsb double precision NOT NULL,
  decimals bigint NOT NULL,
  PRIMARY KEY (hash, position)
);
CREATE TABLE chunks (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  first_tick bigint NOT NULL,
  last_tick bigint NOT NULL,
  first_time_ns bigint NOT NULL,
  last_time_ns bigint NOT NULL,
  samples bigint NOT NULL,
  directory bytea NOT NULL,
  body bytea NOT NULL,
  PRIMARY KEY (session_id, first_tick)
);
CREATE TABLE bus_chunks (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  first_frame bigint NOT NULL,
  frames bigint NOT NULL,
  first_time_ns bigint NOT NULL,
  last_time_ns bigint NOT NULL,
  body bytea NOT NULL,
  PRIMARY KEY (session_id, first_frame)
);
CREATE TABLE journal_chunks (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  first_step bigint NOT NULL,
  steps bigint NOT NULL,
  body bytea NOT NULL,
  PRIMARY KEY (session_id, first_step)
);
CREATE TABLE core_images (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  step bigint NOT NULL,
  tick bigint NOT NULL,
  bytes bigint NOT NULL,
  body bytea NOT NULL,
  PRIMARY KEY (session_id, step)
);
CREATE TABLE gaps (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  number bigint NOT NULL,
  stream text NOT NULL,
  from_tick bigint NOT NULL,
  to_tick bigint NOT NULL,
  reason text NOT NULL,
  PRIMARY KEY (session_id, number)
);
CREATE TABLE events (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  number bigint NOT NULL,
  tick bigint NOT NULL,
  time_ns bigint NOT NULL,
  kind bigint NOT NULL,
  kind_name text NOT NULL,
  code bigint NOT NULL,
  bits bigint NOT NULL,
  item bigint NOT NULL,
  value double precision,
  before double precision,
  name text NOT NULL,
  request_id bigint NOT NULL,
  actor_user text,
  actor_role text,
  actor_origin text,
  actor_client text,
  PRIMARY KEY (session_id, number)
);
CREATE TABLE markers (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  number bigint NOT NULL,
  tick bigint NOT NULL,
  utc_ns bigint NOT NULL,
  text text NOT NULL,
  actor_user text,
  actor_role text,
  actor_origin text,
  actor_client text,
  PRIMARY KEY (session_id, number)
);
CREATE TABLE utc_anchors (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  time_ns bigint NOT NULL,
  utc_ns bigint NOT NULL,
  PRIMARY KEY (session_id, time_ns)
);
CREATE TABLE parameters (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  position bigint NOT NULL,
  name text NOT NULL,
  value double precision NOT NULL,
  PRIMARY KEY (session_id, position)
);
CREATE TABLE node_programs (
  session_id bigint NOT NULL REFERENCES sessions (id) ON DELETE CASCADE,
  position bigint NOT NULL,
  name text NOT NULL,
  product bigint,
  revision bigint,
  version bigint,
  crc bigint,
  PRIMARY KEY (session_id, position)
);

-- Rights by role: a hoist adds and describes, a researcher reads, only the archive's owner erases.
DO $$
BEGIN
  IF NOT EXISTS (SELECT 1 FROM pg_roles WHERE rolname = 'hoist_archive_push') THEN CREATE ROLE hoist_archive_push NOLOGIN; END IF;
  IF NOT EXISTS (SELECT 1 FROM pg_roles WHERE rolname = 'hoist_archive_read') THEN CREATE ROLE hoist_archive_read NOLOGIN; END IF;
END
$$;
GRANT USAGE ON SCHEMA hoist TO hoist_archive_push, hoist_archive_read;
GRANT SELECT ON ALL TABLES IN SCHEMA hoist TO hoist_archive_read;
GRANT SELECT ON archive_schema, patients, visits, sessions, erased_sessions, column_layout TO hoist_archive_push;
GRANT INSERT ON patients, visits, sessions, column_layout, chunks, bus_chunks, journal_chunks, core_images, gaps, events, markers, utc_anchors,
  parameters, node_programs TO hoist_archive_push;
GRANT UPDATE (visit_id, note, exercise, description_sha256, described) ON sessions TO hoist_archive_push;
-- Markers are replaced as a whole when one was edited.
GRANT SELECT, DELETE ON markers TO hoist_archive_push;
