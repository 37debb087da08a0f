// Downloads that clients break off, beside others who list sessions and a walk that is being recorded. ThreadSanitizer watches the same test
// for objects that one thread destroys while another uses them (deploy/dev check).
#include <arpa/inet.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <thread>

#include "tests/support/seeds.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::Mode;

constexpr int kDownloaders = 4, kDownloadsPerList = 10;
// Sanitized programs are ten times slower and see a wrong thread at the first occasion.
int broken_off() { return tests::seeds_for(4'000, 1'000, 400); }

// A connection that ends with a reset, so that the server's next write fails and no port stays in TIME_WAIT.
class Downloader {
 public:
  Downloader(std::uint16_t port, const std::string& request) : fd_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    const linger at_once{.l_onoff = 1, .l_linger = 0};
    ::setsockopt(fd_, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
    asked_ = ::connect(fd_, reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
             ::send(fd_, request.data(), request.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(request.size());
  }
  ~Downloader() { ::close(fd_); }
  Downloader(const Downloader&) = delete;
  Downloader& operator=(const Downloader&) = delete;

  [[nodiscard]] bool asked() const { return asked_; }
  // What is there of the next piece; empty when nothing comes.
  std::string take() {
    pollfd ready{.fd = fd_, .events = POLLIN, .revents = 0};
    std::array<char, 4096> bytes;
    if (::poll(&ready, 1, 10'000) != 1) return {};
    const ssize_t count = ::recv(fd_, bytes.data(), bytes.size(), 0);
    return {bytes.data(), count > 0 ? static_cast<std::size_t>(count) : 0};
  }

 private:
  int fd_;
  bool asked_ = false;
};

class Downloads : public ServerTest {
 protected:
  void set_mode(Mode mode) {
    core_->set([mode](contract::TickRecord& r) { r.mode = static_cast<std::uint8_t>(mode); });
  }
  bool wait_state(const char* state) {
    return until([&] { return get("/api/v1/recording").json()["state"] == state; });
  }
  // One recorded session of ten seconds: several pieces of CSV.
  void record_a_session() {
    set_mode(Mode::user);
    ASSERT_TRUE(wait_state("recording"));
    core_->skip(1000);
    set_mode(Mode::standby);
    core_->skip(400);
    ASSERT_TRUE(wait_state("idle"));
  }
  [[nodiscard]] std::string export_request(const char* format) const {
    return "GET /api/v1/sessions/1/export?format=" + std::string(format) + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port_) +
           "\r\nAuthorization: " + bearer_.front().second + "\r\n\r\n";
  }
  // Breaks off right after the request, after the head or within the body, in turn.
  void break_off(int count) {
    const std::array requests{export_request("csv"), export_request("json"), export_request("events")};
    for (int i = 0; i < count; ++i) {
      Downloader one(port_, requests[static_cast<std::size_t>(i) % requests.size()]);
      const int reads = one.asked() ? (i / 3) % 3 : 0;
      if (reads > 0 && one.take().starts_with("HTTP/1.1 200")) ++granted_;
      if (reads > 1) one.take();
      ++broken_off_;
      broken_off_.notify_all();
    }
  }
  // One list for so many downloads of all: their pace is the same on any machine.
  void list_beside(int all) {
    for (int next = 0; next < all; next += kDownloadsPerList) {
      for (int seen = broken_off_; seen < next; seen = broken_off_) broken_off_.wait(seen);
      if (http(port_, "GET", "/api/v1/sessions", bearer_).status == 200) ++listed_;
    }
  }
  std::atomic<int> broken_off_{0}, granted_{0}, listed_{0};
};

TEST_F(Downloads, ThousandsBrokenOffBesideListsAndAWalk_H30) {
  record_a_session();
  set_mode(Mode::user);
  ASSERT_TRUE(wait_state("recording"));
  std::vector<std::thread> clients;
  const int all = broken_off();
  for (int i = 0; i < kDownloaders; ++i) clients.emplace_back([this, all] { break_off(all / kDownloaders); });
  for (int i = 0; i < 2; ++i) clients.emplace_back([this, all] { list_beside(all); });
  for (std::thread& client : clients) client.join();

  // A few may be refused: those that were broken off hold their seats until the recorder has answered.
  EXPECT_GT(granted_, all / 2);
  EXPECT_GT(listed_, 0);
  const json now = get("/api/v1/recording").json();
  EXPECT_EQ(now["state"], "recording") << now;
  set_mode(Mode::standby);
  core_->skip(400);
  ASSERT_TRUE(wait_state("idle"));
  const json walk = get("/api/v1/sessions/2").json();
  EXPECT_EQ(walk["close_reason"], "finished") << walk;
  EXPECT_EQ(walk["gaps"], 0) << walk;
  EXPECT_EQ(get("/api/v1/sessions/1/export?format=csv").status, 200) << "whole downloads still work";
}

// Connections go before what they use: the recorder, whose exports they hold, and the network itself.
TEST_F(Downloads, TheServerEndsInTheMiddleOfDownloads) {
  record_a_session();
  for (int round = 0; round < 5; ++round) {
    std::vector<std::unique_ptr<Downloader>> under_way;
    for (int i = 0; i < 8; ++i) under_way.push_back(std::make_unique<Downloader>(port_, export_request("csv")));
    EXPECT_TRUE(under_way.front()->take().starts_with("HTTP/1.1 200"));
    stop_server();
    start_server();
  }
  EXPECT_EQ(get("/api/v1/sessions/1/export?format=csv").status, 200);
}

}  // namespace
}  // namespace hoist::test
