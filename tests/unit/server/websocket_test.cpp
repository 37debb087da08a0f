// WebSocket as RFC 6455 says, case by case, over real connections: an endpoint that sends back each message shows what the connection takes and
// with which code it closes; the handshakes go to the whole server. The numbers are the RFC's sections.
#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "server/counters.hpp"
#include "server/stream/stream.hpp"
#include "server/ws/connection.hpp"
#include "server/ws/frame.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using namespace std::string_literals;
using server::Opcode;

class EchoConnection : public server::SocketConnection {
 public:
  using SocketConnection::SocketConnection;

 private:
  void on_text(std::string text) override { send(server::make_frame(Opcode::text, text)); }
  void on_binary(std::string bytes) override { send(server::make_frame(Opcode::binary, bytes)); }
  void on_leave() override {}
};

// Takes connections that are WebSockets from their first byte.
class EchoServer {
 public:
  explicit EchoServer(bool takes_binary) : takes_binary_(takes_binary), acceptor_(context_, {boost::asio::ip::address_v4::loopback(), 0}) {
    accept();
    thread_ = std::thread([this] { context_.run(); });
  }
  ~EchoServer() {
    context_.stop();
    thread_.join();
  }
  EchoServer(const EchoServer&) = delete;
  EchoServer& operator=(const EchoServer&) = delete;
  [[nodiscard]] std::uint16_t port() const { return acceptor_.local_endpoint().port(); }

 private:
  void accept() {
    acceptor_.async_accept([this](const boost::system::error_code& error, boost::asio::ip::tcp::socket socket) {
      if (error) return;
      std::make_shared<EchoConnection>(
          server::SocketConnection::Surroundings{.counters = counters_, .now_ns = now_ns_, .takes_binary = takes_binary_},
          std::make_unique<server::Stream>(std::move(socket), nullptr), nullptr)
          ->start();
      accept();
    });
  }

  bool takes_binary_;
  server::Counters counters_;
  std::function<std::uint64_t()> now_ns_ = [] { return std::uint64_t{0}; };
  boost::asio::io_context context_;
  boost::asio::ip::tcp::acceptor acceptor_;
  std::thread thread_;
};

// The first byte of a frame.
constexpr unsigned kFinal = 0x80, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10;

struct Form {
  std::string mask = "\x5a\xc3\x0f\x99";  // empty: not masked
  int length_bytes = -1;                  // of the extended length; -1: the shortest form
};
std::string frame(unsigned first, const std::string& payload, const Form& form = {}) {
  const std::size_t size = payload.size();
  const int length_bytes = form.length_bytes >= 0 ? form.length_bytes : size < 126 ? 0 : size < 65536 ? 2 : 8;
  const unsigned masked = form.mask.empty() ? 0 : 0x80;
  std::string out{static_cast<char>(first)};
  out += static_cast<char>(masked | (length_bytes == 0 ? size : length_bytes == 2 ? 126U : 127U));
  for (int left = length_bytes; left > 0; --left) out += static_cast<char>(static_cast<std::uint64_t>(size) >> (8 * (left - 1)) & 0xFFU);
  out += form.mask;
  for (std::size_t i = 0; i < size; ++i)
    out += form.mask.empty() ? payload[i] : static_cast<char>(payload[i] ^ form.mask[i % form.mask.size()]);
  return out;
}
std::string text(const std::string& payload) { return frame(kFinal | kText, payload); }
std::string ping(const std::string& payload) { return frame(kFinal | kPing, payload); }
std::string code(unsigned number) { return {static_cast<char>(number >> 8), static_cast<char>(number & 0xFFU)}; }
std::string closing(unsigned number, const std::string& reason = "") { return frame(kFinal | kClose, code(number) + reason); }

