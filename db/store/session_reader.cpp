#include "db/store/session_reader.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "control/contract/faults.hpp"
#include "db/codec/bus_chunk.hpp"
#include "db/codec/journal_chunk.hpp"
#include "db/store/actor_rows.hpp"
#include "db/store/chunk_source.hpp"
#include "db/store/column_layouts.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// Below a quarter of the asked resolution the stored blocks are too coarse and samples are read instead: never more than 1000 blocks' worth.
constexpr std::size_t kCoarse = 4;
constexpr double kNanoseconds = 1e-9;
constexpr const char* kSessionColumns =
    "SELECT sessions.id, code, started_utc_ns, start_time_ns, core_start_time_ns, simulated, ended_utc_ns, close_reason, layout_hash, "
    "software_version, "
    "note, exercise, coalesce(sample_count, (SELECT sum(samples) FROM chunks WHERE session_id = sessions.id), 0), "
    "coalesce(first_time_ns, (SELECT min(first_time_ns) FROM chunks WHERE session_id = sessions.id), 0), "
    "coalesce(last_time_ns, (SELECT max(last_time_ns) FROM chunks WHERE session_id = sessions.id), 0), "
    "(SELECT count(*) FROM gaps WHERE session_id = sessions.id), "
    // The length of a blob stands in its row's head: no chunk is read for this.
    "(SELECT coalesce(sum(length(directory) + length(body)), 0) FROM chunks WHERE session_id = sessions.id) + "
    "(SELECT coalesce(sum(length(body)), 0) FROM bus_chunks WHERE session_id = sessions.id) + "
    "(SELECT coalesce(sum(length(body)), 0) FROM journal_chunks WHERE session_id = sessions.id) + "
    "(SELECT coalesce(sum(length(body)), 0) FROM core_images WHERE session_id = sessions.id), core_version, standby, hoist_id, "
    "study_id, study_runs.subject, study_runs.run FROM ";
// With the patient code; NULL for a session that belongs to no visit. With the run of a study; NULL for all but those of virtual subjects.
constexpr const char* kSessions =
    "sessions LEFT JOIN visits ON visits.id = visit_id LEFT JOIN patients ON patients.id = patient_id "
    "LEFT JOIN study_runs ON study_runs.session_id = sessions.id ";

SessionInfo info_of(const Statement& row) {
  SessionInfo info;
  info.id = row.integer_at(0);
  info.subject = row.optional_text_at(1);
  info.started_utc_ns = row.integer_at(2);
  info.start_time_ns = row.unsigned_at(3);
  info.core_start_time_ns = row.unsigned_at(4);
  info.simulated = row.integer_at(5) != 0;
  if (!row.is_null(6)) info.ended_utc_ns = row.integer_at(6);
  info.recording = row.is_null(6);
  info.close_reason = row.text_at(7);
  info.layout_hash = row.unsigned_at(8);
  info.software_version = row.text_at(9);
  info.note = row.text_at(10);
  info.exercise_json = row.optional_text_at(11);
  info.sample_count = row.unsigned_at(12);
  info.duration_s = static_cast<double>(row.integer_at(14) - row.integer_at(13)) * kNanoseconds;
  info.gap_count = row.unsigned_at(15);
  info.stored_bytes = row.unsigned_at(16);
  info.core_version = row.optional_text_at(17);
  info.standby = row.integer_at(18) != 0;
  info.hoist_id = row.optional_text_at(19);
  if (!row.is_null(20))
    info.study = StudyRun{.study = row.integer_at(20), .subject = row.text_at(21), .run = static_cast<int>(row.integer_at(22))};
  info.tag = session_tag(info.note, info.subject, info.exercise_json);
  return info;
}

Error no_such_session(SessionId session) { return {ErrorKind::not_found, "there is no session " + std::to_string(session), {}}; }

struct Selection {
  std::uint64_t start_time_ns = 0;
  std::size_t column_count = 0;
  std::vector<ColumnInfo> info;                    // of the asked columns
  std::vector<std::size_t> which;                  // tick, time_ns, then the asked ones
  std::uint64_t from_time_ns = 0, to_time_ns = 0;  // half open
};

