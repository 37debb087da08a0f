// What a client may do with patients, their visits and their profiles. A change carries the tag of what it was made for (db/store/edit_tag.hpp);
// empty = any state. `Outcome::row` is the row as it is afterwards.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "db/store/patients.hpp"
#include "db/store/profiles.hpp"
#include "server/actions/actions.hpp"

namespace hoist::server {

void act_create_patient(Services& services, const Asker& asker, std::string code, OutcomeDone done);
void act_change_patient(Services& services, const Asker& asker, std::int64_t patient, db::PatientPatch patch, std::string tag,
                        OutcomeDone done);
// With sessions, visits, profiles and identity, one session at a time, so that recording goes on between them. What fails half-way is gone on
// with by asking again.
void act_delete_patient(Services& services, const Asker& asker, std::int64_t patient, std::string tag, OutcomeDone done);
// Nothing: takes the identity away.
void act_set_identity(Services& services, const Asker& asker, std::int64_t patient, std::optional<db::Identity> identity, std::string tag,
                      OutcomeDone done);
void act_note_visit(Services& services, const Asker& asker, std::int64_t visit, std::string note, std::string tag, OutcomeDone done);
// The patient whom the next motion is recorded for, for all screens; null: none. Refused while a motion is under way.
void act_choose_patient(Services& services, const Asker& asker, const nlohmann::json& patient, OutcomeDone done);

// `settings` null: what is in force. Parameters that only an engineer may change are in no profile.
void act_create_profile(Services& services, const Asker& asker, std::int64_t patient, std::string name, const nlohmann::json& settings,
                        OutcomeDone done);
struct ProfileWish {
  std::optional<std::string> name;
  const nlohmann::json& settings;  // null: as they are
  bool from_in_force = false;      // saves what is in force
};
void act_change_profile(Services& services, const Asker& asker, std::int64_t profile, const ProfileWish& wish, std::string tag,
                        OutcomeDone done);
void act_delete_profile(Services& services, const Asker& asker, std::int64_t profile, std::string tag, OutcomeDone done);
// All or nothing, at standstill; `version` of the parameters that were looked at.
void act_apply_profile(Services& services, const Asker& asker, std::int64_t profile, std::uint32_t version, OutcomeDone done);

}  // namespace hoist::server
