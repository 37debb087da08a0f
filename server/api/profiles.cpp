// A patient's settings: /patients/{id}/profiles and /profiles.
#include <nlohmann/json.hpp>

#include "control/contract/params.hpp"
#include "db/store/profiles.hpp"
#include "server/actions/patients.hpp"
#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
// A page of `read(store, id, wanted)`.
template <typename Read>
void answer_page(const CallPtr& call, const char* thing, Read read) {
  const auto id = path_id(call, thing);
  db::VisitQuery wanted;
  if (!id || !read_page(call, wanted)) return;
  with_database(call, [id = *id, wanted, read, path = call->request.path](db::Database& database) -> Response {
    const auto page = read(db::ProfileStore(database), id, wanted);
    return page ? rows_response(*page, profile_json) : store_error(page.error(), path);
  });
}

// Each value of the profile beside the one in force; nothing in force: no core.
json difference(const db::ProfileInfo& profile, const std::optional<contract::ParamsInForce>& in_force) {
  json items = json::array();
  for (const auto& [name, value] : profile.settings) {
    const auto index = contract::find_param(name);
    const bool unusable = !index || contract::kParams[*index].role > contract::Role::therapist ||
                          contract::check_param(*index, value) != contract::ParamCheck::ok;
    const json now = index && in_force ? json(in_force->values[*index]) : json(nullptr);
    if (!unusable && now == value) continue;
    items.push_back({{"name", name}, {"profile", value}, {"in_force", now}, {"unusable", unusable}});
  }
  return {{"version", in_force ? json(in_force->version) : json(nullptr)}, {"items", std::move(items)}};
}
}  // namespace

void list_profiles(const CallPtr& call) {
  answer_page(call, "patient",
              [](const db::ProfileStore& store, std::int64_t id, const db::VisitQuery& wanted) { return store.list(id, wanted); });
}
void list_profile_versions(const CallPtr& call) {
  answer_page(call, "profile",
              [](const db::ProfileStore& store, std::int64_t id, const db::VisitQuery& wanted) { return store.versions(id, wanted); });
}

void create_profile(const CallPtr& call) {
  if (const auto id = path_id(call, "patient"))
    act_create_profile(call->services, asker_of(*call), *id, field(*call, "name").get<std::string>(), field(*call, "settings"),
                       answer_created(call, "/api/v1/profiles/"));
}

void get_profile(const CallPtr& call) {
  const auto id = path_id(call, "profile");
  if (!id) return;
  with_database(call, [id = *id, path = call->request.path](db::Database& database) -> Response {
    const auto profile = db::ProfileStore(database).get(id);
    return profile ? row_response(profile_json(*profile)) : store_error(profile.error(), path);
  });
}

void change_profile(const CallPtr& call) {
  const auto id = path_id(call, "profile");
  if (!id) return;
  const json& name = field(*call, "name");
  act_change_profile(call->services, asker_of(*call), *id,
                     {.name = name.is_string() ? std::optional(name.get<std::string>()) : std::nullopt,
                      .settings = field(*call, "settings"),
                      .from_in_force = field(*call, "from_in_force") == true},
                     given_tag(*call), answer_row(call));
}

void delete_profile(const CallPtr& call) {
  const auto id = path_id(call, "profile");
  if (!id) return;
  act_delete_profile(call->services, asker_of(*call), *id, given_tag(*call), answer_gone(call));
}

void diff_profile(const CallPtr& call) {
  const auto id = path_id(call, "profile");
  if (!id) return;
  const CoreDesk& core = call->services.core;
  const auto in_force = core.has_parameters() ? std::optional(core.parameters()) : std::nullopt;
  with_database(call, [id = *id, in_force, path = call->request.path](db::Database& database) -> Response {
    const auto profile = db::ProfileStore(database).get(id);
    return profile ? json_response(difference(*profile, in_force)) : store_error(profile.error(), path);
  });
}

void apply_profile(const CallPtr& call) {
  const auto id = path_id(call, "profile");
  if (!id) return;
  const auto version = field(*call, "version").get<std::uint32_t>();
  act_apply_profile(call->services, asker_of(*call), *id, version, [call](const Outcome& outcome) {
    if (outcome.refusals == std::vector<std::string>{"set_outdated"}) {
      Outcome outdated = outcome;
      outdated.kind = Outcome::Kind::outdated;
      return call->fail(problem_of(outdated));
    }
    if (!outcome.done()) return call->fail(problem_of(outcome));
    json values = json::object();
    for (std::size_t i = 0; i < contract::kParamCount; ++i)
      if (contract::kParams[i].role <= contract::Role::therapist)
        values[std::string{contract::kParams[i].name}] = call->services.core.parameters().values[i];
    call->respond(parameters_changed(call->services, std::move(values), outcome));
  });
}

}  // namespace hoist::server::api
