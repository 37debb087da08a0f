// /studies: the paper's experiment as virtual subjects have walked it here.
#include "db/store/studies.hpp"

#include <nlohmann/json.hpp>

#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
json study_json(const db::StudyRow& study) {
  const json report = json::parse(study.report);
  return {{"id", study.id},
          {"made_utc_ms", study.made_utc_ns / 1'000'000},
          {"title", report.at("title")},
          {"subjects", report.at("subjects")},
          {"seed", report.at("seed")},
          {"sessions", study.sessions.size()}};
}
}  // namespace

void list_studies(const CallPtr& call) {
  ListPage page;
  if (!read_page(call, page)) return;
  with_database(call, [page, path = call->request.path](db::Database& database) -> Response {
    const auto studies = db::list_studies(database, page.last, page.limit + 1);
    if (!studies) return store_error(studies.error(), path);
    return json_response(page_json(*studies, page.limit, study_json, [](const db::StudyRow& study) { return std::to_string(study.id); }));
  });
}

void get_study(const CallPtr& call) {
  const auto id = path_id(call, "study");
  if (!id) return;
  with_database(call, [id = *id, path = call->request.path](db::Database& database) -> Response {
    const auto study = db::read_study(database, id);
    if (!study) return store_error(study.error(), path);
    json sessions = json::array();
    for (const db::StudySession& one : study->sessions)
      sessions.push_back({{"session", one.session}, {"subject", one.subject}, {"run", one.run}});
    return json_response({{"id", study->id},
                          {"made_utc_ms", study->made_utc_ns / 1'000'000},
                          {"sessions", std::move(sessions)},
                          {"drawings", study->drawings},
                          {"report", json::parse(study->report)}});
  });
}

void get_study_drawing(const CallPtr& call) {
  const auto id = path_id(call, "study");
  if (!id) return;
  with_database(call, [id = *id, name = call->path_values.at(1), path = call->request.path](db::Database& database) -> Response {
    auto svg = db::study_drawing(database, id, name);
    if (!svg) return store_error(svg.error(), path);
    Response response;
    response.content_type = "image/svg+xml";
    response.body = std::move(*svg);
    return response;
  });
}

}  // namespace hoist::server::api
