// hoist verify: a recorded session, run again and compared bit for bit.
#include <chrono>
#include <cstdio>
#include <string>

#include "control/contract/program_version.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"
#include "deploy/tools/hoist/rerun.hpp"

namespace hoist::tool {

namespace {

unsigned long long number(std::uint64_t value) { return value; }

void print(db::SessionId session, const Verification& result, double took_s) {
  const RerunReport& run = result.run;
  std::printf("session %lld: %llu of %llu samples run again, %llu differ (%.0f x real time)\n", static_cast<long long>(session),
              number(run.samples_run), number(run.samples), number(result.different),
              took_s > 0 ? static_cast<double>(run.steps) * 0.01 / took_s : 0.0);
  if (result.first) {
    const Difference& first = *result.first;
    std::printf("first difference: tick %llu, time_ns %llu, ", number(first.tick), number(first.time_ns));
    if (first.signal.empty())
      std::printf("below the resolution with which samples are stored\n");
    else
      std::printf("%s: recorded %.10g, again %.10g\n", first.signal.c_str(), first.recorded, first.again);
  }
  for (const NotRun& hole : run.not_run)
    std::printf("not run again: ticks %llu to %llu: %s\n", number(hole.from_tick), number(hole.to_tick), hole.reason.c_str());
}

}  // namespace

int run_verify(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(
        "usage: hoist verify DB SESSION\n\nRuns the core again with what each step of the session was given, and compares every field of "
        "every\n"
        "sample, bit for bit. Exit code 0: all samples were run again and are the same; 1: some differ (the first step and field is "
        "named), or\n"
        "the session cannot be run again, for example since another build recorded it; 3: no difference, but some samples could not be "
        "run\n"
        "again (which, and why, is printed).\n",
        stdout);
    return kDone;
  }
  const auto session = arguments.size() == 2 ? parse_session(arguments[1]) : std::nullopt;
  if (!session) return bad_usage("verify", "name a database and a session's number");
  db::Result<db::Database> database = db::Database::attach(std::string(arguments[0]));
  if (!database) return refuse("verify", database.error());
  const auto begin = std::chrono::steady_clock::now();
  const db::Result<Verification> result = verify_session(*database, *session, contract::program_version());
  if (!result) return refuse("verify", result.error());
  print(*session, *result, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  if (contract::program_version().ends_with(".modified") || contract::program_version().ends_with("+unknown"))
    std::printf("note: built from changed or unknown sources; that the recording's build is the same one cannot be known\n");
  if (result->first) return kRefused;
  return result->whole() ? kDone : kPartly;
}

}  // namespace hoist::tool
