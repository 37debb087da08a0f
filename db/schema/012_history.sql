-- What belongs to which session by the core's clock, and the alarms of all sessions, without reading every row.
CREATE INDEX sessions_by_core ON sessions (core_start_time_ns, start_time_ns);
CREATE INDEX events_of_alarms ON events (session_id, number) WHERE kind = 4;  -- EventKind::fault_raised