// What the server has sent, a row for each frame: its kind and payload, of a close frame the code.
std::vector<std::string> rows_of(const std::string& bytes) {
  std::vector<std::string> rows;
  for (std::size_t at = 0; at < bytes.size();) {
    const auto byte = [&](std::size_t i) { return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0U; };
    std::size_t size = byte(at + 1), head = 2;
    if (size == 126) {
      size = byte(at + 2) << 8 | byte(at + 3);
      head = 4;
    }
    // A server never masks, and ours sends short messages whole.
    if (size > 4096 || at + head + size > bytes.size()) return {"no frame at " + std::to_string(at)};
    const std::string payload = bytes.substr(at + head, size);
    const unsigned first = byte(at);
    at += head + size;
    if (first == (kFinal | kText))
      rows.push_back("text " + payload);
    else if (first == (kFinal | kBinary))
      rows.push_back("binary " + payload);
    else if (first == (kFinal | kPing) || first == (kFinal | kPong))
      rows.push_back((first == (kFinal | kPing) ? "ping " : "pong ") + payload);
    else if (first == (kFinal | kClose))
      rows.push_back(size < 2 ? "close" : "close " + std::to_string(byte(at - size) << 8 | byte(at - size + 1)));
    else
      rows.push_back("unknown " + std::to_string(first));
  }
  return rows;
}

struct Case {
  std::string what, bytes;
  std::vector<std::string> answer;
};

// Each case is followed by a closing handshake with code 1000, so that what comes before it is all that the case brings about. A connection
// that a case has closed must not answer it.
void check(std::uint16_t port, const std::vector<Case>& cases) {
  for (const Case& one : cases) {
    std::vector<std::string> expected = one.answer;
    if (expected.empty() || !expected.back().starts_with("close")) expected.emplace_back("close 1000");
    const std::string bytes = one.bytes + closing(1000);
    for (const bool byte_by_byte : {false, true}) {
      if (byte_by_byte && bytes.size() > 600) continue;
      Raw raw(port);
      if (byte_by_byte)
        for (const char byte : bytes) raw.send({byte});
      else
        raw.send(bytes);
      EXPECT_EQ(rows_of(raw.read_to_end()), expected) << one.what << (byte_by_byte ? ", byte by byte" : "");
      EXPECT_TRUE(raw.closed()) << one.what << ": the server ends the connection";
    }
  }
}

std::string x(std::size_t size) { return std::string(size, 'x'); }

TEST(WebSocket, Lengths_5_2) {
  const EchoServer server(true);
  std::vector<Case> cases;
  for (const std::size_t size : {0U, 1U, 125U, 126U, 127U, 128U, 255U, 256U, 4095U, 4096U}) {
    cases.push_back({"text of " + std::to_string(size), text(x(size)), {"text " + x(size)}});
    cases.push_back({"binary of " + std::to_string(size), frame(kFinal | kBinary, x(size)), {"binary " + x(size)}});
  }
  const std::string head = "\x81\xff"s, mask = "\0\0\0\0"s;
  const std::vector<Case> refused{
      {"a byte too many", text(x(4097)), {"close 1009"}},
      {"a binary byte too many", frame(kFinal | kBinary, x(4097)), {"close 1009"}},
      {"64 KiB announced", head + "\0\0\0\0\0\1\0\0"s + mask, {"close 1009"}},
      {"2^63 - 1 bytes announced", head + "\x7f\xff\xff\xff\xff\xff\xff\xff"s + mask, {"close 1009"}},
      {"the highest bit of the length", head + "\x80\0\0\0\0\0\0\0"s + mask, {"close 1002"}},
      {"125 in 16 bits", frame(kFinal | kText, x(125), {.length_bytes = 2}), {"close 1002"}},
      {"0 in 16 bits", frame(kFinal | kText, "", {.length_bytes = 2}), {"close 1002"}},
      {"125 in 64 bits", frame(kFinal | kText, x(125), {.length_bytes = 8}), {"close 1002"}},
      {"4096 in 64 bits", frame(kFinal | kText, x(4096), {.length_bytes = 8}), {"close 1002"}},
      {"a message before is answered", text("good") + text(x(4097)) + text("not read"), {"text good", "close 1009"}}};
  cases.insert(cases.end(), refused.begin(), refused.end());
  check(server.port(), cases);
}

