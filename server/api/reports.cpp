// Reports for print: of a session, and of the sessions of a visit.
#include "db/report/batch.hpp"

#include <memory>

#include "control/contract/program_version.hpp"
#include "db/store/visits.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/api/pieces.hpp"
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

// The sessions of a visit, read one after the other.
struct VisitWork {
  std::int64_t visit = 0;
  std::vector<db::SessionId> sessions;
  db::ReportOptions options;
  std::size_t next = 0;
  std::vector<db::ReportSession> read = {};
};

void go_on(const CallPtr& call, const std::shared_ptr<VisitWork>& work) {
  if (work->next == work->sessions.size())
    return call->respond(page_response(db::group_report(work->read, work->options), "hoist_report_visit_" + std::to_string(work->visit)));
  read_in_pieces<db::ReportReading>(call, work->sessions[work->next++], [call, work](const db::Result<db::ReportSession>& session) {
    // Deleted meanwhile, or still being recorded: not of this report.
    using enum db::ErrorKind;
    if (session) {
      work->read.push_back(*session);
    } else if (const db::Error& error = session.error(); error.kind != not_found && error.kind != wrong_state) {
      return call->respond(store_error(error, call->request.path));
    }
    go_on(call, work);
  });
}

void respond_report(const CallPtr& call, db::ReportSession session, const db::ReportOptions& options) {
  using Trend = db::Result<std::vector<db::TrendSession>>;
  const auto of = std::make_shared<const db::ReportSession>(std::move(session));
  const auto list = [of](Records& records) -> Trend {
    const auto database = database_for_piece(records);
    return database ? db::report_trend(**database, of->session) : Trend(database.error());
  };
  ask_recorder<Trend>(call, list, [call, options, of](Trend sessions) {
    if (!sessions) return call->respond(store_error(sessions.error(), call->request.path));
    read_trend(call, std::move(*sessions), [call, options, of](const std::vector<db::TrendEntry>& trend) {
      with_database(call, [of, trend, options, path = call->request.path](db::Database& database) -> Response {
        auto page = db::session_report(database, *of, trend, options);
        return page ? page_response(std::move(*page), "hoist_report_" + std::to_string(of->session.id)) : store_error(page.error(), path);
      });
    });
  });
}

}  // namespace

void get_session_report(const CallPtr& call) {
  const auto id = path_id(call, "session");
  db::ReportOptions options;
  if (!id || !read_options(call, options)) return;
  read_in_pieces<db::ReportReading>(call, *id, [call, options](db::Result<db::ReportSession> session) {
    if (!session) return call->respond(store_error(session.error(), call->request.path));
    respond_report(call, std::move(*session), options);
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
