// /retention: how long sessions are kept.
#include "db/store/retention.hpp"

#include <nlohmann/json.hpp>

#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
json retention_json(const db::Retention& setting) {
  return {{"months", setting.months ? json(*setting.months) : json(nullptr)}, {"needs_backup", setting.needs_backup}};
}
}  // namespace

void get_retention(const CallPtr& call) {
  in_background(call, [path = call->request.path](Records& records) {
    db::Database* database = records.database();
    if (database == nullptr) return no_database(records.why(), path);
    const auto setting = db::retention(*database);
    return setting ? json_response(retention_json(*setting)) : store_error(setting.error(), path);
  });
}

void set_retention(const CallPtr& call) {
  const json& body = *call->body;
  db::Retention wish{.months = {}, .needs_backup = body.at("needs_backup").get<bool>()};
  if (const json& months = body.at("months"); !months.is_null()) wish.months = months.get<std::int64_t>();
  act_set_retention(call->services, asker_of(*call), wish,
                    answer_with(call, [call, wish](const Outcome&) { call->respond(retention_json(wish)); }));
}

}  // namespace hoist::server::api
