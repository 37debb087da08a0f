// Each export format of ten minutes and of an hour of walking, as `hoist export` writes it: size, CPU, and peak memory, which must not grow
// with the session. Then hoist-server's peak memory while it serves ten minutes and three hours.
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "db/export/formats.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"

namespace hoist::bench {
namespace {

constexpr double kShort_s = 600, kLong_s = 3600, kServed_s = 3 * 3600;

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

// A request on a connection of its own. The begin of the answer; the rest is read and forgotten, as a browser writes it to a disk.
std::string answer_to(std::uint16_t port, const std::string& request) {
  const int fd = connect_to(port);
  (void)!::send(fd, request.data(), request.size(), MSG_NOSIGNAL);
  std::string begin;
  std::array<char, 65536> piece{};
  for (ssize_t got = 0; (got = ::recv(fd, piece.data(), piece.size(), 0)) > 0;)
    if (begin.size() < 4096) begin.append(piece.data(), static_cast<std::size_t>(got));
  ::close(fd);
  if (begin.find("HTTP/1.1 20") != 0) throw std::runtime_error("hoist-server answered: " + begin.substr(0, 200));
  return begin;
}

double peak_mb(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/status");
  for (std::string word; file >> word;)
    if (double kb = 0; word == "VmHWM:" && file >> kb) return kb / 1024;
  throw std::runtime_error("/proc tells no VmHWM");
}

// The server's peak after serving the only session as this format; "bids": as a job, and then its file.
double served_peak_mb(const std::string& bin, const std::string& database, const std::string& format) {
  const RunningHoist hoist(bin, {.database = database});
  const auto get = [&](const std::string& path) {
    return answer_to(hoist.port(), request_for(path, hoist.port(), hoist.token(), "Connection: close\r\n"));
  };
  // The check of the file that each start begins with has memory of its own: let it end first.
  const auto ended = [&](const std::string& path) {
    for (;; ::poll(nullptr, 0, 200)) {
      const std::string job = get(path);
      if (job.find("\"failed\"") != std::string::npos) throw std::runtime_error("a job failed: " + job);
      const auto is = [&job](const char* state) { return job.find(state) != std::string::npos; };
      if (is("\"state\"") && !is("\"waiting\"") && !is("\"running\"")) return;
    }
  };
  ended("/api/v1/jobs");
  if (format != "bids") {
    (void)get("/api/v1/sessions/1/export?format=" + format);
    return peak_mb(hoist.server().pid());
  }
  const std::string body = R"({"kind":"export_sessions","sessions":[1],"layout":"bids"})";
  std::string request =
      request_for("/api/v1/jobs", hoist.port(), hoist.token(),
                  "Connection: close\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(body.size()) + "\r\n");
  request.replace(0, 3, "POST");
  const std::string begun = answer_to(hoist.port(), request + body);
  constexpr std::string_view kLocation = "Location: ";
  const std::size_t at = begun.find(kLocation) + kLocation.size();
  const std::string job = begun.substr(at, begun.find('\r', at) - at);
  ended(job);
  (void)get(job + "/file");
  return peak_mb(hoist.server().pid());
}

}  // namespace

void measure_served(Report& report, const std::string& bin) {
  const TemporaryFolder folder;
  report.progress("recording ten minutes and three hours of walking");
  record_walk(folder.file("short.db"), kShort_s);
  record_walk(folder.file("long.db"), kServed_s);
  std::vector<std::string> formats{"bids"};
  for (const db::ExportFormatInfo& format : db::kExportFormats) formats.emplace_back(format.name);
  for (const std::string& format : formats) {
    report.progress("serving as " + format);
    const double few = served_peak_mb(bin, folder.file("short.db"), format), many = served_peak_mb(bin, folder.file("long.db"), format);
    report.add({"served." + format + ".memory", format + ": hoist-server's peak, three hours", many, "MB", few, "ten minutes", {1.2}});
  }
}

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
