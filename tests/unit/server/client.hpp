// Test clients over plain sockets: HTTP answers, WebSocket messages, raw bytes. They share no parser with the server and refuse what the RFCs do
// not allow. Beast's client would do the same for 46 s and 1.2 GB of the compiler.
#pragma once
#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "control/contract/signals.hpp"

namespace hoist::test {

using Headers = std::vector<std::pair<std::string, std::string>>;

struct Answer {
  unsigned status = 0;
  std::map<std::string, std::string> headers;  // names in lower case
  std::string body;
  [[nodiscard]] nlohmann::json json() const;
  [[nodiscard]] std::string header(const std::string& name) const;
};

// One request on its own connection. Host and Content-Length are added unless given.
Answer http(std::uint16_t port, const std::string& method, const std::string& target, const Headers& headers = {},
            const std::string& body = "");
// If-Match: * for a method that may change what is stored, as a script sends it; not beside another If-Match.
void add_any_tag(Headers& headers, const std::string& method, const Headers& more);

// Sends bytes as they are and returns everything until the server closes or `quiet` passes without a byte.
class Raw {
 public:
  explicit Raw(std::uint16_t port, int receive_buffer = 0);
  ~Raw();
  Raw(const Raw&) = delete;
  Raw& operator=(const Raw&) = delete;
  bool send(const std::string& bytes);
  // What is sent from here on leaves in one packet, with the end of sending. The answers can still be read.
  void hold();
  void end();
  // Reads until `count` bytes, the end or the limit.
  std::string read(std::size_t count, int limit_ms = 2000);
  std::string read_to_end(int limit_ms = 8000);
  // The server has closed.
  [[nodiscard]] bool closed() const { return closed_; }
  // Closes without a word.
  void close();

 private:
  bool receive(std::chrono::steady_clock::time_point end);

  int fd_ = -1;
  std::string received_;  // not yet read: from taken_ on
  std::size_t taken_ = 0;
  bool closed_ = false;
};

// A WebSocket client that collects what comes.
class Live {
 public:
  // The handshake's HTTP status is in `status`; 101 = open.
  Live(std::uint16_t port, const Headers& headers, const std::string& protocol = "hoist.v1", const std::string& target = "/ws");
  ~Live();
  [[nodiscard]] unsigned status() const;
  [[nodiscard]] std::string protocol() const;
  void send(const nlohmann::json& message);
  void send_text(const std::string& text);
  void send_binary(const std::string& bytes);
  // What is sent from here on leaves in one packet, with the end of sending: a close frame before it, or none.
  void hold();
  void end(bool close_frame);
  // The next text message of this type (and, for replies, this request); messages of other types are passed over. Empty object when the
  // limit passes or the socket closes.
  nlohmann::json wait(const std::string& type, int request = -1);
  // Sends a message with a fresh `request` and returns its reply.
  nlohmann::json ask(nlohmann::json message);
  // Records of the next telemetry frames until at least `count` are there.
  std::vector<contract::TickRecord> records(std::size_t count);
  [[nodiscard]] std::uint64_t frame_layout_hash() const;
  // The next binary message of any kind; empty when none comes.
  std::string binary();
  // The code with which the server closes; 0 when that takes longer than `within`, however many messages come meanwhile.
  unsigned wait_close(std::chrono::milliseconds within = std::chrono::seconds(30));
  void close();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace hoist::test
