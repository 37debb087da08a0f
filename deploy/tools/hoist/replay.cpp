// hoist replay: what the core would have done with other parameters, given what it was given.
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "control/contract/program_version.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/out_file.hpp"
#include "deploy/tools/hoist/parameter_change.hpp"
#include "deploy/tools/hoist/recording_file.hpp"
#include "deploy/tools/hoist/rerun.hpp"

namespace hoist::tool {

namespace {

void print_replay_help(std::FILE* out) {
  std::fputs(
      "usage: hoist replay DB SESSION --set NAME=VALUE [--set …] [--out FILE]\n\nRuns the core again with what each step of the session "
      "was given, "
      "but with these values (SI units) in force from the first step\non, and prints which live values would have been others: since when, "
      "and by "
      "how much. --out writes all live values as CSV.\nPatient and hoist do not react to the new values: what was measured stays as "
      "recorded, so "
      "the "
      "wheels go on as they did then.\n",
      out);
}

/// How far each live value came from the recorded one.
class Deviations {
 public:
  void add(const RerunStep& step) {
    if (step.recorded.empty() || step.row.empty()) return;
    for (std::size_t c = 0; c < contract::kSignalCount; ++c) {
      if (step.row[c] == step.recorded[c]) continue;
      Row& row = rows_[c];
      if (row.steps++ == 0) row.first_tick = step.tick;
      row.most = std::max(row.most, std::fabs(static_cast<double>(step.row[c]) - static_cast<double>(step.recorded[c])));
    }
  }
  void print() const {
    std::printf("%-28s %12s %12s %14s\n", "live value", "first tick", "steps", "largest change");
    for (std::size_t c = 0; c < contract::kSignalCount; ++c) {
      const contract::SignalInfo& signal = contract::kSignals[c];
      if (rows_[c].steps > 0)
        std::printf("%-28s %12llu %12llu %14.6g %s\n", std::string(signal.name).c_str(), rows_[c].first_tick, rows_[c].steps,
                    rows_[c].most * signal.lsb, std::string(signal.unit).c_str());
    }
  }

 private:
  struct Row {
    unsigned long long first_tick = 0, steps = 0;
    double most = 0;
  };
  std::array<Row, contract::kSignalCount> rows_{};
};

void write_csv_head(std::FILE* out) {
  for (std::size_t c = 0; c < contract::kSignalCount; ++c)
    std::fprintf(out, "%s%s", c == 0 ? "" : ",", std::string(contract::kSignals[c].name).c_str());
  std::fputc('\n', out);
}
void write_csv_row(std::FILE* out, const RerunStep& step) {
  for (std::size_t c = 0; c < step.row.size(); ++c)
    std::fprintf(out, "%s%.10g", c == 0 ? "" : ",", static_cast<double>(step.row[c]) * contract::kSignals[c].lsb);
  std::fputc('\n', out);
}

}  // namespace

int run_replay(std::span<const std::string_view> arguments) {
  std::vector<std::string_view> places;
  std::vector<ParameterChange> changes;
  std::string out_file;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string_view argument = arguments[i];
    if (argument == "--help") {
      print_replay_help(stdout);
      return kDone;
    }
    if (argument == "--set" || argument == "--out") {
      if (++i == arguments.size()) return bad_usage("replay", std::string(argument) + " needs a value");
      if (argument == "--out")
        out_file = arguments[i];
      else if (const std::string problem = parse_change(arguments[i], changes); !problem.empty())
        return bad_usage("replay", problem);
    } else if (argument.starts_with("--")) {
      return bad_usage("replay", "there is no option " + std::string(argument));
    } else {
      places.push_back(argument);
    }
  }
  const auto session = places.size() == 2 ? parse_session(places[1]) : std::nullopt;
  if (!session) return bad_usage("replay", "name a database and a session's number");
  if (changes.empty()) return bad_usage("replay", "--set says what is to be another; hoist verify runs a session as it was");
  db::Result<db::Database> database = db::Database::attach(std::string(places[0]));
  if (!database) return refuse("replay", database.error());
  OutFile file;
  if (!out_file.empty()) {
    if (const db::Status opened = file.open(out_file); !opened) return refuse("replay", opened.error());
    write_csv_head(file.stream());
  }
  Deviations deviations;
  const auto report = rerun(*database, *session, contract::program_version(), changes, [&](const RerunStep& step) {
    deviations.add(step);
    if (!out_file.empty() && !step.row.empty()) write_csv_row(file.stream(), step);
  });
  if (!report) return refuse("replay", report.error());
  if (!out_file.empty())
    if (const db::Status written = file.finish(); !written) return refuse("replay", written.error());
  deviations.print();
  for (const NotRun& hole : report->not_run)
    std::printf("not run again: ticks %llu to %llu: %s\n", static_cast<unsigned long long>(hole.from_tick),
                static_cast<unsigned long long>(hole.to_tick), hole.reason.c_str());
  return kDone;
}

}  // namespace hoist::tool
