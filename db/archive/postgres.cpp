#include "db/archive/postgres.hpp"

#include <libpq-fe.h>

#include <array>
#include <charconv>
#include <cstring>

#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// SQLSTATE to our kinds; appendix A of PostgreSQL's documentation.
ErrorKind kind_of(std::string_view state) {
  if (state == "53100") return ErrorKind::disk_full;
  if (state.starts_with("58")) return ErrorKind::io;
  if (state.starts_with("22") || state.starts_with("23")) return ErrorKind::bad_value;  // a value, or a rule of the tables
  if (state == "42501") return ErrorKind::wrong_state;                                  // insufficient privilege
  if (state == "40001" || state == "40P01" || state == "55P03") return ErrorKind::busy;
  return ErrorKind::internal;
}

std::string one_line(const char* text) {
  std::string out(text == nullptr ? "" : text);
  while (!out.empty() && (out.back() == '\n' || out.back() == ' ')) out.pop_back();
  for (char& c : out)
    if (c == '\n') c = ' ';
  return out;
}

std::vector<const char*> pointers(std::initializer_list<std::optional<std::string>> values) {
  std::vector<const char*> out;
  for (const auto& value : values) out.push_back(value ? value->c_str() : nullptr);
  return out;
}

std::optional<std::string> text_of(const PGresult* result, int row, int column) {
  if (PQgetisnull(result, row, column) != 0) return std::nullopt;
  return std::string(PQgetvalue(result, row, column), static_cast<std::size_t>(PQgetlength(result, row, column)));
}

Value value_of(const std::optional<std::string>& text, Kind kind) {
  if (!text) return {};
  const char* end = text->data() + text->size();
  switch (kind) {
    case Kind::integer: {
      std::int64_t value = 0;
      if (std::from_chars(text->data(), end, value).ptr != end) break;
      return value;
    }
    case Kind::real: {
      double value = 0;
      if (std::from_chars(text->data(), end, value).ptr != end) break;
      return value;
    }
    case Kind::text:
      return *text;
    case Kind::blob: {
      std::size_t size = 0;
      const std::unique_ptr<unsigned char, decltype(&PQfreemem)> bytes(
          PQunescapeBytea(reinterpret_cast<const unsigned char*>(text->c_str()), &size), &PQfreemem);
      if (bytes == nullptr) break;
      return Bytes(bytes.get(), bytes.get() + size);
    }
  }
  throw SqlFailure{Error{ErrorKind::corrupt, "the archive holds a value that is none of its column's kind: " + *text, {}}};
}

void add_escaped(std::string& out, std::string_view text) {
  for (const char c : text) {
    if (c == '\\' || c == '\t' || c == '\n' || c == '\r') {
      out.push_back('\\');
      out.push_back(c == '\t' ? 't' : c == '\n' ? 'n' : c == '\r' ? 'r' : c);
    } else {
      out.push_back(c);
    }
  }
}

void add_value(std::string& out, const Value& value) {
  std::array<char, 40> digits{};
  if (std::holds_alternative<std::monostate>(value)) {
    out += "\\N";
  } else if (const auto* integer = std::get_if<std::int64_t>(&value)) {
    out.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), *integer).ptr);
  } else if (const auto* real = std::get_if<double>(&value)) {
    out.append(digits.data(), std::to_chars(digits.data(), digits.data() + digits.size(), *real).ptr);
  } else if (const auto* text = std::get_if<std::string>(&value)) {
    add_escaped(out, *text);
  } else {
    constexpr std::string_view kDigits = "0123456789abcdef";
    out += "\\\\x";
    for (const std::uint8_t byte : std::get<Bytes>(value)) {
      out.push_back(kDigits[byte >> 4]);
      out.push_back(kDigits[byte & 15]);
    }
  }
}

}  // namespace

void Postgres::Close::operator()(pg_conn* connection) const { PQfinish(connection); }
void Postgres::Clear::operator()(pg_result* result) const { PQclear(result); }

void Postgres::fail(std::string_view doing, const pg_result* result) const {
  const char* state = result == nullptr ? nullptr : PQresultErrorField(result, PG_DIAG_SQLSTATE);
  const char* primary = result == nullptr ? nullptr : PQresultErrorField(result, PG_DIAG_MESSAGE_PRIMARY);
  const bool lost = PQstatus(connection_.get()) != CONNECTION_OK;
  throw SqlFailure{Error{lost ? ErrorKind::io : kind_of(state == nullptr ? "" : state),
                         std::string(doing) + ": " + one_line(primary != nullptr ? primary : PQerrorMessage(connection_.get())),
                         {}}};
}

