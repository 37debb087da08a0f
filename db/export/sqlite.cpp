#include "db/export/sqlite.hpp"

#include <fcntl.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

#include "db/export/fixed_point.hpp"
#include "db/export/manifest.hpp"
#include "db/export/spool_file.hpp"
#include "db/export/sql.hpp"
#include "db/store/column_layouts.hpp"
#include "db/store/exercise_json.hpp"
#include "db/summary/session_json.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;

constexpr std::size_t kRowsPerPiece = 512, kBytesPerPiece = 64 * 1024;
// The columns of samples before the live values.
enum Fixed : int { kSession = 1, kTime, kUtc, kGap, kFixedCount = kGap };

// No journal: the file is thrown away with the export. The cache bounds the memory.
constexpr const char* kSettings =
    "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; PRAGMA locking_mode = EXCLUSIVE; PRAGMA cache_size = -4000;";
// Types without STRICT: older programs open the file, too.
constexpr const char* kTables = R"sql(
CREATE TABLE sessions (session_id INTEGER PRIMARY KEY, subject TEXT, started_utc TEXT NOT NULL, simulated INTEGER NOT NULL, exercise TEXT,
  note TEXT NOT NULL, samples INTEGER NOT NULL, manifest TEXT NOT NULL, figures TEXT);
CREATE TABLE columns (session_id INTEGER NOT NULL, name TEXT NOT NULL, unit TEXT NOT NULL, axis TEXT, doc TEXT);
CREATE TABLE events (session_id INTEGER NOT NULL, tick INTEGER NOT NULL, time_s REAL NOT NULL, utc TEXT NOT NULL, kind TEXT NOT NULL,
  name TEXT NOT NULL, code INTEGER NOT NULL, item INTEGER NOT NULL, value REAL, before REAL);
CREATE TABLE markers (session_id INTEGER NOT NULL, tick INTEGER NOT NULL, time_s REAL NOT NULL, utc TEXT NOT NULL,
                      kind TEXT NOT NULL, text TEXT NOT NULL);
CREATE TABLE parameters (session_id INTEGER NOT NULL, name TEXT NOT NULL, value REAL, unit TEXT);
CREATE TABLE parameter_changes (session_id INTEGER NOT NULL, tick INTEGER NOT NULL, time_s REAL NOT NULL, in_effect_s REAL,
  name TEXT NOT NULL, value REAL, before REAL, unit TEXT);
CREATE TABLE gaps (session_id INTEGER NOT NULL, stream TEXT NOT NULL, from_tick INTEGER NOT NULL, to_tick INTEGER NOT NULL,
  reason TEXT NOT NULL);
)sql";

std::string utc_text(std::int64_t utc_ns) {
  std::array<char, kMaxNumber_chars> text;
  return {text.data(), UtcPrinter().print(text.data(), utc_ns)};
}
double seconds_since(std::int64_t start_ns, std::int64_t time_ns) {
  return static_cast<double>(microseconds_since(start_ns, time_ns)) / 1e6;
}

// One row of JSON values: texts, numbers and null.
void insert(Statement& statement, SessionId session, const json& row) {
  statement.integer(1, session);
  int place = 1;
  for (const json& value : row) {
    ++place;
    if (value.is_string())
      statement.text(place, std::string_view(value.get_ref<const std::string&>()));
    else if (value.is_number_integer())
      statement.integer(place, value.get<std::int64_t>());
    else if (value.is_number())
      statement.real(place, value.get<double>());
    else
      statement.null(place);
  }
  statement.run();
}

[[noreturn]] void fail(std::string_view doing) {
  const ErrorKind kind = errno == ENOSPC || errno == EDQUOT ? ErrorKind::disk_full : ErrorKind::io;
  throw SqlFailure{Error{kind, "the export could not be " + std::string(doing) + ": " + std::strerror(errno), {}}};
}

}  // namespace

void SqliteWriter::Close::operator()(sqlite3* handle) const { sqlite3_close(handle); }

SqliteWriter::SqliteWriter(Database& database, std::vector<SessionId> sessions, ExportOptions options)
    : database_(database), sessions_(std::move(sessions)), options_(std::move(options)) {
  take_source(SessionReader(database_).get(sessions_.front()));
}
SqliteWriter::SqliteWriter(Database& database, SessionInfo session, ExportOptions options)
    : database_(database), sessions_{session.id}, options_(std::move(options)) {
  take_source(std::move(session));
}

SqliteWriter::~SqliteWriter() {
  insert_.reset();
  handle_.reset();
  if (file_ >= 0) ::close(file_);
}

double SqliteWriter::progress() const { return begun_ == 0 ? 0 : static_cast<double>(begun_ - 1) / static_cast<double>(sessions_.size()); }

