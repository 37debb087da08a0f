// hoist-family: the family of patients walks, falls and faints in virtual time (deploy/dev family).
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/family/falls.hpp"
#include "tests/family/guards.hpp"
#include "tests/family/walks.hpp"

namespace {

using namespace hoist::family;
using hoist::contract::Mode;
using hoist::sim::FamilyMember;
using hoist::sim::kPatientFamily;

constexpr std::array kWalkModes{Mode::user, Mode::remote, Mode::guided};
constexpr double kPiece_s = 600.0;

struct Options {
  double hours = 1.0;  // of each patient in each mode
  int falls = 10;      // of each kind by each patient in each mode
  std::uint64_t seed = 1;
  unsigned jobs = std::max(1U, std::thread::hardware_concurrency());
  bool tradeoff = false;
  std::vector<const FamilyMember*> members;
  hoist::contract::Params params{};
};

[[noreturn]] void refuse(const std::string& why) {
  std::fprintf(stderr, "hoist-family: %s\n", why.c_str());
  std::exit(2);
}

void usage() {
  std::puts(
      "hoist-family: patients of many illnesses walk, fall and faint in virtual time\n"
      "  --hours H         of each patient in each mode (default 1)\n"
      "  --falls N         of each kind by each patient in each mode (default 10)\n"
      "  --patient NAME    only this one; may be repeated\n"
      "  --seed S          (default 1)\n"
      "  --set NAME=VALUE  a parameter of the core, in its own unit; may be repeated\n"
      "  --tradeoff        for each guard: false stops and falls found, over a range of each threshold\n"
      "  --jobs N          at a time (default: processors)");
}

void set(Options& options, const std::string& text) {
  const std::size_t at = text.find('=');
  for (std::size_t i = 0; at != std::string::npos && i < hoist::contract::kParams.size(); ++i) {
    if (hoist::contract::kParams[i].name != std::string_view(text).substr(0, at)) continue;
    hoist::contract::set_param_unchecked(options.params, i, std::atof(text.c_str() + at + 1));
    return;
  }
  refuse("--set: NAME=VALUE with the name of a parameter, not '" + text + "'");
}

Options read(int argc, char** argv) {
  Options options;
  for (int i = 1; i < argc; ++i) {
    const std::string name = argv[i];
    if (name == "--help" || name == "-h") {
      usage();
      std::exit(0);
    }
    if (name == "--tradeoff") {
      options.tradeoff = true;
      continue;
    }
    if (i + 1 == argc) refuse(name + " is no option, or lacks its value");
    const std::string value = argv[++i];
    if (name == "--patient") {
      const FamilyMember* member = hoist::sim::find_patient(value);
      if (member == nullptr) refuse("--patient: no '" + value + "'; hoist-sim --list names them");
      options.members.push_back(member);
    } else if (name == "--set") {
      set(options, value);
    } else {
      char* end = nullptr;
      const double number = std::strtod(value.c_str(), &end);
      if (end == value.c_str() || *end != '\0' || !(number >= 0.0)) refuse(name + " needs a number that is not negative");
      if (name == "--hours") {
        options.hours = number;
      } else if (name == "--falls") {
        options.falls = static_cast<int>(number);
      } else if (name == "--seed") {
        options.seed = static_cast<std::uint64_t>(number);
      } else if (name == "--jobs" && number >= 1.0) {
        options.jobs = static_cast<unsigned>(number);
      } else {
        refuse("unknown option '" + name + "'; --help lists them");
      }
    }
  }
  if (options.members.empty())
    for (const FamilyMember& member : kPatientFamily) options.members.push_back(&member);
  if (const char* wrong = hoist::contract::check_param_set(options.params)) refuse(wrong);
  return options;
}

// Every piece of work once, on as many threads as asked for.
void run_all(const std::vector<std::function<void()>>& work, unsigned jobs) {
  std::atomic<std::size_t> next{0};
  const auto worker = [&] {
    for (std::size_t i = next++; i < work.size(); i = next++) work[i]();
  };
  std::vector<std::thread> threads;
  for (unsigned i = 1; i < jobs; ++i) threads.emplace_back(worker);
  worker();
  for (std::thread& thread : threads) thread.join();
}

std::string_view mode_name(Mode mode) { return hoist::contract::kModes[static_cast<std::size_t>(mode)].name; }

// The same patients and seeds for every caller, in an order that does not depend on the threads.
void each_walk(const Options& options, const std::function<void(const WalkOptions&, std::size_t member, std::size_t mode)>& what) {
  const int pieces = std::max(1, static_cast<int>(options.hours * 3600.0 / kPiece_s + 0.5));
  for (std::size_t m = 0; options.hours > 0.0 && m < options.members.size(); ++m)
    for (std::size_t k = 0; k < kWalkModes.size(); ++k)
      for (int piece = 0; piece < pieces; ++piece) {
        WalkOptions walk{options.members[m], kWalkModes[k], options.seed + static_cast<std::uint64_t>(piece), 0.0, options.params};
        walk.length_s = options.hours * 3600.0 / pieces;
        what(walk, m, k);
      }
}
void each_fall(const Options& options, const std::function<void(const WalkOptions&, FallKind kind)>& what) {
  for (const FamilyMember* member : options.members)
    for (const Mode mode : kWalkModes)
      for (std::size_t kind = 0; kind < kFallNames.size(); ++kind)
        for (int i = 0; i < options.falls; ++i)
          what({member, mode, options.seed + 1000U + static_cast<std::uint64_t>(i), 0.0, options.params}, static_cast<FallKind>(kind));
}

int print_walks(const Options& options) {
  std::vector<std::array<WalkTally, kWalkModes.size()>> tallies(options.members.size());
  std::mutex mutex;
  std::vector<std::function<void()>> work;
  each_walk(options, [&](const WalkOptions& walk_options, std::size_t member, std::size_t mode) {
    work.emplace_back([&, walk_options, member, mode] {
      const WalkTally tally = walk(walk_options);
      const std::lock_guard lock(mutex);
      tallies[member][mode].add(tally);
    });
  });
  run_all(work, options.jobs);
  std::puts("| patient | mode | hours rolling | unasked stops | per hour | causes | of a frozen patient | starts refused |");
  std::puts("|---|---|---|---|---|---|---|---|");
  std::array<WalkTally, kWalkModes.size()> modes;
  WalkTally all;
  const auto row = [](std::string_view name, std::string_view mode, const WalkTally& tally) {
    std::string causes;
    for (const auto& [cause, count] : tally.unasked) causes += (causes.empty() ? "" : ", ") + cause + " " + std::to_string(count);
    const double hours = tally.rolling_s / 3600.0;
    std::printf("| %.*s | %.*s | %.2f | %d | %.2f | %s | %d | %d |\n", static_cast<int>(name.size()), name.data(),
                static_cast<int>(mode.size()), mode.data(), hours, tally.unasked_all(), tally.unasked_all() / std::max(hours, 1e-9),
                causes.c_str(), tally.frozen, tally.refused);
  };
  for (std::size_t m = 0; m < tallies.size(); ++m)
    for (std::size_t k = 0; k < kWalkModes.size(); ++k) {
      row(options.members[m]->name, mode_name(kWalkModes[k]), tallies[m][k]);
      modes[k].add(tallies[m][k]);
      all.add(tallies[m][k]);
    }
  for (std::size_t k = 0; k < kWalkModes.size(); ++k) row("all", mode_name(kWalkModes[k]), modes[k]);
  row("all", "all", all);
  return all.unasked_all();
}

int print_falls(const Options& options) {
  struct Sum {
    int found = 0, late = 0, rest = 0, none = 0;
    double worst_s = 0, fall_s = 0, hang_s = 0, lean_rad = 0;
  };
  std::array<std::array<Sum, kWalkModes.size()>, kFallNames.size()> sums{};
  std::mutex mutex;
  std::vector<std::function<void()>> work;
  std::vector<std::string> missed;
  each_fall(options, [&](const WalkOptions& walk_options, FallKind kind) {
    work.emplace_back([&, walk_options, kind] {
      const FallResult result = fall(walk_options, kind);
      const std::size_t mode =
          static_cast<std::size_t>(std::find(kWalkModes.begin(), kWalkModes.end(), walk_options.mode) - kWalkModes.begin());
      const std::lock_guard lock(mutex);
      Sum& sum = sums[static_cast<std::size_t>(kind)][mode];
      sum.found += result.end == FallEnd::found ? 1 : 0;
      sum.rest += result.end == FallEnd::at_rest ? 1 : 0;
      sum.none += result.end == FallEnd::not_begun ? 1 : 0;
      if (result.end == FallEnd::found || result.end == FallEnd::late) {
        sum.worst_s = std::max(sum.worst_s, result.found_s);
        sum.lean_rad = std::max(sum.lean_rad, result.lean_rad);
        double& after_s = result.fall ? sum.fall_s : sum.hang_s;
        if (result.owed_from_s >= 0.0) after_s = std::max(after_s, result.found_s - result.owed_from_s);
      }
      if (result.end != FallEnd::late) return;
      ++sum.late;
      missed.push_back(std::string(walk_options.member->name) + " " + std::string(mode_name(walk_options.mode)) + " " +
                       std::string(fall_name(kind)) + " seed " + std::to_string(walk_options.seed) + ": owed by " +
                       std::to_string(result.owed_by_s) + " s, " + std::to_string(result.found_s) + " s");
    });
  });
  run_all(work, options.jobs);
  std::puts(
      "\n| fall | mode | found in time | late | at rest before | never walked | longest, s | after H15's lean, ms | after H16's, s | "
      "largest lean at the stop, deg |");
  std::puts("|---|---|---|---|---|---|---|---|---|---|");
  int late = 0;
  for (std::size_t kind = 0; kind < sums.size(); ++kind)
    for (std::size_t k = 0; k < kWalkModes.size(); ++k) {
      const Sum& sum = sums[kind][k];
      late += sum.late;
      std::printf("| %.*s | %.*s | %d | %d | %d | %d | %.2f | %.0f | %.2f | %.1f |\n", static_cast<int>(kFallNames[kind].size()),
                  kFallNames[kind].data(), static_cast<int>(mode_name(kWalkModes[k]).size()), mode_name(kWalkModes[k]).data(), sum.found,
                  sum.late, sum.rest, sum.none, sum.worst_s, 1000.0 * sum.fall_s, sum.hang_s, sum.lean_rad / hoist::sim::kDegree_rad);
    }
  std::sort(missed.begin(), missed.end());
  for (const std::string& line : missed) std::printf("late: %s\n", line.c_str());
  return late;
}

void print_tradeoff(const Options& options) {
  std::vector<GuardCurve> curves = empty_curves();
  std::mutex mutex;
  std::vector<std::function<void()>> work;
  const auto add = [&](const std::vector<GuardCurve>& mine) {
    const std::lock_guard lock(mutex);
    for (std::size_t row = 0; row < curves.size(); ++row)
      for (std::size_t i = 0; i < curves[row].size(); ++i) {
        GuardPoint& to = curves[row][i];
        const GuardPoint& from = mine[row][i];
        to.hours += from.hours, to.false_stops += from.false_stops, to.falls += from.falls, to.in_time += from.in_time;
        to.worst_lean_rad = std::max(to.worst_lean_rad, from.worst_lean_rad);
        to.worst_after_s = std::max(to.worst_after_s, from.worst_after_s);
      }
  };
  each_walk(options, [&](const WalkOptions& walk_options, std::size_t, std::size_t) {
    work.emplace_back([&add, walk_options] {
      std::vector<GuardCurve> mine = empty_curves();
      watch_walk(walk_options, mine);
      add(mine);
    });
  });
  each_fall(options, [&](const WalkOptions& walk_options, FallKind kind) {
    work.emplace_back([&add, walk_options, kind] {
      std::vector<GuardCurve> mine = empty_curves();
      watch_fall(walk_options, kind, mine);
      add(mine);
    });
  });
  run_all(work, options.jobs);
  const hoist::contract::Params shipped;
  for (std::size_t row = 0; row < curves.size(); ++row) {
    const GuardRow& guard = guard_rows()[row];
    const double now = hoist::contract::get_param(shipped, hoist::contract::param_index(guard.param)) / guard.unit;
    std::printf(
        "\n%.*s, %.*s (now %g %.*s)\n\n| %.*s | false stops per hour | falls found in time | of | largest lean at the alarm, deg | "
        "longest, s |\n|---|---|---|---|---|---|\n",
        static_cast<int>(guard.guard.size()), guard.guard.data(), static_cast<int>(guard.what.size()), guard.what.data(), now,
        static_cast<int>(guard.printed.size()), guard.printed.data(), static_cast<int>(guard.printed.size()), guard.printed.data());
    for (const GuardPoint& point : curves[row])
      std::printf("| %g | %.2f | %d | %d | %.1f | %.2f |\n", point.value, point.false_stops / std::max(point.hours, 1e-9), point.in_time,
                  point.falls, point.worst_lean_rad / hoist::sim::kDegree_rad, point.worst_after_s);
  }
}

}  // namespace

int main(int argc, char** argv) {
  const Options options = read(argc, argv);
  if (options.tradeoff) {
    print_tradeoff(options);
    return 0;
  }
  const int unasked = options.hours > 0.0 ? print_walks(options) : 0;
  const int late = options.falls > 0 ? print_falls(options) : 0;
  std::printf("\n%d unasked stops, %d falls found late\n", unasked, late);
  return 0;
}
