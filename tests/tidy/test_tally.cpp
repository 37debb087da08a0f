// The count that decides whether a change lands: deploy/lib/tally.mjs on small reports of every kind of ending.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/shell.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::tidy {
namespace {

struct Outcome : test::ShellResult {
  std::string last_line() const {
    const auto end = output.find_last_not_of('\n');
    const auto begin = output.rfind('\n', end);
    return output.substr(begin + 1, end - begin);
  }
};

class Tally : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("node --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "no Node on this machine";
    std::filesystem::create_directories(folder_ / "gtest");
    write("steps.tsv", "");
  }
  void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }
  void write_ctest(const std::string& rows) { write("ctest.xml", "<testsuite name=\"x\">" + rows + "</testsuite>"); }
  void write_program(const std::string& name, const std::string& rows) {
    write("gtest/" + name + ".xml", "<testsuites><testsuite>" + rows + "</testsuite></testsuites>");
  }
  Outcome count() const {
    return {test::run_shell(std::string("node '") + HOIST_SOURCE_DIR + "/deploy/lib/tally.mjs' '" + folder_.path().string() + "' 2>&1")};
  }
  test::TemporaryFolder folder_;
};

const std::string kPassed = R"(<testcase name="a" status="run" result="completed" classname="S" />)";

TEST_F(Tally, PassedCasesAreCountedNotPrograms) {
  write_ctest(R"(<testcase name="test_x" status="run"></testcase>)");
  write_program("test_x", kPassed + kPassed + kPassed);
  const auto outcome = count();
  EXPECT_EQ(outcome.last_line(), "3 passed, 0 failed, 0 skipped");
  EXPECT_EQ(outcome.exit_code, 0);
}

// GoogleTest never overwrites a report: a program that another test runs or lists leaves NAME_1.xml beside NAME.xml.
TEST_F(Tally, ACaseIsCountedOnceHoweverManyReportsTellIt) {
  const auto row = [](const std::string& name, const std::string& rest) {
    return "<testcase name=\"" + name + "\" " + rest + " classname=\"S\" ";
  };
  const std::string listed = "file=\"f.cpp\" line=\"3\"", ran = "status=\"run\" result=\"completed\"";
  write_ctest(R"(<testcase name="test_x" status="run"></testcase>)");
  write_program("test_x", row("a", listed) + "/>" + row("b", listed) + "/>");
  write_program("test_x_1", row("a", ran) + "/>" + row("b", ran) + "/>");
  write_program("test_x_2", row("a", ran) + "/>");
  EXPECT_EQ(count().last_line(), "2 passed, 0 failed, 0 skipped");
  EXPECT_EQ(count().exit_code, 0);
  // A failure in any of them counts, once, and a program that was only listed has not run.
  write_ctest(R"(<testcase name="test_x" status="fail"><failure message=""/></testcase>)");
  write_program("test_x_1", row("a", ran) + "/>" + row("b", ran) + "><failure message=\"no\"/></testcase>");
  write_program("test_x_3", row("b", ran) + "/>");
  EXPECT_EQ(count().last_line(), "1 passed, 1 failed, 0 skipped");
  EXPECT_EQ(count().exit_code, 1);
  write_ctest(R"(<testcase name="test_y" status="fail"><failure message=""/></testcase>)");
  for (const char* name : {"gtest/test_x.xml", "gtest/test_x_1.xml", "gtest/test_x_2.xml", "gtest/test_x_3.xml"})
    std::filesystem::remove(folder_ / name);
  write_program("test_y", row("a", listed) + "/>");
  const auto not_run = count();
  EXPECT_EQ(not_run.last_line(), "0 passed, 1 failed, 0 skipped");
  EXPECT_NE(not_run.output.find("test_y: ended without a report"), std::string::npos);
}

