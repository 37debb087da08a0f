#include "deploy/tools/hoist/study/record_runs.hpp"

#include <algorithm>
#include <future>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>

#include "control/contract/program_version.hpp"
#include "control/contract/shared_memory.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/session_writer.hpp"
#include "deploy/tools/hoist/study/virtual_run.hpp"

namespace hoist::tool::study {

namespace {

constexpr std::int64_t kBetween_ns = 300'000'000'000;

std::string code_of(int subject) { return (subject < 10 ? "S0" : "S") + std::to_string(subject); }

// The number of the session. A virtual subject is no patient: the session has no code.
db::Result<db::SessionId> record(db::SessionWriter& writer, const Protocol& protocol, const VirtualRun& run, std::int64_t started_utc_ns) {
  db::SessionStart start;
  start.started_utc_ns = started_utc_ns;
  start.note = "run " + std::to_string(run.run) + (run.unfinished.empty() ? "" : ", unfinished: " + run.unfinished);
  start.exercise_json = db::exercise_json(contract::usual_exercise(protocol.find(run.run)->shape), db::ExerciseNames::stored).dump();
  return record_run(writer, run, std::move(start));
}

struct Planned {
  int subject = 0, done_before = 0;
  Run run;
};
std::vector<Planned> plan(const Protocol& protocol, const StudyRequest& request) {
  std::vector<Planned> all;
  for (int subject = 1; subject <= request.subjects; ++subject) {
    int done = 0;
    for (const Run& run : order_of(protocol, subject, request.seed)) all.push_back({subject, done++, run});
  }
  return all;
}

}  // namespace

db::Result<db::SessionId> record_run(db::SessionWriter& writer, const VirtualRun& run, db::SessionStart start) {
  start.start_time_ns = run.records.front().time_ns;
  start.core_start_time_ns = 1;
  start.simulated = true;
  start.layout_hash = contract::layout_hash();
  start.software_version = contract::program_version();
  start.core_version = start.software_version;
  start.parameter_values = run.parameters;
  const db::Result<db::SessionId> session = writer.begin(start);
  if (!session) return session;
  // More at once would wait in memory only.
  for (std::size_t first = 0; first < run.records.size(); first += 1000) {
    const std::size_t count = std::min<std::size_t>(1000, run.records.size() - first);
    if (db::Status status = writer.append_ticks(std::span(run.records).subspan(first, count)); !status) return status.error();
  }
  const std::int64_t ended_utc_ns = start.started_utc_ns + static_cast<std::int64_t>(run.records.size()) * 10'000'000;
  if (db::Status ended = writer.end(db::CloseReason::finished, ended_utc_ns); !ended) return ended.error();
  return session;
}

// One run is walked while the one before is stored: two threads.
db::Result<db::StudyId> walk_all(db::Database& database, const Protocol& protocol, const StudyRequest& request) {
  const db::Result<db::StudyId> study = db::begin_study(database, request.begin_utc_ns);
  if (!study) return study;
  db::Result<db::SessionWriter> writer = db::SessionWriter::create(database);
  if (!writer) return writer.error();
  const std::vector<Planned> runs = plan(protocol, request);
  const auto begin = [&](const Planned& next) {
    return std::async(std::launch::async,
                      [&protocol, next, seed = request.seed] { return walk(protocol, next.run, next.subject, next.done_before, seed); });
  };
  std::future<VirtualRun> walks = runs.empty() ? std::future<VirtualRun>{} : begin(runs.front());
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const VirtualRun walked = walks.get();
    if (i + 1 < runs.size()) walks = begin(runs[i + 1]);
    const std::int64_t at_ns = request.begin_utc_ns + kBetween_ns * static_cast<std::int64_t>(i);
    if (!walked.records.empty()) {
      const db::Result<db::SessionId> session = record(*writer, protocol, walked, at_ns);
      if (!session) return session.error();
      const db::StudyRun run{.study = *study, .subject = code_of(walked.subject), .run = walked.run};
      if (db::Status marked = db::mark_run(database, *session, run); !marked) return marked.error();
    }
    if (request.progress) request.progress(static_cast<int>(i) + 1, static_cast<int>(runs.size()));
  }
  return study;
}

}  // namespace hoist::tool::study
