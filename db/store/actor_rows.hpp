// Actors as rows of their own: each one once, named by number in events and markers.
#pragma once
#include <cstdint>
#include <optional>

#include "db/store/session_types.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {

/// The number of this actor's row, which is written when it is new. Inside a write transaction.
std::int64_t actor_row(sqlite3* handle, const Actor& actor);
/// Sets a parameter to the actor's number; NULL for none.
void bind_actor(Statement& row, int index, sqlite3* handle, const std::optional<Actor>& actor);
/// User, role, origin and client from this column on; nothing when they are NULL.
std::optional<Actor> actor_at(const Statement& row, int first_column);

}  // namespace hoist::db
