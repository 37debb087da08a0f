#include "tests/unit/server/client.hpp"

#include <arpa/inet.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>

#include "server/ws/frame.hpp"

namespace hoist::test {

using nlohmann::json;

namespace {
constexpr int kLimit_ms = 8000;
constexpr std::string_view kHeadEnd = "\r\n\r\n";
// RFC 6455 section 1.3: this key must be answered so.
constexpr std::string_view kKey = "dGhlIHNhbXBsZSBub25jZQ==", kAccept = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";

std::string lower(std::string_view text) {
  std::string out{text};
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

// A later field replaces an earlier one of the same name.
void set_field(Headers& fields, const std::string& name, const std::string& value) {
  std::erase_if(fields, [&name](const auto& field) { return lower(field.first) == lower(name); });
  fields.emplace_back(name, value);
}

std::string request_text(const std::string& method, const std::string& target, const Headers& fields, const std::string& body) {
  std::string text = method + " " + target + " HTTP/1.1\r\n";
  for (const auto& [name, value] : fields) text += name + ": " + value + "\r\n";
  return text + "\r\n" + body;
}

// Everything up to and including `end`, or nothing when the limit passes first.
std::optional<std::string> read_until(Raw& raw, std::string_view end) {
  std::string got;
  while (!got.ends_with(end)) {
    const std::string byte = raw.read(1, kLimit_ms);
    if (byte.empty()) return std::nullopt;
    got += byte;
  }
  return got;
}

// An unsigned number, most significant byte first.
std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char byte : bytes) value = value << 8U | static_cast<unsigned char>(byte);
  return value;
}

// RFC 9112 sections 4 and 5; false for anything else.
bool read_head(Raw& raw, Answer& answer) {
  const std::optional<std::string> head = read_until(raw, kHeadEnd);
  if (!head || !head->starts_with("HTTP/1.1 ") || head->size() < 12) return false;
  const std::string digits = head->substr(9, 3);
  if (digits.find_first_not_of("0123456789") != std::string::npos) return false;
  for (std::size_t from = head->find("\r\n") + 2; from + 2 < head->size();) {
    const std::size_t end = head->find("\r\n", from), colon = head->find(':', from);
    if (colon >= end) return false;
    const std::size_t value = std::min(head->find_first_not_of(" \t", colon + 1), end);
    answer.headers[lower(head->substr(from, colon - from))] = head->substr(value, end - value);
    from = end + 2;
  }
  answer.status = static_cast<unsigned>(std::stoul(digits));
  return true;
}

// RFC 9112 section 7.1; no trailers.
bool read_chunks(Raw& raw, std::string& body) {
  for (;;) {
    const std::optional<std::string> line = read_until(raw, "\r\n");
    if (!line || line->find_first_not_of("0123456789abcdefABCDEF") != line->size() - 2 || line->size() > 10) return false;
    const std::size_t size = std::stoul(*line, nullptr, 16);
    const std::string part = raw.read(size + 2, kLimit_ms);
    if (part.size() != size + 2 || !part.ends_with("\r\n")) return false;
    if (size == 0) return true;
    body.append(part, 0, size);
  }
}

bool read_body(Raw& raw, Answer& answer) {
  if (answer.header("transfer-encoding") == "chunked") return read_chunks(raw, answer.body);
  const std::string length = answer.header("content-length");
  if (length.empty()) {
    answer.body = raw.read_to_end(kLimit_ms);
    return raw.closed();
  }
  if (length.find_first_not_of("0123456789") != std::string::npos) return false;
  const std::size_t size = std::stoul(length);
  answer.body = raw.read(size, kLimit_ms);
  return answer.body.size() == size;
}
}  // namespace

json Answer::json() const { return nlohmann::json::parse(body, nullptr, false); }
std::string Answer::header(const std::string& name) const {
  const auto at = headers.find(name);
  return at == headers.end() ? "" : at->second;
}

Answer http(std::uint16_t port, const std::string& method, const std::string& target, const Headers& headers, const std::string& body) {
  Headers fields{{"Host", "127.0.0.1:" + std::to_string(port)}, {"Connection", "close"}};
  if (!body.empty() || method == "POST" || method == "PUT" || method == "PATCH")
    fields.emplace_back("Content-Length", std::to_string(body.size()));
  for (const auto& [name, value] : headers) set_field(fields, name, value);
  Raw raw(port);
  Answer answer;
  if (!raw.send(request_text(method, target, fields, body)) || !read_head(raw, answer)) return {};
  const bool bodiless = method == "HEAD" || answer.status == 204 || answer.status == 304;
  if (!bodiless && !read_body(raw, answer)) return {};
  return answer;
}