bool SqliteWriter::next(std::string& out) {
  if (file_ < 0) {
    gather_columns();
    create_file();
    create_tables();
    return true;
  }
  if (!handle_) return read(out);
  if (!source_) {
    if (begun_ < sessions_.size()) {
      take_source(SessionReader(database_).get(sessions_[begun_]));
      return true;
    }
    insert_.reset();
    execute(handle_.get(), "COMMIT");
    handle_.reset();
    return true;
  }
  if (!described_ && source_->figures_piece()) return true;
  if (!std::exchange(described_, true))
    describe();
  else if (!write_samples())
    source_.reset();
  struct stat now {};
  if (::fstat(file_, &now) != 0) fail("measured");
  if (Status room = room_for_export(file_, static_cast<std::uint64_t>(now.st_size)); !room) throw SqlFailure{room.error()};
  return true;
}

void SqliteWriter::take_source(Result<SessionInfo> session) {
  if (!session) throw SqlFailure{session.error()};
  source_ = std::make_unique<ExportSource>(database_, std::move(*session), options_);
  if (Status chosen = source_->choose(); !chosen) throw SqlFailure{chosen.error()};
  which_ = source_->chosen;
  which_.push_back(source_->tick_column);
  which_.push_back(source_->time_column);
  described_ = false;
  ++begun_;
}

// Of one session those that are asked for, of several all that one of them has.
void SqliteWriter::gather_columns() {
  const auto add = [this](const std::string& name, int decimals) {
    const auto known = std::ranges::find(columns_, name, &LiveValue::name);
    if (known == columns_.end())
      columns_.push_back({name, decimals == 0});
    else
      known->whole = known->whole && decimals == 0;
  };
  if (sessions_.size() == 1) {
    for (const std::size_t c : source_->chosen) add(source_->layout[c].name, source_->layout[c].decimals);
    return;
  }
  std::vector<std::int64_t> hashes;
  for (const SessionId session : sessions_) {
    Statement layout(database_.handle(), "SELECT columns_hash FROM sessions WHERE id = ?1 AND columns_hash IS NOT NULL");
    if (!layout.integer(1, session).step()) continue;
    const std::int64_t hash = layout.integer_at(0);
    if (std::ranges::find(hashes, hash) != hashes.end()) continue;
    hashes.push_back(hash);
    Statement column(database_.handle(), "SELECT name, decimals FROM column_layout WHERE hash = ?1 ORDER BY position");
    column.integer(1, hash);
    while (column.step()) add(column.text_at(0), static_cast<int>(column.integer_at(1)));
  }
}

void SqliteWriter::create_file() {
  std::string name = (database_.file().parent_path() / ".export-XXXXXX").string();
  if (name.front() != '/') name = "./" + name;
  file_ = ::mkostemp(name.data(), O_CLOEXEC);
  if (file_ < 0) fail("begun");
  sqlite3* raw = nullptr;
  const int code = sqlite3_open_v2(name.c_str(), &raw, SQLITE_OPEN_READWRITE, nullptr);
  handle_.reset(raw);
  // SQLite has the file open: without a name it is gone with the last that uses it, however the program ends.
  ::unlink(name.c_str());
  if (code != SQLITE_OK) throw_sql(raw, code, "beginning an export");
}

void SqliteWriter::create_tables() {
  execute(handle_.get(), kSettings);
  execute(handle_.get(), "BEGIN");
  execute(handle_.get(), kTables);
  std::string table =
      "CREATE TABLE samples (session_id INTEGER NOT NULL, time_s REAL NOT NULL, utc TEXT NOT NULL, gap_before INTEGER NOT NULL";
  std::string marks = "?1, ?2, ?3, ?4";
  int place = kFixedCount;
  for (const LiveValue& column : columns_) {
    table += ", " + sql_name(column.name) + (column.whole ? " INTEGER" : " REAL");
    marks += ", ?" + std::to_string(++place);
  }
  execute(handle_.get(), (table + ")").c_str());
  // Rows come in this order, so that the index only grows at its end.
  execute(handle_.get(), "CREATE INDEX samples_by_session ON samples (session_id)");
  insert_ = std::make_unique<Statement>(handle_.get(), "INSERT INTO samples VALUES (" + marks + ")");
}

void SqliteWriter::describe() {
  places_.clear();
  for (const std::size_t c : source_->chosen) {
    const auto at = std::ranges::find(columns_, source_->layout[c].name, &LiveValue::name);
    if (at == columns_.end())
      throw SqlFailure{Error{ErrorKind::corrupt, "session " + std::to_string(source_->info.id) + " changed during its export", {}}};
    places_.push_back(kFixedCount + 1 + static_cast<int>(at - columns_.begin()));
  }
  const json manifest = manifest_json(*source_);
  write_session(manifest);
  write_manifest(manifest);
  write_events();
}

