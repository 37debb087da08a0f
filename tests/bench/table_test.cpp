// Statistics and comparison of the bench: what makes `deploy/dev bench --compare` fail.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "tests/bench/statistics.hpp"
#include "tests/bench/table.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::bench {
namespace {

Row ratio_row(const std::string& id, double value, double floor, Better better = Better::lower) {
  Row row;
  row.id = id;
  row.value = value;
  row.floor = floor;
  row.goal.better = better;
  return row;
}

TEST(BenchStatistics, PercentilesByNearestRank) {
  // The worked example of the nearest-rank method: ordered list 15, 20, 35, 40, 50.
  const std::vector<double> values{35, 20, 15, 50, 40};
  EXPECT_EQ(percentile(values, 0.05), 15);
  EXPECT_EQ(percentile(values, 0.30), 20);
  EXPECT_EQ(percentile(values, 0.40), 20);
  EXPECT_EQ(median(values), 35);
  EXPECT_EQ(percentile(values, 1.0), 50);
  EXPECT_EQ(percentile({7}, 0.99), 7);
  EXPECT_TRUE(std::isnan(percentile({}, 0.5)));
}

TEST(BenchTable, AGoalIsForTheRatioWhereThereIsAFloor) {
  Row row = ratio_row("loop.p99", 26, 20);
  row.goal.limit = 1.3;
  EXPECT_TRUE(met(row));
  row.value = 26.1;
  EXPECT_FALSE(met(row));
  EXPECT_NE(line_of(row).find("NOT MET"), std::string::npos);
  Row speed;
  speed.value = 1999;
  speed.goal = {2000, Better::higher};
  EXPECT_FALSE(met(speed));
  speed.value = 2000;
  EXPECT_TRUE(met(speed));
}

TEST(BenchCompare, TenPercentWorseIsAllowedAndMoreFails) {
  const StoredFigures stored = parse_stored("a.cost 2.0 lower\na.speed 100 higher # x real time\n");
  const auto failures = [&](double cost, double speed) {
    return compare(stored, {ratio_row("a.cost", cost, 1), ratio_row("a.speed", speed, 1, Better::higher)}, {"a"}).failures.size();
  };
  EXPECT_EQ(failures(2.19, 91), 0U);
  EXPECT_EQ(failures(2.21, 91), 1U);
  EXPECT_EQ(failures(2.19, 90), 1U);
  EXPECT_EQ(failures(0.1, 10000), 0U) << "better never fails";
  EXPECT_EQ(failures(std::nan(""), 100), 1U) << "a figure that is no number";
}

TEST(BenchCompare, AStoredRowThatIsGoneFailsUnlessItsSectionDidNotRunOrItWasSkipped) {
  const StoredFigures stored = parse_stored("a.x 1 lower\nb.y 1 lower\n");
  EXPECT_EQ(compare(stored, {ratio_row("b.y", 1, 1)}, {"a", "b"}).failures.size(), 1U);
  EXPECT_TRUE(compare(stored, {ratio_row("b.y", 1, 1)}, {"b"}).failures.empty());
  Row skipped = ratio_row("a.x", 0, 0);
  skipped.skipped = "nginx is not installed";
  const Comparison with_skip = compare(stored, {skipped, ratio_row("b.y", 1, 1)}, {"a", "b"});
  EXPECT_TRUE(with_skip.failures.empty());
  EXPECT_EQ(with_skip.remarks.size(), 1U);
}

TEST(BenchCompare, OnlyRatiosAndExactCountsAreStored) {
  Row bare = ratio_row("a.time", 5, 0), exact = ratio_row("a.instructions", 5000, 0);
  exact.exact = true;
  StoredFigures stored = parse_stored("b.kept 3 lower");
  store_rows(stored, {bare, exact, ratio_row("a.ratio", 6, 4)});
  EXPECT_EQ(stored.size(), 3U);
  const StoredFigures again = parse_stored(print_stored(stored));
  EXPECT_DOUBLE_EQ(again.at("a.ratio").figure, 1.5);
  EXPECT_DOUBLE_EQ(again.at("a.instructions").figure, 5000);
  EXPECT_FALSE(again.contains("a.time"));
}

TEST(BenchCompare, TimesOfABusyMachineAreNeitherJudgedNorStored) {
  Row time = ratio_row("a.time", 9, 1), count = ratio_row("a.count", 9, 0);
  count.exact = true;
  time.busy = count.busy = true;
  const Comparison compared = compare(parse_stored("a.time 1 lower\na.count 1 lower"), {time, count}, {"a"});
  ASSERT_EQ(compared.failures.size(), 1U);
  EXPECT_EQ(compared.failures[0].find("a.count"), 0U);
  EXPECT_EQ(compared.remarks.size(), 1U);
  StoredFigures stored;
  store_rows(stored, {time, count});
  EXPECT_EQ(stored.size(), 1U);
  EXPECT_TRUE(stored.contains("a.count"));
}

TEST(BenchRun, ASectionIsBusyWhenOthersUseTheMachineBeforeOrAfterIt) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "stored.txt";
  struct Case {
    std::vector<double> used;  // before and after
    int exit_code;             // 1: the row was judged, and is worse
  };
  for (const Case& one : {Case{{0.0, 0.5}, 0}, Case{{0.5, 0.0}, 0}, Case{{0.05, 0.05}, 1}}) {
    std::ofstream(file) << "good.x 1.5 lower\n";
    std::size_t asked = 0;
    Options options;
    options.compare = file;
    options.used_by_others = [&] { return one.used.at(asked++); };
    EXPECT_EQ(run({{"good", "", [](Report& report) { report.add(ratio_row("good.x", 2, 1)); }}}, options), one.exit_code);
  }
}

TEST(BenchCompare, ADamagedFileIsRefusedWithItsLine) {
  for (const char* text : {"a.x 1", "a.x lower", "a.x 1 faster", "a.x 0 lower", "a.x 1 lower 2", "a.x 1 lower\na.x 1 lower"})
    EXPECT_THROW((void)parse_stored(text), std::runtime_error) << text;
}

TEST(BenchRun, AFailingSectionKeepsTheOthersAndTheExitCodeTells) {
  const Section good{"good", "", [](Report& report) { report.add(ratio_row("good.x", 2, 1)); }};
  const Section bad{"bad", "", [](Report&) { throw std::runtime_error("no bus"); }};
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder / "stored.txt";
  Options options;
  options.used_by_others = [] { return 0.0; };
  options.store = file;
  EXPECT_EQ(run({bad, good}, options), 1);
  options.store.clear();
  options.compare = file;
  EXPECT_EQ(run({good}, options), 0);
  std::ofstream(file) << "good.x 1.5 lower\n";
  EXPECT_EQ(run({good}, options), 1);
  options.only = {"bad"};
  EXPECT_EQ(run({bad, good}, options), 1);
}

TEST(BenchRun, OptionsAreRefusedInASentence) {
  const std::vector<Section> sections{{"loop", "", nullptr}};
  EXPECT_EQ(parse_options({"--only", "loop", "--compare", "f"}, sections).only, std::vector<std::string>{"loop"});
  EXPECT_THROW((void)parse_options({"--only", "lop"}, sections), std::runtime_error);
  EXPECT_THROW((void)parse_options({"--store"}, sections), std::runtime_error);
  EXPECT_THROW((void)parse_options({"loop"}, sections), std::runtime_error);
}

}  // namespace
}  // namespace hoist::bench