void add_any_tag(Headers& headers, const std::string& method, const Headers& more) {
  const bool changes = method == "PUT" || method == "PATCH" || method == "DELETE";
  if (changes && std::ranges::none_of(more, [](const auto& header) { return header.first == "If-Match"; }))
    headers.emplace_back("If-Match", "*");
}

Raw::Raw(std::uint16_t port, int receive_buffer) {
  fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (receive_buffer > 0) ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  // As browsers do: a message does not wait for the answer to the one before.
  const int now = 1;
  ::setsockopt(fd_, IPPROTO_TCP, TCP_NODELAY, &now, sizeof now);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) closed_ = true;
}
Raw::~Raw() { close(); }
void Raw::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  closed_ = true;
}
bool Raw::send(const std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::send(fd_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return true;
}
void Raw::hold() {
  const int on = 1;
  ::setsockopt(fd_, IPPROTO_TCP, TCP_CORK, &on, sizeof on);
}
void Raw::end() { ::shutdown(fd_, SHUT_WR); }
bool Raw::receive(std::chrono::steady_clock::time_point end) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now()).count();
  pollfd poll_fd{fd_, POLLIN, 0};
  if (closed_ || left <= 0 || ::poll(&poll_fd, 1, static_cast<int>(left)) <= 0) return false;
  char buffer[4096];
  const ssize_t part = ::recv(fd_, buffer, sizeof buffer, 0);
  if (part <= 0)
    closed_ = true;
  else
    received_.append(buffer, static_cast<std::size_t>(part));
  return !closed_;
}
std::string Raw::read(std::size_t count, int limit_ms) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(limit_ms);
  while (received_.size() - taken_ < count && receive(end)) {
  }
  std::string got = received_.substr(taken_, count);
  taken_ += got.size();
  if (taken_ == received_.size()) {
    received_.clear();
    taken_ = 0;
  }
  return got;
}
std::string Raw::read_to_end(int limit_ms) { return read(static_cast<std::size_t>(1) << 30U, limit_ms); }

struct Live::Parts {
  explicit Parts(std::uint16_t port) : raw(port) {}
  Raw raw;
  Answer response;
  bool open = false;
  unsigned close_code = 0;
  int next_request = 1000;
  std::uint64_t hash = 0;
  std::vector<json> texts;
  std::vector<contract::TickRecord> records;
  std::string binary;

  // One whole message (RFC 6455 section 5.2), masked with zeros.
  void send(server::Opcode opcode, std::string_view payload) {
    const std::size_t size = payload.size();
    const std::size_t length_bytes = size < 126 ? 0 : size < 65536 ? 2 : 8;
    std::string frame{static_cast<char>(0x80U | static_cast<unsigned>(opcode))};
    frame += static_cast<char>(0x80U | (length_bytes == 0 ? size : length_bytes == 2 ? 126 : 127));
    for (std::size_t left = length_bytes; left > 0; --left) frame += static_cast<char>(size >> (8 * (left - 1)) & 0xFFU);
    frame.append(4, '\0').append(payload);
    if (!raw.send(frame)) open = false;
  }

  // Reads one frame; false when the socket is closed, nothing came in time, or it is not a whole unmasked message in its shortest form,
  // which is all that the server sends.
  bool read() {
    if (!open) return false;
    open = false;
    const std::string head = raw.read(2, kLimit_ms);
    if (head.size() != 2 || (head[0] & 0x70) != 0 || (head[0] & 0x80) == 0) return false;
    std::uint64_t size = static_cast<unsigned char>(head[1]);
    if (size > 127) return false;
    if (size >= 126) {
      const std::uint64_t least = size == 126 ? 126 : 65536;
      size = big_endian(raw.read(size == 126 ? 2 : 8, kLimit_ms));
      if (size < least) return false;
    }
    const std::string payload = raw.read(size, kLimit_ms);
    if (payload.size() != size) return false;
    open = true;
    take(static_cast<server::Opcode>(head[0] & 0x0F), payload);
    return open;
  }

