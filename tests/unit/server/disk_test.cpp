// Disks that are slow or full: the network, driving and the walk do not notice, and what can be recorded is.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <set>

#include "tests/support/slow_disk.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

class Disks : public ServerTest {
 protected:
  void SetUp() override { core_ = std::make_unique<FakeCore>((folder_ / "core.sock").string()); }
  void TearDown() override {
    ServerTest::TearDown();
    slow_.reset();
    if (!mounted_.empty()) {
      EXPECT_EQ(std::system(("umount '" + mounted_.string() + "'").c_str()), 0);
    }
  }
  void begin() {
    start_server();
    wait_for_core();
    ASSERT_TRUE(until([&] { return get("/api/v1/health").json()["recordings"]["state"] == "sound"; }));
    ASSERT_TRUE(until([&] { return call("POST", "/api/v1/recording", {{"action", "start"}}).status == 200; }));
  }
  // Does it again until two syncs have each seen it begin and end; how many have. What waits for the disk never ends within one, however
  // slow the machine is.
  template <typename Piece>
  std::size_t answered_during_syncs(Piece piece) {
    std::set<int> syncs;
    until([&] {
      const int sync = slow_->running();
      piece();
      if (sync != 0 && slow_->running() == sync) syncs.insert(sync);
      return syncs.size() == 2;
    });
    return syncs.size();
  }
  json recording() { return get("/api/v1/recording").json(); }
  // The folder `disk`, with the recordings, the accounts and the token in it.
  [[nodiscard]] bool mount_disk(const std::string& size = "64m") {
    std::filesystem::create_directory(folder_ / "disk");
    db_path_ = folder_ / "disk" / "hoist.db";
    adjust_ = [this](server::Settings& settings) { settings.token_file = folder_ / "disk" / "token"; };
    return mount(folder_ / "disk", "size=" + size);
  }
  int remount(const char* how) {
    return std::system(("mount -o remount," + std::string(how) + " '" + (folder_ / "disk").string() + "'").c_str());
  }
  void fill() {
    std::ofstream file(folder_ / "disk" / "fill");
    while (file << std::string(4096, 'x') << std::flush) {
    }
  }
  bool told(const std::string& name) {
    return std::ranges::any_of(get("/api/v1/status").json()["notices"], [&](const json& notice) { return notice["name"] == name; });
  }
  // As a browser, with this cookie.
  Answer as_browser(const std::string& cookie, const std::string& method, const std::string& target, const json& body = nullptr) {
    Headers headers{{"X-Hoist", "1"}, {"Origin", "http://127.0.0.1:" + std::to_string(port_)}, {"Cookie", cookie}};
    if (!body.is_null()) headers.emplace_back("Content-Type", "application/json");
    return http(port_, method, target, headers, body.is_null() ? "" : body.dump());
  }
  // A therapist's sign-in on a tablet.
  std::string sign_in() {
    const json person{{"user", "anna"}, {"password", "four words not together"}};
    const Answer answer = as_browser("", "POST", "/api/v1/session", person);
    EXPECT_EQ(answer.status, 200U) << answer.body;
    const std::string set = answer.header("set-cookie");
    return set.substr(0, set.find(';'));
  }
  void add_people() {
    for (const auto& [user, role] : {std::pair{"erika", "engineer"}, {"anna", "therapist"}})
      ASSERT_EQ(
          call("POST", "/api/v1/users", {{"user", user}, {"display_name", user}, {"role", role}, {"password", "four words not together"}})
              .status,
          201U);
  }
  // The cookie of a therapist's sign-in.
  std::string begin_with_people() {
    begin();
    add_people();
    return sign_in();
  }
  std::size_t stops_in_log() {
    std::size_t stops = 0;
    const json rows = get("/api/v1/audit?limit=200").json()["items"];
    for (const json& row : rows) stops += row["action"] == "stop" && row["user"] == "anna" ? 1 : 0;
    return stops;
  }
  // After a start with a disk that takes no data; `mend` lets it take them again.
  void people_are_known(const std::string& cookie, const std::function<void()>& mend) {
    start_server();
    wait_for_core();
    EXPECT_EQ(as_browser(cookie, "POST", "/api/v1/stop").status, 200U);
    EXPECT_EQ(core_->mode(), contract::Mode::protective_stop);
    const json who = as_browser(cookie, "GET", "/api/v1/session").json();
    EXPECT_EQ(who["user"], "anna") << who;
    EXPECT_EQ(who["set_up"]["needed"], false) << who;
    EXPECT_NE(who["problem"], nullptr) << who;
    EXPECT_TRUE(told("accounts_not_stored"));
    mend();
    ASSERT_TRUE(until([&] { return !told("accounts_not_stored"); }));
    EXPECT_EQ(as_browser(cookie, "GET", "/api/v1/session").json()["problem"], nullptr);
    sign_in();
    EXPECT_TRUE(until([&] { return stops_in_log() == 1; })) << "what was done meanwhile is in the log";
  }
  std::optional<tests::SlowDisk> slow_;
  // A file system in memory at this folder; false when this user may not mount one.
  bool mount(const std::filesystem::path& folder, const std::string& options) {
    const bool done = std::system(("mount -t tmpfs -o " + options + " hoist-test '" + folder.string() + "' 2>/dev/null").c_str()) == 0;
    if (done) mounted_ = folder;
    return done;
  }
  std::filesystem::path mounted_;
};

