#include "db/archive/archive.hpp"
#include "db/archive/conditions.hpp"
#include "db/archive/rows.hpp"
#include "db/store/actor_rows.hpp"
#include "db/store/patient_code.hpp"

namespace hoist::db {
namespace {

struct Found {
  std::string id, uuid, content;
};

std::vector<Found> matching(Postgres& postgres, const ArchiveQuery& query) {
  std::vector<Found> out;
  for (const Postgres::Texts& row :
       postgres.query("SELECT sessions.id, uuid, content_sha256" + std::string(kMatching) + " ORDER BY started_utc_ns, uuid",
                      {query.uuid, query.patient, query.device, query.from_day, query.to_day}))
    out.push_back({*row[0], *row[1], *row[2]});
  return out;
}

void bind_value(Statement& statement, int index, const Value& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value))
    statement.integer(index, *integer);
  else if (const auto* real = std::get_if<double>(&value))
    statement.real(index, *real);
  else if (const auto* text = std::get_if<std::string>(&value))
    statement.text(index, std::string_view(*text));
  else if (const auto* blob = std::get_if<Bytes>(&value))
    statement.blob(index, *blob);
  else
    statement.null(index);
}

std::string insert_sql(std::string_view table, const std::string& names, std::size_t count) {
  std::string sql = "INSERT INTO " + std::string(table) + " (" + names + ") VALUES (?1";
  for (std::size_t i = 2; i <= count; ++i) sql += ", ?" + std::to_string(i);
  return sql + ")";
}

constexpr std::size_t kActorColumns = 4;

std::optional<Actor> actor_of(std::span<const Value> words) {
  const auto* user = std::get_if<std::string>(&words[0]);
  if (user == nullptr) return std::nullopt;
  return Actor{*user, std::get<std::string>(words[1]), std::get<std::string>(words[2]), std::get<std::string>(words[3])};
}

bool has_session(sqlite3* handle, const Row& recorded) {
  Statement row(handle, "SELECT 1 FROM sessions WHERE started_utc_ns = ?1 AND start_time_ns = ?2 AND core_start_time_ns = ?3");
  for (int i = 0; i < 3; ++i) bind_value(row, i + 1, recorded[static_cast<std::size_t>(i)]);
  return row.step();
}

// The day is the archive's, not one counted in this computer's time zone.
Value visit_of(sqlite3* handle, Value code, const Value& day) {
  if (std::holds_alternative<std::monostate>(code)) return {};
  if (std::string here = stored_code(handle, std::get<std::string>(code)); !here.empty()) code = std::move(here);
  Statement patient(handle, "INSERT OR IGNORE INTO patients (code) VALUES (?1)");
  bind_value(patient, 1, code);
  patient.run();
  const auto with_visit = [&](const char* sql) {
    Statement row(handle, sql);
    bind_value(row, 1, code);
    bind_value(row, 2, day);
    return row.step() ? Value(row.integer_at(0)) : Value();
  };
  with_visit("INSERT OR IGNORE INTO visits (patient_id, day) SELECT id, ?2 FROM patients WHERE code = ?1");
  return with_visit("SELECT visits.id FROM visits JOIN patients ON patients.id = patient_id WHERE code = ?1 AND day = ?2");
}

// The session's own row; the others need its number.
SessionId insert_session(sqlite3* handle, const Row& recorded, const Row& description) {
  const std::size_t count = recorded.size() + archive_columns::kDescription.size();
  const std::string names = quoted_names(archive_columns::kSession) + ", " + quoted_names(archive_columns::kDescription);
  Statement row(handle, insert_sql("sessions", names + ", folded, visit_id", count + 2) + " RETURNING id");
  int index = 0;
  for (const Value& value : recorded) bind_value(row, ++index, value);
  for (std::size_t i = 0; i < archive_columns::kDescription.size(); ++i) bind_value(row, ++index, description[i]);
  row.integer(++index, 1);
  bind_value(row, ++index, visit_of(handle, description[2], description[3]));
  row.step();
  return row.integer_at(0);
}

