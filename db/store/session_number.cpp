#include "db/store/session_number.hpp"

#include "db/store/sqlite.hpp"

namespace hoist::db {

std::int64_t last_session_number(sqlite3* handle) { return number_of(handle, "SELECT seq FROM sqlite_sequence WHERE name = 'sessions'"); }

void take_session_numbers(sqlite3* handle, std::int64_t last) {
  if (last <= last_session_number(handle)) return;
  // A file without sessions has no row yet.
  execute(handle,
          "INSERT INTO sqlite_sequence (name, seq) SELECT 'sessions', 0 WHERE NOT EXISTS "
          "(SELECT 1 FROM sqlite_sequence WHERE name = 'sessions')");
  Statement(handle, "UPDATE sqlite_sequence SET seq = ?1 WHERE name = 'sessions'").integer(1, last).run();
}

}  // namespace hoist::db
