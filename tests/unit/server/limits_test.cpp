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

TEST_F(Limits, AHostIsRequired) { EXPECT_TRUE(raw("GET / HTTP/1.1\r\nConnection: close\r\n\r\n").starts_with("HTTP/1.1 421")); }

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
  EXPECT_EQ(get("/api/v1/status").status, 200) << "whoever is signed in still comes in";
  EXPECT_EQ(Live(port_, bearer_).status(), 101U);
  EXPECT_EQ(http(port_, "GET", link_.substr(link_.find("/?"))).status, 303) << "and whoever signs in";
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

TEST_F(Limits, WhenEverySeatIsInUseTheDoorSaysSo_H31) {
  // Signed in and in use: nothing of it may be taken away.
  std::vector<std::unique_ptr<Live>> all;
  for (std::size_t i = 0; i < server::kConnectionLimit; ++i) {
    all.push_back(std::make_unique<Live>(port_, bearer_));
    ASSERT_EQ(all.back()->status(), 101U) << i;
  }
  const std::string answer = raw("GET / HTTP/1.1\r\n" + host() + "\r\n");
  EXPECT_TRUE(answer.empty() || (answer.starts_with("HTTP/1.1 503") && answer.find("too-many-connections") != std::string::npos)) << answer;
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
  Raw body(port_);
  ASSERT_TRUE(body.send("POST /api/v1/stop HTTP/1.1\r\n" + host() + "Content-Length: 5\r\n\r\n12"));
  EXPECT_TRUE(body.read_to_end(20000).starts_with("HTTP/1.1 408"));
  Raw silent(port_);
  EXPECT_EQ(silent.read_to_end(20000), "") << "who asked nothing is told nothing";
  EXPECT_TRUE(silent.closed());
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
