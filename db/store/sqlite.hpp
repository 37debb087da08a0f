// The little of SQLite's C interface that the store needs. Inside db a failed statement throws SqlFailure; `guarded` at each public function
// turns it into a typed Error, so that none leaves.
#pragma once
#include <cstdint>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "db/codec/bytes.hpp"
#include "db/store/result.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace hoist::db {

struct SqlFailure {
  Error error;
};
// The value, or its error thrown.
template <typename Value>
Value or_throw(Result<Value> result) {
  if (!result) throw SqlFailure{result.error()};
  return std::move(*result);
}
[[noreturn]] void throw_sql(sqlite3* handle, int code, std::string_view doing);

class Statement {
 public:
  Statement(sqlite3* handle, std::string_view sql);
  ~Statement();
  Statement(Statement&& other) noexcept : handle_(other.handle_), statement_(std::exchange(other.statement_, nullptr)) {}
  Statement& operator=(Statement&&) = delete;

  // Parameters count from 1, columns from 0. Texts and blobs must live until the statement is reset.
  Statement& integer(int index, std::int64_t value);
  Statement& unsigned_integer(int index, std::uint64_t value) { return integer(index, static_cast<std::int64_t>(value)); }
  Statement& real(int index, double value);
  Statement& text(int index, std::string_view value);
  Statement& text(int index, const std::optional<std::string>& value) {
    return value ? text(index, std::string_view(*value)) : null(index);
  }
  Statement& blob(int index, ByteView value);
  Statement& null(int index);

  bool step();  // true = a row is there
  void run();   // to the end, then reset
  void reset();

  [[nodiscard]] bool is_null(int column) const;
  [[nodiscard]] std::int64_t integer_at(int column) const;
  [[nodiscard]] std::uint64_t unsigned_at(int column) const { return static_cast<std::uint64_t>(integer_at(column)); }
  [[nodiscard]] double real_at(int column) const;
  [[nodiscard]] std::string text_at(int column) const;
  [[nodiscard]] std::optional<std::string> optional_text_at(int column) const;
  [[nodiscard]] ByteView blob_at(int column) const;  // valid until the next step or reset

 private:
  void check(int code) const;
  sqlite3* handle_;
  sqlite3_stmt* statement_ = nullptr;
};

// The first value of the first row; 0 without a row.
std::int64_t number_of(sqlite3* handle, std::string_view sql);
void execute(sqlite3* handle, const char* sql);
// Best effort: tells whether it worked, throws nothing. For housekeeping that may fail.
bool try_execute(sqlite3* handle, const char* sql) noexcept;

/// A read inside of another transaction belongs to it: it sees that one's state, and its end changes nothing.
class Transaction {
 public:
  enum class Kind : std::uint8_t { read, write };
  Transaction(sqlite3* handle, Kind kind);
  ~Transaction();
  Transaction(const Transaction&) = delete;
  Transaction& operator=(const Transaction&) = delete;
  void commit();

 private:
  sqlite3* handle_;
  bool open_;
};

// Runs `work`; a SqlFailure or a lack of memory becomes the error of the returned Result or Status.
template <typename Work>
auto guarded(Work&& work) -> decltype(work()) {
  try {
    return work();
  } catch (SqlFailure& failure) {
    return std::move(failure.error);
  } catch (const std::bad_alloc&) {
    return Error{ErrorKind::internal, "out of memory", {}};
  } catch (const std::exception& other) {
    return Error{ErrorKind::internal, other.what(), {}};
  }
}

}  // namespace hoist::db