// A program run in parts, each with a report.
TEST_F(Tally, APartThatCrashesIsAFailureAlsoWhenTheOthersPass) {
  write_ctest(R"(<testcase name="test_x" status="run"></testcase><testcase name="test_x_1" status="run"></testcase>)");
  const std::string other = R"(<testcase name="b" status="run" result="completed" classname="S" />)";
  write_program("test_x", kPassed);
  write_program("test_x_1", other);
  EXPECT_EQ(count().last_line(), "2 passed, 0 failed, 0 skipped");
  std::filesystem::remove(folder_ / "gtest/test_x_1.xml");
  for (const char* status : {R"("fail")", R"("notrun")"}) {
    write_ctest(std::string(R"(<testcase name="test_x" status="run"></testcase><testcase name="test_x_1" status=)") + status +
                "></testcase>");
    EXPECT_EQ(count().last_line(), "1 passed, 1 failed, 0 skipped") << status;
    EXPECT_NE(count().output.find("test_x_1: "), std::string::npos) << status;
  }
}

TEST_F(Tally, NothingRunIsAFailure) {
  const auto outcome = count();
  EXPECT_EQ(outcome.last_line(), "0 passed, 0 failed, 0 skipped");
  EXPECT_EQ(outcome.exit_code, 1);
}

TEST_F(Tally, AFailedCaseIsNamedAndFails) {
  write_ctest(R"(<testcase name="test_x" status="fail"><failure message=""/></testcase>)");
  // What the test said may look like the end of the case or like another one.
  write_program(
      "test_x",
      kPassed +
          R"(<testcase name="b" status="run" result="completed" classname="S"><failure message="1 &lt; 2"><![CDATA[</testcase><testcase name="no"/>]]></failure></testcase>)");
  const auto outcome = count();
  EXPECT_EQ(outcome.last_line(), "1 passed, 1 failed, 0 skipped");
  EXPECT_NE(outcome.output.find("test_x: S.b"), std::string::npos);
  EXPECT_EQ(outcome.exit_code, 1);
}

TEST_F(Tally, ACrashedProgramIsAFailure) {
  write_ctest(R"(<testcase name="test_x" status="fail"><failure message=""/></testcase><testcase name="test_y" status="run"></testcase>)");
  write_program("test_y", kPassed);
  EXPECT_EQ(count().last_line(), "1 passed, 1 failed, 0 skipped");
  EXPECT_EQ(count().exit_code, 1);
}

TEST_F(Tally, AProgramThatEndsBadlyAfterItsCasesIsAFailure) {
  write_ctest(R"(<testcase name="test_x" status="fail"><failure message=""/></testcase>)");
  write_program("test_x", kPassed);
  EXPECT_EQ(count().last_line(), "1 passed, 1 failed, 0 skipped");
}

TEST_F(Tally, AProgramThatWasNeverBuiltIsAFailure) {
  write_ctest(R"(<testcase name="test_x" status="notrun"><skipped message="Unable to find executable"/></testcase>)");
  EXPECT_EQ(count().last_line(), "0 passed, 1 failed, 0 skipped");
}

TEST_F(Tally, AProgramThatSkipsItselfPrintsTheReason) {
  write_program("test_x", kPassed);
  write_ctest(
      R"(<testcase name="test_x" status="run"></testcase><testcase name="model" status="notrun"><skipped message="SKIP_RETURN_CODE=77"/>)"
      R"(<system-out>skipped: no spin &amp; no gcc
</system-out></testcase>)");
  const auto told = count();
  EXPECT_EQ(told.last_line(), "1 passed, 0 failed, 1 skipped");
  EXPECT_NE(told.output.find("model: no spin & no gcc"), std::string::npos);
}

