// The numbers of sessions stand on paper: one that was given is never given again, also when its file was set aside or replaced (DECISIONS 9).
#pragma once
#include <cstdint>

struct sqlite3;

namespace hoist::db {

/// The last one that this file has given; 0 before the first. Throws SqlFailure.
std::int64_t last_session_number(sqlite3* handle);
/// Numbers up to this one count as given. Inside or outside of a transaction. Throws SqlFailure.
void take_session_numbers(sqlite3* handle, std::int64_t last);

}  // namespace hoist::db
