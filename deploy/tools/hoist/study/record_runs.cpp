#include "deploy/tools/hoist/study/record_runs.hpp"

#include <algorithm>
#include <future>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "control/contract/params.hpp"
#include "control/contract/program_version.hpp"
#include "control/contract/shared_memory.hpp"
#include "db/store/exercise_json.hpp"

namespace hoist::tool::study {

namespace {

db::Status record(db::SessionWriter& writer, const Protocol& protocol, const VirtualRun& run) {
  /// Each study begins at the same moment, so that it gives the same file: 2026-01-05 08:00 UTC, a run every five minutes.
  constexpr std::int64_t kBegin_ns = 1'767'600'000'000'000'000, kBetween_ns = 300'000'000'000;
  db::SessionStart start;
  start.subject = (run.subject < 10 ? "S0" : "S") + std::to_string(run.subject);
  start.started_utc_ns = kBegin_ns + kBetween_ns * (run.subject * 100 + run.run);
  start.note = "run " + std::to_string(run.run) + (run.unfinished.empty() ? "" : ", unfinished: " + run.unfinished);
  start.exercise_json = db::exercise_json(contract::usual_exercise(protocol.find(run.run)->shape), db::ExerciseNames::stored).dump();
  return record_run(writer, run, std::move(start));
}

}  // namespace

db::Status record_run(db::SessionWriter& writer, const VirtualRun& run, db::SessionStart start) {
  if (run.records.empty()) return {};
  std::vector<double> parameters;
  for (std::size_t i = 0; i < contract::kParamCount; ++i) parameters.push_back(contract::get_param(run.params, i));
  start.parameter_values = parameters;
  start.start_time_ns = run.records.front().time_ns;
  start.core_start_time_ns = 1;
  start.simulated = true;
  start.layout_hash = contract::layout_hash();
  start.software_version = contract::program_version();
  start.core_version = start.software_version;
  if (const auto begun = writer.begin(start); !begun) return begun.error();
  // More at once would wait in memory only.
  for (std::size_t first = 0; first < run.records.size(); first += 1000) {
    const std::size_t count = std::min<std::size_t>(1000, run.records.size() - first);
    if (db::Status status = writer.append_ticks(std::span(run.records).subspan(first, count)); !status) return status;
  }
  return writer.end(db::CloseReason::finished, start.started_utc_ns + static_cast<std::int64_t>(run.records.size()) * 10'000'000);
}

// One run is walked while the one before is stored: two threads.
db::Status walk_all(db::Database& database, const Protocol& protocol, int subjects, std::uint64_t seed) {
  db::Result<db::SessionWriter> writer = db::SessionWriter::create(database);
  if (!writer) return writer.error();
  std::future<VirtualRun> next;
  const auto store = [&]() -> db::Status {
    if (!next.valid()) return {};
    return record(*writer, protocol, next.get());
  };
  for (int subject = 1; subject <= subjects; ++subject) {
    int done = 0;
    for (const Run& run : order_of(protocol, subject, seed)) {
      std::future<VirtualRun> before = std::exchange(
          next, std::async(std::launch::async, [&protocol, run, subject, done, seed] { return walk(protocol, run, subject, done, seed); }));
      ++done;
      if (!before.valid()) continue;
      if (db::Status status = record(*writer, protocol, before.get()); !status) return status;
    }
  }
  return store();
}

}  // namespace hoist::tool::study
