// Recordings that can be run again: random sessions go through the real core, shared memory, recorder and store, are read back and run again, and
// each record must come out bit for bit (I15).
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdio>

#include "control/contract/program_version.hpp"
#include "control/publish/step_publisher.hpp"
#include "deploy/tools/hoist/rerun.hpp"
#include "server/record/recorder.hpp"
#include "tests/chaos/session.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/seeds.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::chaos {
namespace {

std::string list(const SessionReport& report) {
  std::string text = "seed " + std::to_string(report.seed) + ":\n";
  for (const std::string& line : report.broken) text += line + "\n";
  return text;
}

TEST(Rerun, EverySampleOfRandomSessionsComesOutBitForBit) {
  const auto sessions = static_cast<std::uint64_t>(tests::seeds_for(100, 40, 4));
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

// It begins between two images of the core, a second apart: its journal goes back to the earlier one.
TEST(Rerun, ARecordingBegunByHandCanBeRunAgainFromItsFirstSample) {
  const test::TemporaryFolder folder;
  std::string error;
  auto core = publish::CoreLink::create("", 1, 1'790'000'000'000'000'000, error);
  ASSERT_NE(core, nullptr) << error;
  publish::ServerLink link("");
  ASSERT_TRUE(link.attach_directly(*core, error)) << error;
  publish::StepPublisher publisher(*core);
  std::uint64_t now_ns = 0, steps = 0;
  server::Recorder::Options options;
  options.file = folder / "hoist.db";
  options.version = "test";
  options.utc_ns = [&now_ns] { return static_cast<std::int64_t>(now_ns); };
  options.steady_ns = [&now_ns] { return now_ns; };
  server::Recorder recorder(link, std::move(options));
  recorder.open_here();
  tests::ClosedLoop loop({});
  loop.on_inputs([&](const core::TickInputs& inputs) { publisher.before(loop.core(), inputs); });
  loop.on_step([&](const core::TickInputs& inputs, const core::TickOutputs& outputs) {
    publisher.after(inputs, outputs, outputs.frames.size());
    now_ns = inputs.time_ns;
    if (++steps % 5 == 0) recorder.pass_here();
  });
  loop.run(2.5);
  db::Status begun, ended;
  ASSERT_TRUE(recorder.run([&begun](server::Records& records) { begun = records.begin_manual(std::nullopt, ""); }));
  loop.run(1.0);
  ASSERT_TRUE(begun.ok()) << begun.error().message;
  ASSERT_TRUE(recorder.run([&ended](server::Records& records) { ended = records.end_manual(); }));
  loop.run(0.2);
  ASSERT_TRUE(ended.ok()) << ended.error().message;
  recorder.finish_here();
  auto database = db::Database::open(folder / "hoist.db");
  ASSERT_TRUE(database.ok()) << database.error().message;
  const auto result = tool::verify_session(*database, 1, contract::program_version());
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_GT(result->run.samples, 80U);
  EXPECT_EQ(result->run.samples_run, result->run.samples) << (result->run.not_run.empty() ? "" : result->run.not_run[0].reason);
  EXPECT_FALSE(result->first.has_value());
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
