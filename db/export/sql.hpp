// SQL over a file of recordings, for reading: its own tables, and the samples as plain rows of the virtual table `samples`:
//   session_id, time_s, utc, gap_before, then every live value that any session has; NULL where a session has it not.
// A condition on session_id (=) and on time_s (<, <=, >, >=) reads only the stored chunks that it needs, and only the columns that are asked for.
#pragma once
#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "db/store/database.hpp"
#include "db/store/result.hpp"

namespace hoist::db {

/// From now on this connection has the table `samples` and refuses everything that is not reading. Errors: internal.
Status enable_sql(Database& database);

struct SqlRow {
  std::span<const std::string> names;
  std::span<const std::optional<std::string>> cells;  ///< numbers as SQLite prints them; nothing = NULL
  bool first = false;                                 ///< of its statement
};
/// Runs the statements of this text one after the other; `row` gets each row and ends the work with false. Call enable_sql before.
/// Errors: bad_value (field sql: what SQLite says of the text, or that it would write), corrupt, busy, io.
Status run_sql(Database& database, std::string_view text, const std::function<bool(const SqlRow&)>& row);
/// A column's name in a statement, with any characters in it.
std::string sql_name(std::string_view name);
/// Whether the text ends with a whole statement.
bool is_complete_sql(const std::string& text);

}  // namespace hoist::db
