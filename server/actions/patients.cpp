#include "server/actions/patients.hpp"

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "control/contract/params.hpp"
#include "db/store/session_reader.hpp"
#include "server/actions/common.hpp"
#include "server/state/views.hpp"

namespace hoist::server {

using contract::Role;
using nlohmann::json;

namespace {
// A changed row, or why it was not changed.
template <typename Row, typename ToJson>
Outcome row_outcome(const db::Result<Row>& row, ToJson to_json) {
  if (!row) return store_outcome(row.error());
  Outcome outcome;
  outcome.row = to_json(*row).dump();
  return outcome;
}
Outcome told(const db::Result<db::PatientInfo>& row) { return row_outcome(row, patient_json); }
Outcome told(const db::Result<db::ProfileInfo>& row) { return row_outcome(row, profile_json); }
Outcome told(const db::Result<db::VisitInfo>& row) { return row_outcome(row, visit_json); }

std::string numbered(const char* what, std::int64_t id) { return what + (" " + std::to_string(id)); }

Outcome refused(Reason reason, std::string detail) {
  Outcome outcome;
  outcome.kind = Outcome::Kind::refused;
  outcome.reason = reason;
  outcome.detail = std::move(detail);
  return outcome;
}

bool is_chosen(const Services& services, std::int64_t patient) {
  return services.state.patient() && services.state.patient()->id == patient;
}

bool led(const Services& services) {
  const auto& newest = services.core.newest();
  return newest && newest->mode < contract::kModes.size() && contract::kModes[newest->mode].moving;
}

Outcome not_standing() {
  Outcome outcome = refused(Reason::refused, "Only while the hoist stands: end the motion first.");
  outcome.refusals = refusal_names(contract::refusal_bit(contract::Refusal::not_standby));
  return outcome;
}
}  // namespace

void act_create_patient(Services& services, const Asker& asker, std::string code, OutcomeDone done) {
  if (!begin_action(services, asker, Action::create_patient, {}, done)) return;
  ask_store_for(
      services, [code = std::move(code)](Records&, db::Database& database) { return told(db::PatientStore(database).create(code)); },
      std::move(done));
}

void act_change_patient(Services& services, const Asker& asker, std::int64_t patient, db::PatientPatch patch, std::string tag,
                        OutcomeDone done) {
  if (!begin_action(services, asker, Action::change_patient, {numbered("patient", patient)}, done)) return;
  if (is_chosen(services, patient)) return done(refused(Reason::patient_chosen, "This patient is chosen for the hoist."));
  ask_store_for(
      services, [=](Records&, db::Database& database) { return told(db::PatientStore(database).change(patient, patch, tag)); },
      std::move(done));
}

namespace {
// Deletes the newest session, and the next one when that is done; the patient when none is left.
struct Deletion {
  std::int64_t patient = 0;
  std::string tag;
  std::shared_ptr<const void> jobs_held;
  OutcomeDone done;
};
constexpr const char* kGoesOn = "{}";  // the row of a step that leaves more to delete

void delete_next(Services& services, const std::shared_ptr<Deletion>& deletion) {
  const auto work = [patient = deletion->patient, tag = deletion->tag](Records&, db::Database& database) -> Outcome {
    db::PatientStore store(database);
    const auto before = store.get(patient);
    if (!before) return store_outcome(before.error());
    if (const db::Status same = db::check_tag(tag, before->tag); !same) return store_outcome(same.error());
    const auto session = store.newest_session(patient);
    if (!session) return store_outcome(session.error());
    Outcome outcome;
    const db::Status removed = *session ? db::SessionEditor(database).remove(**session) : store.remove(patient, tag);
    if (!removed) return store_outcome(removed.error());
    if (*session) outcome.row = kGoesOn;
    // A patient who was only a code in sessions went with the last of them.
    if (*session && !store.get(patient)) outcome.row.clear();
    return outcome;
  };
  ask_store_for(services, work, [&services, deletion](const Outcome& outcome) {
    if (outcome.done()) services.jobs.forget_recordings();
    if (outcome.done() && outcome.row == kGoesOn)
      delete_next(services, deletion);
    else
      deletion->done(outcome);
  });
}
}  // namespace

void act_delete_patient(Services& services, const Asker& asker, std::int64_t patient, std::string tag, OutcomeDone done) {
  if (!begin_action(services, asker, Action::delete_patient, {numbered("patient", patient)}, done)) return;
  if (is_chosen(services, patient)) return done(refused(Reason::patient_chosen, "This patient is chosen for the hoist."));
  delete_next(services, std::make_shared<Deletion>(Deletion{patient, std::move(tag), services.jobs.hold(), std::move(done)}));
}

void act_set_identity(Services& services, const Asker& asker, std::int64_t patient, std::optional<db::Identity> identity, std::string tag,
                      OutcomeDone done) {
  if (!begin_action(services, asker, identity ? Action::set_identity : Action::delete_identity, {numbered("patient", patient)}, done))
    return;
  ask_store_for(
      services,
      [patient, identity = std::move(identity), tag = std::move(tag)](Records&, db::Database& database) {
        db::PatientStore store(database);
        const auto changed = identity ? store.set_identity(patient, *identity, tag) : store.clear_identity(patient, tag);
        Outcome outcome = told(changed);
        if (!changed && changed.error().field == "key") outcome.reason = Reason::identity_key;
        return outcome;
      },
      std::move(done));
}

void act_note_visit(Services& services, const Asker& asker, std::int64_t visit, std::string note, std::string tag, OutcomeDone done) {
  if (!begin_action(services, asker, Action::change_visit, {numbered("visit", visit)}, done)) return;
  ask_store_for(
      services, [=](Records&, db::Database& database) { return told(db::PatientStore(database).note_visit(visit, note, tag)); },
      std::move(done));
}

void act_choose_patient(Services& services, const Asker& asker, const json& patient, OutcomeDone done) {
  if (!begin_action(services, asker, Action::choose_patient,
                    {patient.is_number_unsigned() ? numbered("patient", patient.get<std::int64_t>()) : "nobody"}, done))
    return;
  if (led(services)) return done(not_standing());
  if (patient.is_null()) {
    services.state.choose_patient(std::nullopt);
    return done({});
  }
  if (!patient.is_number_unsigned()) {
    Outcome outcome;
    outcome.kind = Outcome::Kind::invalid;
    outcome.detail = "There is no such patient.";
    outcome.errors.push_back({"patient", "must be the id of a patient"});
    return done(outcome);
  }
  const auto id = patient.get<std::int64_t>();
  const std::uint64_t file = services.recorder.file();
  const auto work = [id](Records&, db::Database& database) {
    const auto code = db::PatientStore(database).choose(id);
    if (!code) return store_outcome(code.error());
    Outcome outcome;
    outcome.row = *code;
    return outcome;
  };
  ask_store_for(services, work, [&services, id, file, done = std::move(done)](const Outcome& outcome) {
    // Motion may have begun meanwhile.
    if (outcome.done() && led(services)) return done(not_standing());
    if (outcome.done()) services.state.choose_patient(ChosenPatient{id, outcome.row, file});
    done(outcome);
  });
}

namespace {
// The therapist's parameters as they are in force.
db::ProfileSettings in_force(const Services& services) {
  db::ProfileSettings settings;
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    if (contract::kParams[i].role <= Role::therapist) settings.emplace(contract::kParams[i].name, services.core.parameters().values[i]);
  return settings;
}

// Named parameters of the therapist, each within its range; else `errors` says which is not.
db::ProfileSettings read_settings(const json& values, std::vector<FieldError>& errors) {
  db::ProfileSettings settings;
  for (const auto& [name, value] : values.items()) {
    const auto index = contract::find_param(name);
    if (!index) {
      errors.push_back({name, "There is no such parameter."});
      continue;
    }
    const contract::ParamInfo& p = contract::kParams[*index];
    if (p.role > Role::therapist)
      errors.push_back({name, "belongs to the hoist, not to a patient"});
    else if (!value.is_number() || contract::check_param(*index, value.get<double>()) != contract::ParamCheck::ok)
      errors.push_back({name, "is outside its range", value.is_number() ? std::optional(value.get<double>()) : std::nullopt, p.min, p.max});
    else
      settings.emplace(name, value.get<double>());
  }
  return settings;
}

// The settings to store; nothing when `done` has been told why not.
std::optional<db::ProfileSettings> wanted_settings(Services& services, const json& values, const OutcomeDone& done) {
  Outcome outcome;
  if (values.is_null()) {
    if (services.core.has_parameters()) return in_force(services);
    outcome.kind = Outcome::Kind::unreachable;
    outcome.detail = "The control core is not connected: nothing is in force.";
    done(outcome);
    return std::nullopt;
  }
  db::ProfileSettings settings = read_settings(values, outcome.errors);
  if (outcome.errors.empty() && !settings.empty()) return settings;
  if (outcome.errors.empty()) outcome.errors.push_back({"settings", "must name at least one parameter"});
  outcome.kind = Outcome::Kind::invalid;
  outcome.detail = "The settings cannot be used; nothing was saved.";
  done(outcome);
  return std::nullopt;
}
}  // namespace

void act_create_profile(Services& services, const Asker& asker, std::int64_t patient, std::string name, const json& settings,
                        OutcomeDone done) {
  if (!begin_action(services, asker, Action::create_profile, {numbered("patient", patient)}, done)) return;
  const auto wanted = wanted_settings(services, settings, done);
  if (!wanted) return;
  const auto work = [=, settings = *wanted, utc_ns = services.utc_ns(), actor = services.actors.find(asker.client)](
                        Records&, db::Database& database) {
    return told(db::ProfileStore(database).create(patient, name, settings, utc_ns, actor));
  };
  ask_store_for(services, work, std::move(done));
}

void act_change_profile(Services& services, const Asker& asker, std::int64_t profile, const ProfileWish& wish, std::string tag,
                        OutcomeDone done) {
  if (!begin_action(services, asker, Action::change_profile, {numbered("profile", profile)}, done)) return;
  db::ProfilePatch patch{.name = wish.name, .settings = {}};
  if (wish.from_in_force || !wish.settings.is_null()) {
    patch.settings = wanted_settings(services, wish.from_in_force ? json() : wish.settings, done);
    if (!patch.settings) return;
  }
  const auto work = [=, utc_ns = services.utc_ns(), actor = services.actors.find(asker.client)](Records&, db::Database& database) {
    return told(db::ProfileStore(database).change(profile, patch, utc_ns, actor, tag));
  };
  ask_store_for(services, work, std::move(done));
}

void act_delete_profile(Services& services, const Asker& asker, std::int64_t profile, std::string tag, OutcomeDone done) {
  if (!begin_action(services, asker, Action::delete_profile, {numbered("profile", profile)}, done)) return;
  ask_store(
      services, [=](Records&, db::Database& database) { return db::ProfileStore(database).remove(profile, tag); }, std::move(done));
}

void act_apply_profile(Services& services, const Asker& asker, std::int64_t profile, std::uint32_t version, OutcomeDone done) {
  if (!begin_action(services, asker, Action::apply_profile, {numbered("profile", profile)}, done)) return;
  if (led(services)) return done(not_standing());
  const auto work = [profile](Records&, db::Database& database) { return told(db::ProfileStore(database).get(profile)); };
  ask_store_for(services, work, [&services, asker, version, done = std::move(done)](const Outcome& outcome) {
    if (!outcome.done()) return done(outcome);
    if (led(services)) return done(not_standing());
    // Held against today's table: a profile may be older than it.
    Outcome invalid;
    const json row = json::parse(outcome.row);
    const db::ProfileSettings settings = read_settings(row.at("settings"), invalid.errors);
    if (!invalid.errors.empty()) {
      invalid.kind = Outcome::Kind::invalid;
      invalid.detail = "The profile does not fit this software; nothing was changed.";
      return done(invalid);
    }
    ValueSet set{.rows = {}, .version = version, .origin = {"profile", row.at("name").get<std::string>()}};
    for (const auto& [name, value] : settings) set.rows.emplace_back(contract::kParams[*contract::find_param(name)].id, value);
    set_values(services, asker, std::move(set), done);
  });
}

}  // namespace hoist::server
