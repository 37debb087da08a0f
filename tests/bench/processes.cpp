#include "tests/bench/processes.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace hoist::bench {

Process::Process(const std::vector<std::string>& command, const std::string& output_path) {
  pid_ = ::fork();
  if (pid_ < 0) throw std::runtime_error("cannot start " + command[0]);
  if (pid_ > 0) return;
  const int output = ::open(output_path.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
  ::dup2(output, 1);
  ::dup2(output, 2);
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  ::execv(arguments[0], arguments.data());
  ::_exit(127);
}
Process::Process(const std::function<void()>& work) : pid_(::fork()) {
  if (pid_ < 0) throw std::runtime_error("cannot fork");
  if (pid_ > 0) return;
  work();
  ::_exit(0);
}
Process::~Process() {
  if (pid_ <= 0) return;
  ::kill(pid_, SIGTERM);
  for (int i = 0; i < 50; ++i) {
    if (::waitpid(pid_, nullptr, WNOHANG) == pid_) return;
    ::poll(nullptr, 0, 100);
  }
  ::kill(pid_, SIGKILL);
  ::waitpid(pid_, nullptr, 0);
}
std::uint64_t Process::cpu_ns() const {
  std::uint64_t sum = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(pid_) + "/task")) {
    std::ifstream file(task.path() / "schedstat");
    std::uint64_t on_cpu = 0;
    file >> on_cpu;
    sum += on_cpu;
  }
  return sum;
}
double Process::resident_kb() const {
  std::ifstream file("/proc/" + std::to_string(pid_) + "/status");
  for (std::string word; file >> word;)
    if (word == "RssAnon:") {
      double kb = 0;
      file >> kb;
      return kb;
    }
  throw std::runtime_error("/proc tells no RssAnon");
}
int Process::wait() {
  int status = -1;
  ::waitpid(pid_, &status, 0);
  pid_ = -1;
  return status;
}
bool Process::running() const { return pid_ > 0 && ::kill(pid_, 0) == 0 && ::waitpid(pid_, nullptr, WNOHANG) == 0; }

std::uint16_t free_port() {
  const int probe = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  ::bind(probe, reinterpret_cast<sockaddr*>(&address), size);
  ::getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size);
  ::close(probe);
  return ntohs(address.sin_port);
}
int connect_to(std::uint16_t port) {
  const int fd = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  for (int i = 0; i < 50; ++i, ::poll(nullptr, 0, 20))
    if (::connect(fd, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0) return fd;
  ::close(fd);
  throw std::runtime_error("nothing listens on port " + std::to_string(port));
}

std::string websocket_request(std::uint16_t port, const std::string& token) {
  return "GET /ws HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) +
         "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
         "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: hoist.v1\r\nAuthorization: Bearer " +
         token + "\r\n\r\n";
}
int open_websocket(std::uint16_t port, const std::string& token) {
  const int fd = connect_to(port);
  // As browsers do: otherwise a small message waits up to 40 ms for the acknowledgement of the one before it.
  const int now = 1;
  ::setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &now, sizeof now);
  const std::string request = websocket_request(port, token);
  std::string answer;
  char byte = 0;
  (void)!::send(fd, request.data(), request.size(), MSG_NOSIGNAL);
  while (answer.find("\r\n\r\n") == std::string::npos && ::recv(fd, &byte, 1, 0) == 1) answer += byte;
  if (answer.find(" 101 ") != std::string::npos) return fd;
  ::close(fd);
  throw std::runtime_error("hoist-server refused a WebSocket: " + answer.substr(0, 60));
}
std::string client_frame(const std::string& message) {
  std::string frame{static_cast<char>(0x81)};
  if (message.size() < 126) {
    frame.push_back(static_cast<char>(0x80U | message.size()));
  } else {
    frame.push_back(static_cast<char>(0x80U | 126U));
    frame.push_back(static_cast<char>(message.size() >> 8));
    frame.push_back(static_cast<char>(message.size() & 0xFF));
  }
  frame.append(4, '\0');  // a mask of zeros leaves the text as it is
  return frame + message;
}
HttpConnection::~HttpConnection() { ::close(fd_); }
void HttpConnection::ask(const std::string& request) {
  answer_.clear();
  if (::send(fd_, request.data(), request.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(request.size()))
    throw std::runtime_error("cannot send a request");
}
bool HttpConnection::take() {
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
std::string HttpConnection::fetch(const std::string& request) {
  ask(request);
  while (!take()) {
  }
  return body();
}
std::string request_for(const std::string& path, std::uint16_t port, const std::string& token, const std::string& more) {
  return "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\nAuthorization: Bearer " + token + "\r\n" + more +
         "\r\n";
}

std::string read_text(const std::string& path) {
  std::ifstream file(path);
  std::stringstream all;
  all << file.rdbuf();
  std::string text = all.str();
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
  return text;
}

std::vector<std::string> under_callgrind(const std::string& file) {
  return {kValgrind, "--tool=callgrind", "--callgrind-out-file=" + file};
}
double instructions_in(const std::string& file) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("totals: ")) return std::stod(line.substr(8));
  throw std::runtime_error("callgrind wrote no totals");
}

RunningHoist::RunningHoist(const std::string& bin, const HoistOptions& options)
    : sim_({bin + "/hoist-sim", "--scenario", "stand", "--pty-link", line(), "--control", folder_.file("sim.sock")}, folder_.file("log")),
      control_(
          {bin + "/hoist-control", "--bus", "slcan:" + (options.core_line.empty() ? line() : options.core_line), "--socket", core_socket()},
          folder_.file("log")) {
  if (!options.server) return;
  port_ = free_port();
  std::vector<std::string> command = options.server_under;
  for (const std::string& word : {bin + "/hoist-server", std::string("--socket"), core_socket(), std::string("--port"),
                                  std::to_string(port_), std::string("--web"), options.web.empty() ? folder_.file("none") : options.web,
                                  std::string("--db"), options.database.empty() ? folder_.file("hoist.db") : options.database,
                                  std::string("--scenario"), std::string("stand"), std::string("--token-file"), folder_.file("token")})
    command.push_back(word);
  if (options.tls) command.insert(command.end(), {"--tls-dir", folder_.file("tls")});
  server_.emplace(command, folder_.file("log"));
  // Half a minute: under valgrind a start takes its time.
  for (int i = 0; i < 1500 && token_.empty(); ++i) {
    ::poll(nullptr, 0, 20);
    token_ = read_text(folder_.file("token"));
  }
  if (token_.empty()) throw std::runtime_error("hoist-server did not come up: " + log());
}

}  // namespace hoist::bench
