// Patients as people manage them: their codes, their sealed identities, which of them are archived. Sessions and visits come by themselves
// (visits.hpp). A patient that a person has made or changed stays without a session; any other goes with its last one.
#pragma once
#include <cstdint>
#include <optional>
#include <string>

#include "db/store/database.hpp"
#include "db/store/edit_tag.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {

/// Longest fields of an identity, in bytes of UTF-8.
inline constexpr std::size_t kMaxPersonName_bytes = 200, kMaxPersonNote_bytes = 1000;

struct PatientPatch {
  std::optional<std::string> code;
  std::optional<bool> archived;
};

/// Who a patient is. Never leaves PatientStore::identity but to a therapist's or engineer's request.
struct Identity {
  std::string name;
  std::optional<std::string> birth_date;  ///< YYYY-MM-DD
  std::string note;
};
enum class IdentityState : std::uint8_t {
  none,         // nothing is stored
  readable,     //
  key_missing,  // FILE.key is not there, or is no key
  key_foreign,  // sealed with another key than that of FILE.key
  damaged,      // sealed with this key, and changed since
};
constexpr const char* identity_state_name(IdentityState state) {
  switch (state) {
    case IdentityState::none:
      return "none";
    case IdentityState::readable:
      return "readable";
    case IdentityState::key_missing:
      return "key_missing";
    case IdentityState::key_foreign:
      return "key_foreign";
    case IdentityState::damaged:
      break;
  }
  return "damaged";
}
struct IdentityTold {
  IdentityState state = IdentityState::none;
  std::optional<Identity> identity;  ///< when readable
  std::string tag;                   ///< of the patient
};

/// On any connection; each change is one transaction. `expected`: the tag of what the change was made for, empty = whatever there is. Errors:
/// not_found, changed, taken (code), bad_value, wrong_state, busy, disk_full.
class PatientStore {
 public:
  explicit PatientStore(Database& database) : database_(&database) {}
  Result<PatientInfo> get(std::int64_t patient) const;
  /// The code by the rule of patient_code.hpp.
  Result<PatientInfo> create(const std::string& typed);
  Result<PatientInfo> change(std::int64_t patient, const PatientPatch& patch, const std::string& expected);
  /// The code of a patient who is to be recorded: not an archived one. The row stays from now on.
  Result<std::string> choose(std::int64_t patient);
  /// The newest session; to delete them one by one before the patient.
  Result<std::optional<SessionId>> newest_session(std::int64_t patient) const;
  /// A patient without sessions, with identity and profiles, overwritten as SessionEditor::remove does. wrong_state while there are sessions.
  Status remove(std::int64_t patient, const std::string& expected);

  /// What people write about a visit; the tag is the visit's.
  Result<VisitInfo> note_visit(std::int64_t visit, const std::string& note, const std::string& expected);

  Result<IdentityTold> identity(std::int64_t patient) const;
  /// Seals it. The first one of a file makes the key; later ones need it.
  Result<PatientInfo> set_identity(std::int64_t patient, const Identity& identity, const std::string& expected);
  /// Needs no key.
  Result<PatientInfo> clear_identity(std::int64_t patient, const std::string& expected);

 private:
  Database* database_;
};

}  // namespace hoist::db
