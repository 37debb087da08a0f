// Recordings that can be run again: random sessions go through the real core, shared memory, recorder and store, are read back and run again, and
// each record must come out bit for bit (I15).
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdio>

#include "tests/chaos/session.hpp"
#include "tests/support/seeds.hpp"

namespace hoist::chaos {
namespace {

std::string list(const SessionReport& report) {
  std::string text = "seed " + std::to_string(report.seed) + ":\n";
  for (const std::string& line : report.broken) text += line + "\n";
  return text;
}

TEST(Rerun, EverySampleOfRandomSessionsComesOutBitForBit) {
  const std::uint64_t sessions = tests::seeds_for(tests::thorough() ? 1000 : 100, 4);
  constexpr double length_s = 25.0;
  std::uint64_t again = 0, not_run = 0;
  for (std::uint64_t seed = 1; seed <= sessions; ++seed) {
    const SessionReport report = run_session({.seed = seed, .length_s = length_s, .record = true});
    EXPECT_TRUE(report.broken.empty()) << list(report);
    again += report.samples_again;
    not_run += report.samples_not_run;
  }
  std::printf("%llu samples run again, %llu not\n", static_cast<unsigned long long>(again), static_cast<unsigned long long>(not_run));
  EXPECT_GT(again, 500 * sessions);
  // Only what a hung server or a refusing disk has lost.
  EXPECT_LT(not_run, again / 20);
}

TEST(Rerun, WithoutFaultsNothingIsLeftOut) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const SessionReport report = run_session({.seed = seed, .length_s = 40.0, .faults = std::vector<Fault>{}, .record = true});
    EXPECT_TRUE(report.broken.empty()) << list(report);
    EXPECT_GT(report.samples_again, 500U);
    EXPECT_EQ(report.samples_not_run, 0U) << "seed " << seed;
  }
}

TEST(Rerun, OneHourComesOutBitForBit) {
  if (!tests::thorough()) GTEST_SKIP() << "takes a minute; deploy/dev check runs it";
  const SessionReport report =
      run_session({.seed = 4, .length_s = 3600.0, .only_walk = true, .faults = std::vector<Fault>{}, .record = true});
  EXPECT_TRUE(report.broken.empty()) << list(report);
  EXPECT_GT(report.samples_again, 100'000U);
  EXPECT_EQ(report.samples_not_run, 0U);
}

// One bit of one value, too small for the stored samples to show.
TEST(RerunBites, ACoreThatDiffersInOneBit) {
  SessionOptions options{.seed = 3, .length_s = 30.0, .faults = std::vector<Fault>{}, .record = true};
  options.sabotage = [](double time_s, core::CoreState&, core::TickOutputs& out) {
    if (time_s > 19.995 && time_s < 20.005) out.record.x_m = std::bit_cast<float>(std::bit_cast<std::uint32_t>(out.record.x_m) ^ 1U);
  };
  const SessionReport report = run_session(options);
  ASSERT_FALSE(report.broken.empty());
  EXPECT_NE(report.broken.back().find("I15: session 1 run again is another one from tick 2000 on, in the last bits"), std::string::npos)
      << list(report);
}

// What the core remembers, not what it says: noticed as soon as it shows.
TEST(RerunBites, ACoreThatRemembersSomethingElse) {
  SessionOptions options{.seed = 3, .length_s = 30.0, .faults = std::vector<Fault>{}, .record = true};
  options.sabotage = [](double time_s, core::CoreState& core, core::TickOutputs&) {
    if (time_s > 19.995 && time_s < 20.005) ++core.bus_refused;
  };
  const SessionReport report = run_session(options);
  ASSERT_FALSE(report.broken.empty());
  EXPECT_NE(report.broken.back().find("in bus_refused"), std::string::npos) << list(report);
}

}  // namespace
}  // namespace hoist::chaos
