#include <map>
#include <optional>

#include "db/archive/archive.hpp"
#include "db/archive/rows.hpp"
#include "db/store/patient_code.hpp"

namespace hoist::db {
namespace {

struct LocalSession {
  SessionId id = 0;
  std::int64_t visit_id = 0;  ///< 0 = none
  std::string code, day;
};
/// The sessions of one visit, or one session without a visit: what one transaction sends.
using Batch = std::vector<LocalSession>;

// Ended and folded walks only: folding changes the stored chunks, and so the digest. What was recorded in standby stays on its hoist.
std::vector<Batch> local_batches(sqlite3* handle, const PushOptions& options, PushReport& report) {
  std::map<std::pair<std::int64_t, SessionId>, Batch> batches;
  Statement row(
      handle,
      "SELECT sessions.id, ifnull(visit_id, 0), ifnull(code, ''), ifnull(day, ''), ended_utc_ns IS NOT NULL AND folded, simulated "
      "FROM sessions LEFT JOIN visits ON visits.id = visit_id LEFT JOIN patients ON patients.id = patient_id WHERE standby = 0 ORDER BY "
      "sessions.id");
  while (row.step()) {
    if (row.integer_at(4) == 0) {
      ++report.not_ended;
    } else if (row.integer_at(5) != 0 && !options.simulated) {
      ++report.simulated;
    } else {
      const LocalSession session{row.integer_at(0), row.integer_at(1), row.text_at(2), row.text_at(3)};
      batches[{session.visit_id, session.visit_id == 0 ? session.id : 0}].push_back(session);
    }
  }
  std::vector<Batch> out;
  out.reserve(batches.size());
  for (auto& [key, batch] : batches) out.push_back(std::move(batch));
  return out;
}

// The code of the patient in the archive: the rule of patient_code.hpp, whatever the locale of that database folds.
std::string archive_code(Postgres& postgres, const std::string& code) {
  std::string found;
  for (const Postgres::Texts& row : postgres.query("SELECT code FROM patients ORDER BY id")) {
    if (row[0] == code) return code;
    if (found.empty() && same_code(*row[0], code)) found = *row[0];
  }
  if (!found.empty()) return found;
  postgres.query("INSERT INTO patients (code) VALUES ($1) ON CONFLICT DO NOTHING", {code});
  return code;
}

std::optional<std::string> archive_visit(Postgres& postgres, const LocalSession& session) {
  if (session.visit_id == 0) return std::nullopt;
  const std::string code = archive_code(postgres, session.code);
  postgres.query("INSERT INTO visits (patient_id, day) SELECT id, $2::date FROM patients WHERE code = $1 ON CONFLICT DO NOTHING",
                 {code, session.day});
  return postgres.query("SELECT visits.id FROM visits JOIN patients ON patients.id = patient_id WHERE code = $1 AND day = $2::date",
                        {code, session.day})[0][0];
}

// COPY takes one table at a time, so each table is read twice: for the digest and for the rows. A session fits the page cache.
void copy_table(Postgres& postgres, LocalRows& rows, const ArchiveTable& table, std::int64_t key, const char* key_name) {
  postgres.copy(std::string(table.name) + " (" + key_name + ", " + quoted_names(table.columns) + ")",
                [&] { rows.each(table, [&](const Row& row) { postgres.copy_row(key, row); }); });
}

std::string text_of(const Value& value) {
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
  return std::get<std::string>(value);
}
std::optional<std::string> optional_text(const Value& value) {
  if (std::holds_alternative<std::monostate>(value)) return std::nullopt;
  return text_of(value);
}

void store_layout(Postgres& postgres, LocalRows& rows, const Value& columns_hash) {
  const auto* hash = std::get_if<std::int64_t>(&columns_hash);
  if (hash == nullptr) return;
  // Two hoists that push at once may both find it missing: the second waits here.
  postgres.query("SELECT pg_advisory_xact_lock($1)", {std::to_string(*hash)});
  if (postgres.query("SELECT 1 FROM column_layout WHERE hash = $1 LIMIT 1", {std::to_string(*hash)}).empty())
    copy_table(postgres, rows, kLayoutTable, *hash, "hash");
}

class Pusher {
 public:
  Pusher(Postgres& postgres, sqlite3* handle, const PushOptions& options, PushReport& report)
      : postgres_(postgres), handle_(handle), options_(options), report_(report) {}

