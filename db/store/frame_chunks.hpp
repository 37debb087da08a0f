// Where stored chunks of frames end, for a reader that goes on behind a damaged one.
#pragma once
#include <cstdint>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// Number of the first frame after the stored chunk that holds frame `first`; `first` itself at the end. Also of a damaged chunk.
Result<std::uint64_t> bus_chunk_end(Database& database, SessionId session, std::uint64_t first);

}  // namespace hoist::db
