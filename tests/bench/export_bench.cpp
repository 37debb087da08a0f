// Each export format of ten minutes and of an hour of walking, as `hoist export` writes it: size, CPU, and peak memory, which must not grow
// with the session.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "db/export/formats.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"

namespace hoist::bench {
namespace {

constexpr double kShort_s = 600, kLong_s = 3600;

struct Cost {
  double size_mb = 0, cpu_s = 0, peak_mb = 0;
};

// getrusage() of all children would give the largest of all programs before.
Cost run(const std::vector<std::string>& command, const std::string& out) {
  const pid_t child = ::fork();
  if (child < 0) throw std::runtime_error("no process can be started");
  if (child == 0) {
    std::vector<char*> words;
    for (const std::string& word : command) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    ::execv(words[0], words.data());
    ::_exit(127);
  }
  int status = 0;
  rusage used{};
  if (::wait4(child, &status, 0, &used) != child || status != 0) throw std::runtime_error(command[0] + " export failed");
  const auto seconds = [](const timeval& t) { return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_usec) * 1e-6; };
  return {static_cast<double>(std::filesystem::file_size(out)) * 1e-6, seconds(used.ru_utime) + seconds(used.ru_stime),
          static_cast<double>(used.ru_maxrss) / 1024};
}

}  // namespace

void measure_export(Report& report, const std::string& bin) {
  const TemporaryFolder folder;
  report.progress("recording ten minutes and an hour of walking");
  record_walk(folder.file("short.db"), kShort_s);
  record_walk(folder.file("long.db"), kLong_s);
  for (const db::ExportFormatInfo& format : db::kExportFormats) {
    const std::string name(format.name), out = folder.file("out");
    report.progress("exporting as " + name);
    std::array<Cost, 2> cost;
    for (std::size_t i = 0; i < cost.size(); ++i) {
      cost[i] = run({bin + "/hoist", "export", folder.file(i == 0 ? "short.db" : "long.db"), "1", "--format", name, "--out", out}, out);
      std::filesystem::remove(out);
    }
    const auto ten_minutes = [](double value, const char* unit) {
      std::array<char, 48> text{};
      std::snprintf(text.data(), text.size(), "ten minutes: %.3g %s", value, unit);
      return std::string(text.data());
    };
    report.add(
        {"export." + name + ".size", name + ": an hour", cost[1].size_mb, "MB", 0, "", {}, true, ten_minutes(cost[0].size_mb, "MB")});
    report.add(
        {"export." + name + ".cpu", name + ": CPU of an hour", cost[1].cpu_s, "s", 0, "", {}, false, ten_minutes(cost[0].cpu_s, "s")});
    report.add(
        {"export." + name + ".memory", name + ": peak memory of an hour", cost[1].peak_mb, "MB", cost[0].peak_mb, "ten minutes", {1.2}});
  }
}

}  // namespace hoist::bench
