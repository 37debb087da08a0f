// hoist-bench: every figure beside the floor measured in the same run.
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>

#include "tests/bench/bench.hpp"

namespace {
using hoist::bench::Row;

void print(const Row& row) {
  std::string verdict;
  if (row.floor > 0) {
    const double ratio = row.value / row.floor;
    char text[160];
    std::snprintf(text, sizeof text, "%.2f x %s (%.3g %s)", ratio, row.floor_what.c_str(), row.floor, row.unit.c_str());
    verdict = text;
    if (row.goal_ratio > 0) {
      std::snprintf(text, sizeof text, "; goal <= %.2f: %s", row.goal_ratio, ratio <= row.goal_ratio ? "met" : "MISSED");
      verdict += text;
    }
  } else if (row.goal_value > 0) {
    char text[80];
    const bool met = row.more_is_better ? row.value >= row.goal_value : row.value <= row.goal_value;
    std::snprintf(text, sizeof text, "goal %s %.4g: %s", row.more_is_better ? ">=" : "<=", row.goal_value, met ? "met" : "MISSED");
    verdict = text;
  }
  std::printf("%-62s %10.4g %-4s %s%s%s\n", row.what.c_str(), row.value, row.unit.c_str(), verdict.c_str(), row.note.empty() ? "" : "  [",
              row.note.empty() ? "" : (row.note + "]").c_str());
  std::fflush(stdout);
}
}  // namespace

int main(int argc, char** argv) {
  const std::string only = argc > 1 ? argv[1] : "";
  if (only == "--help") {
    std::printf("hoist-bench [law|memory|simulator|loop|websocket]: measures, prints one table; no argument: everything\n");
    return 0;
  }
  const std::string bin = std::filesystem::read_symlink("/proc/self/exe").parent_path().string();
  struct Section {
    const char* name;
    hoist::bench::Rows (*measure)(const std::string& bin);
  };
  const Section sections[] = {
      {"law", [](const std::string&) { return hoist::bench::measure_law_and_tick(); }},
      {"memory", [](const std::string&) { return hoist::bench::measure_shared_memory(); }},
      {"simulator", [](const std::string&) { return hoist::bench::measure_simulator(); }},
      {"loop", [](const std::string& b) { return hoist::bench::measure_loop(b, 15.0); }},
      {"websocket", [](const std::string& b) { return hoist::bench::measure_websocket(b, 50, 8.0); }},
  };
  int failed = 0, run = 0;
  for (const Section& section : sections) {
    if (!only.empty() && only != section.name) continue;
    ++run;
    try {
      for (const Row& row : section.measure(bin)) print(row);
    } catch (const std::exception& problem) {
      std::printf("%-62s not measured: %s\n", section.name, problem.what());
      ++failed;
    }
  }
  if (run == 0) {
    std::printf("hoist-bench: there is no section \"%s\"\n", only.c_str());
    return 2;
  }
  return failed == 0 ? 0 : 1;
}
