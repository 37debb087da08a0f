// /sessions: recorded sessions, their columns, figures, markers and exports. All of it runs on the recorder's thread.
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "control/contract/faults.hpp"
#include "db/advice/tuning.hpp"
#include "db/advice/tuning_json.hpp"
#include "db/export/session_export.hpp"
#include "db/store/markers.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/visits.hpp"
#include "db/summary/provenance.hpp"
#include "db/summary/session_json.hpp"
#include "server/actions/records.hpp"
#include "server/api/answers.hpp"
#include "server/api/files.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/api/pieces.hpp"
#include "server/state/exercise.hpp"
#include "server/state/views.hpp"
#include "server/text/json_writer.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
constexpr std::size_t kColumnLimit = 32;
constexpr std::size_t kDefaultPoints = 1000;

// Of a session without a patient code: null.
json visit_of(const std::map<db::SessionId, db::Visit>& visits, db::SessionId session) {
  const auto at = visits.find(session);
  if (at == visits.end()) return nullptr;
  return {{"id", at->second.id}, {"patient", at->second.patient_id}, {"day", at->second.day}};
}

// What one session's page tells beyond the list.
db::Result<json> whole_session(db::Database& database, db::SessionId id) {
  const db::SessionReader reader(database);
  const auto session = reader.get(id);
  if (!session) return session.error();
  const auto nodes = reader.node_programs(id);
  if (!nodes) return nodes.error();
  const auto visits = db::VisitReader(database).of_sessions(std::span(&id, 1));
  if (!visits) return visits.error();
  json told = db::session_json(*session);
  told["etag"] = session->tag;
  told["visit"] = visit_of(*visits, id);
  told["nodes"] = db::node_programs_json(*nodes);
  return told;
}

// The session of {id}; an id that is no number is no session.
std::optional<db::SessionId> session_id(const CallPtr& call) {
  const auto id = number<db::SessionId>(call->path_values.at(0));
  if (!id || *id <= 0) {
    call->fail({.status = 404, .name = "unknown", .title = "There is no such session", .detail = "GET /api/v1/sessions lists them."});
    return std::nullopt;
  }
  return id;
}
}  // namespace

void list_sessions(const CallPtr& call) {
  db::SessionQuery wanted;
  if (!read_page(call, wanted) || !read_id(call, "patient", wanted.patient)) return;
  if (const auto subject = query(*call, "q"); subject && !subject->empty()) wanted.subject = *subject;
  if (const auto standby = query(*call, "standby")) {
    if (*standby != "0" && *standby != "1") return call->fail(bad_query("standby", "must be 0 or 1", 0, 1));
    wanted.standby = *standby == "1";
  }
  with_database(call, [wanted, path = call->request.path](db::Database& database) -> Response {
    const auto page = db::SessionReader(database).list(wanted);
    if (!page) return store_error(page.error(), path);
    std::vector<db::SessionId> ids;
    for (const db::SessionInfo& s : page->sessions) ids.push_back(s.id);
    const auto visits = db::VisitReader(database).of_sessions(ids);
    if (!visits) return store_error(visits.error(), path);
    json items = json::array();
    for (const db::SessionInfo& s : page->sessions) {
      items.push_back(db::session_json(s));
      items.back()["etag"] = s.tag;
      items.back()["visit"] = visit_of(*visits, s.id);
    }
    return json_response({{"items", std::move(items)}, {"next", next_json(page->next)}, {"total", page->total}});
  });
}

namespace {
void respond_session(const CallPtr& call, db::SessionId id) {
  with_database(call, [id, path = call->request.path](db::Database& database) -> Response {
    const auto session = whole_session(database, id);
    return session ? row_response(*session) : store_error(session.error(), path);
  });
}
}  // namespace

void get_session(const CallPtr& call) {
  if (const auto id = session_id(call)) respond_session(call, *id);
}

