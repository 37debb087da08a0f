// /patients, /visits and the chosen patient. Reading runs on the recorder's thread; every change is an action.
#include <nlohmann/json.hpp>

#include "db/store/patients.hpp"
#include "server/actions/patients.hpp"
#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

void list_visits(const CallPtr& call) {
  db::VisitQuery wanted;
  if (!read_page(call, wanted) || !read_id(call, "patient", wanted.patient_id)) return;
  wanted.day = query(*call, "day");
  with_database(call, [wanted, path = call->request.path](db::Database& database) -> Response {
    const auto page = db::VisitReader(database).visits(wanted);
    return page ? rows_response(*page, visit_json) : store_error(page.error(), path);
  });
}

void get_visit(const CallPtr& call) {
  const auto id = path_id(call, "visit");
  if (!id) return;
  with_database(call, [id = *id, path = call->request.path](db::Database& database) -> Response {
    const auto visit = db::VisitReader(database).visit(id);
    return visit ? row_response(visit_json(*visit)) : store_error(visit.error(), path);
  });
}

void change_visit(const CallPtr& call) {
  const auto id = path_id(call, "visit");
  if (!id) return;
  act_note_visit(call->services, asker_of(*call), *id, field(*call, "note").get<std::string>(), given_tag(*call), answer_row(call));
}

void list_patients(const CallPtr& call) {
  db::VisitQuery wanted;
  if (!read_page(call, wanted)) return;
  if (const auto part = query(*call, "q"); part && !part->empty()) wanted.code_part = *part;
  if (const auto archived = query(*call, "archived")) {
    if (*archived != "0" && *archived != "1") return call->fail(bad_query("archived", "must be 0 or 1", 0, 1));
    wanted.archived = *archived == "1";
  }
  with_database(call, [wanted, path = call->request.path](db::Database& database) -> Response {
    const auto page = db::VisitReader(database).patients(wanted);
    return page ? rows_response(*page, patient_json) : store_error(page.error(), path);
  });
}

void create_patient(const CallPtr& call) {
  act_create_patient(call->services, asker_of(*call), field(*call, "code").get<std::string>(), answer_created(call, "/api/v1/patients/"));
}

void get_patient(const CallPtr& call) {
  const auto id = path_id(call, "patient");
  if (!id) return;
  with_database(call, [id = *id, path = call->request.path](db::Database& database) -> Response {
    const auto patient = db::PatientStore(database).get(id);
    return patient ? row_response(patient_json(*patient)) : store_error(patient.error(), path);
  });
}

void change_patient(const CallPtr& call) {
  const auto id = path_id(call, "patient");
  if (!id) return;
  db::PatientPatch patch;
  if (const json& code = field(*call, "code"); code.is_string()) patch.code = code.get<std::string>();
  if (const json& archived = field(*call, "archived"); archived.is_boolean()) patch.archived = archived.get<bool>();
  act_change_patient(call->services, asker_of(*call), *id, patch, given_tag(*call), answer_row(call));
}

void delete_patient(const CallPtr& call) {
  const auto id = path_id(call, "patient");
  if (!id) return;
  act_delete_patient(call->services, asker_of(*call), *id, given_tag(*call), answer_gone(call));
}

void get_identity(const CallPtr& call) {
  const auto id = path_id(call, "patient");
  if (!id) return;
  with_database(call, [id = *id, path = call->request.path](db::Database& database) -> Response {
    const auto told = db::PatientStore(database).identity(id);
    if (!told) return store_error(told.error(), path);
    json person = nullptr;
    if (told->identity)
      person = {{"name", told->identity->name},
                {"birth_date", told->identity->birth_date ? json(*told->identity->birth_date) : json(nullptr)},
                {"note", told->identity->note}};
    return row_response({{"state", db::identity_state_name(told->state)}, {"identity", std::move(person)}, {"etag", told->tag}});
  });
}

void put_identity(const CallPtr& call) {
  const auto id = path_id(call, "patient");
  if (!id) return;
  db::Identity identity;
  identity.name = field(*call, "name").get<std::string>();
  if (const json& day = field(*call, "birth_date"); day.is_string()) identity.birth_date = day.get<std::string>();
  if (const json& note = field(*call, "note"); note.is_string()) identity.note = note.get<std::string>();
  act_set_identity(call->services, asker_of(*call), *id, std::move(identity), given_tag(*call), answer_row(call));
}

void delete_identity(const CallPtr& call) {
  const auto id = path_id(call, "patient");
  if (!id) return;
  act_set_identity(call->services, asker_of(*call), *id, std::nullopt, given_tag(*call), answer_row(call));
}

void get_chosen_patient(const CallPtr& call) { call->respond(chosen_patient_json(call->services.state)); }

void choose_patient(const CallPtr& call) {
  act_choose_patient(call->services, asker_of(*call), field(*call, "patient"),
                     answer_with(call, [call](const Outcome&) { call->respond(chosen_patient_json(call->services.state)); }));
}

}  // namespace hoist::server::api
