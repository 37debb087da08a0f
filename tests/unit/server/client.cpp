#include "tests/unit/server/client.hpp"

#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <cstring>
#include <nlohmann/json.hpp>

namespace hoist::test {

namespace beast = boost::beast;
namespace http_ns = beast::http;
namespace asio = boost::asio;
using tcp = asio::ip::tcp;
using nlohmann::json;

namespace {
constexpr auto kLimit = std::chrono::seconds(8);

tcp::endpoint endpoint(std::uint16_t port) { return {asio::ip::make_address("127.0.0.1"), port}; }

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(c));
  return text;
}

// Runs one asynchronous operation to its end, within the stream's own time limit.
template <typename Start>
beast::error_code run(asio::io_context& io, Start start) {
  beast::error_code result = asio::error::would_block;
  start([&result](beast::error_code error, auto&&...) { result = error; });
  io.restart();
  // Not run(): the WebSocket's own timer stays pending after the operation is done.
  while (result == asio::error::would_block && io.run_one() > 0) {
  }
  return result;
}
}  // namespace

json Answer::json() const { return nlohmann::json::parse(body, nullptr, false); }
std::string Answer::header(const std::string& name) const {
  const auto at = headers.find(name);
  return at == headers.end() ? "" : at->second;
}

Answer http(std::uint16_t port, const std::string& method, const std::string& target, const Headers& headers, const std::string& body) {
  Answer answer;
  asio::io_context io;
  beast::tcp_stream stream(io);
  stream.expires_after(kLimit);
  if (run(io, [&](auto done) { stream.async_connect(endpoint(port), done); })) return answer;
  http_ns::request<http_ns::string_body> request;
  request.method_string(method);
  request.target(target);
  request.version(11);
  request.set(http_ns::field::host, "127.0.0.1:" + std::to_string(port));
  request.set(http_ns::field::connection, "close");
  for (const auto& [name, value] : headers) request.set(name, value);
  request.body() = body;
  if (!body.empty() || method == "POST" || method == "PUT" || method == "PATCH") request.prepare_payload();
  if (run(io, [&](auto done) { http_ns::async_write(stream, request, done); })) return answer;
  beast::flat_buffer buffer;
  http_ns::response_parser<http_ns::string_body> parser;
  parser.body_limit(64 * 1024 * 1024);
  if (method == "HEAD") parser.skip(true);
  if (run(io, [&](auto done) { http_ns::async_read(stream, buffer, parser, done); })) return answer;
  answer.status = parser.get().result_int();
  for (const auto& field : parser.get()) answer.headers[lower(std::string(field.name_string()))] = std::string(field.value());
  answer.body = parser.get().body();
  return answer;
}

Raw::Raw(std::uint16_t port, int receive_buffer) {
  fd_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (receive_buffer > 0) ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) closed_ = true;
}
Raw::~Raw() { ::close(fd_); }
bool Raw::send(const std::string& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::send(fd_, bytes.data() + done, bytes.size() - done, MSG_NOSIGNAL);
    if (count <= 0) return false;
    done += static_cast<std::size_t>(count);
  }
  return true;
}
std::string Raw::read(std::size_t count, int limit_ms) {
  std::string got;
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(limit_ms);
  while (got.size() < count && !closed_) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now()).count();
    pollfd poll_fd{fd_, POLLIN, 0};
    if (left <= 0 || ::poll(&poll_fd, 1, static_cast<int>(left)) <= 0) break;
    char buffer[4096];
    const ssize_t part = ::recv(fd_, buffer, std::min(sizeof buffer, count - got.size()), 0);
    if (part <= 0) {
      closed_ = true;
      break;
    }
    got.append(buffer, static_cast<std::size_t>(part));
  }
  return got;
}
std::string Raw::read_to_end(int limit_ms) { return read(static_cast<std::size_t>(1) << 30U, limit_ms); }

