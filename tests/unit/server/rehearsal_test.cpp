// Rehearsals over REST and WebSocket: refused on a real hoist, what the simulator is told, what the server does itself, and the result with the
// session. What staff do right and wrong in each: tests/loop/rehearsal_test.cpp.
#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "server/contract/rehearsals.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using contract::Mode;
using contract::TickRecord;

// Where hoist-sim would take requests: keeps the lines.
class Listener {
 public:
  explicit Listener(const std::string& path) : fd_(::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.data(), path.size());
    EXPECT_EQ(::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(fd_, 8), 0);
  }
  ~Listener() {
    if (client_ >= 0) ::close(client_);
    ::close(fd_);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;
  // All that has come so far.
  const std::string& told() {
    if (const int next = ::accept(fd_, nullptr, nullptr); next >= 0) {
      if (client_ >= 0) ::close(client_);
      client_ = next;
    }
    std::array<char, 1024> piece{};
    for (ssize_t got = 0; client_ >= 0 && (got = ::recv(client_, piece.data(), piece.size(), MSG_DONTWAIT)) > 0;)
      told_.append(piece.data(), static_cast<std::size_t>(got));
    return told_;
  }

 private:
  int fd_, client_ = -1;
  std::string told_;
};

class Rehearsals : public ServerTest {
 protected:
  void SetUp() override {
    simulator_ = std::make_unique<Listener>((folder_ / "sim.sock").string());
    adjust_ = [this](server::Settings& settings) { settings.simulator = (folder_ / "sim.sock").string(); };
    ServerTest::SetUp();
    simulate();
  }
  void start_core() {
    core_ = std::make_unique<FakeCore>((folder_ / "core.sock").string());
    wait_for_core();
    simulate();
  }
  void simulate() {
    core_->set([](TickRecord& record) {
      record.simulated = 1;
      record.mode = static_cast<std::uint8_t>(Mode::standby);
      record.standing_still = 0;
    });
    ASSERT_TRUE(until([&] { return state()["reason_code"].is_null(); }));
  }
  json state() { return get("/api/v1/rehearsal").json(); }
  Answer choose(const json& name) { return call("PUT", "/api/v1/rehearsal", {{"rehearsal", name}, {"seed", 7}}); }
  void set_mode(Mode mode) {
    core_->set([mode](TickRecord& record) { record.mode = static_cast<std::uint8_t>(mode); });
  }
  // The patient walks until it happens.
  void walk() {
    set_mode(Mode::user);
    ASSERT_TRUE(until([&] { return !get("/api/v1/recording").json()["session"].is_null(); }));
    ASSERT_TRUE(pass("happening"));
  }
  // Time goes on until this phase.
  bool pass(const char* phase) {
    return until([&] {
      core_->skip(20);
      return state()["phase"] == phase;
    });
  }

  std::unique_ptr<Listener> simulator_;
};

TEST_F(Rehearsals, ARealHoistRefusesThem) {
  core_->set([](TickRecord& record) { record.simulated = 0; });
  ASSERT_TRUE(until([&] { return state()["reason_code"] == "not_simulated"; }));
  const Answer refused = choose("trip");
  EXPECT_EQ(refused.status, 409);
  EXPECT_TRUE(refused.json()["type"].get<std::string>().ends_with("not-simulated")) << refused.body;
  EXPECT_EQ(state()["phase"], "none");
  EXPECT_EQ(simulator_->told(), "");
}

TEST_F(Rehearsals, ASimulatorThatTakesNoRequestsRefusesThem) {
  simulator_.reset();
  const Answer refused = choose("trip");
  EXPECT_EQ(refused.status, 409);
  EXPECT_TRUE(refused.json()["type"].get<std::string>().ends_with("no-simulator")) << refused.body;
}

TEST_F(Rehearsals, OnlyKnownOnesAndOnlyByTherapists) {
  EXPECT_EQ(choose("dance").status, 422);
  EXPECT_EQ(call("PUT", "/api/v1/rehearsal", json::object()).status, 422);
  const json kinds = state()["kinds"];
  EXPECT_EQ(kinds.size(), server::kRehearsals.size());
  for (const json& kind : kinds) EXPECT_FALSE(kind["looks"].empty()) << kind;
}

