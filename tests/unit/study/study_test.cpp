// The study: its protocol, its virtual subjects, and what must come out of them.
#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "db/store/session_reader.hpp"
#include "deploy/tools/hoist/study/drawings.hpp"
#include "deploy/tools/hoist/study/protocol.hpp"
#include "deploy/tools/hoist/study/record_runs.hpp"
#include "deploy/tools/hoist/study/results.hpp"
#include "deploy/tools/hoist/study/tables.hpp"
#include "tests/support/seeds.hpp"
#include "tests/support/shell.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::tool::study {
namespace {

using nlohmann::json;
using test::TemporaryFolder;

Protocol paper() {
  std::string problem;
  const auto protocol = read_protocol(paper_protocol(), problem);
  EXPECT_TRUE(protocol) << problem;
  return protocol.value_or(Protocol{});
}

TEST(Protocol, ThePapersHasItsSixRunsAndElevenSubjects) {
  const Protocol protocol = paper();
  ASSERT_EQ(protocol.runs.size(), 6U);
  int subjects = 0;
  for (int subject = 1; subject <= 11; ++subject) subjects += protocol.has(subject, 4) ? 1 : 0;
  EXPECT_EQ(subjects, 7) << "four refused the orthosis";
  EXPECT_TRUE(protocol.find(3)->by_patient && protocol.find(6)->by_patient && !protocol.find(2)->by_patient);
  EXPECT_EQ(protocol.find(1)->shape, contract::ExerciseShape::square);
}

TEST(Protocol, WhatIsNoneIsRefusedByItsField) {
  const auto problem_with = [](const char* pointer, const json& value) {
    json text = json::parse(paper_protocol());
    text[json::json_pointer(pointer)] = value;
    std::string problem;
    EXPECT_FALSE(read_protocol(text.dump(), problem)) << pointer;
    return problem;
  };
  EXPECT_EQ(problem_with("/preset", "fast"), "preset: must be walk or paper");
  EXPECT_EQ(problem_with("/laps", 0), "laps: must be a number from 1.0 to 10.0");
  EXPECT_EQ(problem_with("/runs/2/shape", "circle"), "runs[2].shape: must be square or eight");
  EXPECT_EQ(problem_with("/runs/2/run", 1), "runs: name a run twice");
  EXPECT_EQ(problem_with("/compared/0/1", 9), "compared: names no run of the protocol");
  EXPECT_EQ(problem_with("/assumed/wish_m_s", json::array({0.3, 0.2})), "assumed.wish_m_s: must rise");
  EXPECT_EQ(problem_with("/assumed/therapist_delay_s", 3), "assumed.therapist_delay_s: must be a number from 0.0 to 0.6");
  std::string problem;
  EXPECT_FALSE(read_protocol("{", problem));
  EXPECT_FALSE(read_protocol("{}", problem));
  EXPECT_EQ(problem, "title: is missing");
}

double mean(const Results& results, std::string_view figure, int run) { return mean_of(results.column(figure, run)).value_or(-99); }

// Not tuned: bounds of the issue, and of Tables II and III.
TEST(Study, TheResultOfThePaperComesOut) {
  for (const char* preset : {"walk", "paper"}) {
    SCOPED_TRACE(preset);
    TemporaryFolder folder;
    db::Database database = std::move(*db::Database::open(folder / "study.db"));
    Protocol protocol = paper();
    protocol.preset = preset;
    protocol.excluded.clear();
    const int subjects = tests::thorough() ? 11 : 2;
    const auto study = walk_all(database, protocol, {.subjects = subjects, .seed = 1});
    ASSERT_TRUE(study.ok());
    const auto results = evaluate(database, protocol, {.study = *study});
    ASSERT_TRUE(results.ok());
    for (const LeftOut& one : results->left_out) ADD_FAILURE() << "every run is walked to its end: " << sentence(one);
    EXPECT_EQ(results->subjects.size(), static_cast<std::size_t>(subjects));
    for (const int square : {1, 4}) EXPECT_LT(std::fabs(mean(*results, "C", square)), 0.2);
    for (const int led : {3, 6}) EXPECT_GE(mean(*results, "C", led), 0.8);
    EXPECT_LE(mean(*results, "J_N", 3), 15.0);
    EXPECT_GT(mean(*results, "J_N", 1), 2 * mean(*results, "J_N", 2));
    EXPECT_GT(mean(*results, "C", 3), mean(*results, "C", 2));
    const auto drawn = tracks_drawing(database, protocol, *results);
    ASSERT_TRUE(drawn.ok());
    EXPECT_GT(drawn->size(), 10'000U);
  }
}

// A follower who does not look ahead trails behind the hoist; one who does turns with the path.
TEST(Study, AFollowerTurnsAsFarAsAnticipated) {
  const auto c_of = [](double anticipation_norm) {
    TemporaryFolder folder;
    db::Database database = std::move(*db::Database::open(folder / "study.db"));
    Protocol protocol = paper();
    protocol.runs = {protocol.runs[1]};
    protocol.compared.clear();
    protocol.assumed.anticipation_norm = {anticipation_norm, anticipation_norm};
    const auto study = walk_all(database, protocol, {.subjects = 1, .seed = 3});
    EXPECT_TRUE(study.ok());
    const auto results = evaluate(database, protocol, {.study = *study});
    return results.ok() ? mean(*results, "C", 2) : -99;
  };
  const double none = c_of(0), some = c_of(0.5), all = c_of(1);
  EXPECT_LT(none, -0.3);
  EXPECT_LT(none, some);
  EXPECT_LT(some, all);
  EXPECT_GT(all, 0.6);
}

std::string run(const std::string& command, int expected) {
  const test::ShellResult result = test::run_shell(command);
  EXPECT_EQ(result.exit_code, expected) << command << "\n" << result.output;
  return result.output;
}
std::string tables_in(const std::string& text) {
  const std::size_t begin = text.find("Table II:"), end = text.find("Put in by assumption");
  EXPECT_NE(begin, std::string::npos) << text;
  return text.substr(begin, end == std::string::npos ? end : end - begin);
}

TEST(Study, TheSameSeedGivesTheSameTablesAndSoDoTheRecordings) {
  TemporaryFolder folder;
  const std::string tool = std::string(HOIST_BINARY_DIR) + "/bin/hoist study ", kept = (folder / "kept.db").string();
  const std::string first = run(tool + "--subjects 1 --seed 5 --out " + kept + " --figures " + (folder / "svg").string() + " --json " +
                                    (folder / "study.json").string(),
                                0);
  EXPECT_EQ(first.substr(0, first.find("Drawn")), run(tool + "--subjects 1 --seed 5", 0));
  EXPECT_EQ(tables_in(first.substr(0, first.find("Put in"))), tables_in(run(tool + "--recorded " + kept + " --study 1", 0)));
  EXPECT_NE(tables_in(first), tables_in(run(tool + "--subjects 1 --seed 6", 0)));
  EXPECT_NE(first.find("0.95"), std::string::npos) << "the paper's table stands beside";
  for (const char* name : {"figure-2.svg", "figure-7.svg", "figure-8.svg"})
    EXPECT_GT(std::filesystem::file_size(folder / "svg" / name), 1000U);
  run(tool + "--recorded " + kept + " 2>&1", 1);
  run(tool + "--recorded " + kept + " --study 2 2>&1", 1);
  run(tool + "--recorded " + kept + " --subjects 1 2>&1", 2);
  run(tool + "--recorded " + kept + " --study 1 --tag x 2>&1", 2);
  run(tool + "--subjects 1 --tag x 2>&1", 2);
  run(tool + "--subjects 100 2>&1", 2);
  run(tool + "--subjects 1 --out " + kept + " 2>&1", 2);
}

// The console shows the JSON, the command line prints the text: both are of the same numbers.
TEST(Study, TheJsonHasTheDigitsThatArePrinted) {
  TemporaryFolder folder;
  const std::string file = (folder / "study.json").string();
  const std::string printed = run(std::string(HOIST_BINARY_DIR) + "/bin/hoist study --subjects 1 --seed 5 --progress 1 --json " + file, 0);
  EXPECT_NE(printed.find("progress 1 3\nprogress 2 3\nprogress 3 3\n"), std::string::npos) << "subject 1 has no runs 4 to 6";
  std::ifstream in(file);
  const json told = json::parse(in);
  EXPECT_EQ(told["seed"], 5);
  for (const json& table : told["tables"]) {
    std::array<char, 64> row{};
    const auto at = [&](int run) { return table["own"][run][0].get<double>(); };
    std::snprintf(row.data(), row.size(), "S01       %7.2f%7.2f%7.2f", at(0), at(1), at(2));
    EXPECT_NE(printed.find(row.data()), std::string::npos) << row.data();
    std::snprintf(row.data(), row.size(), "mean      %7.2f", table["own_mean"][0].get<double>());
    EXPECT_NE(printed.find(row.data()), std::string::npos) << row.data();
    EXPECT_TRUE(table["own"][3][0].is_null());
    EXPECT_EQ(table["paper"][0].size(), 11U);
  }
}

// Sessions of people count by code and note; those of virtual subjects only as their study.
TEST(Study, RecordedSessionsAreChosenByTag) {
  TemporaryFolder folder;
  db::Database database = std::move(*db::Database::open(folder / "study.db"));
  Protocol protocol = paper();
  protocol.runs = {protocol.runs[1], protocol.runs[2]};
  protocol.compared.clear();
  protocol.excluded.clear();
  const auto study = walk_all(database, protocol, {.subjects = 1, .seed = 3});
  ASSERT_TRUE(study.ok());
  EXPECT_TRUE(evaluate(database, protocol)->subjects.empty());
  db::SessionEditor editor(database);
  const auto give = [&](db::SessionId session, const char* code, const char* note) {
    ASSERT_TRUE(editor.patch(session, {.note = note, .subject = std::optional<std::string>(code), .exercise_json = {}}).ok());
  };
  ASSERT_TRUE(db::remove_study(database, *study).ok());
  give(1, "K-01", "run 2 spring");
  give(2, "K-01", "run 3 springtime");
  const auto all = evaluate(database, protocol), spring = evaluate(database, protocol, {.tag = "spring"});
  ASSERT_TRUE(all.ok() && spring.ok());
  EXPECT_EQ(all->runs.size(), 2U);
  ASSERT_EQ(spring->runs.size(), 1U) << "a tag is a whole word";
  EXPECT_EQ(spring->runs.begin()->second, 1);
  EXPECT_EQ(spring->subjects, std::vector<std::string>{"K-01"});
  const auto second = evaluate(database, protocol, {.only = {2, 7}});
  ASSERT_TRUE(second.ok());
  ASSERT_EQ(second->runs.size(), 1U);
  EXPECT_EQ(second->runs.begin()->second, 2);
}

}  // namespace
}  // namespace hoist::tool::study