TEST_F(Tally, ASkipNeedsAReason) {
  write_ctest(R"(<testcase name="test_x" status="run"></testcase>)");
  write_program(
      "test_x",
      kPassed +
          R"(<testcase name="b" status="run" result="skipped" classname="S"><skipped message="f.cpp:2&#x0A;no CAN &amp; no root"></skipped></testcase>)");
  const auto told = count();
  EXPECT_EQ(told.last_line(), "1 passed, 0 failed, 1 skipped");
  EXPECT_NE(told.output.find("S.b: no CAN & no root"), std::string::npos);
  EXPECT_EQ(told.exit_code, 0);
  write_program(
      "test_x",
      kPassed + R"(<testcase name="b" status="run" result="skipped" classname="S"><skipped message="f.cpp:2&#x0A;"></skipped></testcase>)");
  EXPECT_EQ(count().last_line(), "1 passed, 1 failed, 0 skipped");
  // Also of the browser tests, of a static check, and of a program that skips itself.
  write_program("test_x", kPassed);
  write_ctest(
      R"(<testcase name="test_x" status="run"></testcase><testcase name="model" status="notrun"><skipped message="SKIP_RETURN_CODE=77"/></testcase>)");
  write("e2e.json", R"({"tests":[{"name":"drives","status":"skipped"}]})");
  write("steps.tsv", "skipped\tlint\t\n");
  EXPECT_EQ(count().last_line(), "1 passed, 3 failed, 0 skipped");
}

TEST_F(Tally, ConsoleBrowserAndStaticChecksCountToo) {
  write("vitest.json", R"({"testResults":[
    {"name":"/x/web/test/a.test.ts","status":"failed","assertionResults":[{"status":"passed","fullName":"a"},{"status":"failed","fullName":"b"},{"status":"pending","fullName":"c"}]},
    {"name":"/x/web/test/broken.test.ts","status":"failed","message":"cannot be loaded","assertionResults":[]}]})");
  write("e2e.json", R"({"tests":[{"name":"opens","status":"passed"},{"name":"drives","status":"skipped","reason":"no chromium"}]})");
  write("steps.tsv", "passed\tformat\t\nfailed\tshell\tsee above\nskipped\tlint\tnot installed\n");
  const auto outcome = count();
  EXPECT_EQ(outcome.last_line(), "3 passed, 3 failed, 3 skipped");
  EXPECT_NE(outcome.output.find("lint: not installed"), std::string::npos);
  EXPECT_EQ(outcome.exit_code, 1);
}

// vitest tells the cases behind a failed beforeAll as skipped.
TEST_F(Tally, AConsoleSuiteThatFailsOutsideItsCasesIsAFailure) {
  write("vitest.json", R"({"testResults":[
    {"name":"/x/web/test/a.test.ts","status":"passed","message":"","assertionResults":[{"status":"passed","fullName":"a"}]},
    {"name":"/x/web/test/b.test.ts","status":"failed","message":"","assertionResults":[{"status":"skipped","fullName":"b"}]}]})");
  const auto outcome = count();
  EXPECT_EQ(outcome.last_line(), "1 passed, 1 failed, 1 skipped");
  EXPECT_NE(outcome.output.find("web: test/b.test.ts: failed outside its cases"), std::string::npos);
  EXPECT_EQ(outcome.exit_code, 1);
}

// The functions that run the suites (deploy/lib/tests.sh), with functions of the shell in place of ctest, npm and the browser tests.
class Suites : public Tally {
 protected:
  void SetUp() override {
    Tally::SetUp();
    std::filesystem::create_directories(folder_ / "deploy/lib");
    std::filesystem::create_directories(folder_ / "web/node_modules");
    write("web/package.json", "{}");
    for (const char* name : {"common.sh", "setup.sh", "tests.sh", "lint.sh", "tally.mjs"})
      std::filesystem::copy(std::filesystem::path(HOIST_SOURCE_DIR) / "deploy/lib" / name, folder_ / "deploy/lib" / name);
  }
  // With `set -e`, as deploy/dev has it.
  Outcome run(const std::string& script) {
    write("steps.tsv", "passed\tformat\t\n");
    write("script.sh",
          "set -euo pipefail\nsource deploy/lib/common.sh\nsource deploy/lib/tests.sh\nresults=$PWD\n" + script + "\ntally $PWD\n");
    return {test::run_shell("cd '" + folder_.path().string() + "' && bash script.sh 2>&1")};
  }
};

