#include "db/store/frame_chunks.hpp"

#include "db/store/sqlite.hpp"

namespace hoist::db {

Result<std::uint64_t> bus_chunk_end(Database& database, SessionId session, std::uint64_t first) {
  return guarded([&]() -> Result<std::uint64_t> {
    Statement row(database.handle(),
                  "SELECT min(first_frame + frames) FROM bus_chunks WHERE session_id = ?1 AND first_frame + frames > ?2");
    row.integer(1, session).unsigned_integer(2, first);
    return row.step() && !row.is_null(0) ? row.unsigned_at(0) : first;
  });
}

}  // namespace hoist::db