// Seconds since the start as steady time, held to what the clock can say.
std::uint64_t steady_ns(std::uint64_t start_time_ns, double seconds) {
  const double ns = std::nearbyint(seconds / kNanoseconds);
  if (ns <= -static_cast<double>(start_time_ns)) return 0;
  if (ns >= 4e18) return static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max());
  return static_cast<std::uint64_t>(static_cast<std::int64_t>(start_time_ns) + static_cast<std::int64_t>(ns));
}

Selection select(sqlite3* handle, SessionId session, std::span<const std::string> names, const TimeRange& range) {
  Selection selection;
  Statement statement(handle, "SELECT start_time_ns FROM sessions WHERE id = ?1");
  if (!statement.integer(1, session).step()) throw SqlFailure{no_such_session(session)};
  selection.start_time_ns = statement.unsigned_at(0);
  if (std::isnan(range.from_s) || std::isnan(range.to_s) || range.from_s > range.to_s)
    throw SqlFailure{Error{ErrorKind::bad_value, "the range must run from an earlier to a later time", "range"}};
  selection.from_time_ns = steady_ns(selection.start_time_ns, range.from_s);
  selection.to_time_ns = steady_ns(selection.start_time_ns, range.to_s);
  const std::vector<ColumnInfo> layout = layout_of(handle, session);
  selection.column_count = layout.size();
  const auto tick = find_column(layout, "tick"), time = find_column(layout, "time_ns");
  if (!tick || !time)
    throw SqlFailure{Error{ErrorKind::corrupt, "session " + std::to_string(session) + " has no tick and time columns", {}}};
  selection.which = {*tick, *time};
  for (const std::string& name : names) {
    const auto found = find_column(layout, name);
    if (!found) throw SqlFailure{Error{ErrorKind::bad_value, "this session has no column " + name, "columns"}};
    selection.which.push_back(*found);
    selection.info.push_back(layout[*found]);
  }
  return selection;
}

double seconds_since(std::uint64_t start_time_ns, std::int64_t time_ns) {
  // Whole and broken seconds apart, so that hours after the start the microseconds are still exact.
  return static_cast<double>(time_ns - static_cast<std::int64_t>(start_time_ns)) / 1e9;
}

// Calls `use(chunk)` for the chunks that overlap the range, in order, until it returns false.
template <typename Use>
void for_chunks(ChunkSource& source, const Selection& selection, Use use) {
  const auto first = source.first_tick_from_time(selection.from_time_ns);
  if (!first) return;
  for (std::uint64_t next_tick = *first;;) {
    auto chunk = source.at_or_after(next_tick);
    if (!chunk || chunk->first_time_ns >= selection.to_time_ns) return;
    next_tick = chunk->last_tick + 1;
    if (!use(*chunk)) return;
  }
}

// Collects minima and maxima; a run is closed when it holds enough parts (blocks or samples).
class RunBuilder {
 public:
  RunBuilder(Overview& out, const Selection& selection, std::size_t parts_per_run)
      : out_(out), selection_(selection), parts_per_run_(parts_per_run) {}

  // `inner_gap`: the part itself misses samples.
  template <typename RangeOf>
  void add(std::uint64_t first_tick, std::uint64_t last_tick, std::int64_t from_ns, std::int64_t to_ns, bool inner_gap, RangeOf range_of) {
    const bool gap = inner_gap || (started_ && first_tick != next_tick_);
    started_ = true;
    next_tick_ = last_tick + 1;
    const bool fresh = parts_ == 0;
    if (fresh) {
      out_.from_s.push_back(seconds_since(selection_.start_time_ns, from_ns));
      out_.to_s.push_back(0);
      out_.gap_before.push_back(0);
    }
    out_.to_s.back() = seconds_since(selection_.start_time_ns, to_ns);
    if (gap) out_.gap_before.back() = 1;
    for (std::size_t i = 0; i < selection_.info.size(); ++i) {
      const MinMax range = range_of(i);
      const double scale = decimal_scale(selection_.info[i].decimals);
      const double low = static_cast<double>(range.min) / scale, high = static_cast<double>(range.max) / scale;
      if (fresh) {
        out_.min[i].push_back(low);
        out_.max[i].push_back(high);
      } else {
        out_.min[i].back() = std::min(out_.min[i].back(), low);
        out_.max[i].back() = std::max(out_.max[i].back(), high);
      }
    }
    if (++parts_ == parts_per_run_) parts_ = 0;
  }

