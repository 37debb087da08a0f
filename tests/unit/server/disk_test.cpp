// Disks that are slow or full: the network, driving and the walk do not notice, and what can be recorded is.
#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <optional>

#include "tests/support/slow_disk.hpp"
#include "tests/unit/server/fixture.hpp"

namespace hoist::test {
namespace {

using Clock = std::chrono::steady_clock;

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
  constexpr auto kSync = std::chrono::milliseconds(500);
  slow_.emplace(kSync);
  begin();
  Live live(port_, bearer_);
  ASSERT_EQ(live.status(), 101U);
  const int syncs = slow_->syncs();
  auto longest = Clock::duration::zero();
  for (const auto end = Clock::now() + 6 * kSync; Clock::now() < end;) {
    const auto asked = Clock::now();
    EXPECT_EQ(get("/api/v1/status").status, 200);
    longest = std::max(longest, Clock::now() - asked);
  }
  EXPECT_GE(slow_->syncs() - syncs, 3) << "the recorder waited for the disk all the time";
  std::printf("longest answer %.1f ms beside syncs of 500 ms\n", std::chrono::duration<double, std::milli>(longest).count());
  EXPECT_LT(longest, kSync / 2);
  const auto session = recording()["session"];
  ASSERT_TRUE(until([&] { return call("POST", "/api/v1/recording", {{"action", "stop"}}).status == 200; }));
  EXPECT_EQ(get("/api/v1/sessions/" + session.dump()).json()["gaps"], 0) << "samples wait in memory";
}

// H17, H25: while the recorder waits for a sync of two seconds, a hand on the stick and STOP reach the core as always.
TEST_F(Disks, ASyncOfSecondsDelaysNeitherDrivingNorStop) {
  using std::chrono::milliseconds;
  constexpr milliseconds kSync(2000);
  slow_.emplace(milliseconds(0));
  begin();
  Live driver(port_, bearer_);
  ASSERT_EQ(driver.ask({{"type", "lease_take"}})["ok"], true);
  slow_->set(kSync);
  const int syncs = slow_->syncs();
  ASSERT_TRUE(until([&] { return slow_->syncs() > syncs; }));
  auto longest_drive = Clock::duration::zero(), longest_stop = Clock::duration::zero();
  std::uint64_t sequence = 0;
  for (const auto end = Clock::now() + kSync + kSync / 2; Clock::now() < end;) {
    const auto sent = Clock::now();
    driver.send({{"type", "drive"}, {"sequence", ++sequence}, {"echo", 5}, {"speed", 0.5}, {"yaw", 0.0}, {"held", true}});
    while (core_->drive().sequence != sequence && Clock::now() - sent < kSync) EXPECT_EQ(get("/api/v1/status").status, 200);
    longest_drive = std::max(longest_drive, Clock::now() - sent);
    // As often as the console sends while the stick is held.
    while (Clock::now() - sent < milliseconds(40)) EXPECT_EQ(get("/api/v1/status").status, 200);
    if (sequence % 10 != 0) continue;
    const auto asked = Clock::now();
    EXPECT_EQ(call("POST", "/api/v1/stop").status, 200);
    longest_stop = std::max(longest_stop, Clock::now() - asked);
    EXPECT_EQ(core_->mode(), contract::Mode::protective_stop);
  }
  const auto in_ms = [](Clock::duration time) { return std::chrono::duration<double, std::milli>(time).count(); };
  std::printf("beside syncs of 2 s: hand to core %.1f ms, STOP %.1f ms at most\n", in_ms(longest_drive), in_ms(longest_stop));
  EXPECT_GT(slow_->syncs(), syncs) << "the disk was slow all the time";
  EXPECT_GE(sequence, 20U);
  EXPECT_LT(longest_drive, kSync / 4);
  EXPECT_LT(longest_stop, kSync / 4);
  slow_->set(milliseconds(0));
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
}

}  // namespace
}  // namespace hoist::test