TEST(WebSocket, ReservedBitsAndOpcodes_5_2) {
  const EchoServer server(true);
  std::vector<Case> cases;
  for (const unsigned bits : {0x40U, 0x20U, 0x10U, 0x70U})
    for (const unsigned opcode : {kText, kBinary, kClose, kPing, kPong})
      cases.push_back({"bits " + std::to_string(bits) + ", opcode " + std::to_string(opcode),
                       text("good") + frame(kFinal | bits | opcode, "xx") + ping(""),
                       {"text good", "close 1002"}});
  cases.push_back({"a bit within a message", frame(kText, "a") + frame(kFinal | 0x40, "b"), {"close 1002"}});
  for (const unsigned opcode : {3U, 4U, 5U, 6U, 7U, 11U, 12U, 13U, 14U, 15U})
    cases.push_back({"opcode " + std::to_string(opcode), frame(kFinal | opcode, "xx"), {"close 1002"}});
  check(server.port(), cases);
  const EchoServer text_only(false);
  check(text_only.port(), {{"binary", text("a") + frame(kFinal | kBinary, "b"), {"text a", "close 1003"}},
                           {"binary in parts", frame(kBinary, "b"), {"close 1003"}},
                           {"text", text("a"), {"text a"}}});
}

TEST(WebSocket, Masks_5_3) {
  const EchoServer server(true);
  const Form none{.mask = ""};
  check(server.port(), {{"text without", frame(kFinal | kText, "a", none), {"close 1002"}},
                        {"empty text without", frame(kFinal | kText, "", none), {"close 1002"}},
                        {"ping without", frame(kFinal | kPing, "a", none), {"close 1002"}},
                        {"close without", frame(kFinal | kClose, code(1000), none), {"close 1002"}},
                        {"the second part without", frame(kText, "a") + frame(kFinal, "b", none), {"close 1002"}},
                        {"of zeros", frame(kFinal | kText, "abcde", {.mask = std::string(4, '\0')}), {"text abcde"}},
                        {"of ones", frame(kFinal | kText, "abcde", {.mask = "\xff\xff\xff\xff"}), {"text abcde"}},
                        {"another in each frame",
                         frame(kText, "abcde", {.mask = "1234"}) + frame(kFinal, "fghij", {.mask = "\x80\x81\x82\x83"}),
                         {"text abcdefghij"}}});
}

TEST(WebSocket, Parts_5_4) {
  const EchoServer server(true);
  std::string many = frame(kText, "");
  for (int i = 0; i < 4096; ++i) many += frame(0, "x");
  const std::vector<Case> cases{
      {"two", frame(kText, "a") + frame(kFinal, "b"), {"text ab"}},
      {"three", frame(kBinary, "a") + frame(0, "b") + frame(kFinal, "c"), {"binary abc"}},
      {"the first empty", frame(kText, "") + frame(kFinal, "b"), {"text b"}},
      {"the last empty", frame(kText, "a") + frame(kFinal, ""), {"text a"}},
      {"all empty", frame(kText, "") + frame(0, "") + frame(kFinal, ""), {"text "}},
      {"of one byte", many + frame(kFinal, ""), {"text " + x(4096)}},
      {"of one byte, one too many", many + frame(kFinal, "x"), {"close 1009"}},
      {"together as long as may be", frame(kText, x(4000)) + frame(kFinal, x(96)), {"text " + x(4096)}},
      {"together too long", frame(kText, x(4000)) + frame(0, x(97)), {"close 1009"}},
      {"a ping between", frame(kText, "a") + ping("p") + frame(kFinal, "b"), {"pong p", "text ab"}},
      {"pings between",
       frame(kText, "a") + ping("1") + frame(0, "b") + ping("2") + ping("3") + frame(kFinal, "c"),
       {"pong 1", "pong 2", "pong 3", "text abc"}},
      {"a pong between", frame(kText, "a") + frame(kFinal | kPong, "p") + frame(kFinal, "b"), {"text ab"}},
      {"a ping as long as may be between",
       frame(kText, x(4095)) + ping(x(125)) + frame(kFinal, "x"),
       {"pong " + x(125), "text " + x(4096)}},
      {"a close between", frame(kText, "a") + closing(1001) + frame(kFinal, "b"), {"close 1001"}},
      {"an end without a begin", frame(kFinal, "a"), {"close 1002"}},
      {"a middle without a begin", frame(0, "a"), {"close 1002"}},
      {"an end after the end", frame(kText, "a") + frame(kFinal, "b") + frame(kFinal, "c"), {"text ab", "close 1002"}},
      {"an end after a whole message", text("a") + frame(kFinal, "b"), {"text a", "close 1002"}},
      {"text within text", frame(kText, "a") + text("b"), {"close 1002"}},
      {"the begin of text within text", frame(kText, "a") + frame(kText, "b"), {"close 1002"}},
      {"binary within text", frame(kText, "a") + frame(kFinal | kBinary, "b"), {"close 1002"}},
      {"text within binary", frame(kBinary, "a") + text("b"), {"close 1002"}},
      {"a ping in parts", frame(kPing, "a") + frame(kFinal, "b"), {"close 1002"}},
      {"a pong in parts", frame(kPong, "a"), {"close 1002"}},
      {"a close in parts", frame(kClose, code(1000)), {"close 1002"}},
      {"two messages in parts",
       frame(kText, "a") + frame(kFinal, "b") + frame(kBinary, "c") + frame(kFinal, "d"),
       {"text ab", "binary cd"}}};
  check(server.port(), cases);
}