 private:
  Overview& out_;
  const Selection& selection_;
  std::size_t parts_per_run_, parts_ = 0;
  std::uint64_t next_tick_ = 0;
  bool started_ = false;
};

}  // namespace

Result<SessionPage> SessionReader::list(const SessionQuery& query) const {
  if (query.limit == 0 || query.limit > kMaxPage)
    return Error{ErrorKind::bad_value, "limit must be 1 to " + std::to_string(kMaxPage), "limit"};
  return guarded([&]() -> Result<SessionPage> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    SessionPage page;
    const std::string fits = std::string(query.standby ? "1 " : "standby = 0 ") + (query.subject ? "AND code_has(code, ?3) " : "") +
                             (query.patient ? "AND patient_id = ?4 " : "");
    const auto bind = [&query](Statement& statement) {
      if (query.subject) statement.text(3, query.subject);
      if (query.patient) statement.integer(4, *query.patient);
    };
    {
      Statement count(handle, std::string("SELECT count(*) FROM ") + kSessions + "WHERE " + fits);
      bind(count);
      if (count.step()) page.total = count.unsigned_at(0);
    }
    Statement rows(handle,
                   std::string(kSessionColumns) + kSessions + "WHERE sessions.id < ?1 AND " + fits + "ORDER BY sessions.id DESC LIMIT ?2");
    rows.integer(1, query.before.value_or(std::numeric_limits<std::int64_t>::max()));
    // One more than asked tells whether a next page exists.
    rows.unsigned_integer(2, query.limit + 1);
    bind(rows);
    while (rows.step()) {
      if (page.sessions.size() == query.limit) {
        page.next = page.sessions.back().id;
        break;
      }
      page.sessions.push_back(info_of(rows));
    }
    return page;
  });
}

Result<SessionInfo> SessionReader::get(SessionId session) const {
  return guarded([&]() -> Result<SessionInfo> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    Statement row(handle, std::string(kSessionColumns) + kSessions + "WHERE sessions.id = ?1");
    if (!row.integer(1, session).step()) return no_such_session(session);
    return info_of(row);
  });
}

Result<bool> SessionReader::has(SessionId session) const {
  return guarded(
      [&]() -> Result<bool> { return Statement(database_->handle(), "SELECT 1 FROM sessions WHERE id = ?1").integer(1, session).step(); });
}

Result<std::vector<ColumnInfo>> SessionReader::columns(SessionId session) const {
  return guarded([&]() -> Result<std::vector<ColumnInfo>> {
    std::vector<ColumnInfo> layout = layout_of(database_->handle(), session);
    if (layout.empty()) return no_such_session(session);
    return layout;
  });
}

