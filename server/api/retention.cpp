// /retention: how long sessions are kept.
#include "db/store/retention.hpp"

#include <nlohmann/json.hpp>

#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
Response rule_response(const db::RetentionRule& rule) {
  json row = db::rule_json(rule);
  row["etag"] = db::tag_of(rule);
  return row_response(row);
}
}  // namespace

void get_retention(const CallPtr& call) {
  with_database(call, [path = call->request.path](db::Database& database) {
    const auto rule = db::retention_rule(database);
    return rule ? rule_response(*rule) : store_error(rule.error(), path);
  });
}

void set_retention(const CallPtr& call) {
  const db::RetentionRule rule = db::rule_of(*call->body);
  act_set_retention(call->services, asker_of(*call), rule, given_tag(*call),
                    answer_with(call, [call, rule](const Outcome&) { call->respond(rule_response(rule)); }));
}

}  // namespace hoist::server::api
