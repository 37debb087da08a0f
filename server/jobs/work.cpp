#include "server/jobs/work.hpp"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>
#include <utility>

#include "db/store/backup.hpp"
#include "db/store/deletion.hpp"
#include "db/store/session_reader.hpp"
#include "db/summary/session_json.hpp"
#include "server/jobs/deletion.hpp"

namespace hoist::server {

db::Result<db::Database> JobTools::open() const {
  db::Result<db::Database> database = db::Database::attach(file);
  // An older schema: jobs begin when the recorder has opened the file, so it has failed, and says why.
  if (!database && database.error().kind == db::ErrorKind::wrong_state) return db::Error{db::ErrorKind::io, database.error().message, {}};
  return database;
}

}  // namespace hoist::server

namespace hoist::server::job {

using nlohmann::json;

JobResult integrity_check(const JobTools& tools, const JobArguments&, const JobStep& step) {
  auto database = tools.open();
  if (!database) return database.error();
  auto checked = db::check_integrity(*database, step);
  if (!checked) return checked.error();
  if (!*checked) return std::optional<JobYield>{};
  db::IntegrityReport& report = **checked;
  const json told{{"kind", "integrity_check"},
                  {"sound", report.sound()},
                  {"structure", report.structure},
                  {"blobs", report.blobs},
                  {"damaged_blobs", report.damaged_blobs},
                  {"damaged_sessions", report.damaged_sessions}};
  return std::optional(JobYield{.result = told.dump(-1, ' ', false, json::error_handler_t::replace), .check = std::move(report)});
}

namespace {
db::Result<std::vector<db::SessionId>> newest_sessions(db::Database& database) {
  std::vector<db::SessionId> ids;
  db::SessionQuery query{.limit = db::kMaxPage, .before = {}, .subject = {}};
  do {
    const auto page = db::SessionReader(database).list(query);
    if (!page) return page.error();
    for (const db::SessionInfo& session : page->sessions) ids.push_back(session.id);
    query.before = page->next;
  } while (query.before && ids.size() < kJobSessions);
  ids.resize(std::min(ids.size(), kJobSessions));
  return ids;
}
}  // namespace

JobResult recompute_metrics(const JobTools& tools, const JobArguments& arguments, const JobStep& step) {
  auto database = tools.open();
  if (!database) return database.error();
  std::vector<db::SessionId> ids = arguments.sessions;
  if (ids.empty()) {
    auto newest = newest_sessions(*database);
    if (!newest) return newest.error();
    ids = std::move(*newest);
  }
  json items = json::array(), failed = json::array();
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!step(static_cast<double>(i) / static_cast<double>(ids.size()))) return std::optional<JobYield>{};
    // A session that is gone or damaged is one of its own: the others are computed.
    if (auto figures = db::session_metrics_json(*database, ids[i]); figures)
      items.push_back(std::move(*figures));
    else
      failed.push_back({{"session", ids[i]}, {"detail", figures.error().message}});
  }
  const json told{{"kind", "recompute_metrics"}, {"items", std::move(items)}, {"failed", std::move(failed)}};
  return std::optional(JobYield{.result = told.dump(-1, ' ', false, json::error_handler_t::replace), .check = {}});
}

JobResult export_sessions(const JobTools& tools, const JobArguments& arguments, const JobStep& step) {
  auto database = tools.open();
  if (!database) return database.error();
  std::vector<db::SessionId> ids = arguments.sessions;
  if (ids.empty()) {
    auto chosen = db::select_sessions(*database, arguments.filter);
    if (!chosen) return chosen.error();
    ids = std::move(*chosen);
  }
  const std::size_t count = ids.size();
  db::ReportOptions reports = arguments.reports;
  reports.program = tools.program;
  auto bundle = db::Bundle::open(*database, std::move(ids), arguments.layout, reports);
  if (!bundle) return bundle.error();
  const auto file = db::SpoolFile::create(tools.file.parent_path());
  if (!file) return file.error();
  std::string piece;
  for (;;) {
    if (!step(bundle->progress())) return std::optional<JobYield>{};
    const auto more = bundle->next_chunk(piece);
    if (!more) return more.error();
    if (!*more) break;
    if (const db::Status written = (*file)->append(piece); !written) return written.error();
  }
  const json told{{"kind", "export_sessions"},
                  {"sessions", count},
                  {"bytes", (*file)->size()},
                  {"file_name", db::bundle_layout_info(arguments.layout).file_name}};
  return std::optional(JobYield{.result = told.dump(), .check = {}, .file = *file});
}