TEST(WebSocket, PingsAndPongs_5_5) {
  const EchoServer server(true);
  const std::string no_text = "\0\xff\xfe\x80"s;
  std::string ten;
  std::vector<std::string> answers;
  for (const char digit : "0123456789"s) {
    ten += ping({digit});
    answers.push_back("pong "s + digit);
  }
  check(server.port(), {{"empty", ping(""), {"pong "}},
                        {"of bytes that are no text", ping(no_text), {"pong " + no_text}},
                        {"of 125 bytes", ping(x(125)), {"pong " + x(125)}},
                        {"of 126 bytes", ping(x(126)), {"close 1002"}},
                        {"ten", ten, answers},
                        {"a pong without a ping", frame(kFinal | kPong, "p") + ping("q"), {"pong q"}},
                        {"a pong of 126 bytes", frame(kFinal | kPong, x(126)), {"close 1002"}}});
}

TEST(WebSocket, ClosingHandshakes_5_5_1) {
  const EchoServer server(true);
  std::vector<Case> cases{{"without a code", frame(kFinal | kClose, ""), {"close"}},
                          {"with a reason", closing(1001, "going"), {"close 1001"}},
                          {"with the longest reason", closing(1000, x(123)), {"close 1000"}},
                          {"longer", closing(1000, x(124)), {"close 1002"}},
                          {"half a code", frame(kFinal | kClose, "\x03"), {"close 1002"}},
                          {"a reason that is no text", closing(1000, "\xff"), {"close 1007"}},
                          {"a reason cut within a character", closing(1000, "\xe2\x82"), {"close 1007"}},
                          {"nothing after it is taken", closing(1001) + text("a") + ping("p") + closing(1000), {"close 1001"}},
                          {"what came before it is answered", text("a") + ping("p") + closing(3000), {"text a", "pong p", "close 3000"}}};
  for (const unsigned number :
       {1000U, 1001U, 1002U, 1003U, 1007U, 1008U, 1009U, 1010U, 1011U, 1012U, 1013U, 1014U, 3000U, 3999U, 4000U, 4999U})
    cases.push_back({"code " + std::to_string(number), closing(number), {"close " + std::to_string(number)}});
  for (const unsigned number : {0U, 1U, 999U, 1004U, 1005U, 1006U, 1015U, 1016U, 1100U, 2000U, 2999U, 5000U, 65535U})
    cases.push_back({"code " + std::to_string(number), closing(number), {"close 1002"}});
  check(server.port(), cases);
}

