#include "db/export/sql.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>
#include <vector>

#include "db/export/fixed_point.hpp"
#include "db/export/source.hpp"
#include "db/store/chunk_source.hpp"
#include "db/store/column_layouts.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// The columns that are not live values.
enum FixedColumn : int { kSessionColumn, kTimeColumn, kUtcColumn, kGapColumn, kFixedColumns };
// What xBestIndex tells xFilter.
enum Plan : int { kBySession = 1, kFrom = 2, kUntil = 4 };
constexpr double kOneSession_rows = 1e5, kAll_rows = 1e8, kRange_share = 0.1;

struct Table : sqlite3_vtab {
  Database* database = nullptr;
  std::vector<std::string> names;  // of the live values
};

// Where a cursor stands in one session.
class SessionRows {
 public:
  SessionRows(Database& database, const SessionInfo& info, std::span<const std::string> names, double from_s, double to_s)
      : source_(database, info, {}), from_s_(from_s), to_s_(to_s), chunks_(database.handle(), info.id, source_.layout.size()) {
    for (const std::string& name : names) columns_.push_back(find_column(source_.layout, name));
    ready_.resize(source_.layout.size());
    values_.resize(source_.layout.size());
    const double begin_ns = static_cast<double>(info.start_time_ns) + from_s * 1e9;
    if (begin_ns > 0)
      tick_ = chunks_.first_tick_from_time(static_cast<std::uint64_t>(std::min(begin_ns, 9e18)));
    else
      tick_ = 0;
    next_chunk();
    skip();
  }
  [[nodiscard]] bool at_end() const { return !chunk_; }
  void next() {
    last_ = tick();
    ++row_;
    skip();
  }
  [[nodiscard]] SessionId session() const { return source_.info.id; }
  double time_s() { return static_cast<double>(microseconds_since(source_.start_ns(), value(source_.time_column))) / 1e6; }
  std::string utc() {
    std::array<char, kMaxNumber_chars> text;
    return {text.data(), utc_.print(text.data(), source_.utc_of(value(source_.time_column)))};
  }
  bool gap_before() {
    source_.written_tick = last_;
    return source_.gap_before(tick());
  }
  // Absent: this session does not have it.
  const ColumnInfo* info_of(std::size_t live) const { return columns_[live] ? &source_.layout[*columns_[live]] : nullptr; }
  std::int64_t live_value(std::size_t live) { return value(*columns_[live]); }

 private:
  std::uint64_t tick() { return static_cast<std::uint64_t>(value(source_.tick_column)); }
  std::int64_t value(std::size_t column) {
    if (!ready_[column]) load(column);
    return values_[column][row_];
  }
  // A chunk of a frame per column gives one column at a time; of the other layout all cost as much as one.
  void load(std::size_t column) {
    std::vector<std::size_t> which{column};
    if (chunk_->directory.layout == ChunkLayout::one_frame) {
      which.resize(source_.layout.size());
      for (std::size_t c = 0; c < which.size(); ++c) which[c] = c;
    }
    std::vector<std::vector<std::int64_t>> loaded;
    chunks_.load(*chunk_, which, loaded);
    for (std::size_t i = 0; i < which.size(); ++i) {
      values_[which[i]] = std::move(loaded[i]);
      ready_[which[i]] = true;
    }
  }
  void next_chunk() {
    chunk_ = tick_ && source_.any_samples && *tick_ <= source_.last_tick ? chunks_.at_or_after(*tick_) : std::nullopt;
    if (chunk_) tick_ = chunk_->last_tick + 1;
    row_ = 0;
    std::fill(ready_.begin(), ready_.end(), false);
  }
  // To the next row that is wanted.
  void skip() {
    while (chunk_) {
      if (row_ >= chunk_->directory.samples) {
        next_chunk();
        continue;
      }
      const double at_s = time_s();
      if (at_s > to_s_ || tick() > source_.last_tick) return chunk_.reset();
      if (at_s >= from_s_ && !(last_ && tick() <= *last_)) return;
      last_ = tick();
      ++row_;
    }
  }

