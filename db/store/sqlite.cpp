#include "db/store/sqlite.hpp"

#include <sqlite3.h>

#include <limits>

namespace hoist::db {
namespace {

ErrorKind kind_of(int code) {
  switch (code & 0xFF) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return ErrorKind::busy;
    case SQLITE_FULL:
      return ErrorKind::disk_full;
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
    case SQLITE_PERM:
    case SQLITE_READONLY:
      return ErrorKind::io;
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
      return ErrorKind::corrupt;
    default:
      return ErrorKind::internal;
  }
}

}  // namespace

void throw_sql(sqlite3* handle, int code, std::string_view doing) {
  std::string message(doing);
  message += ": ";
  message += sqlite3_errstr(code);
  if (handle != nullptr && sqlite3_errcode(handle) != SQLITE_OK) {
    message += " (";
    message += sqlite3_errmsg(handle);
    message += ')';
  }
  throw SqlFailure{Error{kind_of(code), std::move(message), {}}};
}

Statement::Statement(sqlite3* handle, std::string_view sql) : handle_(handle) {
  const int code = sqlite3_prepare_v3(handle, sql.data(), static_cast<int>(sql.size()), 0, &statement_, nullptr);
  if (code != SQLITE_OK) throw_sql(handle, code, "preparing a statement");
}
Statement::~Statement() { sqlite3_finalize(statement_); }

void Statement::check(int code) const {
  if (code != SQLITE_OK) throw_sql(handle_, code, "binding a value");
}
Statement& Statement::integer(int index, std::int64_t value) {
  check(sqlite3_bind_int64(statement_, index, value));
  return *this;
}
Statement& Statement::real(int index, double value) {
  check(sqlite3_bind_double(statement_, index, value));  // a NaN becomes NULL here, which the schema refuses or means so
  return *this;
}
Statement& Statement::text(int index, std::string_view value) {
  check(sqlite3_bind_text64(statement_, index, value.empty() ? "" : value.data(), value.size(), SQLITE_STATIC, SQLITE_UTF8));
  return *this;
}
Statement& Statement::blob(int index, ByteView value) {
  check(value.empty() ? sqlite3_bind_zeroblob(statement_, index, 0)
                      : sqlite3_bind_blob64(statement_, index, value.data(), value.size(), SQLITE_STATIC));
  return *this;
}
Statement& Statement::null(int index) {
  check(sqlite3_bind_null(statement_, index));
  return *this;
}

bool Statement::step() {
  const int code = sqlite3_step(statement_);
  if (code == SQLITE_ROW) return true;
  if (code == SQLITE_DONE) return false;
  // Read the error before the reset that lets the transaction roll back.
  try {
    throw_sql(handle_, sqlite3_extended_errcode(handle_), "the database");
  } catch (...) {
    sqlite3_reset(statement_);
    throw;
  }
}
void Statement::run() {
  while (step()) {
  }
  reset();
}
void Statement::reset() {
  sqlite3_reset(statement_);
  sqlite3_clear_bindings(statement_);
}

bool Statement::is_null(int column) const { return sqlite3_column_type(statement_, column) == SQLITE_NULL; }
std::int64_t Statement::integer_at(int column) const { return sqlite3_column_int64(statement_, column); }
double Statement::real_at(int column) const {
  return is_null(column) ? std::numeric_limits<double>::quiet_NaN() : sqlite3_column_double(statement_, column);
}
std::string Statement::text_at(int column) const {
  const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return text == nullptr ? std::string() : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)));
}
std::optional<std::string> Statement::optional_text_at(int column) const {
  if (is_null(column)) return std::nullopt;
  return text_at(column);
}
ByteView Statement::blob_at(int column) const {
  const auto* data = static_cast<const std::uint8_t*>(sqlite3_column_blob(statement_, column));
  return data == nullptr ? ByteView{} : ByteView(data, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)));
}

std::int64_t number_of(sqlite3* handle, std::string_view sql) {
  Statement statement(handle, sql);
  return statement.step() ? statement.integer_at(0) : 0;
}

void execute(sqlite3* handle, const char* sql) {
  const int code = sqlite3_exec(handle, sql, nullptr, nullptr, nullptr);
  if (code != SQLITE_OK) throw_sql(handle, sqlite3_extended_errcode(handle), "the database");
}
bool try_execute(sqlite3* handle, const char* sql) noexcept { return sqlite3_exec(handle, sql, nullptr, nullptr, nullptr) == SQLITE_OK; }

Transaction::Transaction(sqlite3* handle, Kind kind) : handle_(handle), open_(kind == Kind::write || sqlite3_get_autocommit(handle) != 0) {
  if (open_) execute(handle, kind == Kind::write ? "BEGIN IMMEDIATE" : "BEGIN");
}
Transaction::~Transaction() {
  // After SQLITE_FULL or SQLITE_IOERR the database may have rolled back by itself.
  if (open_ && sqlite3_get_autocommit(handle_) == 0) try_execute(handle_, "ROLLBACK");
}
void Transaction::commit() {
  if (!open_) return;
  execute(handle_, "COMMIT");
  open_ = false;
}

}  // namespace hoist::db
