#include "db/store/column_layouts.hpp"

#include <string>

#include "control/contract/check.hpp"

namespace hoist::db {

std::int64_t hash_text(std::string_view text) { return static_cast<std::int64_t>(contract::hash_bytes(contract::kHashStart, text)); }

std::int64_t layout_row(sqlite3* handle, std::span<const ColumnInfo> layout) {
  // The same text as in schema/006_layouts.sql.
  std::string text;
  for (const ColumnInfo& column : layout) {
    if (!text.empty()) text += '\n';
    text += column.name + '\t' + column.unit + '\t' + column.type + '\t' + std::to_string(column.decimals);
  }
  const std::int64_t hash = hash_text(text);
  Statement known(handle, "SELECT 1 FROM column_layout WHERE hash = ?1 LIMIT 1");
  if (known.integer(1, hash).step()) return hash;
  Statement row(handle, "INSERT INTO column_layout (hash, position, name, unit, type, lsb, decimals) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
  for (std::size_t c = 0; c < layout.size(); ++c)
    row.integer(1, hash)
        .unsigned_integer(2, c)
        .text(3, std::string_view(layout[c].name))
        .text(4, std::string_view(layout[c].unit))
        .text(5, std::string_view(layout[c].type))
        .real(6, layout[c].lsb)
        .integer(7, layout[c].decimals)
        .run();
  return hash;
}

std::vector<ColumnInfo> layout_of(sqlite3* handle, SessionId session) {
  std::vector<ColumnInfo> layout;
  Statement row(handle,
                "SELECT name, unit, type, lsb, decimals FROM column_layout "
                "WHERE hash = (SELECT columns_hash FROM sessions WHERE id = ?1) ORDER BY position");
  row.integer(1, session);
  while (row.step())
    layout.push_back({row.text_at(0), row.text_at(1), row.text_at(2), row.real_at(3), static_cast<int>(row.integer_at(4))});
  return layout;
}

}  // namespace hoist::db
