// What each kind of job does. One function per row of jobs.def, on the jobs' thread, with a connection of its own.
#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "db/export/bundle.hpp"
#include "db/export/spool_file.hpp"
#include "db/store/database.hpp"
#include "db/store/integrity.hpp"
#include "db/store/result.hpp"
#include "db/store/retention.hpp"
#include "server/contract/jobs.hpp"

namespace hoist::server {

// Sessions of one recompute_metrics: its result is kept in memory, about 700 bytes for each.
inline constexpr std::size_t kJobSessions = 1000;

struct JobArguments {
  std::vector<db::SessionId> sessions = {};  // of recompute_metrics (empty = the newest ones) and export_sessions
  std::string folder = {};                   // of backup; empty = the first of the allowed ones
  std::string backup = {};                   // of restore
  bool identity_key = false;                 // of backup: the key of the patients' names goes with it
  db::SessionFilter filter = {};             // of export_sessions without sessions
  db::BundleLayout layout = db::BundleLayout::files;
  db::ReportOptions reports = {};  // of the layout of that name
  db::RetentionRule rule = {};     // of preview_retention
  int subjects = 1;                // of study …
  std::uint64_t seed = 1;          // … and their seed
  std::int64_t study = 0;          // of delete_study
};
// What a job may use.
struct JobTools {
  std::filesystem::path file;
  std::function<std::int64_t()> utc_ns;
  // Backups are written below these folders only, and put back from there only.
  std::vector<std::filesystem::path> backup_roots = {};
  std::string device = {}, program = {};
  // What goes into a backup beside the recordings, as far as it exists; the key only when the engineer says so.
  std::vector<std::filesystem::path> other_databases = {};
  std::filesystem::path identity_key = {};
  // Puts a file that `prepare_restore` has made in the place of the one in use, which it names. Refused while a session is recorded.
  std::function<db::Result<std::filesystem::path>(const std::filesystem::path& prepared)> replace_file = {};
  // What retention has deleted, in a sentence for the audit log.
  std::function<void(const std::string& what)> log_deletion = {};
  // A session was deleted: what was made of it goes. Set by Jobs.
  std::function<void()> on_deletion = {};

  // The engineer's tool, which walks the virtual subjects of a study.
  std::filesystem::path study_program = {};
  // From any thread: whether the wheels may turn. A study rests meanwhile.
  std::function<bool()> moving = {};

  // A connection for this job: the file may be another one since the last, and nothing stays open while nothing runs. Errors as of
  // Database::attach; io for a file that the recorder could not set up.
  [[nodiscard]] db::Result<db::Database> open() const;
};
struct JobYield {
  std::string result;                              // as JSON
  std::optional<db::IntegrityReport> check;        // of integrity_check
  std::shared_ptr<const db::SpoolFile> file = {};  // of export_sessions
};
// Called often with the share that is done, 0 to 1; false = end here.
using JobStep = std::function<bool(double)>;
// Nothing when `step` ended it.
using JobResult = db::Result<std::optional<JobYield>>;

namespace job {
#define HOIST_JOB(name, role, doc) JobResult name(const JobTools& tools, const JobArguments& arguments, const JobStep& step);
#include "server/contract/jobs.def"
#undef HOIST_JOB
}  // namespace job

}  // namespace hoist::server
