// Own lines on the floor: /lines.
#include <nlohmann/json.hpp>

#include "db/store/lines.hpp"
#include "server/actions/lines.hpp"
#include "server/api/answers.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
LineWish line_wish(const Call& call) {
  const json& name = field(call, "name");
  return {.name = name.is_string() ? std::optional(name.get<std::string>()) : std::nullopt, .exercise = field(call, "exercise")};
}
}  // namespace

void list_lines(const CallPtr& call) {
  db::VisitQuery wanted;
  if (!read_page(call, wanted)) return;
  with_database(call, [wanted, path = call->request.path](db::Database& database) -> Response {
    const auto page = db::LineStore(database).list(wanted);
    return page ? rows_response(*page, line_json) : store_error(page.error(), path);
  });
}

void create_line(const CallPtr& call) {
  act_create_line(call->services, asker_of(*call), line_wish(*call), answer_created(call, "/api/v1/lines/"));
}

void get_line(const CallPtr& call) {
  const auto id = path_id(call, "line");
  if (!id) return;
  with_database(call, [id = *id, path = call->request.path](db::Database& database) -> Response {
    const auto line = db::LineStore(database).get(id);
    return line ? row_response(line_json(*line)) : store_error(line.error(), path);
  });
}

void change_line(const CallPtr& call) {
  if (const auto id = path_id(call, "line"))
    act_change_line(call->services, asker_of(*call), *id, line_wish(*call), given_tag(*call), answer_row(call));
}

void delete_line(const CallPtr& call) {
  if (const auto id = path_id(call, "line")) act_delete_line(call->services, asker_of(*call), *id, given_tag(*call), answer_gone(call));
}

}  // namespace hoist::server::api
