#include "db/store/actor_rows.hpp"

namespace hoist::db {

std::int64_t actor_row(sqlite3* handle, const Actor& actor) {
  const auto with_actor = [&](const char* sql) {
    Statement statement(handle, sql);
    statement.text(1, std::string_view(actor.user))
        .text(2, std::string_view(actor.role))
        .text(3, std::string_view(actor.origin))
        .text(4, std::string_view(actor.client));
    return statement.step() ? std::optional(statement.integer_at(0)) : std::nullopt;
  };
  const auto known = with_actor("SELECT id FROM actors WHERE user = ?1 AND role = ?2 AND origin = ?3 AND client = ?4");
  return known ? *known : with_actor("INSERT INTO actors (user, role, origin, client) VALUES (?1, ?2, ?3, ?4) RETURNING id").value();
}

void bind_actor(Statement& row, int index, sqlite3* handle, const std::optional<Actor>& actor) {
  if (actor)
    row.integer(index, actor_row(handle, *actor));
  else
    row.null(index);
}

std::optional<Actor> actor_at(const Statement& row, int first_column) {
  if (row.is_null(first_column)) return std::nullopt;
  return Actor{row.text_at(first_column), row.text_at(first_column + 1), row.text_at(first_column + 2), row.text_at(first_column + 3)};
}

}  // namespace hoist::db