// H25
TEST_F(Disks, ASyncOfHalfASecondDelaysNoAnswerAndCostsNoSample) {
  slow_.emplace(std::chrono::milliseconds(500));
  begin();
  Live live(port_, bearer_);
  ASSERT_EQ(live.status(), 101U);
  EXPECT_EQ(answered_during_syncs([&] { EXPECT_EQ(get("/api/v1/status").status, 200); }), 2U);
  const auto session = recording()["session"];
  ASSERT_TRUE(until([&] { return call("POST", "/api/v1/recording", {{"action", "stop"}}).status == 200; }));
  EXPECT_EQ(get("/api/v1/sessions/" + session.dump()).json()["gaps"], 0) << "samples wait in memory";
}

// H17, H25: while the recorder waits for syncs of a second, a hand on the stick and STOP reach the core as always.
TEST_F(Disks, ASyncOfASecondDelaysNeitherDrivingNorStop) {
  slow_.emplace(std::chrono::seconds(0));
  begin();
  Live driver(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  slow_->set(std::chrono::seconds(1));
  std::uint64_t sequence = 0;
  EXPECT_EQ(answered_during_syncs([&] {
              driver.send({{"type", "drive"}, {"sequence", ++sequence}, {"echo", 5}, {"speed", 0.5}, {"yaw", 0.0}, {"held", true}});
              ASSERT_TRUE(until([&] { return core_->drive().sequence == sequence; }));
            }),
            2U);
  EXPECT_EQ(answered_during_syncs([&] {
              EXPECT_EQ(call("POST", "/api/v1/stop").status, 200);
              EXPECT_EQ(core_->mode(), contract::Mode::protective_stop);
            }),
            2U);
  slow_->set(std::chrono::seconds(0));
}

// H24
TEST_F(Disks, AStartOnAFullDiskKnowsItsPeople) {
  if (!mount_disk()) GTEST_SKIP() << "this user may not mount a file system";
  const std::string cookie = begin_with_people();
  stop_server();
  fill();
  people_are_known(cookie, [this] { std::filesystem::remove(folder_ / "disk" / "fill"); });
}
TEST_F(Disks, AStartOnAReadOnlyDiskKnowsItsPeople) {
  if (!mount_disk()) GTEST_SKIP() << "this user may not mount a file system";
  const std::string cookie = begin_with_people();
  stop_server();
  ASSERT_EQ(remount("ro"), 0);
  people_are_known(cookie, [this] { EXPECT_EQ(remount("rw"), 0); });
}

// H24
TEST_F(Disks, RowsOfTheAuditLogWaitForAFullDisk) {
  if (!mount_disk()) GTEST_SKIP() << "this user may not mount a file system";
  const std::string cookie = begin_with_people();
  fill();
  std::size_t stops = 0;
  // The first of them still fit into the pages that the log has.
  ASSERT_TRUE(until([&] {
    if (as_browser(cookie, "POST", "/api/v1/stop").status == 200U) ++stops;
    return told("accounts_not_stored");
  }));
  for (int i = 0; i < 3; ++i)
    if (as_browser(cookie, "POST", "/api/v1/stop").status == 200U) ++stops;
  std::filesystem::remove(folder_ / "disk" / "fill");
  ASSERT_TRUE(until([&] { return !told("accounts_not_stored"); }));
  EXPECT_TRUE(until([&] { return stops_in_log() == stops; })) << stops_in_log() << " of " << stops;
}

TEST_F(Disks, AReadOnlyDiskIsToldAndRecordedIntoOnceItMayBeWritten) {
  if (!mount_disk()) GTEST_SKIP() << "this user may not mount a file system";
  start_server();
  wait_for_core();
  ASSERT_TRUE(until([&] { return get("/api/v1/health").json()["recordings"]["state"] == "sound"; }));
  stop_server();
  ASSERT_EQ(remount("ro"), 0);
  start_server();
  wait_for_core();
  EXPECT_TRUE(until([&] { return recording()["state"] == "failed"; }));
  EXPECT_EQ(recording()["reason_code"], "read_only") << recording();
  EXPECT_EQ(get("/api/v1/status").json()["core"]["connected"], true) << "walking goes on";
  EXPECT_NE(call("POST", "/api/v1/recording", {{"action", "start"}}).status, 200U);
  ASSERT_EQ(remount("rw"), 0);
  EXPECT_TRUE(until([&] { return recording()["state"] == "idle"; })) << recording();
  ASSERT_TRUE(until([&] { return call("POST", "/api/v1/recording", {{"action", "start"}}).status == 200; }));
  EXPECT_EQ(call("POST", "/api/v1/recording", {{"action", "stop"}}).status, 200);
}

// H24
TEST_F(Disks, ADiskThatIsNearlyFullTakesNoNewSession) {
  if (!mount_disk("100m")) GTEST_SKIP() << "this user may not mount a file system";
  begin();
  const json running = recording();
  const auto most = std::filesystem::path(folder_ / "disk" / "fill");
  std::ofstream(most) << std::string(64'000'000, 'x');
  const auto started = [&] { return call("POST", "/api/v1/recording", {{"action", "start"}}); };
  EXPECT_TRUE(until([&] { return recording()["durable_tick"] > running["durable_tick"]; })) << "what runs goes on";
  EXPECT_EQ(recording()["session"], running["session"]);
  ASSERT_EQ(call("POST", "/api/v1/recording", {{"action", "stop"}}).status, 200);
  const Answer refused = started();
  ASSERT_EQ(refused.status, 507U) << refused.body;
  // What the end of the session still stored lies between the two looks at the disk.
  const auto free_MB = static_cast<double>(std::filesystem::space(folder_ / "disk").available) / 1e6;
  const std::string detail = refused.json()["detail"];
  EXPECT_NEAR(std::atof(detail.c_str()), free_MB, 3) << detail;
  EXPECT_EQ(detail.substr(detail.find(' ')), " MB are free on the disk of the recordings, and a new session needs 50 MB.");
  EXPECT_TRUE(until([&] { return told("recordings_low_space"); }));
  // A walk, too: it is recorded from the moment at which there is room.
  core_->set([](contract::TickRecord& record) { record.mode = static_cast<std::uint8_t>(contract::Mode::user); });
  EXPECT_TRUE(until([&] { return recording()["state"] == "failed"; }));
  EXPECT_EQ(recording()["reason_code"], "disk_full") << recording();
  EXPECT_EQ(get("/api/v1/mode").json()["mode"], "user") << "walking goes on";
  std::filesystem::remove(most);
  EXPECT_TRUE(until([&] { return recording()["state"] == "recording"; }));
}

TEST_F(Disks, AFullDiskIsToldAndRecordingGoesOnWhenThereIsRoomAgain) {
  core_.reset();
  if (!mount(folder_.path(), "size=64m")) GTEST_SKIP() << "this user may not mount a file system";
  core_ = std::make_unique<FakeCore>((folder_ / "core.sock").string());
  begin();
  {
    std::ofstream fill(folder_ / "fill");
    while (fill << std::string(4096, 'x') << std::flush) {
    }
  }
  EXPECT_TRUE(until([&] { return recording()["state"] == "failed"; }));
  EXPECT_EQ(recording()["reason_code"], "disk_full") << recording();
  EXPECT_EQ(get("/api/v1/status").json()["core"]["connected"], true) << "walking goes on";
  std::filesystem::remove(folder_ / "fill");
  EXPECT_TRUE(until([&] { return recording()["state"] == "recording"; }));
  const auto session = recording()["session"];
  EXPECT_EQ(call("POST", "/api/v1/recording", {{"action", "stop"}}).status, 200);
  EXPECT_EQ(get("/api/v1/sessions/" + session.dump()).json()["gaps"], 0) << "what did not fit meanwhile waited in memory";
  // A format that is made whole first needs far more room than this disk has.
  EXPECT_EQ(get("/api/v1/sessions/" + session.dump() + "/export?format=sqlite").status, 507U);
}

}  // namespace
}  // namespace hoist::test
