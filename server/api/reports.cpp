// Reports for print: of a session, and of the sessions of a visit.
#include "db/report/batch.hpp"

#include <memory>

#include "control/contract/program_version.hpp"
#include "db/store/visits.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/api/trend_reading.hpp"

namespace hoist::server::api {

namespace {

// False: the call has failed.
bool read_options(const CallPtr& call, db::ReportOptions& options) {
  options.program = contract::program_version();
  const auto kind = db::find_report_kind(query(*call, "kind").value_or("full"));
  const auto language = db::find_language(query(*call, "language").value_or("en"));
  if (!kind) call->fail(bad_query("kind", "must be patient or full", {}, {}));
  if (kind && !language) call->fail(bad_query("language", "must be en or de", {}, {}));
  if (!kind || !language) return false;
  options.kind = *kind;
  options.language = *language;
  return true;
}

Response page_response(std::string page, const std::string& name) {
  Response response;
  response.content_type = "text/html; charset=utf-8";
  response.set("Content-Security-Policy", std::string(db::kReportPolicy));
  // Shown, so that the browser can print it; saved under this name.
  response.set("Content-Disposition", "inline; filename=\"" + name + ".html\"");
  response.body = std::move(page);
  return response;
}

struct SessionWork {
  db::ReportSession of;
  std::vector<db::TrendSession> trend;
};
using SessionRead = db::Result<std::shared_ptr<SessionWork>>;

SessionRead read_session(Records& records, db::SessionId id) {
  const auto database = database_for_piece(records);
  if (!database) return database.error();
  auto of = db::read_report_session(**database, id);
  if (!of) return of.error();
  auto trend = db::report_trend(**database, of->session);
  if (!trend) return trend.error();
  return std::make_shared<SessionWork>(SessionWork{std::move(*of), std::move(*trend)});
}

// The sessions of a visit, read one after the other.
struct VisitWork {
  std::int64_t visit = 0;
  std::vector<db::SessionId> sessions;
  db::ReportOptions options;
  std::size_t next = 0;
  std::vector<db::ReportSession> read = {};
};
using VisitRead = db::Result<std::optional<db::ReportSession>>;

void go_on(const CallPtr& call, const std::shared_ptr<VisitWork>& work) {
  if (work->next == work->sessions.size())
    return call->respond(page_response(db::group_report(work->read, work->options), "hoist_report_visit_" + std::to_string(work->visit)));
  const auto read = [id = work->sessions[work->next++]](Records& records) -> VisitRead {
    const auto database = database_for_piece(records);
    if (!database) return database.error();
    auto session = db::read_report_session(**database, id);
    if (session) return std::optional(std::move(*session));
    // Deleted meanwhile, or still being recorded: not of this report.
    using enum db::ErrorKind;
    if (session.error().kind == not_found || session.error().kind == wrong_state) return std::optional<db::ReportSession>{};
    return session.error();
  };
  ask_recorder<VisitRead>(call, read, [call, work](VisitRead session) {
    if (!session) return call->respond(store_error(session.error(), call->request.path));
    if (*session) work->read.push_back(std::move(**session));
    go_on(call, work);
  });
}

}  // namespace

void get_session_report(const CallPtr& call) {
  const auto id = path_id(call, "session");
  db::ReportOptions options;
  if (!id || !read_options(call, options)) return;
  const auto read = [id = *id](Records& records) { return read_session(records, id); };
  ask_recorder<SessionRead>(call, read, [call, options, id = *id](SessionRead work) {
    if (!work) return call->respond(store_error(work.error(), call->request.path));
    auto sessions = std::move((*work)->trend);
    read_trend(call, std::move(sessions), [call, options, id, work = *work](const std::vector<db::TrendEntry>& trend) {
      with_database(call, [work, trend, options, id, path = call->request.path](db::Database& database) -> Response {
        auto page = db::session_report(database, work->of, trend, options);
        return page ? page_response(std::move(*page), "hoist_report_" + std::to_string(id)) : store_error(page.error(), path);
      });
    });
  });
}

void get_visit_report(const CallPtr& call) {
  const auto id = path_id(call, "visit");
  db::ReportOptions options;
  if (!id || !read_options(call, options)) return;
  using Visit = db::Result<db::VisitInfo>;
  const auto read = [id = *id](Records& records) -> Visit {
    const auto database = database_for_piece(records);
    return database ? db::VisitReader(**database).visit(id) : Visit(database.error());
  };
  ask_recorder<Visit>(call, read, [call, options, id = *id](Visit visit) {
    if (!visit) return call->respond(store_error(visit.error(), call->request.path));
    go_on(call, std::make_shared<VisitWork>(VisitWork{.visit = id, .sessions = visit->sessions, .options = options}));
  });
}

}  // namespace hoist::server::api