TEST_F(Rehearsals, TheBumperIsPressedAndLetGoAndTheResultStaysWithTheSession) {
  ASSERT_EQ(choose("bumper").status, 200);
  EXPECT_EQ(state()["phase"], "waiting");
  core_->skip(100);
  EXPECT_EQ(simulator_->told(), "") << "nothing happens in standby";
  walk();
  const std::string pressed = std::string(server::rehearsal_info(server::RehearsalKind::bumper).happens) + "\n";
  const std::string released = std::string(server::rehearsal_info(server::RehearsalKind::bumper).ends) + "\n";
  ASSERT_TRUE(until([&] { return simulator_->told() == pressed; }));
  const json happening = state();
  EXPECT_TRUE(happening["result"].is_null()) << "told when it is over";
  const std::string session = std::to_string(happening["session"].get<std::int64_t>());
  EXPECT_EQ(choose("trip").status, 409) << "one at a time";

  EXPECT_EQ(call("POST", "/api/v1/stop", json::object()).status, 200);
  ASSERT_TRUE(until([&] {
    core_->skip(20);
    return simulator_->told() == pressed + released;
  }));
  const Answer lease = call("POST", "/api/v1/lease", {{"take_over", true}});
  const Headers holder{{"X-Hoist-Lease", std::to_string(lease.json()["epoch"].get<std::uint32_t>())}};
  EXPECT_EQ(call("POST", "/api/v1/acknowledge", json::object(), holder).status, 200);
  EXPECT_EQ(call("POST", "/api/v1/neutral", json::object(), holder).status, 200);
  EXPECT_EQ(call("POST", "/api/v1/mode", {{"mode", "user"}}, holder).status, 200);
  ASSERT_TRUE(pass("over"));
  const json result = state()["result"];
  for (const json& item : result["items"]) EXPECT_EQ(item["seen"], "good") << item;
  EXPECT_EQ(result["seed"], 7);

  json markers;
  ASSERT_TRUE(until([&] {
    markers = get("/api/v1/sessions/" + session + "/markers").json()["items"];
    return !markers.empty();
  }));
  EXPECT_EQ(markers[0]["rehearsal"], result);
  EXPECT_TRUE(markers[0]["text"].get<std::string>().starts_with("Rehearsal, simulated hoist: bumper")) << markers[0];
  EXPECT_EQ(markers[0]["actor"]["user"], "local") << "who chose it";
}

TEST_F(Rehearsals, CancelledWhatHappenedGoesAgain) {
  ASSERT_EQ(choose("low_battery").status, 200);
  walk();
  EXPECT_EQ(choose(nullptr).status, 200);
  EXPECT_EQ(state()["phase"], "none");
  const server::RehearsalInfo& info = server::rehearsal_info(server::RehearsalKind::low_battery);
  EXPECT_TRUE(until([&] { return simulator_->told() == std::string(info.happens) + "\n" + std::string(info.ends) + "\n"; }));
}

TEST_F(Rehearsals, ALostCoreIsToldInPlaceOfAResult) {
  for (const bool happened : {false, true}) {
    SCOPED_TRACE(happened);
    ASSERT_EQ(choose("trip").status, 200);
    if (happened) walk();
    core_.reset();
    ASSERT_TRUE(until([&] { return state()["phase"] == "lost"; })) << state();
    const json lost = state();
    EXPECT_EQ(lost["rehearsal"], "trip");
    EXPECT_EQ(lost["session"].is_null(), !happened);
    EXPECT_TRUE(lost["result"].is_null());
    start_core();
    core_->skip(100);
    EXPECT_EQ(state()["phase"], "lost") << "until another one is chosen";
  }
  EXPECT_EQ(choose(nullptr).status, 200);
  EXPECT_EQ(state()["phase"], "none");
}

TEST_F(Rehearsals, ASecondTherapistAsksGetsControlAndGivesItBack) {
  const Answer lease = call("POST", "/api/v1/lease", {{"take_over", true}});
  const Headers holder{{"X-Hoist-Lease", std::to_string(lease.json()["epoch"].get<std::uint32_t>())}};
  ASSERT_EQ(choose("second_therapist").status, 200);
  walk();
  const json asking = get("/api/v1/lease").json()["asking"];
  ASSERT_EQ(asking.size(), 1U);
  EXPECT_EQ(asking[0]["actor"]["origin"], "rehearsal");
  EXPECT_EQ(call("POST", "/api/v1/mode", {{"mode", "standby"}}, holder).status, 200);
  EXPECT_EQ(call("POST", "/api/v1/lease/hand-over", {{"client", asking[0]["client"]}}, holder).status, 200);
  ASSERT_TRUE(until([&] { return get("/api/v1/lease").json()["holder"] == asking[0]["client"]; }));
  ASSERT_TRUE(until([&] {
    core_->skip(20);
    return get("/api/v1/lease").json()["holder"] == 0;
  }));
  ASSERT_TRUE(pass("over"));
  const json items = state()["result"]["items"];
  for (const json& item : items) EXPECT_EQ(item["seen"], "good") << item;
}

TEST_F(Rehearsals, ALostLinkIsTheStreamOfWhoIsInControl) {
  const std::string cookie = log_in();
  const Headers headers{{"Cookie", cookie}, {"Origin", origin()}};
  Live driver(port_, headers);
  ASSERT_EQ(driver.status(), 101U);
  EXPECT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  ASSERT_EQ(choose("link_loss").status, 200);
  walk();
  EXPECT_NE(driver.wait_close(), 0U);
  ASSERT_TRUE(until([&] { return get("/api/v1/lease").json()["holder"] == 0; }));
  Live again(port_, headers);
  EXPECT_TRUE(again.wait("welcome").empty()) << "cut for some seconds";
  // Not earlier: a screen that does not listen is given up after some seconds.
  Live other(port_, bearer_);
  EXPECT_EQ(other.ask({{"type", "lease_take"}})["ok"], true) << "another screen works";
  ASSERT_TRUE(pass("over"));
  const json over = state();
  EXPECT_EQ(over["result"]["items"][0]["seen"], "good") << over;
  // The patient has walked on: the result comes into a recording under way.
  const std::string markers = "/api/v1/sessions/" + std::to_string(over["session"].get<std::int64_t>()) + "/markers";
  EXPECT_TRUE(until([&] {
    const json items = get(markers).json()["items"];
    return !items.empty() && items[0]["rehearsal"] == over["result"];
  }));
}

}  // namespace
}  // namespace hoist::test