Result<Columns> SessionReader::read_columns(SessionId session, std::span<const std::string> names, const TimeRange& range) const {
  return guarded([&]() -> Result<Columns> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    const Selection selection = select(handle, session, names, range);
    Columns out;
    out.info = selection.info;
    out.values.resize(selection.info.size());
    ChunkSource source(handle, session, selection.column_count);
    std::vector<std::vector<std::int64_t>> values;
    std::optional<std::uint64_t> next_tick;
    bool too_many = false;
    for_chunks(source, selection, [&](const StoredChunk& chunk) {
      source.load(chunk, selection.which, values);
      const std::vector<std::int64_t>&ticks = values[0], &times = values[1];
      const auto from =
          static_cast<std::size_t>(std::ranges::lower_bound(times, static_cast<std::int64_t>(selection.from_time_ns)) - times.begin());
      const auto to =
          static_cast<std::size_t>(std::ranges::lower_bound(times, static_cast<std::int64_t>(selection.to_time_ns)) - times.begin());
      if (to <= from) return true;
      if (out.tick.size() + (to - from) > kMaxReadSamples) {
        too_many = true;
        return false;
      }
      for (std::size_t i = from; i < to; ++i) {
        const auto tick = static_cast<std::uint64_t>(ticks[i]);
        out.tick.push_back(tick);
        out.time_s.push_back(seconds_since(selection.start_time_ns, times[i]));
        const bool gap = next_tick ? tick != *next_tick : gap_ends_before(handle, session, tick);
        out.gap_before.push_back(gap ? 1 : 0);
        next_tick = tick + 1;
      }
      for (std::size_t c = 0; c < selection.info.size(); ++c) {
        const double scale = decimal_scale(selection.info[c].decimals);
        const std::size_t before = out.values[c].size();
        out.values[c].resize(before + (to - from));
        for (std::size_t i = from; i < to; ++i) out.values[c][before + i - from] = static_cast<double>(values[c + 2][i]) / scale;
      }
      return true;
    });
    if (too_many)
      return Error{ErrorKind::bad_value,
                   "the range holds more than " + std::to_string(kMaxReadSamples) + " samples: ask for less, or for the overview", "range"};
    return out;
  });
}

Result<Overview> SessionReader::overview(SessionId session, std::span<const std::string> names, std::size_t runs,
                                         const TimeRange& range) const {
  if (runs == 0 || runs > kMaxOverviewRuns)
    return Error{ErrorKind::bad_value, "runs must be 1 to " + std::to_string(kMaxOverviewRuns), "runs"};
  return guarded([&]() -> Result<Overview> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    const Selection selection = select(handle, session, names, range);
    ChunkSource source(handle, session, selection.column_count);
    std::vector<StoredChunk> chunks;
    std::size_t blocks = 0, samples = 0;
    const auto from = static_cast<std::int64_t>(selection.from_time_ns), to = static_cast<std::int64_t>(selection.to_time_ns);
    const auto block_inside = [&](const MinMax& time) { return time.max >= from && time.min < to; };
    for_chunks(source, selection, [&](StoredChunk& chunk) {
      for (std::size_t b = 0; b < chunk.directory.block_count(); ++b) {
        if (!block_inside(chunk.directory.block(selection.which[1], b))) continue;
        ++blocks;
        samples += chunk.directory.block_samples(b);
      }
      chunks.push_back(std::move(chunk));
      return true;
    });
    Overview out;
    out.info = selection.info;
    out.min.resize(selection.info.size());
    out.max.resize(selection.info.size());
    if (blocks * kCoarse >= runs && blocks > 0) {
      RunBuilder builder(out, selection, (blocks + runs - 1) / runs);
      for (const StoredChunk& chunk : chunks) {
        for (std::size_t b = 0; b < chunk.directory.block_count(); ++b) {
          const MinMax tick = chunk.directory.block(selection.which[0], b), time = chunk.directory.block(selection.which[1], b);
          if (!block_inside(time)) continue;
          const bool inner_gap = static_cast<std::size_t>(tick.max - tick.min) + 1 != chunk.directory.block_samples(b);
          builder.add(static_cast<std::uint64_t>(tick.min), static_cast<std::uint64_t>(tick.max), time.min, time.max, inner_gap,
                      [&](std::size_t i) { return chunk.directory.block(selection.which[i + 2], b); });
        }
      }
      return out;
    }
    out.exact_range = true;
    RunBuilder builder(out, selection, std::max<std::size_t>(1, (samples + runs - 1) / runs));
    std::vector<std::vector<std::int64_t>> values;
    for (const StoredChunk& chunk : chunks) {
      source.load(chunk, selection.which, values);
      for (std::size_t i = 0; i < values[1].size(); ++i) {
        if (values[1][i] < from || values[1][i] >= to) continue;
        const auto tick = static_cast<std::uint64_t>(values[0][i]);
        builder.add(tick, tick, values[1][i], values[1][i], false, [&](std::size_t c) {
          return MinMax{values[c + 2][i], values[c + 2][i]};
        });
      }
    }
    return out;
  });
}