  ExportSource source_;
  double from_s_, to_s_;
  ChunkSource chunks_;
  std::vector<std::optional<std::size_t>> columns_;  // of the live values, in this session's layout
  std::optional<std::uint64_t> tick_;
  std::optional<StoredChunk> chunk_;
  std::vector<bool> ready_;
  std::vector<std::vector<std::int64_t>> values_;
  std::size_t row_ = 0;
  std::optional<std::uint64_t> last_;
  UtcPrinter utc_;
};

struct Cursor : sqlite3_vtab_cursor {
  std::vector<SessionId> sessions;  // still to come, the next one last
  double from_s = 0, to_s = 0;
  std::unique_ptr<SessionRows> rows;
  sqlite3_int64 row_number = 0;
};

Table& table_of(sqlite3_vtab_cursor* cursor) { return *static_cast<Table*>(cursor->pVtab); }

// Calls from SQLite may not throw: the failure becomes the table's message.
template <typename Work>
int safely(sqlite3_vtab* table, Work work) {
  const Status done = guarded([&]() -> Status {
    work();
    return {};
  });
  if (done) return SQLITE_OK;
  sqlite3_free(table->zErrMsg);
  table->zErrMsg = sqlite3_mprintf("%s", done.error().message.c_str());
  return done.error().kind == ErrorKind::corrupt ? SQLITE_CORRUPT : SQLITE_ERROR;
}

void next_session(Cursor& cursor) {
  Table& table = table_of(&cursor);
  while (!cursor.sessions.empty()) {
    const SessionId id = cursor.sessions.back();
    cursor.sessions.pop_back();
    Result<SessionInfo> info = SessionReader(*table.database).get(id);
    if (!info && info.error().kind == ErrorKind::not_found) continue;
    if (!info) throw SqlFailure{info.error()};
    // A session without a sample may have no columns.
    if (layout_of(table.database->handle(), id).empty()) continue;
    cursor.rows = std::make_unique<SessionRows>(*table.database, *info, table.names, cursor.from_s, cursor.to_s);
    if (!cursor.rows->at_end()) return;
  }
  cursor.rows.reset();
}

int connect(sqlite3* handle, void* database, int, const char* const*, sqlite3_vtab** out, char** error) {
  auto table = std::make_unique<Table>();
  table->database = static_cast<Database*>(database);
  std::string declared = "CREATE TABLE samples(session_id INTEGER, time_s REAL, utc TEXT, gap_before INTEGER";
  const Status read = guarded([&]() -> Status {
    Statement name(handle, "SELECT name FROM column_layout GROUP BY name ORDER BY min(position), name");
    while (name.step()) table->names.push_back(name.text_at(0));
    return {};
  });
  if (!read) {
    *error = sqlite3_mprintf("%s", read.error().message.c_str());
    return SQLITE_ERROR;
  }
  for (const std::string& name : table->names) declared += ", " + sql_name(name);
  const int code = sqlite3_declare_vtab(handle, (declared + ")").c_str());
  if (code == SQLITE_OK) *out = table.release();
  return code;
}
int disconnect(sqlite3_vtab* table) {
  delete static_cast<Table*>(table);
  return SQLITE_OK;
}

