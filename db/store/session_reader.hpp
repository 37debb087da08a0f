// Reads sessions, also one that is being recorded. Every call is its own read transaction: nothing is held between calls.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "control/contract/commands.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

inline constexpr std::size_t kMaxPage = 200;             ///< sessions of one list page
inline constexpr std::size_t kMaxOverviewRuns = 4000;    ///< runs of one overview
inline constexpr std::size_t kMaxReadSamples = 1000000;  ///< samples of one read_columns; more is refused: ask for less or for the overview

struct SessionQuery {
  std::size_t limit = 50;                    ///< 1 to kMaxPage
  std::optional<SessionId> before;           ///< only sessions older than this one: the cursor of the page before
  std::optional<std::string> subject;        ///< only codes that contain this, capital or small
  std::optional<std::int64_t> patient = {};  ///< only sessions in visits of this patient
  bool standby = false;                      ///< also what was recorded in standby
};
struct SessionPage {
  std::vector<SessionInfo> sessions;  ///< newest first
  std::optional<SessionId> next;      ///< cursor for the next page; absent at the end
  std::uint64_t total = 0;            ///< sessions that match, on all pages
};

/// A part of a session's numbered rows (events, gaps): all of them unless it says otherwise.
struct RowPart {
  std::int64_t after = -1;  ///< only rows behind this number
  std::int64_t limit = -1;  ///< at most so many; -1 = no limit
};

class SessionReader {
 public:
  explicit SessionReader(Database& database) : database_(&database) {}

  Result<SessionPage> list(const SessionQuery& query = {}) const;
  Result<SessionInfo> get(SessionId session) const;
  Result<bool> has(SessionId session) const;
  /// The columns this session was recorded with, in their order: those of its own time, not today's.
  Result<std::vector<ColumnInfo>> columns(SessionId session) const;
  /// Samples as doubles. An unknown name is bad_value, more than kMaxReadSamples too.
  Result<Columns> read_columns(SessionId session, std::span<const std::string> names, const TimeRange& range = {}) const;
  /// At most `runs` minima and maxima per column. A long range comes from the chunk directories alone, without reading any sample.
  Result<Overview> overview(SessionId session, std::span<const std::string> names, std::size_t runs, const TimeRange& range = {}) const;
  Result<std::vector<StoredEvent>> events(SessionId session, const RowPart& part = {}) const;
  Result<std::vector<Gap>> gaps(SessionId session, const RowPart& part = {}) const;
  Result<std::vector<Marker>> markers(SessionId session) const;
  /// The newest session of this life of the core, when it ended with its recorder ("interrupted", "server_stopped") and its last sample was
  /// moving.
  Result<std::optional<BrokenOff>> broken_off(std::uint64_t core_start_time_ns) const;
  /// Parameters in force when the session began: name and value.
  Result<std::vector<std::pair<std::string, double>>> parameters(SessionId session) const;
  /// What the nodes had said of their programs when the session began; empty when that was not recorded.
  Result<std::vector<NodeProgram>> node_programs(SessionId session) const;
  /// Raw frames from number `first` (0 = the session's first) to the end of the stored chunk that holds it (at most kFoldedBusFrames); empty
  /// at the end. For a caller that reads all of them: each chunk is unpacked once.
  Result<std::vector<contract::BusRecord>> bus_chunk(SessionId session, std::uint64_t first) const;
  /// Raw frames in the order they were recorded, from number `first` (0 = the session's first), at most `limit`; empty at the end.
  Result<std::vector<contract::BusRecord>> bus_frames(SessionId session, std::uint64_t first, std::size_t limit) const;
  /// The journal's stored runs, in rising order; empty in recordings from before it was stored.
  Result<std::vector<JournalExtent>> journal(SessionId session) const;
  /// The run that begins with this step. A damaged one is the error `corrupt`, of this run only.
  Result<JournalRun> journal_run(SessionId session, std::uint64_t first_step) const;
  /// Where the core's memory is stored, in rising order, and one of them.
  Result<std::vector<ImagePlace>> images(SessionId session) const;
  Result<contract::CoreImage> image(SessionId session, std::uint64_t step) const;
  /// The stored chunk that holds this tick or comes first after it; without samples at the end.
  Result<StoredSamples> samples(SessionId session, std::uint64_t tick) const;

 private:
  Database* database_;
};

/// Of what people may change of a session (edit_tag.hpp).
std::string session_tag(const std::string& note, const std::optional<std::string>& subject,
                        const std::optional<std::string>& exercise_json);

struct SessionPatch {
  std::optional<std::string> note;
  std::optional<std::optional<std::string>> subject;        ///< inner absent = take the code away
  std::optional<std::optional<std::string>> exercise_json;  ///< inner absent = no exercise
};

/// Changes and deletes closed and open sessions' descriptions; may run on another connection than the recorder's.
class SessionEditor {
 public:
  explicit SessionEditor(Database& database) : database_(&database) {}
  /// All or nothing. `expected`: the tag of what the change was made for, empty = any. Errors: not_found, changed, bad_value
  /// (field note, subject, exercise), busy, disk_full.
  Status patch(SessionId session, const SessionPatch& change, const std::string& expected = {});
  /// Deletes a session with everything in it and overwrites its pages. wrong_state while it is being recorded.
  Status remove(SessionId session);

 private:
  Database* database_;
};

}  // namespace hoist::db