Result<std::vector<StoredEvent>> SessionReader::events(SessionId session, const RowPart& part) const {
  return guarded([&]() -> Result<std::vector<StoredEvent>> {
    std::vector<StoredEvent> out;
    Statement row(
        database_->handle(),
        "SELECT tick, time_ns, kind, code, bits, item, request_id, value, before, kind_name, name, user, role, origin, client, "
        "number FROM events LEFT JOIN actors ON actors.id = actor_id WHERE session_id = ?1 AND number > ?2 ORDER BY number LIMIT ?3");
    row.integer(1, session).integer(2, part.after).integer(3, part.limit);
    while (row.step()) {
      StoredEvent event;
      event.tick = row.unsigned_at(0);
      event.time_ns = row.unsigned_at(1);
      event.kind = static_cast<std::uint32_t>(row.integer_at(2));
      event.code = static_cast<std::uint32_t>(row.integer_at(3));
      event.bits = static_cast<std::uint32_t>(row.integer_at(4));
      event.item = static_cast<std::uint32_t>(row.integer_at(5));
      event.request_id = static_cast<std::uint32_t>(row.integer_at(6));
      event.value = row.real_at(7);
      event.before = row.real_at(8);
      event.kind_name = row.text_at(9);
      event.name = row.text_at(10);
      event.actor = actor_at(row, 11);
      event.number = row.integer_at(15);
      out.push_back(std::move(event));
    }
    return out;
  });
}

Result<std::vector<Gap>> SessionReader::gaps(SessionId session, const RowPart& part) const {
  return guarded([&]() -> Result<std::vector<Gap>> {
    std::vector<Gap> out;
    Statement row(
        database_->handle(),
        "SELECT stream, from_tick, to_tick, reason, number FROM gaps WHERE session_id = ?1 AND number > ?2 ORDER BY number LIMIT ?3");
    row.integer(1, session).integer(2, part.after).integer(3, part.limit);
    while (row.step()) out.push_back({row.text_at(0), row.unsigned_at(1), row.unsigned_at(2), row.text_at(3), row.integer_at(4)});
    return out;
  });
}

Result<std::vector<Marker>> SessionReader::markers(SessionId session) const {
  return guarded([&]() -> Result<std::vector<Marker>> {
    std::vector<Marker> out;
    Statement row(
        database_->handle(),
        "SELECT tick, utc_ns, text, ifnull(kind, 'note'), user, role, origin, client FROM markers LEFT JOIN actors ON actors.id = actor_id "
        "WHERE session_id = ?1 ORDER BY number");
    row.integer(1, session);
    while (row.step()) out.push_back({row.unsigned_at(0), row.integer_at(1), row.text_at(2), actor_at(row, 4), row.text_at(3)});
    return out;
  });
}