void change_session(const CallPtr& call) {
  const auto id = session_id(call);
  if (!id) return;
  db::SessionPatch patch;
  std::vector<FieldError> errors;
  const json& body = *call->body;
  if (const auto note = body.find("note"); note != body.end()) patch.note = note->get<std::string>();
  if (const auto subject = body.find("subject"); subject != body.end())
    patch.subject = subject->is_null() ? std::optional<std::string>{} : std::optional{subject->get<std::string>()};
  if (const auto told = body.find("exercise"); told != body.end())
    if (const auto exercise = read_exercise(*told, errors)) patch.exercise_json = stored_exercise(*exercise);
  if (!errors.empty()) {
    call->fail({.status = 422,
                .name = "invalid",
                .title = "A value cannot be used",
                .detail = "Nothing was changed.",
                .errors = std::move(errors)});
    return;
  }
  act_change_session(call->services, asker_of(*call), *id, std::move(patch), given_tag(*call),
                     answer_with(call, [call, id = *id](const Outcome&) { respond_session(call, id); }));
}

void delete_session(const CallPtr& call) {
  const auto id = session_id(call);
  if (!id) return;
  act_delete_session(call->services, asker_of(*call), *id, given_tag(*call), answer_gone(call));
}

namespace {
template <typename Value>
void write_list(JsonWriter& out, std::string_view name, const std::vector<Value>& values) {
  out.key(name).begin('[');
  for (const Value& value : values) out.value(value);
  out.end(']');
}

Response overview_response(const db::Overview& overview) {
  constexpr std::size_t kNumber_bytes = 20;
  JsonWriter out(overview.from_s.size() * (2 * overview.info.size() + 3) * kNumber_bytes);
  out.begin('{');
  write_list(out, "from_s", overview.from_s);
  write_list(out, "to_s", overview.to_s);
  write_list(out, "gap_before", overview.gap_before);
  out.key("columns").begin('[');
  for (std::size_t i = 0; i < overview.info.size(); ++i) {
    out.begin('{').field("name", overview.info[i].name).field("unit", overview.info[i].unit);
    write_list(out, "min", overview.min[i]);
    write_list(out, "max", overview.max[i]);
    out.end('}');
  }
  out.end(']').end('}');
  Response response;
  response.content_type = "application/json";
  response.body = out.take();
  return response;
}
}  // namespace

void get_samples(const CallPtr& call) {
  const auto id = session_id(call);
  if (!id) return;
  std::vector<std::string> names = db::column_names(query(*call, "columns").value_or(""));
  std::erase(names, "");
  if (names.empty() || names.size() > kColumnLimit)
    return call->fail(bad_query("columns", "must name 1 to 32 live values, separated by commas", 1, static_cast<double>(kColumnLimit)));
  std::size_t points = kDefaultPoints;
  if (const auto text = query(*call, "points")) {
    const auto value = number<std::size_t>(*text);
    if (!value || *value < 1 || *value > db::kMaxOverviewRuns)
      return call->fail(bad_query("points", "must be a whole number from 1 to " + std::to_string(db::kMaxOverviewRuns), 1,
                                  static_cast<double>(db::kMaxOverviewRuns)));
    points = *value;
  }
  db::TimeRange range;
  for (const char* name : {"from_s", "to_s"}) {
    const auto text = query(*call, name);
    if (!text) continue;
    const auto value = number<double>(*text);
    if (!value || !std::isfinite(*value)) return call->fail(bad_query(name, "must be a number", {}, {}));
    (name == std::string_view{"from_s"} ? range.from_s : range.to_s) = *value;
  }
  with_database(call, [id = *id, names, points, range, path = call->request.path](db::Database& database) -> Response {
    const auto overview = db::SessionReader(database).overview(id, names, points, range);
    if (!overview) return store_error(overview.error(), path);
    return overview_response(*overview);
  });
}

