// Due times and lateness of steps, requests of threads, notifications to the service manager.
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <string>
#include <thread>

#include "control/contract/loop_report.hpp"
#include "control/run/lateness.hpp"
#include "control/run/pacer.hpp"
#include "control/run/real_time.hpp"
#include "control/run/watchdog.hpp"

namespace hoist::run {
namespace {

constexpr std::uint64_t kMs = 1'000'000;

TEST(Pacer, StepsOnTimeAreNumberedWithoutHolesAndNeverLate) {
  Pacer pacer(1000 * kMs);
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const std::uint64_t wake_ns = pacer.wake_ns();
    ASSERT_EQ(wake_ns, 1000 * kMs + i * kPeriodNs) << "the grid does not drift";
    ASSERT_EQ(pacer.tick(), i);
    ASSERT_LE(pacer.begin(wake_ns + 50'000 * (i % 2)), 50'000U);
    pacer.end(wake_ns + 200'000);
  }
}

TEST(Pacer, H22ALateWakeUpIsLateOnceAndLeavesStepsOut) {
  Pacer pacer(1000 * kMs);
  EXPECT_EQ(pacer.begin(1025 * kMs), 25 * kMs);
  pacer.end(1025 * kMs + 1);
  EXPECT_EQ(pacer.tick(), 3U) << "two steps are left out, and the number shows it";
  EXPECT_EQ(pacer.wake_ns(), 1030 * kMs);
  EXPECT_EQ(pacer.begin(1030 * kMs), 0U) << "one hold-up is no second late step";
  pacer.end(1030 * kMs + 1);
  EXPECT_EQ(pacer.tick(), 4U);
}

TEST(Pacer, H22AStepThatTakesTooLongMakesTheNextOneLate) {
  Pacer pacer(1000 * kMs);
  EXPECT_EQ(pacer.begin(1000 * kMs), 0U);
  pacer.end(1045 * kMs);  // a write that hung
  EXPECT_EQ(pacer.tick(), 5U);
  EXPECT_EQ(pacer.wake_ns(), 1050 * kMs);
  EXPECT_EQ(pacer.begin(1050 * kMs), 40 * kMs) << "it was due 10 ms after the one before began";
}

TEST(Pacer, AStepThatJustFillsItsTimeLosesNothing) {
  Pacer pacer(1000 * kMs);
  EXPECT_EQ(pacer.begin(1000 * kMs), 0U);
  pacer.end(1010 * kMs);
  EXPECT_EQ(pacer.tick(), 1U);
  EXPECT_EQ(pacer.begin(1010 * kMs), 0U);
}

TEST(Lateness, BucketsCoverEverythingInOrderWithinAQuarter) {
  std::size_t before = 0;
  for (std::uint64_t ns = 0; ns < 14'000'000'000; ns = ns * 21 / 20 + 1) {
    const std::size_t bucket = contract::lateness_bucket(ns);
    ASSERT_GE(bucket, before);
    ASSERT_LE(bucket, before + 1) << "no hole between buckets at " << ns;
    ASSERT_LT(ns, contract::lateness_bucket_end_ns(bucket));
    if (bucket > 0) {
      ASSERT_GE(ns, contract::lateness_bucket_end_ns(bucket - 1));
      ASSERT_LE(contract::lateness_bucket_end_ns(bucket) * 4, contract::lateness_bucket_end_ns(bucket - 1) * 5) << "a quarter at most";
    }
    before = bucket;
  }
  EXPECT_EQ(contract::lateness_bucket(~std::uint64_t{0}), contract::kLatenessBuckets - 1);
}

TEST(Lateness, TellsMiddleTailAndLatestOfTheLastTenSeconds) {
  Lateness lateness;
  int told = 0;
  // 10 s: 20 us each, one in fifty 300 us, one 7 ms.
  for (int i = 0; i < 1000; ++i) told += lateness.add(i == 500 ? 7 * kMs : i % 50 == 0 ? 300'000 : 20'000, 100'000) ? 1 : 0;
  EXPECT_EQ(told, 10) << "once a second";
  EXPECT_GE(lateness.p50_s(), 20e-6F);
  EXPECT_LE(lateness.p50_s(), 25e-6F);
  EXPECT_GE(lateness.p99_s(), 300e-6F);
  EXPECT_LE(lateness.p99_s(), 375e-6F);
  EXPECT_FLOAT_EQ(lateness.max_s(), 7e-3F);
  // Ten seconds later it has left that window, and stays in the count since the start.
  for (int i = 0; i < 1100; ++i) lateness.add(20'000, 100'000);
  EXPECT_LE(lateness.p99_s(), 25e-6F);
  EXPECT_FLOAT_EQ(lateness.max_s(), 20e-6F);
  const contract::LoopReport& report = lateness.report();
  EXPECT_EQ(report.steps, 2100U);
  EXPECT_EQ(report.latest_ever_ns, 7 * kMs);
  EXPECT_EQ(report.longest_step_ns, 100'000U);
  std::uint64_t ever = 0, lately = 0;
  for (std::size_t i = 0; i < contract::kLatenessBuckets; ++i) {
    ever += report.ever[i];
    lately += report.lately[i];
  }
  EXPECT_EQ(ever, 2100U);
  EXPECT_EQ(lately, 900U) << "nine whole seconds and the one that has just begun";
}

TEST(RealTime, ChoosesTheCoreThatTheKernelKeepsFreeElseTheLastElseNone) {
  std::string error;
  EXPECT_EQ(choose_cpu("auto", "2-3\n", 0b1111, error), 2);
  EXPECT_EQ(choose_cpu("auto", "5\n", 0b1111, error), 3) << "one that we may not use is none";
  EXPECT_EQ(choose_cpu("auto", "\n", 0b1011, error), 3);
  EXPECT_EQ(choose_cpu("auto", "", 0b0001, error), kNoCpu) << "the only one is everybody's";
  EXPECT_EQ(choose_cpu("auto", "", 0, error), kNoCpu);
  EXPECT_EQ(choose_cpu("none", "2", 0b1111, error), kNoCpu);
  EXPECT_EQ(choose_cpu("1", "", 0b0011, error), 1);
  EXPECT_TRUE(error.empty());
  for (const char* wish : {"2", "64", "-1", "1x", "", "01", "99999999999"}) {
    error.clear();
    EXPECT_FALSE(choose_cpu(wish, "", 0b0011, error).has_value()) << wish;
    EXPECT_FALSE(error.empty()) << wish;
  }
}

TEST(RealTime, TheControlThreadIsAboveAllOfOursAndBelowTheKernels) {
  for (const ThreadRow& row : kThreads) {
    if (row.name != "control") {
      EXPECT_LT(row.fifo, row_of(ThreadId::control).fifo) << row.name;
    }
    EXPECT_LT(row.fifo, 50) << row.name << ": the kernel's interrupt threads come first";
    EXPECT_EQ(row.own_cpu, row.name == "control") << row.name;
  }
}

TEST(RealTime, CountsThePageFaultsOfAThread) {
  const auto before = page_faults_of(::gettid());
  ASSERT_TRUE(before.has_value());
  std::string fresh(std::size_t{64} * 4096, 'x');
  volatile char sink = fresh[fresh.size() / 2];
  static_cast<void>(sink);
  const auto after = page_faults_of(::gettid());
  ASSERT_TRUE(after.has_value());
  EXPECT_GE(*after, *before);
  EXPECT_FALSE(page_faults_of(-1).has_value());
}

class Manager : public ::testing::Test {
 protected:
  Manager() : path(::testing::TempDir() + "hoist-notify-" + std::to_string(::getpid())) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.data(), path.size());
    descriptor = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ::unlink(path.c_str());
    bound = ::bind(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Manager() override {
    ::close(descriptor);
    ::unlink(path.c_str());
  }
  Manager(const Manager&) = delete;
  Manager& operator=(const Manager&) = delete;
  // What waits, or nothing.
  [[nodiscard]] std::string heard() const {
    std::array<char, 200> text{};
    const ssize_t got = ::recv(descriptor, text.data(), text.size(), MSG_DONTWAIT);
    return got > 0 ? std::string(text.data(), static_cast<std::size_t>(got)) : std::string();
  }
  std::string path;
  int descriptor = -1;
  bool bound = false;
};

TEST_F(Manager, H23TheWatchdogIsFedOnlyWhenStepsGoOn) {
  ASSERT_TRUE(bound);
  Notifier notifier(path, 500'000);
  EXPECT_EQ(notifier.period_ns(), 100 * kMs);
  EXPECT_FALSE(notifier.look(0)) << "not one step yet: not ready";
  EXPECT_EQ(heard(), "");
  EXPECT_TRUE(notifier.look(3));
  EXPECT_EQ(heard(), "READY=1\nWATCHDOG=1");
  EXPECT_FALSE(notifier.look(3)) << "the steps stand still";
  EXPECT_EQ(heard(), "");
  EXPECT_TRUE(notifier.look(4));
  EXPECT_EQ(heard(), "WATCHDOG=1");
}

TEST_F(Manager, LooksFourTimesInTheManagersTimeAndBearsNobodyListening) {
  EXPECT_EQ(Notifier(path, 100'000).period_ns(), 25 * kMs);
  EXPECT_EQ(Notifier(path, 0).period_ns(), 100 * kMs);
  Notifier nobody("", 0);
  EXPECT_TRUE(nobody.look(1));
  Notifier gone(path + "-gone", 0);
  EXPECT_TRUE(gone.look(1));
  Notifier longer(std::string(500, 'x'), 0);
  EXPECT_TRUE(longer.look(1));
  EXPECT_EQ(heard(), "");
}

}  // namespace
}  // namespace hoist::run