TEST(WebSocket, TextIsUtf8_8_1) {
  const EchoServer server(true);
  std::vector<Case> cases;
  for (const std::string& good :
       {"\xce\xba\xe1\xbd\xb9\xcf\x83\xce\xbc\xce\xb5"s, "\0"s, "\x7f"s, "\xc2\x80"s, "\xdf\xbf"s, "\xe0\xa0\x80"s, "\xed\x9f\xbf"s,
        "\xee\x80\x80"s, "\xef\xbb\xbf"s, "\xef\xbf\xbd"s, "\xef\xbf\xbf"s, "\xf0\x90\x80\x80"s, "\xf4\x8f\xbf\xbf"s}) {
    cases.push_back({testing::PrintToString(good), text(good), {"text " + good}});
    // Each character is cut between each two of its bytes.
    std::string parts = frame(kText, "");
    for (const char byte : good) parts += frame(0, {byte}) + ping("p");
    std::vector<std::string> answer(good.size(), "pong p");
    answer.push_back("text " + good);
    cases.push_back({"in parts: " + testing::PrintToString(good), parts + frame(kFinal, ""), answer});
  }
  for (const std::string& bad : {"\x80"s,
                                 "\xbf"s,
                                 "a\x80"s,
                                 "\xc0\xaf"s,
                                 "\xc1\xbf"s,
                                 "\xe0\x80\xaf"s,
                                 "\xe0\x9f\xbf"s,
                                 "\xf0\x80\x80\xaf"s,
                                 "\xf0\x8f\xbf\xbf"s,
                                 "\xed\xa0\x80"s,
                                 "\xed\xbf\xbf"s,
                                 "\xed\xa0\x81\xed\xb0\x80"s,
                                 "\xf4\x90\x80\x80"s,
                                 "\xf5\x80\x80\x80"s,
                                 "\xf8\x88\x80\x80\x80"s,
                                 "\xfc\x84\x80\x80\x80\x80"s,
                                 "\xfe"s,
                                 "\xff"s,
                                 "\xc3"s,
                                 "\xe2\x82"s,
                                 "\xf0\x9f\x98"s,
                                 "\xc3\x28"s,
                                 "\xe2\x28\xa1"s,
                                 "\xe2\x82\x28"s,
                                 "\xf0\x9f\x28\x80"s}) {
    cases.push_back({testing::PrintToString(bad), text("good") + text(bad), {"text good", "close 1007"}});
    cases.push_back(
        {"in parts: " + testing::PrintToString(bad), frame(kText, bad.substr(0, 1)) + frame(kFinal, bad.substr(1)), {"close 1007"}});
  }
  cases.push_back({"a character does not go on in the next message", text("\xe2\x82") + text("\xac"), {"close 1007"}});
  cases.push_back({"binary may hold anything", frame(kFinal | kBinary, "\xff\xfe"), {"binary \xff\xfe"}});
  check(server.port(), cases);
}

