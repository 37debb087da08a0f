#include "db/store/profiles.hpp"

#include <limits>
#include <nlohmann/json.hpp>

#include "db/store/actor_rows.hpp"
#include "db/store/page.hpp"
#include "db/store/session_checks.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

using nlohmann::json;

constexpr const char* kProfileRows =
    "SELECT profiles.id, patient_id, name, version, utc_ns, settings, user, role, origin, client FROM profiles "
    "JOIN profile_versions ON profile_id = profiles.id LEFT JOIN actors ON actors.id = actor_id WHERE ";
constexpr const char* kNewest = "version = (SELECT max(version) FROM profile_versions WHERE profile_id = profiles.id) ";

ProfileInfo profile_at(const Statement& row) {
  ProfileInfo info{.id = row.integer_at(0),
                   .patient_id = row.integer_at(1),
                   .name = row.text_at(2),
                   .version = row.integer_at(3),
                   .utc_ns = row.integer_at(4),
                   .actor = actor_at(row, 6),
                   .settings = {},
                   .tag = {}};
  const json settings = json::parse(row.text_at(5), nullptr, false);
  if (!settings.is_object())
    throw SqlFailure{Error{ErrorKind::corrupt, "the settings of profile " + std::to_string(info.id) + " cannot be read", {}}};
  for (const auto& [name, value] : settings.items())
    if (value.is_number()) info.settings.emplace(name, value.get<double>());
  info.tag = edit_tag({info.name, std::to_string(info.version)});
  return info;
}

std::optional<ProfileInfo> profile_row(sqlite3* handle, std::int64_t profile) {
  Statement row(handle, std::string(kProfileRows) + "profiles.id = ?1 AND " + kNewest);
  return row.integer(1, profile).step() ? std::optional(profile_at(row)) : std::nullopt;
}

Error no_such_profile(std::int64_t profile) { return {ErrorKind::not_found, "there is no profile " + std::to_string(profile), {}}; }

Status check_name(const std::string& name) {
  if (name.empty() || name.size() > kMaxProfileName_bytes || name.find('\n') != std::string::npos || !check_note(name))
    return Error{ErrorKind::bad_value, "name must be 1 to 64 bytes in one line", "name"};
  return {};
}

void write_version(sqlite3* handle, const ProfileInfo& profile, const std::optional<Actor>& actor) {
  const std::string text = json(profile.settings).dump();
  Statement insert(handle, "INSERT INTO profile_versions (profile_id, version, utc_ns, actor_id, settings) VALUES (?1, ?2, ?3, ?4, ?5)");
  insert.integer(1, profile.id).integer(2, profile.version).integer(3, profile.utc_ns).text(5, std::string_view(text));
  bind_actor(insert, 4, handle, actor);
  insert.run();
}

bool name_used(sqlite3* handle, std::int64_t patient, const std::string& name, std::int64_t but_of) {
  Statement row(handle, "SELECT 1 FROM profiles WHERE patient_id = ?1 AND name = ?2 AND id <> ?3");
  return row.integer(1, patient).text(2, std::string_view(name)).integer(3, but_of).step();
}
Error name_taken() { return {ErrorKind::taken, "this patient has a profile of this name already", "name"}; }

}  // namespace

Result<VisitPage<ProfileInfo>> ProfileStore::list(std::int64_t patient, const VisitQuery& query) const {
  return guarded([&]() -> Result<VisitPage<ProfileInfo>> {
    Transaction transaction(database_->handle(), Transaction::Kind::read);
    if (!patient_row(database_->handle(), patient))
      return Error{ErrorKind::not_found, "there is no patient " + std::to_string(patient), {}};
    Statement rows(database_->handle(), std::string(kProfileRows) + "profiles.id < ?1 AND patient_id = ?3 AND " + kNewest +
                                            "ORDER BY profiles.id DESC LIMIT ?2");
    rows.integer(3, patient);
    return page_of<ProfileInfo>(rows, query, profile_at, [](const ProfileInfo& p) { return p.id; });
  });
}

Result<ProfileInfo> ProfileStore::get(std::int64_t profile) const {
  return guarded([&]() -> Result<ProfileInfo> {
    const auto found = profile_row(database_->handle(), profile);
    return found ? Result<ProfileInfo>(*found) : no_such_profile(profile);
  });
}