Result<std::optional<BrokenOff>> SessionReader::broken_off(std::uint64_t core_start_time_ns) const {
  return guarded([&]() -> Result<std::optional<BrokenOff>> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::read);
    Statement row(
        handle,
        std::string(
            "SELECT sessions.id, code, exercise, start_time_ns, close_reason, (SELECT max(last_tick) FROM chunks WHERE session_id = "
            "sessions.id), (SELECT max(tick) FROM events WHERE session_id = sessions.id), (SELECT max(last_time_ns) FROM bus_chunks "
            "WHERE session_id = sessions.id) FROM ") +
            kSessions + "WHERE core_start_time_ns = ?1 ORDER BY sessions.id DESC LIMIT 1");
    if (!row.unsigned_integer(1, core_start_time_ns).step()) return std::optional<BrokenOff>{};
    const std::string reason = row.text_at(4);
    if (reason != close_reason_name(CloseReason::interrupted) && reason != close_reason_name(CloseReason::server_stopped))
      return std::optional<BrokenOff>{};
    BrokenOff out;
    out.session = row.integer_at(0);
    out.subject = row.optional_text_at(1);
    out.exercise_json = row.optional_text_at(2);
    out.start_time_ns = row.unsigned_at(3);
    out.last_time_ns = out.start_time_ns > 0 ? out.start_time_ns - 1 : 0;
    if (!row.is_null(6)) out.last_event_tick = row.unsigned_at(6);
    if (!row.is_null(7)) out.last_frame_time_ns = row.unsigned_at(7);
    if (row.is_null(5)) return std::optional(std::move(out));
    const std::vector<ColumnInfo> layout = layout_of(handle, out.session);
    const auto tick = find_column(layout, "tick"), time = find_column(layout, "time_ns"), mode = find_column(layout, "mode"),
               missed = find_column(layout, "missed_ticks");
    ChunkSource source(handle, out.session, layout.size());
    const auto chunk = source.at_or_after(row.unsigned_at(5));
    if (!tick || !time || !mode || !missed || !chunk) return std::optional<BrokenOff>{};
    std::vector<std::vector<std::int64_t>> values;
    source.load(*chunk, std::array{*tick, *time, *mode, *missed}, values);
    const auto last_mode = static_cast<std::size_t>(values[2].back());
    if (last_mode >= contract::kModes.size() || !contract::kModes[last_mode].moving) return std::optional<BrokenOff>{};
    out.last_tick = static_cast<std::uint64_t>(values[0].back());
    out.last_time_ns = static_cast<std::uint64_t>(values[1].back());
    out.missed_ticks = static_cast<std::uint32_t>(values[3].back());
    return std::optional(std::move(out));
  });
}

Result<std::vector<std::pair<std::string, double>>> SessionReader::parameters(SessionId session) const {
  return guarded([&]() -> Result<std::vector<std::pair<std::string, double>>> {
    std::vector<std::pair<std::string, double>> out;
    Statement row(database_->handle(), "SELECT name, value FROM parameters WHERE session_id = ?1 ORDER BY position");
    row.integer(1, session);
    while (row.step()) out.emplace_back(row.text_at(0), row.real_at(1));
    return out;
  });
}

Result<std::vector<NodeProgram>> SessionReader::node_programs(SessionId session) const {
  return guarded([&]() -> Result<std::vector<NodeProgram>> {
    std::vector<NodeProgram> out;
    Statement row(database_->handle(),
                  "SELECT name, product, revision, version, crc FROM node_programs WHERE session_id = ?1 ORDER BY position");
    row.integer(1, session);
    const auto number = [&row](int column) {
      return row.is_null(column) ? std::nullopt : std::optional(static_cast<std::uint32_t>(row.unsigned_at(column)));
    };
    while (row.step()) out.push_back({row.text_at(0), number(1), number(2), number(3), number(4)});
    return out;
  });
}

Result<std::vector<contract::BusRecord>> SessionReader::bus_chunk(SessionId session, std::uint64_t first) const {
  return guarded([&]() -> Result<std::vector<contract::BusRecord>> {
    std::vector<contract::BusRecord> chunk;
    Statement row(
        database_->handle(),
        "SELECT first_frame, body FROM bus_chunks WHERE session_id = ?1 AND first_frame + frames > ?2 ORDER BY first_frame LIMIT 1");
    if (!row.integer(1, session).unsigned_integer(2, first).step()) return chunk;
    const std::uint64_t first_frame = row.unsigned_at(0);
    if (const CodecError error = decode_bus(row.blob_at(1), chunk); error != CodecError::none)
      return Error{
          ErrorKind::corrupt,
          "session " + std::to_string(session) + ", bus frames from number " + std::to_string(first_frame) + ": " + codec_error_text(error),
          {}};
    const std::size_t skip = first > first_frame ? std::min<std::size_t>(first - first_frame, chunk.size()) : 0;
    chunk.erase(chunk.begin(), chunk.begin() + static_cast<std::ptrdiff_t>(skip));
    return chunk;
  });
}