TEST_F(Suites, CtestWithoutAWholeReportIsAFailure) {
  const std::string whole = R"(<testsuite><testcase name="model" status="run"></testcase>)"
                            "\n</testsuite>\n";
  struct {
    const char* report;
    int status;
    const char* tally;
  } const cases[] = {
      {whole.c_str(), 0, "2 passed, 0 failed, 0 skipped"},
      {"<testsuite name=\"(empty)\"\n\ttests=\"0\"\n\ttimestamp=\"now\"/>\n", 0, "1 passed, 0 failed, 0 skipped"},
      {whole.c_str(), 137, "2 passed, 1 failed, 0 skipped"},
      {nullptr, 8, "1 passed, 1 failed, 0 skipped"},
      {"", 8, "1 passed, 1 failed, 0 skipped"},
      {R"(<testsuite><testcase name="model" status="run"></testcase><testcase name="la)", 8, "2 passed, 1 failed, 0 skipped"},
  };
  for (const auto& one : cases) {
    std::filesystem::remove(folder_ / "ctest.xml");
    if (one.report != nullptr) write("ctest.xml", one.report);
    const Outcome outcome = run("ends() { return " + std::to_string(one.status) + "; }\nrun_ctest build $results . ends");
    EXPECT_EQ(outcome.last_line(), one.tally) << outcome.output;
  }
}

TEST_F(Suites, AProgramThatFailsThoughItsReportNamesNoFailureIsAFailure) {
  const std::string ended = "have_node() { true; }\nnpm() { return 1; }\nrun_web_tests $results .";
  write("vitest.json", R"({"testResults":[{"name":"/x/web/test/a.test.ts","status":"passed","assertionResults":[
    {"status":"passed","fullName":"says \"status\":\"failed\""}]}]})");
  EXPECT_EQ(run(ended).last_line(), "2 passed, 1 failed, 0 skipped") << run(ended).output;
  // A failed case that is named counts once.
  write("vitest.json",
        R"({"testResults":[{"name":"/x/web/test/a.test.ts","status":"failed","assertionResults":[{"status":"failed","fullName":"a"}]}]})");
  EXPECT_EQ(run(ended).last_line(), "1 passed, 1 failed, 0 skipped");
  std::filesystem::remove(folder_ / "vitest.json");
  EXPECT_EQ(run(ended).last_line(), "1 passed, 1 failed, 0 skipped");
}

TEST_F(Suites, UnitTestsOfTheConsoleRunAtAnyPriorityAndTheirEndCounts) {
  const std::string beside = "real_time_over() { true; }\nrun_browser_tests() { true; }\nrenice() { return 1; }\n";
  EXPECT_EQ(run(beside + "run_web_tests() { record_step $1 passed web; }\nrun_console_suites $results .").last_line(),
            "2 passed, 0 failed, 0 skipped");
  EXPECT_EQ(run(beside + "run_web_tests() { return 1; }\nrun_console_suites $results .").last_line(), "1 passed, 1 failed, 0 skipped");
}

// clang-tidy gives up the other findings of a source that clang cannot compile.
TEST_F(Suites, ASourceThatClangCannotReadIsAFinding) {
  const std::string script =
      "source deploy/lib/lint.sh\nclang-tidy() { echo \"x.cpp:1:1: error: no answer [clang-diagnostic-error]\"; return 1; }\n"
      "tidy_one . x.cpp || record_step $results failed clang-tidy";
  const Outcome outcome = run(script);
  EXPECT_EQ(outcome.last_line(), "1 passed, 1 failed, 0 skipped");
  EXPECT_NE(outcome.output.find("no answer"), std::string::npos) << outcome.output;
}

}  // namespace
}  // namespace hoist::tidy