void SqliteWriter::write_session(const json& manifest) {
  const json figures = source_->figures.is_null() ? json(nullptr) : json(dumped(source_->figures));
  const json& session = manifest["session"];
  const json exercise = session["exercise"].is_null() ? json(nullptr) : json(dumped(session["exercise"]));
  Statement row(handle_.get(), "INSERT INTO sessions VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)");
  insert(row, source_->info.id,
         {session["subject"], session["started_utc"], session["simulated"].get<bool>() ? 1 : 0, exercise, session["note"],
          session["samples"], dumped(manifest), figures});
}

void SqliteWriter::write_manifest(const json& manifest) {
  const SessionId id = source_->info.id;
  Statement column(handle_.get(), "INSERT INTO columns VALUES (?1, ?2, ?3, ?4, ?5)");
  insert(column, id, {"time_s", "s", nullptr, "Time since the session's start by the steady clock."});
  for (const json& told : manifest["columns"]) insert(column, id, {told["name"], told["unit"], told["axis"], told["doc"]});
  Statement parameter(handle_.get(), "INSERT INTO parameters VALUES (?1, ?2, ?3, ?4)");
  for (const auto& [name, told] : manifest["parameters"].items()) insert(parameter, id, {name, told["value"], told["unit"]});
  Statement change(handle_.get(), "INSERT INTO parameter_changes VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8)");
  for (const json& told : manifest["parameter_changes"])
    insert(change, id, {told["tick"], told["time_s"], told["in_effect_s"], told["name"], told["value"], told["before"], told["unit"]});
  Statement gap(handle_.get(), "INSERT INTO gaps VALUES (?1, ?2, ?3, ?4, ?5)");
  for (const json& told : manifest["gaps"]) insert(gap, id, {told["stream"], told["from_tick"], told["to_tick"], told["reason"]});
}

void SqliteWriter::write_events() {
  const SessionId id = source_->info.id;
  Statement event(handle_.get(), "INSERT INTO events VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10)");
  source_->each_event([&](const StoredEvent& told) {
    const auto time_ns = static_cast<std::int64_t>(told.time_ns);
    insert(event, id,
           {told.tick, seconds_since(source_->start_ns(), time_ns), utc_text(source_->utc_of(time_ns)), told.kind_name, told.name,
            told.code, told.item, told.value, told.before});
  });
  Statement marker(handle_.get(), "INSERT INTO markers VALUES (?1, ?2, ?3, ?4, ?5, ?6)");
  for (const Marker& told : source_->markers())
    insert(marker, id,
           {told.tick, seconds_since(source_->start_ns(), source_->time_of_tick(told.tick)), utc_text(told.utc_ns), told.kind, told.text});
}

bool SqliteWriter::write_samples() {
  if (!source_->chunk && !source_->next_samples(which_)) return false;
  const std::vector<std::int64_t>& ticks = source_->values[which_.size() - 2];
  const std::vector<std::int64_t>& times = source_->values[which_.size() - 1];
  UtcPrinter printer;
  std::array<char, kMaxNumber_chars> utc;
  for (const std::size_t end = std::min(source_->row + kRowsPerPiece, ticks.size()); source_->row < end; ++source_->row) {
    const std::size_t row = source_->row;
    const auto tick = static_cast<std::uint64_t>(ticks[row]);
    if (!source_->wanted(tick)) continue;
    insert_->integer(kSession, source_->info.id).real(kTime, seconds_since(source_->start_ns(), times[row]));
    insert_->text(kUtc, std::string_view(utc.data(), printer.print(utc.data(), source_->utc_of(times[row]))));
    insert_->integer(kGap, source_->gap_before(tick) ? 1 : 0);
    for (std::size_t c = 0; c < places_.size(); ++c) {
      const int decimals = source_->layout[source_->chosen[c]].decimals;
      const std::int64_t stored = source_->values[c][row];
      if (decimals == 0)
        insert_->integer(places_[c], stored);
      else
        insert_->real(places_[c], static_cast<double>(stored) / decimal_scale(decimals));
    }
    insert_->run();
    source_->written_tick = tick;
  }
  if (source_->row >= ticks.size()) source_->chunk.reset();
  return true;
}

bool SqliteWriter::read(std::string& out) {
  const std::size_t before = out.size();
  out.resize(before + kBytesPerPiece);
  const ssize_t count = ::pread(file_, out.data() + before, kBytesPerPiece, static_cast<off_t>(read_));
  if (count < 0) fail("read");
  out.resize(before + static_cast<std::size_t>(count));
  read_ += static_cast<std::uint64_t>(count);
  return count > 0;
}

std::unique_ptr<FormatWriter> make_sqlite(ExportSource& source) {
  return std::make_unique<SqliteWriter>(source.database, source.info, source.options);
}

}  // namespace hoist::db