namespace {
namespace fs = std::filesystem;

json backup_json(const db::BackupInfo& info) {
  json files = json::array();
  for (const db::BackupFile& file : info.files) files.push_back({{"name", file.name}, {"bytes", file.bytes}, {"sha256", file.sha256}});
  return {{"backup", info.folder.string()},
          {"device", info.device},
          {"hoist_id", info.hoist_id.empty() ? json(nullptr) : json(info.hoist_id)},
          {"program", info.program},
          {"utc_ms", info.utc_ns / 1'000'000},
          {"sessions", info.sessions},
          {"files", std::move(files)}};
}

std::string dumped(const json& told) { return told.dump(-1, ' ', false, json::error_handler_t::replace); }

// Whether this path is one of the allowed folders or below one, links followed.
db::Status check_place(const JobTools& tools, const fs::path& path, const char* field) {
  std::string allowed;
  for (const fs::path& root : tools.backup_roots) {
    std::error_code error;
    const fs::path real = fs::weakly_canonical(path, error), base = fs::weakly_canonical(root, error);
    if (!error && path.is_absolute() && std::ranges::mismatch(base, real).in1 == base.end()) return {};
    allowed += (allowed.empty() ? "" : ", ") + root.string();
  }
  return db::Error{
      db::ErrorKind::bad_value,
      allowed.empty() ? "this server has no folder for backups (--backup-root)" : "backups are allowed below " + allowed + " only", field};
}
}  // namespace

JobResult backup(const JobTools& tools, const JobArguments& arguments, const JobStep& step) {
  const fs::path folder = !arguments.folder.empty() || tools.backup_roots.empty() ? fs::path(arguments.folder) : tools.backup_roots.front();
  if (db::Status allowed = check_place(tools, folder, "folder"); !allowed) return allowed.error();
  auto database = tools.open();
  if (!database) return database.error();
  db::BackupOptions options{.folder = folder,
                            .device = db::clean_device(tools.device),
                            .program = tools.program,
                            .utc_ns = tools.utc_ns(),
                            .databases = tools.other_databases};
  if (arguments.identity_key) options.files.push_back(tools.identity_key);
  const auto written = db::back_up(*database, options, step);
  if (!written) return written.error();
  if (!*written) return std::optional<JobYield>{};
  json told = backup_json(**written);
  told["kind"] = "backup";
  return std::optional(JobYield{.result = dumped(told), .check = {}});
}

JobResult restore(const JobTools& tools, const JobArguments& arguments, const JobStep& step) {
  if (db::Status allowed = check_place(tools, arguments.backup, "backup"); !allowed) return allowed.error();
  const auto prepared = db::prepare_restore(arguments.backup, tools.file, step);
  if (!prepared) return prepared.error();
  if (!*prepared) return std::optional<JobYield>{};
  const auto aside = tools.replace_file(**prepared);
  if (!aside) {
    std::error_code ignored;
    fs::remove(**prepared, ignored);
    return aside.error();
  }
  const json told{{"kind", "restore"}, {"backup", arguments.backup}, {"set_aside", aside->string()}};
  return std::optional(JobYield{.result = dumped(told), .check = {}});
}

JobResult list_backups(const JobTools& tools, const JobArguments&, const JobStep& step) {
  json folders = json::array(), items = json::array();
  for (const fs::path& root : tools.backup_roots) {
    if (!step(0)) return std::optional<JobYield>{};
    std::error_code error;
    const auto space = fs::space(root, error);
    folders.push_back({{"folder", root.string()}, {"there", !error}, {"free_bytes", error ? json(nullptr) : json(space.available)}});
    for (const db::BackupInfo& info : db::list_backups(root)) items.push_back(backup_json(info));
  }
  const json told{{"kind", "list_backups"}, {"folders", std::move(folders)}, {"items", std::move(items)}};
  return std::optional(JobYield{.result = dumped(told), .check = {}});
}

