// CPU of hoist-server per request beside nginx, which serves the same bytes to the same client; and of the overview of an hour.
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/bench/bench.hpp"
#include "tests/bench/processes.hpp"
#include "tests/bench/statistics.hpp"

namespace hoist::bench {
namespace {
constexpr const char* kNginx = "/usr/sbin/nginx";
constexpr int kPairs = 6, kConnections = 8;
constexpr double kTurn_s = 0.7;
constexpr std::size_t kFileBytes = 30'000;
constexpr const char* kStatusPath = "/api/v1/status";
constexpr const char* kFilePath = "/page.js";

// Answers within kTurn_s.
std::uint64_t load(std::uint16_t port, const std::string& request) {
  std::vector<std::unique_ptr<HttpConnection>> connections;
  std::vector<pollfd> waits;
  for (int i = 0; i < kConnections; ++i) {
    connections.push_back(std::make_unique<HttpConnection>(port));
    connections.back()->ask(request);
    waits.push_back({connections.back()->fd(), POLLIN, 0});
  }
  std::uint64_t answers = 0;
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(kTurn_s);
  while (Clock::now() < end) {
    ::poll(waits.data(), waits.size(), 100);
    for (std::size_t i = 0; i < waits.size(); ++i) {
      if ((waits[i].revents & POLLIN) == 0 || !connections[i]->take()) continue;
      ++answers;
      connections[i]->ask(request);
    }
  }
  return answers;
}

struct Peer {
  const Process& process;
  std::uint16_t port;
  std::string request;
  std::vector<double> us_per_request = {};
  void turn() {
    const std::uint64_t before = process.cpu_ns();
    const std::uint64_t answers = load(port, request);
    if (answers == 0) throw std::runtime_error("no answer within a turn");
    us_per_request.push_back(static_cast<double>(process.cpu_ns() - before) * 1e-3 / static_cast<double>(answers));
  }
};

void write_file(const std::string& path, const std::string& text) {
  std::filesystem::create_directories(std::filesystem::path(path).parent_path());
  if (!(std::ofstream(path) << text << std::flush)) throw std::runtime_error("cannot write " + path);
}
void write_nginx_settings(const TemporaryFolder& folder, std::uint16_t port) {
  std::string temp;
  for (const char* what : {"client_body", "proxy", "fastcgi", "uwsgi", "scgi"})
    temp += std::string(what) + "_temp_path " + folder.file("tmp;\n");
  write_file(folder.file("nginx.conf"), "daemon off; master_process off; pid " + folder.file("pid") + "; error_log " + folder.file("log") +
                                            ";\nevents { worker_connections 256; }\nhttp { access_log off; sendfile on;\n" + temp +
                                            "default_type application/json; open_file_cache max=100; keepalive_requests 1000000000;\n" +
                                            "server { listen 127.0.0.1:" + std::to_string(port) + "; root " + folder.file("www") +
                                            "; } }\n");
}

void measure_pair(Report& report, Row row, Peer ours, Peer theirs) {
  report.progress(row.what);
  for (int pair = 0; pair < kPairs; ++pair) {
    Peer& first = pair % 2 == 0 ? ours : theirs;
    Peer& second = pair % 2 == 0 ? theirs : ours;
    first.turn();
    second.turn();
  }
  row.value = median(ours.us_per_request);
  row.floor = median(theirs.us_per_request);
  row.unit = "us";
  row.floor_what = "nginx";
  row.goal = {1.0};
  report.add(row);
}

// CPU of all threads of the server for the overview of six values over an hour.
void measure_overview(Report& report, const std::string& bin) {
  constexpr int kRequests = 200;
  constexpr const char* kPath =
      "/api/v1/sessions/1/samples?points=1000&columns=speed_m_s,yaw_rate_rad_s,lean_norm,turn_norm,left_current_a,right_current_a";
  report.progress("recording an hour of simulated walking");
  const TemporaryFolder folder;
  record_walk(folder.file("hour.db"), 3600);
  const RunningHoist hoist(bin, {.database = folder.file("hour.db")});
  report.progress("its overview");
  for (const bool gzip : {false, true}) {
    const std::string request = request_for(kPath, hoist.port(), hoist.token(), gzip ? "Accept-Encoding: gzip\r\n" : "");
    HttpConnection connection(hoist.port());
    for (int i = 0; i < 10; ++i) (void)connection.fetch(request);
    const std::uint64_t before = hoist.server().cpu_ns();
    for (int i = 0; i < kRequests; ++i) (void)connection.fetch(request);
    const double ms = static_cast<double>(hoist.server().cpu_ns() - before) * 1e-6 / kRequests;
    const std::string size = std::to_string(connection.body().size()) + " B, six values";
    if (gzip)
      report.add({"rest.overview_gzip", "CPU of the overview of an hour, gzip", ms, "ms", 0, "", {2}, false, size});
    else
      report.add({"rest.overview", "CPU of the overview of an hour", ms, "ms", 0, "", {2}, false, size});
  }
}

// Instructions of one of `count` GETs of the status and everything else the process does meanwhile.
constexpr int kFewRequests = 200, kManyRequests = 1200;
double ours_instructions(const std::string& bin, int count, std::string& answer) {
  const TemporaryFolder folder;
  {
    const RunningHoist hoist(bin, {.server_under = under_callgrind(folder.file("counts"))});
    const std::string request = request_for(kStatusPath, hoist.port(), hoist.token());
    HttpConnection connection(hoist.port());
    for (int i = 0; i < count; ++i) answer = connection.fetch(request);
  }
  return instructions_in(folder.file("counts"));
}
double nginx_instructions(const std::string& body, int count) {
  const TemporaryFolder folder;
  write_file(folder.file("www") + kStatusPath, body);
  const std::uint16_t port = free_port();
  write_nginx_settings(folder, port);
  {
    std::vector<std::string> command = under_callgrind(folder.file("counts"));
    command.insert(command.end(), {kNginx, "-e", folder.file("log"), "-c", folder.file("nginx.conf")});
    const Process nginx(command, folder.file("log"));
    const std::string request = request_for(kStatusPath, port, "none");
    HttpConnection connection(port);
    for (int i = 0; i < count; ++i) (void)connection.fetch(request);
  }
  return instructions_in(folder.file("counts"));
}
}  // namespace

void measure_status_instructions(Report& report, const std::string& bin) {
  Row row{"instructions.status", "instructions of a GET of the status", 0, "instr", 0, "nginx", {}, true, "the same bytes from a file"};
  for (const char* peer : {kValgrind, kNginx})
    if (::access(peer, X_OK) != 0) {
      report.skip(row.id, row.what, std::string(peer) + " is missing");
      return;
    }
  report.progress(row.what);
  std::string answer;
  const double few = ours_instructions(bin, kFewRequests, answer), many = ours_instructions(bin, kManyRequests, answer);
  row.value = (many - few) / (kManyRequests - kFewRequests);
  row.floor = (nginx_instructions(answer, kManyRequests) - nginx_instructions(answer, kFewRequests)) / (kManyRequests - kFewRequests);
  report.add(row);
}

void measure_rest(Report& report, const std::string& bin) {
  measure_overview(report, bin);
  const Row status{"rest.status", "CPU per GET of the status, 8 connections", 0, "", 0, ""};
  const Row file{"rest.file", "CPU per GET of a file of 30 kB", 0, "", 0, ""};
  if (::access(kNginx, X_OK) != 0) {
    for (const Row& row : {status, file}) report.skip(row.id, row.what, std::string("nginx is missing (") + kNginx + ")");
    return;
  }
  const TemporaryFolder folder;
  write_file(folder.file("www/index.html"), "<!doctype html>\n");
  std::string page(kFileBytes, ' ');
  for (std::size_t i = 0; i < page.size(); ++i) page[i] = static_cast<char>('a' + i * i % 23);
  write_file(folder.file("www") + kFilePath, page);
  const RunningHoist hoist(bin, {.web = folder.file("www")});
  ::poll(nullptr, 0, 2000);
  const std::string status_request = request_for(kStatusPath, hoist.port(), hoist.token());
  const std::string file_request = request_for(kFilePath, hoist.port(), hoist.token());
  write_file(folder.file("www") + kStatusPath, HttpConnection(hoist.port()).fetch(status_request));
  const std::uint16_t port = free_port();
  write_nginx_settings(folder, port);
  const Process nginx({kNginx, "-e", folder.file("log"), "-c", folder.file("nginx.conf")}, folder.file("log"));
  if (HttpConnection(port).fetch(file_request) != page) throw std::runtime_error("nginx serves other bytes");
  measure_pair(report, status, {hoist.server(), hoist.port(), status_request}, {nginx, port, status_request});
  measure_pair(report, file, {hoist.server(), hoist.port(), file_request}, {nginx, port, file_request});
}

}  // namespace hoist::bench