struct Live::Parts {
  asio::io_context io;
  beast::websocket::stream<beast::tcp_stream> stream{io};
  http_ns::response<http_ns::string_body> response;
  unsigned status = 0;
  bool open = false;
  unsigned close_code = 0;
  int next_request = 1000;
  std::uint64_t hash = 0;
  std::vector<json> texts;
  std::vector<contract::TickRecord> records;

  // Reads one message; false when the socket is closed or nothing came in time.
  bool read() {
    if (!open) return false;
    beast::flat_buffer buffer;
    const beast::error_code error = run(io, [&](auto done) { stream.async_read(buffer, done); });
    if (error) {
      open = false;
      // Kept also when the other side was gone before our answer to its close frame.
      close_code = static_cast<unsigned>(stream.reason().code);
      return false;
    }
    const std::string text = beast::buffers_to_string(buffer.data());
    if (stream.got_text()) {
      texts.push_back(json::parse(text));
      return true;
    }
    if (text.size() < 16) return true;
    std::uint16_t count = 0;
    std::uint32_t bytes = 0;
    std::memcpy(&count, text.data() + 2, 2);
    std::memcpy(&bytes, text.data() + 4, 4);
    std::memcpy(&hash, text.data() + 8, 8);
    if (text[0] != 1 || text[1] != 1 || bytes != sizeof(contract::TickRecord) || text.size() != 16 + std::size_t{count} * bytes)
      return true;
    for (std::size_t i = 0; i < count; ++i) {
      contract::TickRecord record;
      std::memcpy(&record, text.data() + 16 + i * bytes, bytes);
      records.push_back(record);
    }
    return true;
  }
};

Live::Live(std::uint16_t port, const Headers& headers, const std::string& protocol) : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  beast::websocket::stream_base::timeout limits{};
  limits.handshake_timeout = kLimit;
  limits.idle_timeout = kLimit;
  limits.keep_alive_pings = false;
  p.stream.set_option(limits);
  p.stream.set_option(beast::websocket::stream_base::decorator([&](beast::websocket::request_type& request) {
    if (!protocol.empty()) request.set(http_ns::field::sec_websocket_protocol, protocol);
    for (const auto& [name, value] : headers) request.set(name, value);
  }));
  if (run(p.io, [&](auto done) { beast::get_lowest_layer(p.stream).async_connect(endpoint(port), done); })) return;
  // As browsers do: a message does not wait for the answer to the one before.
  beast::get_lowest_layer(p.stream).socket().set_option(asio::ip::tcp::no_delay(true));
  const std::string host = "127.0.0.1:" + std::to_string(port);
  const beast::error_code error = run(p.io, [&](auto done) { p.stream.async_handshake(p.response, host, "/ws", done); });
  p.status = p.response.result_int();
  p.open = !error;
}
Live::~Live() = default;
unsigned Live::status() const { return parts_->open ? 101 : parts_->status; }
std::string Live::protocol() const { return std::string(parts_->response[http_ns::field::sec_websocket_protocol]); }
void Live::send(const json& message) { send_text(message.dump()); }
void Live::send_text(const std::string& text) {
  parts_->stream.text(true);
  if (run(parts_->io, [&](auto done) { parts_->stream.async_write(asio::buffer(text), done); })) parts_->open = false;
}
void Live::send_binary(const std::string& bytes) {
  parts_->stream.binary(true);
  static_cast<void>(run(parts_->io, [&](auto done) { parts_->stream.async_write(asio::buffer(bytes), done); }));
}
json Live::wait(const std::string& type, int request) {
  const auto end = std::chrono::steady_clock::now() + kLimit;
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
  const auto end = std::chrono::steady_clock::now() + kLimit;
  while (parts_->records.size() < count && std::chrono::steady_clock::now() < end)
    if (!parts_->read()) break;
  return parts_->records;
}
std::uint64_t Live::frame_layout_hash() const { return parts_->hash; }
unsigned Live::wait_close() {
  while (parts_->read()) {
  }
  return parts_->close_code;
}
void Live::close() {
  beast::error_code ignored;
  beast::get_lowest_layer(parts_->stream).socket().close(ignored);
  parts_->open = false;
}

}  // namespace hoist::test
