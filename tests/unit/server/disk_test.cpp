// Disks that are slow or full: the network, driving and the walk do not notice, and what can be recorded is.
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

TEST_F(Disks, AReadOnlyDiskIsToldAndRecordedIntoOnceItMayBeWritten) {
  db_path_ = folder_ / "disk" / "hoist.db";
  std::filesystem::create_directory(folder_ / "disk");
  if (!mount(folder_ / "disk", "size=32m")) GTEST_SKIP() << "this user may not mount a file system";
  start_server();
  wait_for_core();
  ASSERT_TRUE(until([&] { return get("/api/v1/health").json()["recordings"]["state"] == "sound"; }));
  stop_server();
  const auto remount = [&](const char* how) {
    return std::system(("mount -o remount," + std::string(how) + " '" + (folder_ / "disk").string() + "'").c_str());
  };
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

TEST_F(Disks, AFullDiskIsToldAndRecordingGoesOnWhenThereIsRoomAgain) {
  core_.reset();
  if (!mount(folder_.path(), "size=6m")) GTEST_SKIP() << "this user may not mount a file system";
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
