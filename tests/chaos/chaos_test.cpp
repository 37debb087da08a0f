// A few sessions in every test run; `deploy/dev chaos` has as many as one likes, `deploy/dev check` two thousand.
#include <gtest/gtest.h>

#include "tests/chaos/session.hpp"

namespace hoist::chaos {
namespace {

#ifdef HOIST_SANITIZED
constexpr std::uint64_t kSessions = 6;
#else
constexpr std::uint64_t kSessions = 40;
#endif

std::string list(const SessionReport& report) {
  std::string text = "hoist-chaos --sessions 1 --story --seed " + std::to_string(report.seed) + " shows it:\n";
  for (const std::string& line : report.broken) text += line + "\n";
  return text;
}

TEST(Chaos, WhateverBreaksWhatMustHoldHolds) {
  int stops = 0;
  double walked_s = 0;
  for (std::uint64_t seed = 1; seed <= kSessions; ++seed) {
    const SessionReport report = run_session({.seed = seed});
    EXPECT_TRUE(report.broken.empty()) << list(report);
    stops += report.stops;
    walked_s += report.walked_s;
  }
  // The sessions are no good if nobody walks in them or nothing ever happens.
  EXPECT_GT(walked_s, 30.0 * static_cast<double>(kSessions));
  EXPECT_GT(stops, static_cast<int>(kSessions) / 2);
}

TEST(Chaos, WithoutFaultsOnlyTheTherapistStopsTheHoist) {
  for (std::uint64_t seed = 1; seed <= kSessions / 2; ++seed) {
    SessionOptions options{.seed = seed, .faults_max = 0};
    const SessionReport report = run_session(options);
    EXPECT_TRUE(report.broken.empty()) << list(report);
    EXPECT_EQ(report.false_stops, 0);
  }
}

TEST(Chaos, TheSameSeedIsTheSameSession) {
  const SessionReport once = run_session({.seed = 77, .length_s = 40}), again = run_session({.seed = 77, .length_s = 40});
  EXPECT_EQ(once.digest, again.digest);
  EXPECT_NE(once.digest, run_session({.seed = 78, .length_s = 40}).digest);
}

}  // namespace
}  // namespace hoist::chaos
