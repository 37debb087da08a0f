// What each kind of job does. One function per row of jobs.def, on the jobs' thread, with a connection of its own.
#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/integrity.hpp"
#include "db/store/result.hpp"
#include "server/contract/jobs.hpp"

namespace hoist::server {

struct JobArguments {
  std::vector<db::SessionId> sessions;  // of recompute_metrics; empty = the newest ones
};
struct JobYield {
  std::string result;                        // as JSON
  std::optional<db::IntegrityReport> check;  // of integrity_check
};
// Called often with the share that is done, 0 to 1; false = end here.
using JobStep = std::function<bool(double)>;
// Nothing when `step` ended it.
using JobResult = db::Result<std::optional<JobYield>>;

namespace job {
#define HOIST_JOB(name, role, doc) JobResult name(db::Database& database, const JobArguments& arguments, const JobStep& step);
#include "server/contract/jobs.def"
#undef HOIST_JOB
}  // namespace job

}  // namespace hoist::server
