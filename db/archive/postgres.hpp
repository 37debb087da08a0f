// The little of libpq that the archive needs. As in store/sqlite.hpp, a failed call throws SqlFailure inside db; public functions are `guarded`.
#pragma once
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "db/archive/tables.hpp"
#include "db/store/result.hpp"

struct pg_conn;
struct pg_result;

namespace hoist::db {

/// A connection to a PostgreSQL server; one thread.
class Postgres {
 public:
  /// `target`: a connection string or URI of libpq; empty = from the environment (PGHOST, PGSERVICE, PGPASSFILE …).
  explicit Postgres(const std::string& target);

  using Texts = std::vector<std::optional<std::string>>;
  /// One statement with texts as $1, $2 …; its rows as texts.
  std::vector<Texts> query(const std::string& sql, std::initializer_list<std::optional<std::string>> values = {});
  /// The same, one row after the other: memory stays that of one row.
  void each_row(const std::string& sql, std::initializer_list<std::optional<std::string>> values, std::span<const ArchiveColumn> columns,
                const std::function<void(const Row&)>& use);
  /// Several statements without values.
  void script(const std::string& sql);

  /// COPY table (columns) FROM STDIN. `rows` is called once and writes rows by `copy_row`; when it throws, none of them is taken.
  void copy(const std::string& table_and_columns, const std::function<void()>& rows);
  void copy_row(std::int64_t key, std::span<const Value> values);

 private:
  struct Close {
    void operator()(pg_conn* connection) const;
  };
  struct Clear {
    void operator()(pg_result* result) const;
  };
  using ResultPtr = std::unique_ptr<pg_result, Clear>;
  [[noreturn]] void fail(std::string_view doing, const pg_result* result = nullptr) const;
  void drain();  ///< reads away what is left of an answer

  std::unique_ptr<pg_conn, Close> connection_;
  std::string line_;
};

/// BEGIN … COMMIT; without `commit` everything is taken back. All reads of a `read` transaction see one state.
class PostgresTransaction {
 public:
  enum class Kind : std::uint8_t { read, write };
  PostgresTransaction(Postgres& postgres, Kind kind);
  ~PostgresTransaction();
  PostgresTransaction(const PostgresTransaction&) = delete;
  PostgresTransaction& operator=(const PostgresTransaction&) = delete;
  void commit();

 private:
  Postgres* postgres_;
  bool open_ = true;
};

}  // namespace hoist::db