Result<std::vector<contract::BusRecord>> SessionReader::bus_frames(SessionId session, std::uint64_t first, std::size_t limit) const {
  std::vector<contract::BusRecord> out;
  while (out.size() < limit) {
    const Result<std::vector<contract::BusRecord>> chunk = bus_chunk(session, first + out.size());
    if (!chunk) return chunk.error();
    if (chunk->empty()) break;
    const std::size_t count = std::min(chunk->size(), limit - out.size());
    out.insert(out.end(), chunk->begin(), chunk->begin() + static_cast<std::ptrdiff_t>(count));
  }
  return out;
}

Result<std::vector<JournalExtent>> SessionReader::journal(SessionId session) const {
  return guarded([&]() -> Result<std::vector<JournalExtent>> {
    std::vector<JournalExtent> out;
    Statement row(database_->handle(), "SELECT first_step, steps FROM journal_chunks WHERE session_id = ?1 ORDER BY first_step");
    row.integer(1, session);
    while (row.step()) out.push_back({row.unsigned_at(0), row.unsigned_at(1)});
    return out;
  });
}

Result<JournalRun> SessionReader::journal_run(SessionId session, std::uint64_t first_step) const {
  return guarded([&]() -> Result<JournalRun> {
    JournalRun run;
    Statement row(database_->handle(), "SELECT body FROM journal_chunks WHERE session_id = ?1 AND first_step = ?2");
    CodecError error = CodecError::body_damaged;
    if (row.integer(1, session).unsigned_integer(2, first_step).step()) error = decode_journal(row.blob_at(0), run.steps, run.commands);
    if (error != CodecError::none)
      return Error{
          ErrorKind::corrupt,
          "session " + std::to_string(session) + ", journal from step " + std::to_string(first_step) + ": " + codec_error_text(error),
          {}};
    return run;
  });
}

Result<std::vector<ImagePlace>> SessionReader::images(SessionId session) const {
  return guarded([&]() -> Result<std::vector<ImagePlace>> {
    std::vector<ImagePlace> out;
    Statement row(database_->handle(), "SELECT step, tick FROM core_images WHERE session_id = ?1 ORDER BY step");
    row.integer(1, session);
    while (row.step()) out.push_back({row.unsigned_at(0), row.unsigned_at(1)});
    return out;
  });
}

Result<contract::CoreImage> SessionReader::image(SessionId session, std::uint64_t step) const {
  return guarded([&]() -> Result<contract::CoreImage> {
    contract::CoreImage image;
    Statement row(database_->handle(), "SELECT step, tick, bytes, body FROM core_images WHERE session_id = ?1 AND step = ?2");
    const bool found = row.integer(1, session).unsigned_integer(2, step).step();
    if (found) {
      image.step = row.unsigned_at(0);
      image.tick = row.unsigned_at(1);
      image.bytes = row.unsigned_at(2);
    }
    if (!found || image.bytes > image.memory.size() || !unpack_bytes(row.blob_at(3), std::span(image.memory).first(image.bytes)))
      return Error{ErrorKind::corrupt,
                   "session " + std::to_string(session) + ", image of the core at step " + std::to_string(step) + ": it is damaged",
                   {}};
    return image;
  });
}

Result<StoredSamples> SessionReader::samples(SessionId session, std::uint64_t tick) const {
  return guarded([&]() -> Result<StoredSamples> {
    StoredSamples out;
    Transaction transaction(database_->handle(), Transaction::Kind::read);
    const std::vector<ColumnInfo> layout = layout_of(database_->handle(), session);
    std::vector<std::size_t> which(layout.size());
    for (std::size_t c = 0; c < which.size(); ++c) which[c] = c;
    ChunkSource source(database_->handle(), session, layout.size());
    if (const auto chunk = source.at_or_after(tick)) source.load(*chunk, which, out.values);
    return out;
  });
}

}  // namespace hoist::db
