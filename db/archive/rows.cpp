#include "db/archive/rows.hpp"

namespace hoist::db {
namespace {

constexpr std::size_t kActorColumns = 4;

Value local_value(const Statement& row, int column, Kind kind) {
  if (row.is_null(column)) return {};
  switch (kind) {
    case Kind::integer:
      return row.integer_at(column);
    case Kind::real:
      return row.real_at(column);
    case Kind::text:
      return row.text_at(column);
    case Kind::blob:
      break;
  }
  const ByteView bytes = row.blob_at(column);
  return Bytes(bytes.begin(), bytes.end());
}

void read_local(const Statement& statement, std::span<const ArchiveColumn> columns, Row& row) {
  row.resize(columns.size());
  for (std::size_t i = 0; i < columns.size(); ++i) row[i] = local_value(statement, static_cast<int>(i), columns[i].kind);
}

// The columns that a hoist's own table has.
std::span<const ArchiveColumn> own_columns(const ArchiveTable& table) {
  return table.columns.first(table.columns.size() - (table.has_actor ? kActorColumns : 0));
}

std::string local_select(const ArchiveTable& table) {
  const std::string name(table.name);
  std::string sql = "SELECT " + quoted_names(own_columns(table));
  if (table.has_actor) sql += R"(, "user", role, origin, client)";
  sql += " FROM " + name;
  if (table.has_actor) sql += " LEFT JOIN actors ON actors.id = actor_id";
  sql += &table == &kLayoutTable ? " WHERE hash = (SELECT columns_hash FROM sessions WHERE id = ?1)" : " WHERE session_id = ?1";
  return sql + " ORDER BY " + std::string(table.order);
}

std::string archive_select(const ArchiveTable& table) {
  return "SELECT " + quoted_names(table.columns) + " FROM " + std::string(table.name) +
         (&table == &kLayoutTable ? " WHERE hash = (SELECT columns_hash FROM sessions WHERE id = $1)" : " WHERE session_id = $1") +
         " ORDER BY " + std::string(table.order);
}

void digest_table(SessionRows& rows, const ArchiveTable& table, RowDigest& digest, const UseTableRow& use) {
  digest.table(table.name);
  rows.each(table, [&](const Row& row) {
    digest.row(table.columns, row);
    if (use) use(table, row);
  });
}

[[noreturn]] void no_session() { throw SqlFailure{Error{ErrorKind::not_found, "the session is no longer there", {}}}; }

}  // namespace

std::string quoted_names(std::span<const ArchiveColumn> columns) {
  std::string out;
  for (const ArchiveColumn& column : columns) {
    if (!out.empty()) out += ", ";
    out += '"';
    out += column.name;
    out += '"';
  }
  return out;
}

void LocalRows::each(const ArchiveTable& table, const UseRow& use) {
  Statement statement(handle_, local_select(table));
  statement.integer(1, session_);
  Row row;
  while (statement.step()) {
    read_local(statement, table.columns, row);
    use(row);
  }
}
Row LocalRows::one_row(std::span<const ArchiveColumn> columns, const std::string& sql) {
  Statement statement(handle_, sql);
  if (!statement.integer(1, session_).step()) no_session();
  Row row;
  read_local(statement, columns, row);
  return row;
}
Row LocalRows::session() {
  return one_row(archive_columns::kSession, "SELECT " + quoted_names(archive_columns::kSession) + " FROM sessions WHERE id = ?1");
}
Row LocalRows::description() {
  return one_row(kDescriptionRow,
                 "SELECT sessions.note, exercise, code, day FROM sessions LEFT JOIN visits ON visits.id = visit_id "
                 "LEFT JOIN patients ON patients.id = patient_id WHERE sessions.id = ?1");
}

void ArchivedRows::each(const ArchiveTable& table, const UseRow& use) {
  postgres_->each_row(archive_select(table), {session_}, table.columns, use);
}
Row ArchivedRows::one_row(std::span<const ArchiveColumn> columns, const std::string& sql) {
  Row found;
  postgres_->each_row(sql, {session_}, columns, [&](const Row& row) { found = row; });
  if (found.empty()) no_session();
  return found;
}
Row ArchivedRows::session() {
  return one_row(archive_columns::kSession, "SELECT " + quoted_names(archive_columns::kSession) + " FROM sessions WHERE id = $1");
}
Row ArchivedRows::description() {
  return one_row(kDescriptionRow,
                 "SELECT sessions.note, exercise, code, to_char(day, 'YYYY-MM-DD') FROM sessions LEFT JOIN visits ON visits.id = visit_id "
                 "LEFT JOIN patients ON patients.id = patient_id WHERE sessions.id = $1");
}

std::string content_digest(SessionRows& rows, const UseTableRow& use) {
  RowDigest digest;
  digest.table("sessions");
  digest.row(archive_columns::kSession, rows.session());
  digest_table(rows, kLayoutTable, digest, use);
  for (const ArchiveTable& table : kSessionTables)
    if (!table.changeable) digest_table(rows, table, digest, use);
  return digest.text();
}

std::string description_digest(SessionRows& rows) {
  RowDigest digest;
  digest.table("sessions");
  digest.row(kDescriptionRow, rows.description());
  for (const ArchiveTable& table : kSessionTables)
    if (table.changeable) digest_table(rows, table, digest, {});
  return digest.text();
}

}  // namespace hoist::db
