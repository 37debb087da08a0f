#include "db/archive/archive.hpp"

#include "db/archive/conditions.hpp"
#include "db/archive/postgres.hpp"
#include "db/archive/schema_list.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// Two programs may create or update an archive at once; the number is ours, from the letters "hoist".
constexpr const char* kLock = "SELECT pg_advisory_xact_lock(448328299380)";

int archive_version(Postgres& postgres) {
  if (!postgres.query("SELECT to_regclass('hoist.archive_schema')")[0][0]) return 0;
  return std::stoi(postgres.query("SELECT count(*) FROM hoist.archive_schema")[0][0].value_or("0"));
}
int newest_version() { return static_cast<int>(archive_schema_list().size()); }

Error newer_archive(int version) {
  return {ErrorKind::newer_schema,
          "the archive has schema " + std::to_string(version) + ", this program knows " + std::to_string(newest_version()) +
              ": use the newer program",
          {}};
}

}  // namespace

Archive::Archive(std::unique_ptr<Postgres> postgres) : postgres_(std::move(postgres)) {}
Archive::Archive(Archive&&) noexcept = default;
Archive& Archive::operator=(Archive&&) noexcept = default;
Archive::~Archive() = default;

Result<Archive> Archive::connect(const std::string& target) {
  return guarded([&]() -> Result<Archive> {
    auto postgres = std::make_unique<Postgres>(target);
    const int version = archive_version(*postgres);
    if (version > newest_version()) return newer_archive(version);
    if (version < newest_version())
      return Error{ErrorKind::wrong_state,
                   version == 0 ? "there is no archive in this database: make one with hoist archive create"
                                : "the archive has schema " + std::to_string(version) + ", this program needs " +
                                      std::to_string(newest_version()) + ": bring it up to date with hoist archive create",
                   {}};
    postgres->script("SET search_path = hoist");
    return Archive(std::move(postgres));
  });
}

Result<int> Archive::create(const std::string& target) {
  return guarded([&]() -> Result<int> {
    Postgres postgres(target);
    PostgresTransaction transaction(postgres, PostgresTransaction::Kind::write);
    postgres.query(kLock);
    const int version = archive_version(postgres);
    if (version > newest_version()) return newer_archive(version);
    if (version == 0)
      postgres.script(
          "CREATE SCHEMA IF NOT EXISTS hoist; "
          "CREATE TABLE hoist.archive_schema (version int PRIMARY KEY, applied timestamptz NOT NULL DEFAULT now())");
    postgres.script("SET LOCAL search_path = hoist");
    for (int next = version; next < newest_version(); ++next) {
      postgres.script(std::string(archive_schema_list()[static_cast<std::size_t>(next)]));
      postgres.query("INSERT INTO archive_schema (version) VALUES ($1)", {std::to_string(next + 1)});
    }
    transaction.commit();
    return version;
  });
}

Result<std::vector<ArchivedSession>> Archive::list(const ArchiveQuery& query) {
  return guarded([&]() -> Result<std::vector<ArchivedSession>> {
    if (Status checked = check_query(query); !checked) return checked.error();
    const auto rows = postgres_->query(
        "SELECT uuid, device, coalesce(hoist_id, ''), coalesce(code, ''), to_char(to_timestamp(started_utc_ns / 1000000000) AT TIME ZONE "
        "'UTC', "
        "'YYYY-MM-DD\"T\"HH24:MI:SS\"Z\"'), sessions.note, coalesce(last_time_ns - first_time_ns, 0), simulated" +
            std::string(kMatching) + " ORDER BY started_utc_ns, uuid",
        {query.uuid, query.patient, query.device, query.from_day, query.to_day});
    std::vector<ArchivedSession> out;
    out.reserve(rows.size());
    for (const Postgres::Texts& row : rows)
      out.push_back({*row[0], *row[1], *row[2], *row[3], *row[4], *row[5], std::stod(*row[6]) * 1e-9, *row[7] == "1"});
    return out;
  });
}

Status Archive::erase(const std::string& uuid) {
  return guarded([&]() -> Status {
    if (Status checked = check_query({.uuid = uuid}); !checked) return checked;
    PostgresTransaction transaction(*postgres_, PostgresTransaction::Kind::write);
    if (postgres_->query("DELETE FROM sessions WHERE uuid = $1 RETURNING id", {uuid}).empty())
      return Error{ErrorKind::not_found, "there is no session " + uuid + " in the archive", {}};
    postgres_->query("INSERT INTO erased_sessions (uuid) VALUES ($1) ON CONFLICT DO NOTHING", {uuid});
    // No code outlives its last session, as in a hoist's own file.
    postgres_->script(
        "DELETE FROM visits WHERE NOT EXISTS (SELECT 1 FROM sessions WHERE visit_id = visits.id); "
        "DELETE FROM patients WHERE NOT EXISTS (SELECT 1 FROM visits WHERE patient_id = patients.id)");
    transaction.commit();
    return {};
  });
}

}  // namespace hoist::db
