// Starts the real programs for a measurement and ends them with it.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"

namespace hoist::bench {

using test::TemporaryFolder;

// A program with its output in a file; SIGTERM at the end, SIGKILL if it does not listen.
class Process {
 public:
  Process(const std::vector<std::string>& command, const std::string& output_path);
  // A fork of this program that runs `work`; for floors. Only while this program has one thread.
  explicit Process(const std::function<void()>& work);
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  [[nodiscard]] pid_t pid() const { return pid_; }
  // CPU time of all its threads so far, in nanoseconds, from the scheduler's own accounts.
  [[nodiscard]] std::uint64_t cpu_ns() const;
  // Memory of its own that is resident, without files' pages.
  [[nodiscard]] double resident_kb() const;
  [[nodiscard]] bool running() const;
  // Waits for its end; the status as waitpid gives it.
  int wait();

 private:
  pid_t pid_ = -1;
};

// An unused TCP port of this machine at the moment of the call.
[[nodiscard]] std::uint16_t free_port();
// A blocking connection to a local port, tried for a second. Throws when nothing listens.
[[nodiscard]] int connect_to(std::uint16_t port);
// The opening handshake of a WebSocket, and a connection behind it. Throws with the server's answer when it refuses.
[[nodiscard]] std::string websocket_request(std::uint16_t port, const std::string& token);
[[nodiscard]] int open_websocket(std::uint16_t port, const std::string& token);
// A text message as a client's frame, of at most 65535 bytes.
[[nodiscard]] std::string client_frame(const std::string& message);
// Whole records of every step: the most that a client can ask for.
inline constexpr const char* kAskWholeRecords = R"({"type":"stream","topics":["all"]})";
// One keep-alive HTTP connection with one open request.
class HttpConnection {
 public:
  explicit HttpConnection(std::uint16_t port) : fd_(connect_to(port)) {}
  ~HttpConnection();
  HttpConnection(const HttpConnection&) = delete;
  HttpConnection& operator=(const HttpConnection&) = delete;
  [[nodiscard]] int fd() const { return fd_; }
  void ask(const std::string& request);
  // Reads available bytes; true when the answer is complete. Throws unless it is a 200 with its length.
  bool take();
  [[nodiscard]] std::string body() const { return answer_.substr(body_at_); }
  // Sends a request and waits for the complete answer.
  std::string fetch(const std::string& request);

 private:
  int fd_;
  std::string answer_;
  std::size_t body_at_ = 0;
};
// A GET; `more`: further header lines, each with its end.
[[nodiscard]] std::string request_for(const std::string& path, std::uint16_t port, const std::string& token, const std::string& more = "");

// Without the line ends at its end; empty when the file is missing.
[[nodiscard]] std::string read_text(const std::string& path);

// The command that counts a program's instructions, to be put in front of its own; the sum is in `file` when the program has ended.
inline constexpr const char* kValgrind = "/usr/bin/valgrind";
[[nodiscard]] std::vector<std::string> under_callgrind(const std::string& file);
[[nodiscard]] double instructions_in(const std::string& file);

struct HoistOptions {
  bool server = true;
  std::string web = {};                        // the server's pages; empty: none
  std::string database = {};                   // empty: a new one
  std::vector<std::string> server_under = {};  // command in front of the server's, such as valgrind's
  std::string core_line = {};                  // serial line of the core; empty: the simulator's
  bool tls = false;                            // the server speaks TLS only, with a certificate of its own
};

// Simulator, hoist-control and hoist-server in their own folder; the simulated patient stands.
class RunningHoist {
 public:
  explicit RunningHoist(const std::string& bin, const HoistOptions& options = {});
  [[nodiscard]] std::string line() const { return folder_ / "can"; }  // the simulator's serial line
  [[nodiscard]] std::string core_socket() const { return folder_ / "core.sock"; }
  [[nodiscard]] const Process& control() const { return control_; }
  [[nodiscard]] const Process& server() const { return *server_; }
  [[nodiscard]] std::uint16_t port() const { return port_; }
  [[nodiscard]] const std::string& token() const { return token_; }  // of the engineer
  [[nodiscard]] std::string log() const { return read_text(folder_ / "log"); }

 private:
  TemporaryFolder folder_;
  std::uint16_t port_ = 0;
  std::string token_;
  Process sim_, control_;
  std::optional<Process> server_;
};

}  // namespace hoist::bench