int best_index(sqlite3_vtab*, sqlite3_index_info* info) {
  // The values come to xFilter in this order.
  constexpr std::array<std::pair<Plan, int>, 3> kWanted{{{kBySession, kSessionColumn}, {kFrom, kTimeColumn}, {kUntil, kTimeColumn}}};
  int arguments = 0;
  double rows = kAll_rows;
  for (const auto& [plan, column] : kWanted)
    for (int i = 0; i < info->nConstraint; ++i) {
      const auto& asked = info->aConstraint[i];
      const bool fits = plan == kBySession ? asked.op == SQLITE_INDEX_CONSTRAINT_EQ
                        : plan == kFrom    ? asked.op == SQLITE_INDEX_CONSTRAINT_GE || asked.op == SQLITE_INDEX_CONSTRAINT_GT
                                           : asked.op == SQLITE_INDEX_CONSTRAINT_LE || asked.op == SQLITE_INDEX_CONSTRAINT_LT;
      if (asked.usable == 0 || asked.iColumn != column || !fits) continue;
      info->aConstraintUsage[i].argvIndex = ++arguments;
      info->idxNum |= plan;
      rows = plan == kBySession ? kOneSession_rows : rows * kRange_share;
      break;
    }
  info->estimatedCost = rows;
  info->estimatedRows = static_cast<sqlite3_int64>(rows);
  return SQLITE_OK;
}

int open_cursor(sqlite3_vtab*, sqlite3_vtab_cursor** out) {
  *out = new Cursor();
  return SQLITE_OK;
}
int close_cursor(sqlite3_vtab_cursor* cursor) {
  delete static_cast<Cursor*>(cursor);
  return SQLITE_OK;
}

int filter(sqlite3_vtab_cursor* base, int plan, const char*, int, sqlite3_value** values) {
  auto& cursor = *static_cast<Cursor*>(base);
  return safely(base->pVtab, [&] {
    cursor.sessions.clear();
    int next = 0;
    if ((plan & kBySession) != 0) {
      cursor.sessions.push_back(sqlite3_value_int64(values[next++]));
    } else {
      Statement row(table_of(base).database->handle(), "SELECT id FROM sessions ORDER BY id DESC");
      while (row.step()) cursor.sessions.push_back(row.integer_at(0));
    }
    cursor.from_s = (plan & kFrom) != 0 ? sqlite3_value_double(values[next++]) : -1e18;
    cursor.to_s = (plan & kUntil) != 0 ? sqlite3_value_double(values[next++]) : 1e18;
    next_session(cursor);
  });
}
int next_row(sqlite3_vtab_cursor* base) {
  auto& cursor = *static_cast<Cursor*>(base);
  return safely(base->pVtab, [&] {
    ++cursor.row_number;
    cursor.rows->next();
    if (cursor.rows->at_end()) next_session(cursor);
  });
}
int at_end(sqlite3_vtab_cursor* cursor) { return static_cast<Cursor*>(cursor)->rows ? 0 : 1; }

int column(sqlite3_vtab_cursor* base, sqlite3_context* out, int which) {
  SessionRows& rows = *static_cast<Cursor*>(base)->rows;
  return safely(base->pVtab, [&] {
    switch (which) {
      case kSessionColumn:
        return sqlite3_result_int64(out, rows.session());
      case kTimeColumn:
        return sqlite3_result_double(out, rows.time_s());
      case kUtcColumn: {
        const std::string text = rows.utc();
        return sqlite3_result_text(out, text.data(), static_cast<int>(text.size()), SQLITE_TRANSIENT);
      }
      case kGapColumn:
        return sqlite3_result_int(out, rows.gap_before() ? 1 : 0);
      default: {
        const auto live = static_cast<std::size_t>(which - kFixedColumns);
        const ColumnInfo* info = rows.info_of(live);
        if (info == nullptr) return sqlite3_result_null(out);
        const std::int64_t stored = rows.live_value(live);
        if (info->decimals == 0) return sqlite3_result_int64(out, stored);
        return sqlite3_result_double(out, static_cast<double>(stored) / decimal_scale(info->decimals));
      }
    }
  });
}
int row_id(sqlite3_vtab_cursor* cursor, sqlite3_int64* out) {
  *out = static_cast<Cursor*>(cursor)->row_number;
  return SQLITE_OK;
}

// No xCreate: the table is there by itself and is never made or dropped.
const sqlite3_module kModule = [] {
  sqlite3_module module{};
  module.xConnect = connect;
  module.xBestIndex = best_index;
  module.xDisconnect = disconnect;
  module.xOpen = open_cursor;
  module.xClose = close_cursor;
  module.xFilter = filter;
  module.xNext = next_row;
  module.xEof = at_end;
  module.xColumn = column;
  module.xRowid = row_id;
  return module;
}();