  void session(const LocalSession& session) {
    LocalRows rows(handle_, session.id);
    const Row recorded = rows.session();
    const std::string uuid = session_uuid(recorded);
    if (!postgres_.query("SELECT 1 FROM erased_sessions WHERE uuid = $1", {uuid}).empty()) {
      ++report_.erased;
      return;
    }
    const std::string content = content_digest(rows);
    const std::string description = description_digest(rows);
    const auto there = postgres_.query("SELECT id, content_sha256, description_sha256 FROM sessions WHERE uuid = $1", {uuid});
    if (there.empty())
      add(session, rows, recorded, uuid, content, description);
    else if (there[0][1] != content)
      throw SqlFailure{Error{
          ErrorKind::corrupt,
          "the archive holds another recording under its uuid " + uuid + ": one of the two is damaged (hoist verify, hoist archive verify)",
          {}}};
    else if (there[0][2] != description)
      describe(session, rows, *there[0][0], description);
    else
      ++report_.present;
  }

 private:
  void add(const LocalSession& session, LocalRows& rows, const Row& recorded, const std::string& uuid, const std::string& content,
           const std::string& description) {
    const Row words = rows.description();
    const auto id = postgres_.query(
        "INSERT INTO sessions (uuid, content_sha256, description_sha256, device, visit_id, note, exercise, started_utc_ns, start_time_ns, "
        "core_start_time_ns, simulated, layout_hash, software_version, core_version, ended_utc_ns, close_reason, sample_count, "
        "first_time_ns, last_time_ns, hoist_id, columns_hash) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13, $14, $15, "
        "$16, $17, "
        "$18, $19, $20, $21) ON CONFLICT (uuid) DO NOTHING RETURNING id",
        {uuid,
         content,
         description,
         options_.device,
         archive_visit(postgres_, session),
         text_of(words[0]),
         optional_text(words[1]),
         optional_text(recorded[0]),
         optional_text(recorded[1]),
         optional_text(recorded[2]),
         optional_text(recorded[3]),
         optional_text(recorded[4]),
         optional_text(recorded[5]),
         optional_text(recorded[6]),
         optional_text(recorded[7]),
         optional_text(recorded[8]),
         optional_text(recorded[9]),
         optional_text(recorded[10]),
         optional_text(recorded[11]),
         optional_text(recorded[12]),
         optional_text(recorded[13])});
    if (id.empty()) {  // another push has just brought it
      ++report_.present;
      return;
    }
    store_layout(postgres_, rows, recorded.back());
    const std::int64_t key = std::stoll(*id[0][0]);
    for (const ArchiveTable& table : kSessionTables) copy_table(postgres_, rows, table, key, "session_id");
    ++report_.pushed;
  }

  void describe(const LocalSession& session, LocalRows& rows, const std::string& id, const std::string& description) {
    const Row words = rows.description();
    postgres_.query("UPDATE sessions SET visit_id = $2, note = $3, exercise = $4, description_sha256 = $5, described = now() WHERE id = $1",
                    {id, archive_visit(postgres_, session), text_of(words[0]), optional_text(words[1]), description});
    for (const ArchiveTable& table : kSessionTables)
      if (table.changeable) {
        postgres_.query("DELETE FROM " + std::string(table.name) + " WHERE session_id = $1", {id});
        copy_table(postgres_, rows, table, std::stoll(id), "session_id");
      }
    ++report_.described;
  }

  Postgres& postgres_;
  sqlite3* handle_;
  const PushOptions& options_;
  PushReport& report_;
};

// False when no other batch would fare better: no connection, no right, no space.
bool is_of_this_session(const Error& error) {
  return error.kind == ErrorKind::corrupt || error.kind == ErrorKind::bad_value || error.kind == ErrorKind::not_found;
}

}  // namespace

Result<PushReport> Archive::push(Database& database, const PushOptions& options, const ArchiveProgress& progress) {
  if (options.device.empty() || options.device.size() > kMaxDevice_bytes)
    return Error{ErrorKind::bad_value, "device must be a name of 1 to " + std::to_string(kMaxDevice_bytes) + " bytes", "device"};
  return guarded([&]() -> Result<PushReport> {
    PushReport report;
    const std::vector<Batch> batches = local_batches(database.handle(), options, report);
    std::uint64_t number = 0;
    for (const Batch& batch : batches) {
      if (progress && !progress(++number, batches.size())) break;
      // All sessions of the file as they stood at one moment, and all of the visit in the archive or none.
      Transaction reading(database.handle(), Transaction::Kind::read);
      PostgresTransaction writing(*postgres_, PostgresTransaction::Kind::write);
      PushReport sent = report;
      SessionId current = 0;
      try {
        Pusher pusher(*postgres_, database.handle(), options, sent);
        for (const LocalSession& session : batch) {
          current = session.id;
          pusher.session(session);
        }
        writing.commit();
        report = sent;
      } catch (const SqlFailure& failure) {
        if (!is_of_this_session(failure.error)) throw;
        report.refused.push_back("session " + std::to_string(current) + ": " + failure.error.message +
                                 (batch.size() > 1 ? " (its visit is not sent)" : ""));
      }
    }
    return report;
  });
}

}  // namespace hoist::db