// 7.1.1: the server closes the TCP connection, also where the client leaves its half open.
TEST(WebSocket, TheConnectionEndsWithoutTheClient_7_1_1) {
  const EchoServer server(true);
  Raw raw(server.port());
  raw.send(frame(kFinal | 3, ""));
  EXPECT_EQ(rows_of(raw.read_to_end()), std::vector<std::string>{"close 1002"});
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (raw.send("x") && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  EXPECT_FALSE(raw.send("x")) << "its other half is closed, too";
}

class Handshake : public ServerTest {
 protected:
  // The head of the answer to a handshake of these fields, with a right Host and token. After 101 also what comes until the server has closed
  // after `frames` and a closing handshake.
  std::string answer(const std::vector<std::string>& fields, const std::string& line, const std::string& frames = "") {
    std::string request = line + "\r\nHost: 127.0.0.1:" + std::to_string(port_) + "\r\nAuthorization: " + bearer_[0].second + "\r\n";
    for (const std::string& field : fields) request += field + "\r\n";
    Raw raw(port_);
    raw.send(request + "\r\n");
    std::string got;
    while (!got.ends_with("\r\n\r\n") && !raw.closed()) got += raw.read(1, 8000);
    if (!got.starts_with("HTTP/1.1 101")) return got;
    raw.send(frames + closing(1000));
    return got + raw.read_to_end();
  }
};

TEST_F(Handshake, IsAnsweredAsAsked_4_2_2) {
  const std::string upgrade = "Upgrade: websocket", connection = "Connection: Upgrade", version = "Sec-WebSocket-Version: 13",
                    key = "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==", protocol = "Sec-WebSocket-Protocol: hoist.v1";
  struct Row {
    const char* what;
    std::vector<std::string> fields;
    unsigned status;
    std::string line = "GET /ws HTTP/1.1";
  };
  const std::vector<Row> rows{
      {"names and values in other cases", {"UPGRADE: WebSocket", "connection: keep-alive, upgrade", version, key, protocol}, 101},
      {"another protocol beside", {"Upgrade: h2c, websocket", connection, version, key, protocol}, 101},
      {"several subprotocols", {upgrade, connection, version, key, "Sec-WebSocket-Protocol: chat,hoist.v1 , superchat"}, 101},
      {"subprotocols in two fields", {upgrade, connection, version, key, "Sec-WebSocket-Protocol: chat", protocol}, 101},
      {"extensions are left out", {upgrade, connection, version, key, protocol, "Sec-WebSocket-Extensions: permessage-deflate"}, 101},
      {"no Upgrade", {connection, version, key, protocol}, 426},
      {"another Upgrade", {"Upgrade: h2c", connection, version, key, protocol}, 426},
      {"no Connection", {upgrade, version, key, protocol}, 426},
      {"another Connection", {upgrade, "Connection: close", version, key, protocol}, 426},
      {"no version", {upgrade, connection, key, protocol}, 426},
      {"an older version", {upgrade, connection, "Sec-WebSocket-Version: 8", key, protocol}, 426},
      {"two versions", {upgrade, connection, "Sec-WebSocket-Version: 13, 8", key, protocol}, 426},
      {"no subprotocol", {upgrade, connection, version, key}, 426},
      {"a subprotocol in another case", {upgrade, connection, version, key, "Sec-WebSocket-Protocol: HOIST.V1"}, 426},
      {"HTTP/1.0", {upgrade, connection, version, key, protocol}, 426, "GET /ws HTTP/1.0"},
      {"another method", {upgrade, connection, version, key, protocol, "Content-Length: 0"}, 405, "POST /ws HTTP/1.1"},
      {"no key", {upgrade, connection, version, protocol}, 400},
      {"a key of 15 bytes", {upgrade, connection, version, "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25j", protocol}, 400},
      {"a key of 18 bytes", {upgrade, connection, version, "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZWVl", protocol}, 400},
      {"a key that is not base64", {upgrade, connection, version, "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZ*==", protocol}, 400},
      {"two keys", {upgrade, connection, version, key, key, protocol}, 400},
      {"two versions in two fields", {upgrade, connection, version, version, key, protocol}, 400}};
  for (const Row& row : rows) {
    const std::string got = answer(row.fields, row.line);
    EXPECT_EQ(got.substr(0, 12), "HTTP/1.1 " + std::to_string(row.status)) << row.what << ": " << got.substr(0, 300);
    if (row.status == 426) {
      EXPECT_NE(got.find("Sec-WebSocket-Version: 13\r\n"), std::string::npos) << row.what << " (4.4)";
    }
    if (row.status != 101) continue;
    EXPECT_NE(got.find("\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n"), std::string::npos) << row.what;
    EXPECT_NE(got.find("\r\nSec-WebSocket-Protocol: hoist.v1\r\n"), std::string::npos) << row.what;
    EXPECT_EQ(got.find("Sec-WebSocket-Extensions"), std::string::npos) << row.what;
    EXPECT_TRUE(got.ends_with("\x88\x02\x03\xe8")) << row.what << ": the closing handshake is answered";
  }
  const std::vector<std::string> good{upgrade, connection, version, key, protocol};
  EXPECT_TRUE(answer(good, "GET /ws HTTP/1.1", frame(kFinal | kText | 0x40, "{}")).ends_with("\x88\x02\x03\xea"))
      << "no extension is in force (9.1)";
}

// 4.1: a client waits for the answer. Bytes that come with the request could be the ones of another, so the connection ends without an answer.
TEST_F(Handshake, NothingComesBeforeTheAnswer_4_1) {
  EXPECT_EQ(Live(port_, bearer_).status(), 101U);
  Raw raw(port_);
  raw.send("GET /ws HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) + "\r\nAuthorization: " + bearer_[0].second +
           "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
           "Sec-WebSocket-Protocol: hoist.v1\r\n\r\n" +
           text(R"({"type":"stop"})"));
  EXPECT_EQ(raw.read_to_end(), "");
  EXPECT_TRUE(raw.closed());
}

}  // namespace
}  // namespace hoist::test