// What a reader needs; nothing that writes, and no other file.
int only_reading(void*, int action, const char*, const char*, const char*, const char*) {
  switch (action) {
    case SQLITE_SELECT:
    case SQLITE_READ:
    case SQLITE_FUNCTION:
    case SQLITE_RECURSIVE:
    case SQLITE_TRANSACTION:
      return SQLITE_OK;
    default:
      return SQLITE_DENY;
  }
}

struct Finalize {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

Error sql_error(sqlite3* handle) {
  const int code = sqlite3_errcode(handle);
  const std::string message = sqlite3_errmsg(handle);
  if (code == SQLITE_AUTH) return {ErrorKind::bad_value, "this statement does not only read", "sql"};
  if (code == SQLITE_BUSY) return {ErrorKind::busy, message, {}};
  if (code == SQLITE_CORRUPT) return {ErrorKind::corrupt, message, {}};
  if (code == SQLITE_IOERR) return {ErrorKind::io, message, {}};
  return {ErrorKind::bad_value, message, "sql"};
}

}  // namespace

std::string sql_name(std::string_view name) {
  std::string out = "\"";
  for (const char c : name) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + '"';
}

Status enable_sql(Database& database) {
  if (sqlite3_create_module_v2(database.handle(), "samples", &kModule, &database, nullptr) != SQLITE_OK)
    return Error{ErrorKind::internal, sqlite3_errmsg(database.handle()), {}};
  // The table connects now: the rules below would refuse that.
  if (const Status connected = guarded([&]() -> Status {
        execute(database.handle(), "SELECT 1 FROM samples LIMIT 0");
        return {};
      });
      !connected)
    return connected.error();
  sqlite3_set_authorizer(database.handle(), only_reading, nullptr);
  return {};
}

Status run_sql(Database& database, std::string_view text, const std::function<bool(const SqlRow&)>& row) {
  sqlite3* const handle = database.handle();
  while (!text.empty()) {
    sqlite3_stmt* raw = nullptr;
    const char* rest = nullptr;
    if (sqlite3_prepare_v2(handle, text.data(), static_cast<int>(text.size()), &raw, &rest) != SQLITE_OK) return sql_error(handle);
    const std::unique_ptr<sqlite3_stmt, Finalize> statement(raw);
    text.remove_prefix(static_cast<std::size_t>(rest - text.data()));
    // Only spaces or a comment.
    if (!statement) continue;
    const int columns = sqlite3_column_count(raw);
    std::vector<std::string> names;
    names.reserve(static_cast<std::size_t>(columns));
    for (int i = 0; i < columns; ++i) names.emplace_back(sqlite3_column_name(raw, i));
    std::vector<std::optional<std::string>> cells(names.size());
    int code = 0;
    bool first = true;
    while ((code = sqlite3_step(raw)) == SQLITE_ROW) {
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const auto column_number = static_cast<int>(i);
        const auto* bytes = static_cast<const char*>(sqlite3_column_blob(raw, column_number));
        cells[i].reset();
        if (sqlite3_column_type(raw, column_number) == SQLITE_NULL) continue;
        if (sqlite3_column_type(raw, column_number) != SQLITE_BLOB)
          bytes = reinterpret_cast<const char*>(sqlite3_column_text(raw, column_number));
        cells[i].emplace(bytes == nullptr ? "" : bytes,
                         bytes == nullptr ? 0 : static_cast<std::size_t>(sqlite3_column_bytes(raw, column_number)));
      }
      if (!row({names, cells, std::exchange(first, false)})) return {};
    }
    if (code != SQLITE_DONE) return sql_error(handle);
  }
  return {};
}

bool is_complete_sql(const std::string& text) { return sqlite3_complete(text.c_str()) != 0; }

}  // namespace hoist::db
