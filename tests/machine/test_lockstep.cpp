// The servo and the tilt filter as machine code against the same sources compiled for this computer: the same bits for 20 000 ticks. And what
// they cost.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/machine/image.hpp"
#include "tests/machine/lockstep_core.hpp"
#include "tests/machine/programs/lockstep.hpp"

namespace hoist::machine {
namespace {

constexpr std::uint32_t kTicks = 20'000;

constexpr std::uint64_t kMillisecond_cycles = 48'000;

// `limit_cycles`: what one tick may cost with a flash that keeps up.
template <class Run>
void compare(const std::string& program, std::uint64_t limit_cycles) {
  const auto image = load_elf(std::string(HOIST_PROGRAMS_DIR) + "/" + program + ".elf", kFlashBytes);
  if (!image) GTEST_SKIP() << "no ARM compiler when this was built: program " << program << " is missing";
  LockstepCore arm(*image);
  Run host;
  std::uint64_t worst_cycles = 0;
  for (std::uint32_t tick = 0; tick < kTicks; ++tick) {
    host.step([](bool) {});
    ASSERT_TRUE(arm.tick()) << "tick " << tick << ": " << arm.trouble();
    ASSERT_EQ(arm.digest(), host.digest()) << program << " differs first in tick " << tick;
    worst_cycles = std::max(worst_cycles, arm.cycles());
  }
  // Checks that the run had motion.
  EXPECT_GT(host.sent(), kTicks / 10);
  EXPECT_EQ(arm.trouble(), "");
  EXPECT_GT(worst_cycles, 1000U);
  EXPECT_LE(worst_cycles, limit_cycles);
}

TEST(Lockstep, TheDriveGivesTheSameBits) { compare<lockstep::DriveRun>("lockstep_drive", kMillisecond_cycles / 4); }
TEST(Lockstep, TheTiltSensorGivesTheSameBits) { compare<lockstep::TiltRun>("lockstep_tilt", kMillisecond_cycles); }

// The comparison needs motion: the drive is enabled, turns in both directions and stops in between.
TEST(Lockstep, TheDriveReallyDrives) {
  lockstep::DriveRun run;
  std::int32_t least = 0, most = 0;
  for (std::uint32_t tick = 0; tick < kTicks; ++tick) {
    run.step([](bool) {});
    least = std::min(least, run.millirad_s());
    most = std::max(most, run.millirad_s());
  }
  EXPECT_LT(least, -50'000);
  EXPECT_GT(most, 150'000);
}

// A second opinion on the machine code: QEMU's Cortex-M0, another interpreter of the same instructions.
template <class Run>
void ask_qemu(const std::string& program) {
  const std::string path = std::string(HOIST_PROGRAMS_DIR) + "/" + program + ".elf";
  if (!load_elf(path, kFlashBytes)) GTEST_SKIP() << "no ARM compiler when this was built: program " << program << " is missing";
  if (std::system("qemu-system-arm --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "qemu-system-arm is not installed";
  // Semihosting prints on standard error.
  FILE* qemu = popen(
      ("timeout 300 qemu-system-arm -M microbit -display none -monitor none -serial none -semihosting -kernel " + path + " 2>&1").c_str(),
      "r");
  ASSERT_NE(qemu, nullptr);
  std::array<char, 64> line{};
  const char* got = std::fgets(line.data(), line.size(), qemu);
  EXPECT_EQ(pclose(qemu), 0);
  ASSERT_NE(got, nullptr);
  Run host;
  for (std::uint32_t tick = 0; tick < kTicks; ++tick) host.step([](bool) {});
  std::array<char, 16> expected{};
  std::snprintf(expected.data(), expected.size(), "%08x\n", static_cast<unsigned>(host.digest()));
  EXPECT_STREQ(line.data(), expected.data());
}
TEST(Qemu, TheDriveGivesTheSameBits) { ask_qemu<lockstep::DriveRun>("qemu_drive"); }
TEST(Qemu, TheTiltSensorGivesTheSameBits) { ask_qemu<lockstep::TiltRun>("qemu_tilt"); }

}  // namespace
}  // namespace hoist::machine