  void take(server::Opcode opcode, const std::string& payload) {
    switch (opcode) {
      case server::Opcode::text:
        texts.push_back(json::parse(payload));
        break;
      case server::Opcode::binary:
        binary = payload;
        take_telemetry(payload);
        break;
      case server::Opcode::ping:
        send(server::Opcode::pong, payload);
        break;
      case server::Opcode::close:
        close_code = payload.size() < 2 ? 1005U : static_cast<unsigned>(big_endian(payload.substr(0, 2)));
        send(opcode, payload.substr(0, 2));
        open = false;
        break;
      default:
        open = false;
    }
  }

  void take_telemetry(const std::string& bytes) {
    if (bytes.size() < 16) return;
    std::uint16_t count = 0;
    std::uint32_t record_bytes = 0;
    std::memcpy(&count, bytes.data() + 2, 2);
    std::memcpy(&record_bytes, bytes.data() + 4, 4);
    std::memcpy(&hash, bytes.data() + 8, 8);
    if (bytes[0] != 1 || bytes[1] != 1 || record_bytes != sizeof(contract::TickRecord) ||
        bytes.size() != 16 + std::size_t{count} * record_bytes)
      return;
    for (std::size_t i = 0; i < count; ++i) {
      contract::TickRecord record;
      std::memcpy(&record, bytes.data() + 16 + i * record_bytes, record_bytes);
      records.push_back(record);
    }
  }
};

Live::Live(std::uint16_t port, const Headers& headers, const std::string& protocol, const std::string& target)
    : parts_(std::make_unique<Parts>(port)) {
  Headers fields{{"Host", "127.0.0.1:" + std::to_string(port)},
                 {"Upgrade", "websocket"},
                 {"Connection", "Upgrade"},
                 {"Sec-WebSocket-Key", std::string(kKey)},
                 {"Sec-WebSocket-Version", "13"}};
  if (!protocol.empty()) fields.emplace_back("Sec-WebSocket-Protocol", protocol);
  for (const auto& [name, value] : headers) set_field(fields, name, value);
  Parts& p = *parts_;
  if (!p.raw.send(request_text("GET", target, fields, "")) || !read_head(p.raw, p.response)) return;
  p.open = p.response.status == 101 && p.response.header("sec-websocket-accept") == kAccept;
}
Live::~Live() = default;
unsigned Live::status() const { return parts_->open ? 101 : parts_->response.status; }
std::string Live::protocol() const { return parts_->response.header("sec-websocket-protocol"); }
void Live::send(const json& message) { send_text(message.dump()); }
void Live::send_text(const std::string& text) { parts_->send(server::Opcode::text, text); }
void Live::send_binary(const std::string& bytes) { parts_->send(server::Opcode::binary, bytes); }
void Live::hold() { parts_->raw.hold(); }
void Live::end(bool close_frame) {
  if (close_frame) parts_->send(server::Opcode::close, std::string("\x03\xe9", 2));  // 1001: the page is left
  parts_->raw.end();
}
json Live::wait(const std::string& type, int request) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kLimit_ms);
  while (std::chrono::steady_clock::now() < end) {
    for (auto it = parts_->texts.begin(); it != parts_->texts.end(); ++it) {
      if ((*it)["type"] != type || (request >= 0 && (*it)["request"] != request)) continue;
      json found = *it;
      parts_->texts.erase(it);
      return found;
    }
    if (!parts_->read()) break;
  }
  return json::object();
}
json Live::ask(json message) {
  const int request = parts_->next_request++;
  message["request"] = request;
  send(message);
  return wait("reply", request);
}
std::vector<contract::TickRecord> Live::records(std::size_t count) {
  parts_->records.clear();
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kLimit_ms);
  while (parts_->records.size() < count && std::chrono::steady_clock::now() < end)
    if (!parts_->read()) break;
  return parts_->records;
}
std::string Live::binary() {
  parts_->binary.clear();
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kLimit_ms);
  while (parts_->binary.empty() && std::chrono::steady_clock::now() < end)
    if (!parts_->read()) break;
  return parts_->binary;
}
std::uint64_t Live::frame_layout_hash() const { return parts_->hash; }
unsigned Live::wait_close(std::chrono::milliseconds within) {
  const auto until = std::chrono::steady_clock::now() + within;
  while (parts_->read())
    if (std::chrono::steady_clock::now() > until) return 0;
  return parts_->close_code;
}
void Live::close() {
  parts_->raw.close();
  parts_->open = false;
}

}  // namespace hoist::test
