// The jobs `study` and `delete_study`. The virtual subjects walk in a process of their own (`hoist study`); this thread only watches it, then
// puts what it has recorded beside the recordings of people.
#include "db/store/studies.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string_view>

#include "db/export/bundle.hpp"
#include "server/jobs/child.hpp"
#include "server/jobs/deletion.hpp"
#include "server/jobs/work.hpp"

namespace hoist::server::job {

using nlohmann::json;

namespace {
namespace fs = std::filesystem;

constexpr int kLook_ms = 200;
// Walking takes this share of the progress, putting the sessions in the rest.
constexpr double kWalkShare = 0.9;
// Virtual subjects walk in no time of day: their sessions are dated back from the begin of the job, five minutes apart.
constexpr std::int64_t kBetween_ms = 300'000;
constexpr int kRunsEach = 6;
// `hoist study` ends with 3 when runs were left out: the report says which.
constexpr int kDone = 0, kPartly = 3;

// A folder beside the recordings, so on their disk, that goes with its owner. What a killed server has left goes at the next one.
class Workshop {
 public:
  explicit Workshop(const fs::path& recordings) {
    const std::string prefix = recordings.string() + ".study-";
    std::error_code unread, ignored;
    for (fs::directory_iterator entry(recordings.parent_path(), unread), end; !unread && entry != end; entry.increment(unread))
      if (entry->path().string().starts_with(prefix)) fs::remove_all(entry->path(), ignored);
    std::string pattern = prefix + "XXXXXX";
    if (::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  ~Workshop() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  Workshop(const Workshop&) = delete;
  Workshop& operator=(const Workshop&) = delete;
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

// The share that "progress DONE ALL" tells.
std::optional<double> share_in(std::string_view line) {
  constexpr std::string_view kBegin = "progress ";
  if (!line.starts_with(kBegin)) return {};
  line.remove_prefix(kBegin.size());
  int done = 0, all = 0;
  const auto [space, first] = std::from_chars(line.data(), line.data() + line.size(), done);
  if (first != std::errc{} || space == line.data() + line.size()) return {};
  const auto [end, second] = std::from_chars(space + 1, line.data() + line.size(), all);
  if (second != std::errc{} || end != line.data() + line.size() || all <= 0) return {};
  return static_cast<double>(done) / all;
}

// `hoist study` with these arguments, to its end. False: `step` ended it.
db::Result<bool> run(const JobTools& tools, std::vector<std::string> arguments, const JobStep& step) {
  arguments.insert(arguments.begin(), {tools.study_program.string(), "study"});
  auto child = Child::start(arguments);
  if (!child) return child.error();
  double share = 0;
  std::string complaint;
  while (!child->ended()) {
    // A patient who walks has the processor.
    child->pause(tools.moving && tools.moving());
    if (!step(kWalkShare * share)) return false;
    while (const auto line = child->line(kLook_ms)) {
      share = share_in(*line).value_or(share);
      if (line->starts_with("hoist study: ")) complaint = *line;
    }
  }
  const int code = child->exit_code();
  if (code == kDone || code == kPartly) return true;
  return db::Error{db::ErrorKind::internal, complaint.empty() ? "the study ended with " + std::to_string(code) : complaint, {}};
}

std::vector<std::string> walking(const JobTools& tools, const JobArguments& arguments, const fs::path& file) {
  const std::int64_t begin_ms = tools.utc_ns() / 1'000'000 - kBetween_ms * arguments.subjects * kRunsEach;
  return {"--subjects",     std::to_string(arguments.subjects),
          "--seed",         std::to_string(arguments.seed),
          "--begin-utc-ms", std::to_string(begin_ms),
          "--progress",     "1",
          "--out",          file.string()};
}

// What ended early, or was left by a killed server, goes again.
db::Status take_back(const JobTools& tools, db::Database& database, db::StudyId study) {
  const auto sessions = db::study_sessions(database, study);
  if (!sessions) return sessions.error();
  for (const db::SessionId session : *sessions)
    if (db::Status deleted = delete_session(tools, database, session); !deleted) return deleted;
  return db::remove_study(database, study);
}
db::Status take_back_unfinished(const JobTools& tools, db::Database& database) {
  const auto unfinished = db::unfinished_studies(database);
  if (!unfinished) return unfinished.error();
  for (const db::StudyId study : *unfinished)
    if (db::Status gone = take_back(tools, database, study); !gone) return gone;
  return {};
}

// The study that is now among the recordings; nothing: `step` ended it. Each session is a commit of its own, so that the recorder never waits
// for long.
db::Result<std::optional<db::StudyId>> put_in(const JobTools& tools, const fs::path& file, const JobStep& step) {
  auto made = db::Database::attach(file);
  if (!made) return made.error();
  const auto studies = db::list_studies(*made, {}, 2);
  if (!studies) return studies.error();
  if (studies->size() != 1) return db::Error{db::ErrorKind::internal, "the study has written no report", {}};
  const db::StudyRow& row = studies->front();
  std::vector<db::StudyDrawing> drawings;
  for (const std::string& name : row.drawings) {
    auto svg = db::study_drawing(*made, row.id, name);
    if (!svg) return svg.error();
    drawings.push_back({name, std::move(*svg)});
  }
  auto database = tools.open();
  if (!database) return database.error();
  const auto study = db::begin_study(*database, tools.utc_ns());
  if (!study) return study.error();
  for (std::size_t i = 0; i < row.sessions.size(); ++i) {
    const double share = static_cast<double>(i) / static_cast<double>(row.sessions.size());
    if (!step(kWalkShare + (1 - kWalkShare) * share)) return std::optional<db::StudyId>{};
    const db::StudySession& one = row.sessions[i];
    if (const auto taken = db::take_run(*database, file, one.session, {.study = *study, .subject = one.subject, .run = one.run}); !taken)
      return taken.error();
  }
  if (db::Status finished = db::finish_study(*database, *study, row.report, drawings); !finished) return finished.error();
  return std::optional(*study);
}
}  // namespace

JobResult study(const JobTools& tools, const JobArguments& arguments, const JobStep& step) {
  const Workshop workshop(tools.file);
  if (workshop.path().empty()) return db::Error{db::ErrorKind::io, "no folder can be made beside the recordings", {}};
  const fs::path file = workshop.path() / "study.db";
  const auto walked = run(tools, walking(tools, arguments, file), step);
  if (!walked) return walked.error();
  if (!*walked) return std::optional<JobYield>{};
  auto result = put_in(tools, file, step);
  auto database = tools.open();
  if (!database) return database.error();
  if (db::Status tidied = take_back_unfinished(tools, *database); !tidied && result) return tidied.error();
  if (!result) return result.error();
  if (!*result) return std::optional<JobYield>{};
  const json told{{"kind", "study"}, {"study", **result}};
  return std::optional(JobYield{.result = told.dump(), .check = {}});
}

namespace {
std::string content_of(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}
// Without runs of its own: the sessions are those of people, and stay when the study goes.
db::Result<db::StudyId> keep(db::Database& database, std::int64_t utc_ns, const std::string& report, const fs::path& figures) {
  std::vector<db::StudyDrawing> drawings;
  std::error_code unread;
  for (fs::directory_iterator entry(figures, unread), end; !unread && entry != end; entry.increment(unread))
    drawings.push_back({entry->path().stem().string(), content_of(entry->path())});
  std::ranges::sort(drawings, {}, &db::StudyDrawing::name);
  const auto study = db::begin_study(database, utc_ns);
  if (!study) return study.error();
  if (db::Status finished = db::finish_study(database, *study, report, drawings); !finished) return finished.error();
  return *study;
}
}  // namespace

JobResult study_recorded(const JobTools& tools, const JobArguments& arguments, const JobStep& step) {
  const Workshop workshop(tools.file);
  if (workshop.path().empty()) return db::Error{db::ErrorKind::io, "no folder can be made beside the recordings", {}};
  auto database = tools.open();
  if (!database) return database.error();
  const auto sessions = db::select_sessions(*database, arguments.filter);
  if (!sessions) return sessions.error();
  std::string list;
  for (const db::SessionId session : *sessions) list += (list.empty() ? "" : ",") + std::to_string(session);
  const db::Error none{db::ErrorKind::bad_value, "no session of a patient has a note that begins with \"run N\"", "sessions"};
  if (list.empty()) return none;
  const fs::path told = workshop.path() / "study.json", figures = workshop.path() / "figures";
  const auto ended =
      run(tools, {"--recorded", tools.file.string(), "--sessions", list, "--json", told.string(), "--figures", figures.string()}, step);
  const std::string report = content_of(told);
  if (!ended) return report.empty() && ended.error().message.find("no session") != std::string::npos ? none : ended.error();
  if (!*ended) return std::optional<JobYield>{};
  if (json::parse(report, nullptr, false).is_discarded()) return db::Error{db::ErrorKind::internal, "the study has written no report", {}};
  const auto study = keep(*database, tools.utc_ns(), report, figures);
  if (!study) return study.error();
  const json result{{"kind", "study_recorded"}, {"study", *study}};
  return std::optional(JobYield{.result = result.dump(), .check = {}});
}

JobResult delete_study(const JobTools& tools, const JobArguments& arguments, const JobStep& step) {
  auto database = tools.open();
  if (!database) return database.error();
  if (const auto row = db::read_study(*database, arguments.study); !row) return row.error();
  const auto sessions = db::study_sessions(*database, arguments.study);
  if (!sessions) return sessions.error();
  for (std::size_t i = 0; i < sessions->size(); ++i) {
    if (!step(static_cast<double>(i) / static_cast<double>(sessions->size()))) return std::optional<JobYield>{};
    if (db::Status deleted = delete_session(tools, *database, (*sessions)[i]); !deleted) return deleted.error();
  }
  if (db::Status removed = db::remove_study(*database, arguments.study); !removed) return removed.error();
  const json told{{"kind", "delete_study"}, {"study", arguments.study}, {"sessions", sessions->size()}};
  return std::optional(JobYield{.result = told.dump(), .check = {}});
}

}  // namespace hoist::server::job