namespace {
json event_json(const db::StoredEvent& e, std::uint64_t start_time_ns) {
  return {{"number", e.number},
          {"time_s", (static_cast<double>(e.time_ns) - static_cast<double>(start_time_ns)) * 1e-9},
          {"tick", e.tick},
          {"kind", e.kind_name},
          {"name", e.name},
          {"code", e.code},
          {"item", e.item},
          {"bits", e.bits},
          {"value", e.value},
          {"before", e.before},
          {"actor", db::actor_json(e.actor)}};
}
json gap_json(const db::Gap& g, std::uint64_t /*start_time_ns*/) {
  return {{"number", g.number}, {"stream", g.stream}, {"from_tick", g.from_tick}, {"to_tick", g.to_tick}, {"reason", g.reason}};
}

// A page of a session's numbered rows. `read`: of the session, the rows of a part; `to_json`: a row, with the session's start.
template <typename Read, typename ToJson>
void respond_rows(const CallPtr& call, Read read, ToJson to_json) {
  const auto id = session_id(call);
  ListPage page;
  if (!id || !read_page(call, page)) return;
  with_database(call, [id = *id, page, read, to_json, path = call->request.path](db::Database& database) -> Response {
    const db::SessionReader reader(database);
    const auto session = reader.get(id);
    if (!session) return store_error(session.error(), path);
    const db::RowPart part{.after = page.last.value_or(-1), .limit = static_cast<std::int64_t>(page.limit) + 1};
    const auto rows = (reader.*read)(id, part);
    if (!rows) return store_error(rows.error(), path);
    return json_response(page_json(
        *rows, page.limit, [&](const auto& row) { return to_json(row, session->start_time_ns); },
        [](const auto& row) { return std::to_string(row.number); }));
  });
}
}  // namespace

void list_events(const CallPtr& call) { respond_rows(call, &db::SessionReader::events, event_json); }
void list_gaps(const CallPtr& call) { respond_rows(call, &db::SessionReader::gaps, gap_json); }

void get_metrics(const CallPtr& call) {
  const auto id = session_id(call);
  if (!id) return;
  read_in_pieces<db::FiguresReading>(call, *id, [call](const db::Result<json>& told) {
    call->respond(told ? json_response(*told) : store_error(told.error(), call->request.path));
  });
}

void get_tuning_advice(const CallPtr& call) {
  const auto id = session_id(call);
  if (!id) return;
  read_in_pieces<db::TuningReading>(call, *id, [call](const db::Result<db::TuningAdvice>& advice) {
    call->respond(advice ? json_response(db::tuning_json(*advice)) : store_error(advice.error(), call->request.path));
  });
}

namespace {
using PieceDone = std::function<void(PieceState, std::string)>;

// One piece per job, so that recording and other jobs go on between the pieces. A client would take an empty one for the end.
void next_piece(RecorderDesk& records, const RecorderDesk::ExportHandle& held, PieceDone done) {
  using Piece = std::pair<PieceState, std::string>;
  const auto next = [id = *held](Records& on_thread) -> Piece {
    std::string text;
    const auto more = on_thread.export_piece(id, text);
    return {!more ? PieceState::failed : *more ? PieceState::more : PieceState::last, std::move(text)};
  };
  const auto given = [&records, held, done](Piece piece) {
    if (piece.first == PieceState::more && piece.second.empty()) return next_piece(records, held, done);
    done(piece.first, std::move(piece.second));
  };
  if (!records.ask<Piece>(next, given)) done(PieceState::failed, "");
}
PieceSource pieces_of(RecorderDesk& records, RecorderDesk::ExportHandle held) {
  return [&records, held = std::move(held)](PieceDone done) { next_piece(records, held, std::move(done)); };
}
}  // namespace

namespace {
// A format that is made whole first: asked for piece by piece, so that recording goes on between the pieces.
struct WholeExport {
  RecorderDesk::ExportHandle held;
  Download download;
};
void make_whole(const CallPtr& call, WholeExport wanted) {
  using File = db::Result<std::shared_ptr<const db::SpoolFile>>;
  const auto make = [id = *wanted.held](Records& records) { return records.export_file(id); };
  ask_recorder<File>(call, make, [call, wanted = std::move(wanted)](File file) mutable {
    if (!file) return call->respond(store_error(file.error(), call->request.path));
    if (!*file) return make_whole(call, std::move(wanted));
    wanted.download.file = std::move(*file);
    respond_file(call, std::move(wanted.download));
  });
}

void send_export(const CallPtr& call, db::SessionId id, const db::ExportOptions& options) {
  struct Opened {
    Response response;
    ExportId id = 0;  // 0 = none: `response` says why
    std::string file_name = {}, etag = {};
  };
  const auto open = [id, options, path = call->request.path](Records& records) -> Opened {
    if (records.database() == nullptr) return {no_database(records.why(), path)};
    const auto opened = records.open_export(id, options);
    if (!opened) return {store_error(opened.error(), path)};
    Opened out{.response = {}, .id = opened->id, .file_name = opened->file_name, .etag = opened->etag};
    out.response.content_type = opened->content_type;
    out.response.set("Content-Disposition", "attachment; filename=\"" + opened->file_name + "\"");
    return out;
  };
  const bool whole = db::export_format_info(options.format).delivery == db::ExportDelivery::whole;
  ask_recorder<Opened>(call, open, [call, whole](Opened opened) {
    RecorderDesk& records = call->services.records;
    if (opened.id != 0 && whole)
      return make_whole(call, {records.hold(opened.id),
                               {.file = {},
                                .content_type = opened.response.content_type,
                                .file_name = std::move(opened.file_name),
                                .etag = std::move(opened.etag)}});
    if (opened.id != 0) opened.response.next_piece = pieces_of(records, records.hold(opened.id));
    call->respond(std::move(opened.response));
  });
}
}  // namespace

