// /jobs: long work on the database, its progress and its end.
#include <charconv>
#include <nlohmann/json.hpp>
#include <utility>

#include "server/api/answers.hpp"
#include "server/api/files.hpp"
#include "server/api/handlers.hpp"
#include "server/api/lists.hpp"
#include "server/state/views.hpp"

namespace hoist::server::api {

using nlohmann::json;

namespace {
// The job of {id}; nothing after a refusal.
std::optional<JobInfo> job_of(const CallPtr& call) {
  const std::string& text = call->path_values.at(0);
  JobId id = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), id);
  auto info = code == std::errc{} && end == text.data() + text.size() ? call->services.jobs.find(id) : std::nullopt;
  if (!info) call->fail({.status = 404, .name = "unknown", .title = "There is no such job", .detail = "GET /api/v1/jobs lists them."});
  return info;
}

json whole_job(const JobInfo& info) {
  json told = job_json(info);
  told["result"] = info.result ? json::parse(*info.result) : json(nullptr);
  return told;
}

void respond_accepted(const CallPtr& call, JobId id) {
  const auto info = call->services.jobs.find(id);
  if (!info) return;
  Response response = json_response(whole_job(*info), 202);
  response.set("Location", "/api/v1/jobs/" + std::to_string(id));
  call->respond(std::move(response));
}
}  // namespace

void list_jobs(const CallPtr& call) {
  ListPage page;
  if (!read_page(call, page)) return;
  std::vector<JobInfo> jobs = call->services.jobs.list();
  std::erase_if(jobs, [&](const JobInfo& info) { return page.last && std::cmp_less_equal(info.id, *page.last); });
  call->respond(page_json(jobs, page.limit, job_json, [](const JobInfo& info) { return std::to_string(info.id); }));
}

void get_job(const CallPtr& call) {
  if (const auto info = job_of(call)) call->respond(whole_job(*info));
}

// The body fits its schema: the kind is one of the table.
void start_job(const CallPtr& call) {
  const json& body = *call->body;
  JobArguments arguments;
  if (const auto sessions = body.find("sessions"); sessions != body.end()) arguments.sessions = sessions->get<std::vector<db::SessionId>>();
  arguments.folder = body.value("folder", "");
  arguments.backup = body.value("backup", "");
  arguments.identity_key = body.value("identity_key", false);
  const auto text = [&body](const char* name) { return body.contains(name) ? std::optional(body[name].get<std::string>()) : std::nullopt; };
  arguments.filter.subject = text("subject");
  arguments.filter.from_day = text("from_day");
  arguments.filter.to_day = text("to_day");
  arguments.filter.exercise = text("exercise");
  arguments.filter.tag = text("tag");
  if (body.contains("visit")) arguments.filter.visit = body["visit"].get<std::int64_t>();
  arguments.filter.simulated = body.value("simulated", true);
  if (const auto rule = body.find("rule"); rule != body.end()) arguments.rule = db::rule_of(*rule);
  arguments.subjects = body.value("subjects", arguments.subjects);
  arguments.seed = body.value("seed", arguments.seed);
  arguments.study = body.value("study", arguments.study);
  arguments.layout = *db::find_bundle_layout(body.value("layout", "files"));
  arguments.reports.kind = *db::find_report_kind(body.value("report", "full"));
  arguments.reports.language = *db::find_language(body.value("language", "en"));
  act_start_job(call->services, asker_of(*call), *find_job_kind(body.at("kind").get_ref<const std::string&>()), std::move(arguments),
                answer_with(call, [call](const Outcome& outcome) { respond_accepted(call, outcome.job); }));
}

void get_job_file(const CallPtr& call) {
  const auto info = job_of(call);
  if (!info) return;
  if (!info->file)
    return call->fail({.status = 404,
                       .name = "unknown",
                       .title = "This job has no file",
                       .detail = "Only an export that is done has one, and only the newest " + std::to_string(kJobFiles) +
                                 " are kept, until a session is deleted."});
  const std::string name = json::parse(*info->result)["file_name"];
  const auto layout = std::ranges::find(db::kBundleLayouts, name, &db::BundleLayoutInfo::file_name);
  respond_file(call, {.file = info->file,
                      .content_type = std::string(layout == db::kBundleLayouts.end() ? "application/octet-stream" : layout->media_type),
                      .file_name = name,
                      .etag = "\"job-" + std::to_string(call->services.started_utc_ns) + "-" + std::to_string(info->id) + "\""});
}

void cancel_job(const CallPtr& call) {
  const auto info = job_of(call);
  if (!info) return;
  act_cancel_job(call->services, asker_of(*call), info->id,
                 answer_with(call, [call](const Outcome& outcome) { respond_accepted(call, outcome.job); }));
}

}  // namespace hoist::server::api
