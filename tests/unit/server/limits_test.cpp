// The door: sizes, malformed bytes, connections, what is left in order afterwards (hazards H30 and H31).
#include "server/http/listener.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::Mode;

class Limits : public ServerTest {
 protected:
  std::string raw(const std::string& bytes) {
    Raw socket(port_);
    EXPECT_TRUE(socket.send(bytes));
    return socket.read_to_end();
  }
  std::string host() const { return "Host: 127.0.0.1:" + std::to_string(port_) + "\r\n"; }
};

TEST_F(Limits, HeaderAndBodySizes_H30) {
  EXPECT_TRUE(raw("GET / HTTP/1.1\r\n" + host() + "X-Long: " + std::string(9000, 'x') + "\r\n\r\n").starts_with("HTTP/1.1 431"));
  EXPECT_TRUE(raw("POST /api/v1/stop HTTP/1.1\r\n" + host() + "Content-Length: 70000\r\n\r\n").starts_with("HTTP/1.1 413"))
      << "before the body is sent";
  EXPECT_TRUE(raw("POST /api/v1/stop HTTP/1.1\r\n" + host() + "Content-Length: 70000\r\n\r\n" + std::string(70000, 'x'))
                  .starts_with("HTTP/1.1 413"));
  std::string chunked = "POST /api/v1/stop HTTP/1.1\r\n" + host() + "Transfer-Encoding: chunked\r\n\r\n";
  for (int i = 0; i < 20; ++i) chunked += "1000\r\n" + std::string(4096, 'x') + "\r\n";
  EXPECT_TRUE(raw(chunked + "0\r\n\r\n").starts_with("HTTP/1.1 413"));
}

// However a client cuts its request into packets: the same answer, and the same limit of the header.
TEST_F(Limits, AHeaderInPartsIsLikeAWholeOne_H30) {
  const auto in_parts = [&](const std::string& bytes, std::size_t part) {
    Raw socket(port_);
    for (std::size_t at = 0; at < bytes.size() && socket.send(bytes.substr(at, part)); at += part) continue;
    return socket.read_to_end().substr(0, 12);
  };
  // Fields of 64 bytes each, so that a read ends with a field, also when packets come together.
  const auto request = [&](std::size_t header_bytes) {
    std::string text = "GET / HTTP/1.1\r\n" + host() + "Connection: close\r\n";
    text += "X: " + std::string(128 - text.size() - 5, 'x') + "\r\n";
    while (text.size() + 64 <= header_bytes - 2) text += "X: " + std::string(59, 'x') + "\r\n";
    text.insert(text.size() - 2, header_bytes - 2 - text.size(), 'x');
    return text + "\r\n";
  };
  for (const std::size_t part : {std::size_t{1}, std::size_t{7}, std::size_t{64}, std::size_t{4096}, std::size_t{1} << 20U}) {
    EXPECT_EQ(in_parts(request(server::kHeaderLimit_bytes), part), "HTTP/1.1 200") << part;
    EXPECT_EQ(in_parts(request(server::kHeaderLimit_bytes + 1), part), "HTTP/1.1 431") << part;
  }
  EXPECT_EQ(in_parts(request(1024 * 1024), 64), "HTTP/1.1 431") << "one that never ends";
  EXPECT_EQ(in_parts("POST /api/v1/stop HTTP/1.1\r\n" + host() + "Authorization: " + bearer_[0].second +
                         "\r\nConnection: close\r\nContent-Length: 2\r\n\r\n{}",
                     1),
            "HTTP/1.1 200");
}