Postgres::Postgres(const std::string& target) : connection_(PQconnectdb(target.c_str())) {
  if (connection_ == nullptr) throw std::bad_alloc();
  if (PQstatus(connection_.get()) != CONNECTION_OK) fail("the archive cannot be reached");
  // Numbers and bytes as this program reads them, whatever the server's or the user's settings are.
  script("SET client_encoding = 'UTF8'; SET extra_float_digits = 1; SET bytea_output = 'hex'; SET client_min_messages = warning");
}

std::vector<Postgres::Texts> Postgres::query(const std::string& sql, std::initializer_list<std::optional<std::string>> values) {
  const ResultPtr result(
      PQexecParams(connection_.get(), sql.c_str(), static_cast<int>(values.size()), nullptr, pointers(values).data(), nullptr, nullptr, 0));
  const ExecStatusType status = PQresultStatus(result.get());
  if (status != PGRES_TUPLES_OK && status != PGRES_COMMAND_OK) fail("the archive refused a statement", result.get());
  std::vector<Texts> rows(static_cast<std::size_t>(PQntuples(result.get())));
  for (std::size_t row = 0; row < rows.size(); ++row)
    for (int column = 0; column < PQnfields(result.get()); ++column)
      rows[row].push_back(text_of(result.get(), static_cast<int>(row), column));
  return rows;
}

void Postgres::each_row(const std::string& sql, std::initializer_list<std::optional<std::string>> values,
                        std::span<const ArchiveColumn> columns, const std::function<void(const Row&)>& use) {
  if (PQsendQueryParams(connection_.get(), sql.c_str(), static_cast<int>(values.size()), nullptr, pointers(values).data(), nullptr, nullptr,
                        0) != 1 ||
      PQsetSingleRowMode(connection_.get()) != 1)
    fail("reading from the archive");
  Row row(columns.size());
  while (const ResultPtr result{PQgetResult(connection_.get())}) {
    const ExecStatusType status = PQresultStatus(result.get());
    if (status == PGRES_TUPLES_OK) continue;  // the end
    if (status != PGRES_SINGLE_TUPLE) fail("reading from the archive", result.get());
    try {
      for (std::size_t i = 0; i < columns.size(); ++i) row[i] = value_of(text_of(result.get(), 0, static_cast<int>(i)), columns[i].kind);
      use(row);
    } catch (...) {
      drain();
      throw;
    }
  }
}

void Postgres::script(const std::string& sql) {
  const ResultPtr result(PQexec(connection_.get(), sql.c_str()));
  const ExecStatusType status = PQresultStatus(result.get());
  if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) fail("the archive refused a statement", result.get());
}

void Postgres::copy(const std::string& table_and_columns, const std::function<void()>& rows) {
  {
    const ResultPtr result(PQexec(connection_.get(), ("COPY " + table_and_columns + " FROM STDIN").c_str()));
    if (PQresultStatus(result.get()) != PGRES_COPY_IN) fail("the archive takes no rows", result.get());
  }
  try {
    rows();
  } catch (...) {
    PQputCopyEnd(connection_.get(), "given up");
    drain();
    throw;
  }
  if (PQputCopyEnd(connection_.get(), nullptr) != 1) fail("writing to the archive");
  while (const ResultPtr result{PQgetResult(connection_.get())})
    if (PQresultStatus(result.get()) != PGRES_COMMAND_OK) fail("writing to the archive", result.get());
}
void Postgres::copy_row(std::int64_t key, std::span<const Value> values) {
  line_ = std::to_string(key);
  for (const Value& value : values) {
    line_.push_back('\t');
    add_value(line_, value);
  }
  line_.push_back('\n');
  if (PQputCopyData(connection_.get(), line_.data(), static_cast<int>(line_.size())) != 1) fail("writing to the archive");
}
void Postgres::drain() {
  while (const ResultPtr rest{PQgetResult(connection_.get())}) {
  }
}

PostgresTransaction::PostgresTransaction(Postgres& postgres, Kind kind) : postgres_(&postgres) {
  postgres_->script(kind == Kind::read ? "BEGIN ISOLATION LEVEL REPEATABLE READ READ ONLY" : "BEGIN");
}
PostgresTransaction::~PostgresTransaction() {
  if (!open_) return;
  try {
    postgres_->script("ROLLBACK");
  } catch (const SqlFailure&) {
    // A lost connection has rolled back by itself.
  }
}
void PostgresTransaction::commit() {
  postgres_->script("COMMIT");
  open_ = false;
}

}  // namespace hoist::db