Result<VisitPage<ProfileInfo>> ProfileStore::versions(std::int64_t profile, const VisitQuery& query) const {
  return guarded([&]() -> Result<VisitPage<ProfileInfo>> {
    Transaction transaction(database_->handle(), Transaction::Kind::read);
    if (!profile_row(database_->handle(), profile)) return no_such_profile(profile);
    Statement rows(database_->handle(), std::string(kProfileRows) + "version < ?1 AND profiles.id = ?3 ORDER BY version DESC LIMIT ?2");
    rows.integer(3, profile);
    return page_of<ProfileInfo>(rows, query, profile_at, [](const ProfileInfo& p) { return p.version; });
  });
}

Result<ProfileInfo> ProfileStore::create(std::int64_t patient, const std::string& name, const ProfileSettings& settings,
                                         std::int64_t utc_ns, const std::optional<Actor>& actor) {
  if (Status checked = check_name(name); !checked) return checked.error();
  return guarded([&]() -> Result<ProfileInfo> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    if (!patient_row(handle, patient)) return Error{ErrorKind::not_found, "there is no patient " + std::to_string(patient), {}};
    if (name_used(handle, patient, name, 0)) return name_taken();
    {
      Statement count(handle, "SELECT count(*) FROM profiles WHERE patient_id = ?1");
      count.integer(1, patient).step();
      if (count.unsigned_at(0) >= kMaxProfiles)
        return Error{ErrorKind::wrong_state, "a patient has at most " + std::to_string(kMaxProfiles) + " profiles", {}};
    }
    ProfileInfo made{
        .id = 0, .patient_id = patient, .name = name, .version = 1, .utc_ns = utc_ns, .actor = actor, .settings = settings, .tag = {}};
    {
      Statement row(handle, "INSERT INTO profiles (patient_id, name) VALUES (?1, ?2) RETURNING id");
      row.integer(1, patient).text(2, std::string_view(name)).step();
      made.id = row.integer_at(0);
    }
    write_version(handle, made, actor);
    Statement(handle, "UPDATE patients SET registered = 1 WHERE id = ?1").integer(1, patient).run();
    made = profile_row(handle, made.id).value();
    transaction.commit();
    return made;
  });
}

Result<ProfileInfo> ProfileStore::change(std::int64_t profile, const ProfilePatch& patch, std::int64_t utc_ns,
                                         const std::optional<Actor>& actor, const std::string& expected) {
  if (patch.name)
    if (Status checked = check_name(*patch.name); !checked) return checked.error();
  return guarded([&]() -> Result<ProfileInfo> {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    auto row = profile_row(handle, profile);
    if (!row) return no_such_profile(profile);
    if (Status same = check_tag(expected, row->tag); !same) return same.error();
    if (patch.name) {
      if (name_used(handle, row->patient_id, *patch.name, profile)) return name_taken();
      Statement(handle, "UPDATE profiles SET name = ?2 WHERE id = ?1").integer(1, profile).text(2, std::string_view(*patch.name)).run();
    }
    if (patch.settings) {
      if (row->version >= static_cast<std::int64_t>(kMaxProfileVersions))
        return Error{
            ErrorKind::wrong_state, "a profile has at most " + std::to_string(kMaxProfileVersions) + " versions: make a new one", {}};
      row->settings = *patch.settings;
      row->utc_ns = utc_ns;
      ++row->version;
      write_version(handle, *row, actor);
    }
    row = profile_row(handle, profile);
    transaction.commit();
    return row.value();
  });
}

Status ProfileStore::remove(std::int64_t profile, const std::string& expected) {
  return guarded([&]() -> Status {
    sqlite3* handle = database_->handle();
    Transaction transaction(handle, Transaction::Kind::write);
    const auto row = profile_row(handle, profile);
    if (!row) return no_such_profile(profile);
    if (Status same = check_tag(expected, row->tag); !same) return same;
    Statement(handle, "DELETE FROM profiles WHERE id = ?1").integer(1, profile).run();
    transaction.commit();
    return {};
  });
}

}  // namespace hoist::db