void insert_layout_row(sqlite3* handle, const Value& hash, const Row& row) {
  Statement statement(handle, "INSERT OR IGNORE INTO column_layout (hash, " + quoted_names(archive_columns::kColumnLayout) +
                                  ") VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
  bind_value(statement, 1, hash);
  for (std::size_t i = 0; i < row.size(); ++i) bind_value(statement, static_cast<int>(i) + 2, row[i]);
  statement.run();
}

void insert_row(sqlite3* handle, const ArchiveTable& table, SessionId session, const Row& row) {
  const std::size_t own = row.size() - (table.has_actor ? kActorColumns : 0);
  std::string names = "session_id, " + quoted_names(table.columns.first(own));
  if (table.has_actor) names += ", actor_id";
  Statement statement(handle, insert_sql(table.name, names, own + 1 + (table.has_actor ? 1U : 0U)));
  statement.integer(1, session);
  for (std::size_t i = 0; i < own; ++i) bind_value(statement, static_cast<int>(i) + 2, row[i]);
  if (table.has_actor) bind_actor(statement, static_cast<int>(own) + 2, handle, actor_of(std::span(row).subspan(own)));
  statement.run();
}

// One transaction: what does not have the archive's digest is taken back.
Status pull_session(Postgres& postgres, sqlite3* handle, const Found& found, PullReport& report) {
  ArchivedRows rows(postgres, found.id);
  const Row recorded = rows.session();
  if (has_session(handle, recorded)) {
    ++report.present;
    return {};
  }
  Transaction transaction(handle, Transaction::Kind::write);
  const SessionId session = insert_session(handle, recorded, rows.description());
  const std::string digest = content_digest(rows, [&](const ArchiveTable& table, const Row& row) {
    if (&table == &kLayoutTable)
      insert_layout_row(handle, recorded.back(), row);
    else
      insert_row(handle, table, session, row);
  });
  if (digest != found.content)
    return Error{ErrorKind::corrupt, "session " + found.uuid + " does not have the digest with which it was archived", {}};
  for (const ArchiveTable& table : kSessionTables)
    if (table.changeable) rows.each(table, [&](const Row& row) { insert_row(handle, table, session, row); });
  transaction.commit();
  ++report.pulled;
  return {};
}

}  // namespace

Result<PullReport> Archive::pull(Database& database, const ArchiveQuery& query, const ArchiveProgress& progress) {
  return guarded([&]() -> Result<PullReport> {
    if (Status checked = check_query(query); !checked) return checked.error();
    PullReport report;
    PostgresTransaction reading(*postgres_, PostgresTransaction::Kind::read);
    const std::vector<Found> sessions = matching(*postgres_, query);
    std::uint64_t number = 0;
    for (const Found& session : sessions) {
      if (progress && !progress(++number, sessions.size())) break;
      if (Status pulled = pull_session(*postgres_, database.handle(), session, report); !pulled) return pulled.error();
    }
    return report;
  });
}

Result<std::vector<std::string>> Archive::verify(const ArchiveQuery& query, const ArchiveProgress& progress) {
  return guarded([&]() -> Result<std::vector<std::string>> {
    if (Status checked = check_query(query); !checked) return checked.error();
    std::vector<std::string> wrong;
    PostgresTransaction reading(*postgres_, PostgresTransaction::Kind::read);
    const std::vector<Found> sessions = matching(*postgres_, query);
    std::uint64_t number = 0;
    for (const Found& session : sessions) {
      if (progress && !progress(++number, sessions.size())) break;
      ArchivedRows rows(*postgres_, session.id);
      if (content_digest(rows) != session.content) wrong.push_back(session.uuid);
    }
    return wrong;
  });
}

}  // namespace hoist::db
