// Layouts of columns, each stored once under the hash of its text.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "db/store/session_types.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {

/// FNV-1a, as the signed number that SQLite stores. In SQL: hash_text(text).
std::int64_t hash_text(std::string_view text);
/// The hash of this layout, whose rows are written when they are new. Inside a write transaction.
std::int64_t layout_row(sqlite3* handle, std::span<const ColumnInfo> layout);
/// The columns of this session, in their order; empty when it has none.
std::vector<ColumnInfo> layout_of(sqlite3* handle, SessionId session);

}  // namespace hoist::db
