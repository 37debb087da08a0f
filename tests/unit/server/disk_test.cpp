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
  }
  void begin() {
    start_server();
    wait_for_core();
    ASSERT_TRUE(until([&] { return get("/api/v1/health").json()["recordings"]["state"] == "sound"; }));
    ASSERT_TRUE(until([&] { return call("POST", "/api/v1/recording", {{"action", "start"}}).status == 200; }));
  }
  json recording() { return get("/api/v1/recording").json(); }
  std::optional<tests::SlowDisk> slow_;
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

TEST_F(Disks, AFullDiskIsToldAndRecordingGoesOnWhenThereIsRoomAgain) {
  const std::string mount = "mount -t tmpfs -o size=6m hoist-test '" + (folder_ / "small").string() + "' 2>/dev/null";
  std::filesystem::create_directory(folder_ / "small");
  if (std::system(mount.c_str()) != 0) GTEST_SKIP() << "this user may not mount a file system";
  db_path_ = folder_ / "small" / "hoist.db";
  begin();
  {
    std::ofstream fill(folder_ / "small" / "fill");
    while (fill << std::string(4096, 'x') << std::flush) {
    }
  }
  EXPECT_TRUE(until([&] { return recording()["state"] == "failed"; }));
  EXPECT_EQ(recording()["reason_code"], "disk_full") << recording();
  EXPECT_EQ(get("/api/v1/status").json()["core"]["connected"], true) << "walking goes on";
  std::filesystem::remove(folder_ / "small" / "fill");
  EXPECT_TRUE(until([&] { return recording()["state"] == "recording"; }));
  const auto session = recording()["session"];
  EXPECT_EQ(call("POST", "/api/v1/recording", {{"action", "stop"}}).status, 200);
  EXPECT_EQ(get("/api/v1/sessions/" + session.dump()).json()["gaps"], 0) << "what did not fit meanwhile waited in memory";
  stop_server();
  EXPECT_EQ(std::system(("umount '" + (folder_ / "small").string() + "'").c_str()), 0);
}

}  // namespace
}  // namespace hoist::test