namespace {
// A plan takes this share of the progress, the deletions the rest.
constexpr double kPlanShare = 0.1;

db::Result<std::uint64_t> disk_bytes(const JobTools& tools) {
  std::error_code error;
  const fs::path folder = tools.file.has_parent_path() ? tools.file.parent_path() : fs::path(".");
  const auto space = fs::space(folder, error);
  if (error) return db::Error{db::ErrorKind::io, folder.string() + " cannot be read: " + error.message(), {}};
  return static_cast<std::uint64_t>(space.capacity);
}

json plan_json(const char* kind, const db::RetentionRule& rule, const db::RetentionPlan& plan, std::uint64_t disk) {
  const auto utc_ms = [&](std::int64_t utc_ns) { return plan.sessions.empty() ? json(nullptr) : json(utc_ns / 1'000'000); };
  return {{"kind", kind},
          {"rule", db::rule_json(rule)},
          {"sessions", plan.sessions.size()},
          {"bytes", plan.bytes},
          {"from_utc_ms", utc_ms(plan.from_utc_ns)},
          {"to_utc_ms", utc_ms(plan.to_utc_ns)},
          {"without_backup", plan.without_backup},
          {"used_bytes", plan.used_bytes},
          {"disk_bytes", disk},
          {"excess_bytes", plan.excess_bytes}};
}

}  // namespace

db::Status delete_session(const JobTools& tools, db::Database& database, db::SessionId session) {
  using Clock = std::chrono::steady_clock;
  // It may have been deleted since the plan was made.
  if (db::Status taken = db::take_out(database, session); !taken && taken.error().kind != db::ErrorKind::not_found) return taken;
  if (tools.on_deletion) tools.on_deletion();
  for (;;) {
    const auto begin = Clock::now();
    const auto more = db::erase_piece(database);
    if (!more) return more.error();
    if (!*more) return {};
    std::this_thread::sleep_for(Clock::now() - begin);
  }
}

JobResult preview_retention(const JobTools& tools, const JobArguments& arguments, const JobStep& step) {
  auto database = tools.open();
  if (!database) return database.error();
  const auto disk = disk_bytes(tools);
  if (!disk) return disk.error();
  const auto plan = db::plan_retention(*database, arguments.rule, tools.utc_ns(), *disk, step);
  if (!plan) return plan.error();
  if (!*plan) return std::optional<JobYield>{};
  return std::optional(JobYield{.result = plan_json("preview_retention", arguments.rule, **plan, *disk).dump(), .check = {}});
}

JobResult retention(const JobTools& tools, const JobArguments&, const JobStep& step) {
  auto database = tools.open();
  if (!database) return database.error();
  const auto rule = db::retention_rule(*database);
  const auto disk = disk_bytes(tools);
  if (!rule || !disk) return rule ? disk.error() : rule.error();
  auto planned = db::plan_retention(*database, *rule, tools.utc_ns(), *disk, [&](double share) { return step(kPlanShare * share); });
  if (!planned) return planned.error();
  if (!*planned) return std::optional<JobYield>{};
  db::RetentionPlan& plan = **planned;
  std::size_t deleted = 0;
  bool ended = false;
  db::Status status;
  while (deleted < plan.sessions.size() && status) {
    const double share = static_cast<double>(deleted) / static_cast<double>(plan.sessions.size());
    ended = !step(kPlanShare + (1 - kPlanShare) * share);
    // Another rule in the meantime ends this one.
    const auto now = db::retention_rule(*database);
    if (ended || !now || *now != *rule) break;
    status = delete_session(tools, *database, plan.sessions[deleted]);
    if (status) ++deleted;
  }
  if (deleted > 0 && tools.log_deletion)
    tools.log_deletion(std::to_string(deleted) + " sessions, " + std::to_string(plan.sessions.front()) + " to " +
                       std::to_string(plan.sessions[deleted - 1]) + ", rule " + db::rule_json(*rule).dump());
  if (!status) return status.error();
  if (ended) return std::optional<JobYield>{};
  plan.sessions.resize(deleted);
  return std::optional(JobYield{.result = plan_json("retention", *rule, plan, *disk).dump(), .check = {}});
}

}  // namespace hoist::server::job
