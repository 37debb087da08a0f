// A patient's settings: parameters and values under a name, each saving a version of its own.
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/edit_tag.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {

inline constexpr std::size_t kMaxProfileName_bytes = 64;
/// Of one patient, and versions of one profile; more are refused.
inline constexpr std::size_t kMaxProfiles = 50, kMaxProfileVersions = 1000;

using ProfileSettings = std::map<std::string, double>;
struct ProfileInfo {
  std::int64_t id = 0, patient_id = 0;
  std::string name;
  std::int64_t version = 0;  ///< counts the savings
  std::int64_t utc_ns = 0;   ///< of the newest
  std::optional<Actor> actor;
  ProfileSettings settings;
  std::string tag;
};
struct ProfilePatch {
  std::optional<std::string> name;
  std::optional<ProfileSettings> settings;  ///< saves a new version
};

/// Errors: not_found, changed, taken (name), bad_value, wrong_state (too many), busy, disk_full.
class ProfileStore {
 public:
  explicit ProfileStore(Database& database) : database_(&database) {}
  /// Newest first.
  Result<VisitPage<ProfileInfo>> list(std::int64_t patient, const VisitQuery& query) const;
  Result<ProfileInfo> get(std::int64_t profile) const;
  /// Newest first; `next` is a version.
  Result<VisitPage<ProfileInfo>> versions(std::int64_t profile, const VisitQuery& query) const;
  Result<ProfileInfo> create(std::int64_t patient, const std::string& name, const ProfileSettings& settings, std::int64_t utc_ns,
                             const std::optional<Actor>& actor);
  Result<ProfileInfo> change(std::int64_t profile, const ProfilePatch& patch, std::int64_t utc_ns, const std::optional<Actor>& actor,
                             const std::string& expected);
  Status remove(std::int64_t profile, const std::string& expected);

 private:
  Database* database_;
};

}  // namespace hoist::db