TEST_F(Limits, MalformedRequestsAreAnsweredOrClosed_H30) {
  for (const std::string& bad : {std::string("\r\n\r\nnonsense\r\n\r\n"), std::string("GET\r\n\r\n"), std::string("GET / HTTP/9.9\r\n\r\n"),
                                 std::string("GET / HTTP/1.1\r\nbroken header\r\n\r\n"),
                                 std::string("POST / HTTP/1.1\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\nx"),
                                 std::string("POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n"),
                                 std::string("POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\nContent-Length: 3\r\n\r\n0\r\n\r\n"),
                                 std::string("GET /%00 HTTP/1.1\r\n" + host() + "Connection: close\r\n\r\n"),
                                 std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03", 11) + "\r\n\r\n"}) {
    const std::string answer = raw(bad);
    EXPECT_TRUE(answer.empty() || answer.starts_with("HTTP/1.1 4")) << bad << " -> " << answer;
    EXPECT_EQ(answer.find("HTTP/1.1 2"), std::string::npos);
  }
  EXPECT_EQ(get("/api/v1/status").status, 200);
}

// RFC 9112, 3.2 and 3.2.2: HTTP/1.1 without Host is 400; the authority of an address in absolute form counts instead of Host.
TEST_F(Limits, AHostIsRequired) {
  const auto status = [this](const std::string& request) { return raw(request).substr(0, 12); };
  const std::string close = "Connection: close\r\n\r\n", own = "127.0.0.1:" + std::to_string(port_);
  EXPECT_EQ(status("GET / HTTP/1.1\r\n" + close), "HTTP/1.1 400");
  EXPECT_EQ(status("GET / HTTP/1.0\r\n" + close), "HTTP/1.1 421");
  const std::string mode = "/api/v1/mode HTTP/1.1\r\n", token = "Authorization: " + bearer_[0].second + "\r\n";
  EXPECT_EQ(status("GET http://" + own + mode + host() + token + close), "HTTP/1.1 200");
  EXPECT_EQ(status("GET HTTP://" + own + mode + "Host: elsewhere.example\r\n" + token + close), "HTTP/1.1 200");
  EXPECT_EQ(status("GET http://" + own + mode + token + close), "HTTP/1.1 400") << "Host is required beside it";
  for (const std::string& other : {std::string("elsewhere.example"), "me@" + own, own + "@elsewhere.example", std::string()})
    EXPECT_EQ(status("GET http://" + other + mode + host() + token + close), "HTTP/1.1 421") << other;
}

// Names of schemes and media types are those of RFC 9110, in capital or small letters (11.1, 8.3.1).
TEST_F(Limits, SchemesAndTypesAreReadInAnyCase) {
  const std::string token = bearer_[0].second.substr(std::string("Bearer ").size());
  for (const char* scheme : {"bearer ", "BEARER ", "Bearer   "}) {
    const Headers headers{{"Authorization", scheme + token}, {"Content-Type", "Application/JSON; charset=utf-8"}};
    EXPECT_EQ(http(port_, "GET", "/api/v1/status", headers).status, 200) << scheme;
    EXPECT_EQ(http(port_, "POST", "/api/v1/lease", headers, "{}").status, 200) << scheme;
    EXPECT_EQ(http(port_, "POST", "/api/v1/stop", headers).status, 200) << scheme;
  }
  for (const std::string& other : {"Bearer" + token, "Basic " + token, std::string("Bearer "), std::string("Bearer")})
    EXPECT_EQ(http(port_, "GET", "/api/v1/status", {{"Authorization", other}}).status, 401) << other;
  EXPECT_EQ(http(port_, "POST", "/api/v1/lease", {bearer_[0], {"Content-Type", "application/jsonp"}}, "{}").status, 415);
}

TEST_F(Limits, ConnectionsPerAddress_H31) {
  std::vector<std::unique_ptr<Raw>> held;
  for (std::size_t i = 0; i < server::kAddressLimit; ++i) held.push_back(std::make_unique<Raw>(port_));
  // The first one proves that all before it were accepted as well.
  ASSERT_TRUE(held.back()->send("GET / HTTP/1.1\r\n" + host() + "\r\n"));
  EXPECT_EQ(held.back()->read(12), "HTTP/1.1 200");
  const Answer answer = http(port_, "GET", "/");
  EXPECT_EQ(answer.status, 503);
  EXPECT_EQ(answer.header("content-type"), "application/problem+json");
  EXPECT_EQ(answer.json()["type"], "/problems/too-many-connections");
  EXPECT_EQ(answer.header("retry-after"), "2");
  EXPECT_EQ(get("/api/v1/status").status, 200) << "a client that is signed in still comes in";
  EXPECT_EQ(Live(port_, bearer_).status(), 101U) << "a WebSocket has a seat of its own";
  EXPECT_EQ(http(port_, "GET", link_.substr(link_.find("/?"))).status, 303) << "and one that signs in";
  held.clear();
  EXPECT_TRUE(until([&] { return http(port_, "GET", "/").status == 200; })) << "places are given back";
  EXPECT_GE(get("/api/v1/status").json()["counters"]["connections_refused_address_limit"].get<int>(), 1);
}

TEST_F(Limits, SilentConnectionsKeepNobodyOut_H31) {
  std::vector<std::unique_ptr<Raw>> held;
  for (std::size_t i = 0; i < 2 * server::kConnectionLimit; ++i) held.push_back(std::make_unique<Raw>(port_));
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  EXPECT_EQ(call("POST", "/api/v1/stop").status, 200);
  EXPECT_EQ(core_->mode(), Mode::protective_stop);
  EXPECT_EQ(get("/api/v1/status").status, 200);
}

TEST_F(Limits, WebSocketsKeepNoRequestOut_H31) {
  std::vector<std::unique_ptr<Live>> all;
  for (std::size_t i = 0; i < server::kConnectionLimit; ++i) {
    all.push_back(std::make_unique<Live>(port_, bearer_));
    ASSERT_EQ(all.back()->status(), 101U) << i;
  }
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  EXPECT_EQ(call("POST", "/api/v1/stop").status, 200);
  EXPECT_EQ(core_->mode(), Mode::protective_stop);
  EXPECT_EQ(http(port_, "GET", "/").status, 200);
  EXPECT_EQ(Live(port_, bearer_).status(), 503U) << "their own seats are taken";
  all.clear();
  EXPECT_TRUE(until([&] { return Live(port_, bearer_).status() == 101U; })) << "places are given back";
}

// Signed in and busy, so that nothing of it may be taken away: a body that does not come.
TEST_F(Limits, WhenEverySeatIsInUseTheDoorSaysSo_AndStopComesIn_H31) {
  const std::string begun = "PATCH /api/v1/parameters HTTP/1.1\r\n" + host() + "Authorization: " + bearer_[0].second +
                            "\r\nContent-Type: application/json\r\nContent-Length: 10\r\nExpect: 100-continue\r\n\r\n";
  std::vector<std::unique_ptr<Raw>> busy;
  const auto waits = [&] {
    busy.push_back(std::make_unique<Raw>(port_));
    return busy.back()->send(begun) && busy.back()->read(12) == "HTTP/1.1 100";
  };
  while (busy.size() < server::kConnectionLimit && waits()) {
  }
  EXPECT_GE(busy.size(), server::kConnectionLimit - server::kReservedSeats);
  EXPECT_LE(busy.size(), server::kConnectionLimit) << "the last ones are for STOP";
  busy.pop_back();
  const Answer full = http(port_, "GET", "/api/v1/status", bearer_);
  EXPECT_EQ(full.status, 503);
  EXPECT_EQ(full.json()["type"], "/problems/too-many-connections");
  std::vector<std::unique_ptr<Raw>> silent;
  for (std::size_t i = 0; i < server::kConnectionLimit; ++i) silent.push_back(std::make_unique<Raw>(port_));
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  EXPECT_EQ(raw("POST /api/v1/stop HTTP/1.1\r\n" + host() + "Content-Length: 2\r\n\r\n{}").substr(0, 12), "HTTP/1.1 503") << "a stranger's";
  EXPECT_EQ(raw("POST /api/v1/stop HTTP/1.1\r\n" + host() + "Authorization: " + bearer_[0].second + "\r\nContent-Length: 9\r\n\r\n")
                .substr(0, 12),
            "HTTP/1.1 200")
      << "its body is not waited for";
  EXPECT_EQ(core_->mode(), Mode::protective_stop);
  busy.clear();
  EXPECT_TRUE(until([&] { return http(port_, "GET", "/api/v1/status", bearer_).status == 200; }));
}

// What two readers of one request could take for two different requests (RFC 9112, section 11.2) is no request.
TEST_F(Limits, AmbiguousRequestsAreRefusedAndClosed_H30) {
  const std::string token = "Authorization: " + bearer_[0].second + "\r\n";
  const std::string json_type = "Content-Type: application/json\r\n";
  const std::string post = "POST /api/v1/lease HTTP/1.1\r\n" + host();
  const std::string chunks = "2\r\n{}\r\n0\r\n\r\n";
  const std::string next = "GET /api/v1/status HTTP/1.1\r\n" + host() + token + "\r\n";
  for (const std::string& bad :
       {post + token + json_type + "Transfer-Encoding: gzip\r\n\r\n",
        post + token + json_type + "Transfer-Encoding: gzip, chunked\r\n\r\n" + chunks,
        post + token + json_type + "Transfer-Encoding: chunked, chunked\r\n\r\n" + chunks,
        post + token + json_type + "Transfer-Encoding: chunked, gzip\r\n\r\n" + chunks,
        post + token + json_type + "Transfer-Encoding: gzip\r\nTransfer-Encoding: chunked\r\n\r\n" + chunks,
        post + token + json_type + "Transfer-Encoding: identity\r\n\r\n",
        post + token + json_type + "Transfer-Encoding: \r\n\r\n",
        post + token + json_type + "Transfer-Encoding: chunked\r\nContent-Length: 2\r\n\r\n" + chunks,
        post + token + json_type + "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n" + chunks,
        post + token + json_type + "Transfer-Encoding: gzip\r\nContent-Length: 2\r\n\r\n{}",
        post + token + json_type + "Content-Length: 2\r\nContent-Length: 2\r\n\r\n{}",
        post + token + json_type + "Content-Length: 2, 2\r\n\r\n{}",
        "POST /api/v1/lease HTTP/1.0\r\n" + host() + token + json_type + "Transfer-Encoding: chunked\r\n\r\n" + chunks,
        post + token + token + json_type + "Content-Length: 2\r\n\r\n{}",
        post + host() + token + json_type + "Content-Length: 2\r\n\r\n{}",
        post + token + json_type + json_type + "Content-Length: 2\r\n\r\n{}",
        post + token + "Cookie: a=b\r\nCookie: c=d\r\n" + json_type + "Content-Length: 2\r\n\r\n{}",
        post + token + "Origin: " + origin() + "\r\nOrigin: " + origin() + "\r\n" + json_type + "Content-Length: 2\r\n\r\n{}",
        post + token + "X-A: 1\n" + json_type + "Content-Length: 2\r\n\r\n{}",
        post + token + "X-A: 1" + std::string(1, '\0') + "\r\n" + json_type + "Content-Length: 2\r\n\r\n{}",
        post + token + "X-A : 1\r\n" + json_type + "Content-Length: 2\r\n\r\n{}",
        "GET /api/v1/sessions?limit=1&limit=2 HTTP/1.1\r\n" + host() + token + "Connection: close\r\n\r\n"}) {
    const std::string answer = raw(bad + next);
    EXPECT_TRUE(answer.starts_with("HTTP/1.1 400")) << bad << " -> " << answer.substr(0, 200);
    EXPECT_EQ(answer.find("HTTP/1.1 2"), std::string::npos) << "what follows is not read as a request: " << bad;
  }
  EXPECT_EQ(raw(post + token + json_type + "Connection: close\r\nTransfer-Encoding: Chunked\r\n\r\n" + chunks).substr(0, 12),
            "HTTP/1.1 200");
}

TEST_F(Limits, ATrailerIsNoHeader_H28) {
  const std::string token = "Authorization: " + bearer_[0].second + "\r\n";
  core_->set([](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(Mode::user); });
  const std::string answer =
      raw("POST /api/v1/stop HTTP/1.1\r\n" + host() + "Transfer-Encoding: chunked\r\nConnection: close\r\n\r\n" + "0\r\n" + token + "\r\n");
  EXPECT_EQ(answer.substr(0, 12), "HTTP/1.1 401") << "it signs nobody in";
  EXPECT_EQ(core_->mode(), Mode::user);
  for (const std::string& more :
       {host(), token, std::string("Content-Type: text/plain\r\n"), std::string("Origin: http://evil.example\r\n")}) {
    EXPECT_EQ(
        raw("POST /api/v1/lease HTTP/1.1\r\n" + host() + token +
            "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\nConnection: close\r\n\r\n2\r\n{}\r\n0\r\n" + more + "\r\n")
            .substr(0, 12),
        "HTTP/1.1 200")
        << "nor does it change anything else: " << more;
  }
  EXPECT_EQ(raw("GET /ws HTTP/1.1\r\n" + host() + token +
                "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Protocol: hoist.v1\r\n"
                "Transfer-Encoding: chunked\r\n\r\n0\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n")
                .substr(0, 12),
            "HTTP/1.1 426")
      << "an upgrade has no body";
}

// A folded line goes on with the field above it, as RFC 9112 lets a server read it; it is no field of its own.
TEST_F(Limits, AFoldedLineIsNoFieldOfItsOwn_H30) {
  EXPECT_EQ(
      raw("GET /api/v1/status HTTP/1.1\r\n" + host() + "X-A: 1\r\n Authorization: " + bearer_[0].second + "\r\nConnection: close\r\n\r\n")
          .substr(0, 12),
      "HTTP/1.1 401");
}

TEST_F(Limits, JsonFollowedByOtherBytesIsRefused_H30) {
  for (const std::string& tail :
       {std::string(1, '\0'), std::string(1, '\0') + "{\"take_over\": true}", std::string("x"), std::string("{}"), std::string("\x1a")}) {
    const Answer answer = http(port_, "POST", "/api/v1/lease", {bearer_[0], {"Content-Type", "application/json"}}, "{}" + tail);
    EXPECT_EQ(answer.status, 400) << testing::PrintToString(tail);
    EXPECT_EQ(answer.json()["type"], "/problems/bad-json");
  }
  EXPECT_EQ(http(port_, "POST", "/api/v1/lease", {bearer_[0], {"Content-Type", "application/json"}}, "{} \r\n").status, 200);
}

TEST_F(Limits, PipelinedRequestsAreAnsweredInOrder) {
  const std::string one = "GET /api/openapi.json HTTP/1.1\r\n" + host() + "\r\n";
  const std::string two = "GET /none HTTP/1.1\r\n" + host() + "Connection: close\r\n\r\n";
  const std::string answer = raw(one + two);
  const auto first = answer.find("HTTP/1.1 200");
  const auto second = answer.find("HTTP/1.1 404");
  EXPECT_EQ(first, 0U);
  ASSERT_NE(second, std::string::npos);
  EXPECT_GT(second, first);
}

TEST_F(Limits, ASlowHeaderIsCutOff_H31) {
  Raw slow(port_);
  ASSERT_TRUE(slow.send("GET / HTTP/1.1\r\nHost: 127"));
  const std::string answer = slow.read_to_end(20000);
  EXPECT_TRUE(answer.starts_with("HTTP/1.1 408")) << answer;
  EXPECT_NE(answer.find("/problems/too-slow"), std::string::npos) << answer;
  EXPECT_TRUE(slow.closed());
  EXPECT_EQ(get("/api/v1/status").json()["counters"]["connections_timed_out"], 1);
  Raw body(port_), silent(port_);
  ASSERT_TRUE(body.send("POST /api/v1/stop HTTP/1.1\r\n" + host() + "Content-Length: 5\r\n\r\n12"));
  EXPECT_TRUE(body.read_to_end(20000).starts_with("HTTP/1.1 408"));
  EXPECT_EQ(silent.read_to_end(20000), "") << "who asked nothing is told nothing";
  EXPECT_TRUE(silent.closed());
  EXPECT_EQ(get("/api/v1/status").json()["counters"]["connections_timed_out"], 3)
      << "each once: not again when the moment ends in which what a client still sends is read";
}

TEST_F(Limits, EndsWhileClientsAreConnected) {
  Raw idle(port_);
  Live live(port_, bearer_);
  ASSERT_EQ(live.status(), 101U);
  stop_server();
  EXPECT_EQ(live.wait_close(), 1001U);
  idle.read_to_end();
  EXPECT_TRUE(idle.closed());
}

}  // namespace
}  // namespace hoist::test
