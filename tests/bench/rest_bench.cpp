// CPU of hoist-server per request beside nginx, which serves the same bytes to the same client.
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

// One keep-alive connection with one request under way.
class Connection {
 public:
  explicit Connection(std::uint16_t port) : fd_(connect_to(port)) {}
  ~Connection() { ::close(fd_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;
  [[nodiscard]] int fd() const { return fd_; }
  void ask(const std::string& request) {
    answer_.clear();
    if (::send(fd_, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size()))
      throw std::runtime_error("cannot send a request");
  }
  // Takes what has arrived; true when the answer is whole. Throws unless it is a 200 with its length.
  bool take() {
    char buffer[65536];
    const ssize_t got = ::recv(fd_, buffer, sizeof buffer, 0);
    if (got <= 0) throw std::runtime_error("the connection was closed after: " + answer_.substr(0, 100));
    answer_.append(buffer, static_cast<std::size_t>(got));
    const std::size_t head = answer_.find("\r\n\r\n");
    if (head == std::string::npos) return false;
    const std::size_t length = answer_.find("Content-Length: ");
    if (answer_.compare(0, 12, "HTTP/1.1 200") != 0 || length > head)
      throw std::runtime_error("unexpected answer: " + answer_.substr(0, 100));
    body_at_ = head + 4;
    return answer_.size() >= body_at_ + std::stoul(answer_.substr(length + 16));
  }
  [[nodiscard]] std::string body() const { return answer_.substr(body_at_); }

 private:
  int fd_;
  std::string answer_;
  std::size_t body_at_ = 0;
};

std::string request_for(const std::string& path, std::uint16_t port, const std::string& token) {
  return "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\nAuthorization: Bearer " + token + "\r\n\r\n";
}
std::string fetch(std::uint16_t port, const std::string& request) {
  Connection connection(port);
  connection.ask(request);
  while (!connection.take()) {
  }
  return connection.body();
}
// Answers within kTurn_s.
std::uint64_t load(std::uint16_t port, const std::string& request) {
  std::vector<std::unique_ptr<Connection>> connections;
  std::vector<pollfd> waits;
  for (int i = 0; i < kConnections; ++i) {
    connections.push_back(std::make_unique<Connection>(port));
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
    temp += std::string(what) + "_temp_path " + (folder / "tmp;\n");
  write_file(folder / "nginx.conf", "daemon off; master_process off; pid " + (folder / "pid") + "; error_log " + (folder / "log") +
                                        ";\nevents { worker_connections 256; }\nhttp { access_log off; sendfile on;\n" + temp +
                                        "default_type application/json; open_file_cache max=100; keepalive_requests 1000000000;\n" +
                                        "server { listen 127.0.0.1:" + std::to_string(port) + "; root " + (folder / "www") + "; } }\n");
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
}  // namespace

void measure_rest(Report& report, const std::string& bin) {
  const Row status{"rest.status", "CPU per GET of the status, 8 connections", 0, "", 0, ""};
  const Row file{"rest.file", "CPU per GET of a file of 30 kB", 0, "", 0, ""};
  if (::access(kNginx, X_OK) != 0) {
    for (const Row& row : {status, file}) report.skip(row.id, row.what, std::string("nginx is missing (") + kNginx + ")");
    return;
  }
  const TemporaryFolder folder;
  write_file(folder / "www/index.html", "<!doctype html>\n");
  std::string page(kFileBytes, ' ');
  for (std::size_t i = 0; i < page.size(); ++i) page[i] = static_cast<char>('a' + i * i % 23);
  write_file((folder / "www") + kFilePath, page);
  const RunningHoist hoist(bin, "stand", true, folder / "www");
  ::poll(nullptr, 0, 2000);
  const std::string status_request = request_for(kStatusPath, hoist.port(), hoist.token());
  const std::string file_request = request_for(kFilePath, hoist.port(), hoist.token());
  write_file((folder / "www") + kStatusPath, fetch(hoist.port(), status_request));
  const std::uint16_t port = free_port();
  write_nginx_settings(folder, port);
  const Process nginx({kNginx, "-e", folder / "log", "-c", folder / "nginx.conf"}, folder / "log");
  if (fetch(port, file_request) != page) throw std::runtime_error("nginx serves other bytes");
  measure_pair(report, status, {hoist.server(), hoist.port(), status_request}, {nginx, port, status_request});
  measure_pair(report, file, {hoist.server(), hoist.port(), file_request}, {nginx, port, file_request});
}

}  // namespace hoist::bench