void export_session(const CallPtr& call) {
  const auto id = session_id(call);
  if (!id) return;
  const std::string format = query(*call, "format").value_or("csv");
  const auto wanted = db::find_export_format(format);
  if (!wanted) return call->fail(bad_query("format", "must be one of " + std::string(db::kExportFormatNames), {}, {}));
  db::ExportOptions options;
  options.format = *wanted;
  if (const auto names = query(*call, "columns")) options.columns = db::column_names(*names);
  for (const auto& [name, option] : {std::pair{"comments", &options.comments}, std::pair{"constant", &options.constant}}) {
    const auto text = query(*call, name);
    if (!text) continue;
    if (*text != "0" && *text != "1") return call->fail(bad_query(name, "must be 0 or 1", 0, 1));
    *option = *text == "1";
  }
  send_export(call, *id, options);
}

void export_mcap(const CallPtr& call) {
  const auto id = session_id(call);
  if (!id) return;
  db::ExportOptions options;
  options.format = db::ExportFormat::mcap;
  send_export(call, *id, options);
}

namespace {
// The marker of {id} and {number}.
std::optional<MarkerPlace> marker_place(const CallPtr& call) {
  const auto session = session_id(call);
  if (!session) return std::nullopt;
  const auto number = path_id(call, "marker", 1);
  return number ? std::optional(MarkerPlace{*session, *number}) : std::nullopt;
}
}  // namespace

void list_markers(const CallPtr& call) {
  const auto id = session_id(call);
  ListPage page;
  if (!id || !read_page(call, page)) return;
  with_database(call, [id = *id, page, path = call->request.path](db::Database& database) -> Response {
    const auto markers = db::MarkerStore(database).list(id, page.last.value_or(-1), page.limit + 1);
    if (!markers) return store_error(markers.error(), path);
    return json_response(page_json(
        *markers, page.limit, [id](const db::MarkerInfo& marker) { return marker_json(id, marker); },
        [](const db::MarkerInfo& marker) { return std::to_string(marker.number); }));
  });
}

void change_marker(const CallPtr& call) {
  const auto place = marker_place(call);
  if (!place) return;
  db::MarkerPatch patch;
  if (const json& text = field(*call, "text"); text.is_string()) patch.text = text.get<std::string>();
  if (const json& kind = field(*call, "kind"); kind.is_string()) patch.kind = kind.get<std::string>();
  if (const json& time = field(*call, "time_s"); time.is_number()) patch.time_s = time.get<double>();
  act_change_marker(call->services, asker_of(*call), *place, std::move(patch), given_tag(*call), answer_row(call));
}

void delete_marker(const CallPtr& call) {
  const auto place = marker_place(call);
  if (!place) return;
  act_delete_marker(call->services, asker_of(*call), *place, given_tag(*call), answer_gone(call));
}

void add_marker(const CallPtr& call) {
  const auto id = session_id(call);
  if (!id) return;
  act_mark(call->services, asker_of(*call), *id, marker_wish(*call->body), answer_with(call, [call](const Outcome&) {
             call->respond(json{{"ok", true}}, 201);
           }));
}

}  // namespace hoist::server::api
