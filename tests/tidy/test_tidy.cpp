// The house rules on the tree itself, and each rule on small files that break it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "tests/support/shell.hpp"
#include "tests/tidy/rules.hpp"

namespace hoist::tidy {
namespace {

// The files in git; others on the disk (builds, packages) are ignored.
std::vector<File> tracked_files() {
  const std::string top = HOIST_SOURCE_DIR;
  std::vector<File> files;
  std::istringstream stream(test::run_shell("git -C '" + top + "' ls-files -z 2>/dev/null").output);
  for (std::string path; std::getline(stream, path, '\0');) {
    const std::filesystem::path full = std::filesystem::path(top) / path;
    std::error_code error;
    if (!std::filesystem::is_regular_file(full, error)) continue;
    std::ifstream in(full, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    const auto permissions = std::filesystem::status(full, error).permissions();
    files.push_back({path, text.str(), (permissions & std::filesystem::perms::owner_exec) != std::filesystem::perms::none});
  }
  return files;
}

std::vector<std::string> paths_of(const std::vector<File>& files) {
  std::vector<std::string> paths;
  for (const auto& file : files) paths.push_back(file.path);
  std::sort(paths.begin(), paths.end());
  return paths;
}

std::string told(const std::vector<Finding>& findings) {
  std::ostringstream out;
  for (const auto& finding : findings) out << finding.path << ':' << finding.line << ": [" << finding.rule << "] " << finding.what << '\n';
  return out.str();
}

// The rules that a small file breaks.
std::set<std::string> broken_by(const std::string& path, const std::string& text) {
  // In order, as the tree's own list is.
  const std::vector<std::string> paths = {"control/bus/can_port.hpp",
                                          "control/bus/firmware_update.hpp",
                                          "control/contract/params.hpp",
                                          "control/core/estimate/tilt_sensor.hpp",
                                          "control/core/intent/intent.hpp",
                                          "control/core/law/pfp.hpp",
                                          "control/core/modes/mode.hpp",
                                          "control/core/modes/mode_list.hpp",
                                          "control/core/monitor/monitor.hpp",
                                          "control/core/output/bus_master.hpp",
                                          "control/core/serve/commands.hpp",

                                          "control/core/state.hpp",
                                          "control/core/supervise/supervisor.hpp",
                                          "control/core/supervise/transitions.hpp",
                                          "control/core/tick.hpp",
                                          "control/core/types.hpp",
                                          "control/publish/seq_cell.hpp",
                                          "control/run/loop.hpp",
                                          "db/store/store.hpp",
                                          "firmware/lib/node.hpp",
                                          "firmware/sim/plant.hpp",
                                          "server/actions/actions.hpp",
                                          "server/api/router.hpp",
                                          "server/http/listener.hpp",
                                          "server/link/core_desk.hpp",
                                          "server/live/hub.hpp",
                                          "server/services.hpp",
                                          "tests/support/closed_loop.hpp"};
  std::set<std::string> rules;
  for (const auto& finding : check_file({path, text}, paths)) rules.insert(finding.rule);
  return rules;
}
using Rules = std::set<std::string>;

TEST(Tree, KeepsTheHouseRules) {
  const auto files = tracked_files();
  if (files.empty()) GTEST_SKIP() << "this is not a git checkout, so there is no list of files to look at";
  const auto paths = paths_of(files);
  std::vector<Finding> findings = check_tree(files);
  for (const auto& file : files) {
    const auto more = check_file(file, paths);
    findings.insert(findings.end(), more.begin(), more.end());
  }
  EXPECT_TRUE(findings.empty()) << told(findings);
}

TEST(WallClock, H26OnlyDatesForPeopleComeFromIt) {
  const Rules wall_clock = {"wall-clock"};
  EXPECT_EQ(broken_by("control/run/a.cpp", "int f() { return clock_gettime(CLOCK_REALTIME, &t); }\n"), wall_clock);
  EXPECT_EQ(broken_by("control/bus/a.cpp", "auto t = CLOCK_REALTIME_COARSE;\n"), wall_clock);
  EXPECT_EQ(broken_by("server/link/a.cpp", "auto t = std::chrono::system_clock::now();\n"), wall_clock);
  EXPECT_EQ(broken_by("db/store/a.cpp", "gettimeofday(&t, nullptr);\n"), wall_clock);
  EXPECT_EQ(broken_by("firmware/sim/a.cpp", "auto t = ::time(nullptr);\n"), wall_clock);
  EXPECT_EQ(broken_by("firmware/sim/a.cpp", "auto t = time(nullptr);\n"), wall_clock);
  EXPECT_EQ(broken_by("server/a.cpp", "auto t = std::chrono::file_clock::now();\n"), wall_clock);
  for (const std::string sql : {"date('now')", "Current_Timestamp", "unixepoch( )"}) {
    EXPECT_EQ(broken_by("db/store/a.cpp", "run(\"UPDATE a SET t = " + sql + "\");\n"), wall_clock) << sql;
    EXPECT_EQ(broken_by("db/schema/a.sql", "UPDATE a SET t = " + sql + ";\n"), wall_clock) << sql;
  }
  EXPECT_EQ(broken_by("db/schema/a.sql", "SELECT date(utc_ns / 1000000000, 'unixepoch', 'localtime');\n"), Rules{});
  EXPECT_EQ(broken_by("control/run/main.cpp", "auto t = now_ns(CLOCK_REALTIME);\n"), Rules{});
  EXPECT_EQ(broken_by("control/run/a.cpp",
                      "auto t = CLOCK_MONOTONIC; // not CLOCK_REALTIME\nauto u = lead_time(3), v = std::chrono::steady_clock::now();\n"),
            Rules{});
}

TEST(Functions, ALongOneIsFoundInTheCoreAndTheNodes) {
  const auto lines = [](int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += "  if (a) {  // }}}\n    a = \"{\";\n  }\n";
    return text;
  };
  const auto function = [&](int count) { return "int f(int a,\n      int b) const noexcept {\n" + lines(count) + "}\n"; };
  const Rules too_long = {"long-function"};
  EXPECT_EQ(broken_by("control/core/modes/a.cpp", function(20)), too_long);
  EXPECT_EQ(broken_by("firmware/nodes/drive/a.cpp", "class A {\n" + function(20) + "};\n"), too_long);
  EXPECT_EQ(broken_by("control/run/a.cpp", function(19)), Rules{});
  EXPECT_EQ(broken_by("control/core/modes/a.cpp", "namespace a {\n" + function(15) + function(15) + "}\n"), Rules{});
  EXPECT_EQ(broken_by("server/api/a.cpp", function(20)), Rules{});
}

TEST(Layers, EachForbiddenArrowIsFound) {
  const std::string pragma = "#pragma once\n";
  const auto includes = [&](const std::string& target) { return pragma + "#include \"" + target + "\"\n"; };
  const Rules layer = {"layer"};
  EXPECT_EQ(broken_by("control/core/law/a.hpp", includes("control/contract/params.hpp")), layer);
  EXPECT_EQ(broken_by("control/core/law/a.hpp", includes("control/core/types.hpp")), layer);
  EXPECT_EQ(broken_by("control/core/modes/a.hpp", includes("control/bus/can_port.hpp")), layer);
  EXPECT_EQ(broken_by("control/contract/a.hpp", includes("control/core/types.hpp")), layer);
  EXPECT_EQ(broken_by("control/bus/a.hpp", includes("control/publish/seq_cell.hpp")), layer);
  EXPECT_EQ(broken_by("firmware/nodes/tilt/a.hpp", includes("control/core/types.hpp")), layer);
  EXPECT_EQ(broken_by("firmware/sim/plant.hpp", includes("control/core/law/pfp.hpp")), layer);
  EXPECT_EQ(broken_by("server/api/a.cpp", includes("control/core/types.hpp")), layer);
  EXPECT_EQ(broken_by("server/api/a.cpp", includes("control/bus/can_port.hpp")), layer);
  EXPECT_EQ(broken_by("db/store/a.cpp", includes("server/api/router.hpp")), layer);
  // Inside the server: each step of the way back.
  EXPECT_EQ(broken_by("server/stream/a.cpp", includes("server/http/listener.hpp")), layer);
  EXPECT_EQ(broken_by("server/http/a.cpp", includes("server/api/router.hpp")), layer);
  EXPECT_EQ(broken_by("server/http/a.cpp", includes("server/live/hub.hpp")), layer);
  EXPECT_EQ(broken_by("server/http/a.cpp", includes("server/services.hpp")), layer);
  EXPECT_EQ(broken_by("server/ws/a.cpp", includes("server/live/hub.hpp")), layer);
  EXPECT_EQ(broken_by("server/api/a.cpp", includes("server/live/hub.hpp")), layer);
  EXPECT_EQ(broken_by("server/live/a.cpp", includes("server/api/router.hpp")), layer);
  EXPECT_EQ(broken_by("server/actions/a.cpp", includes("server/api/router.hpp")), layer);
  EXPECT_EQ(broken_by("server/actions/a.cpp", includes("server/live/hub.hpp")), layer);
  EXPECT_EQ(broken_by("server/actions/a.cpp", includes("server/http/listener.hpp")), layer);
  EXPECT_EQ(broken_by("server/state/a.cpp", includes("server/actions/actions.hpp")), layer);
  EXPECT_EQ(broken_by("server/link/a.cpp", includes("server/actions/actions.hpp")), layer);
  EXPECT_EQ(broken_by("server/record/a.cpp", includes("server/link/core_desk.hpp")), layer);
  EXPECT_EQ(broken_by("deploy/tools/hoist/a.cpp", includes("control/run/loop.hpp")), layer);
  EXPECT_EQ(broken_by("tests/chaos/judge/a.cpp", includes("control/core/supervise/transitions.hpp")), layer);
  EXPECT_EQ(broken_by("tests/chaos/judge/a.cpp", includes("tests/support/closed_loop.hpp")), layer);
  EXPECT_EQ(broken_by("control/core/law/a.hpp", pragma + "#include <Eigen/Dense>\n"), layer);
  EXPECT_EQ(broken_by("web/src/panels/drive/a.ts", "import { x } from '../../../../control/x';\n"), layer);
}

// One arrow back over each border of the core's rooms, those that were there before the rooms had an order among them.
TEST(Layers, TheRoomsOfTheCoreHaveOneOrder) {
  const auto includes = [](const std::string& target) { return "#pragma once\n#include \"control/core/" + target + "\"\n"; };
  const Rules room = {"room"};
  EXPECT_EQ(broken_by("control/core/base/a.hpp", includes("estimate/tilt_sensor.hpp")), room);
  EXPECT_EQ(broken_by("control/core/estimate/a.hpp", includes("intent/intent.hpp")), room);
  EXPECT_EQ(broken_by("control/core/estimate/a.hpp", includes("output/bus_master.hpp")), room);
  EXPECT_EQ(broken_by("control/core/output/a.hpp", includes("monitor/monitor.hpp")), room);
  EXPECT_EQ(broken_by("control/core/output/a.hpp", includes("modes/mode_list.hpp")), room);
  EXPECT_EQ(broken_by("control/core/command/a.hpp", includes("supervise/supervisor.hpp")), room);
  EXPECT_EQ(broken_by("control/core/calibrate/a.cpp", includes("state.hpp")), room);
  EXPECT_EQ(broken_by("control/core/state.hpp", includes("modes/mode.hpp")), room);
  EXPECT_EQ(broken_by("control/core/modes/a.hpp", includes("supervise/supervisor.hpp")), room);
  EXPECT_EQ(broken_by("control/core/supervise/a.cpp", includes("serve/commands.hpp")), room);
  EXPECT_EQ(broken_by("control/core/serve/a.cpp", includes("tick.hpp")), room);
  EXPECT_EQ(broken_by("control/core/new_room/a.hpp", "#pragma once\n"), room);
  EXPECT_EQ(broken_by("control/core/modes/a.hpp", includes("state.hpp")), Rules{});
  EXPECT_EQ(broken_by("control/core/modes/a.hpp", includes("modes/mode.hpp")), Rules{});
  EXPECT_EQ(broken_by("control/core/tick.cpp", includes("serve/commands.hpp")), Rules{});
}

TEST(Layers, EachAllowedArrowIsLeftAlone) {
  const auto includes = [](const std::string& target) { return "#pragma once\n#include \"" + target + "\"\n"; };
  EXPECT_EQ(broken_by("control/core/law/a.hpp", "#pragma once\n#include <cmath>\n#include \"control/core/law/pfp.hpp\"\n"), Rules{});
  EXPECT_EQ(broken_by("control/core/modes/a.hpp", includes("control/core/law/pfp.hpp")), Rules{});
  EXPECT_EQ(broken_by("firmware/nodes/tilt/a.hpp", includes("control/core/law/pfp.hpp")), Rules{});
  EXPECT_EQ(broken_by("server/api/a.cpp", includes("control/publish/seq_cell.hpp")), Rules{});
  EXPECT_EQ(broken_by("server/api/a.cpp", includes("db/store/store.hpp")), Rules{});
  EXPECT_EQ(broken_by("server/api/a.cpp", includes("server/actions/actions.hpp")), Rules{});
  EXPECT_EQ(broken_by("server/live/a.cpp", includes("server/actions/actions.hpp")), Rules{});
  EXPECT_EQ(broken_by("server/link/a.cpp", includes("control/bus/firmware_update.hpp")), Rules{});
  EXPECT_EQ(broken_by("tests/loop/a.cpp", includes("firmware/sim/plant.hpp")), Rules{});
  EXPECT_EQ(broken_by("web/src/panels/drive/a.ts", "import { x } from '../../link/socket';\n"), Rules{});
  // An include inside a comment is no include.
  EXPECT_EQ(broken_by("control/core/law/a.hpp", "#pragma once\n// #include \"server/api/router.hpp\"\n"), Rules{});
}

TEST(Includes, AreWrittenFromTheTopAndExist) {
  EXPECT_EQ(broken_by("server/api/a.cpp", "#include \"router.hpp\"\n"), Rules{"include-from-top"});
  EXPECT_EQ(broken_by("server/api/a.cpp", "#include \"../http/router.hpp\"\n"), Rules{"include-from-top"});
  EXPECT_EQ(broken_by("server/api/a.cpp", "#include \"server/http/gone.hpp\"\n"), Rules{"include-exists"});
  EXPECT_EQ(broken_by("server/api/a.hpp", "int a;\n"), Rules{"pragma-once"});
}

class PureWords : public testing::TestWithParam<const char*> {};
TEST_P(PureWords, AreFoundInCoreAndFirmwareOnly) {
  const std::string text = std::string("#pragma once\n") + GetParam() + "\n";
  EXPECT_EQ(broken_by("control/core/intent/a.hpp", text).count("pure"), 1U);
  EXPECT_EQ(broken_by("firmware/lib/a.hpp", text).count("pure"), 1U);
  EXPECT_EQ(broken_by("server/api/a.hpp", text).count("pure"), 0U);
  // The same word in a comment or a message is allowed.
  EXPECT_EQ(broken_by("control/core/intent/a.hpp", std::string("#pragma once\n// ") + GetParam() + "\n"), Rules{});
}
INSTANTIATE_TEST_SUITE_P(Each, PureWords,
                         testing::Values("int* p = new int;", "delete p;", "void* p = malloc(4);", "std::vector<int> v;", "std::string s;",
                                         "throw 1;", "auto t = std::chrono::steady_clock::now();", "std::cout << 1;", "std::mutex m;",
                                         "int r = rand();", "std::function<void()> f;"));

TEST(Pure, WhatOnlyLooksForbiddenIsLeftAlone) {
  EXPECT_EQ(broken_by("control/core/base/a.hpp",
                      "#pragma once\nA(const A&) = delete;\nstd::string_view renew;\nconst char* s = \"throw new\";\n"),
            Rules{});
}

TEST(Words, UnfinishedWorkMachinePathsAndRegistriesAreFound) {
  EXPECT_EQ(broken_by("server/api/a.cpp", std::string("// TO") + "DO later\n"), Rules{"unfinished"});
  EXPECT_EQ(broken_by("server/README.md", std::string("see /wo") + "rk/x\n"), Rules{"machine-path"});
  EXPECT_EQ(broken_by("web/package-lock.json", std::string("\"https://registry.np") + "mjs.org/a\"\n"), Rules{"registry-host"});
  EXPECT_EQ(broken_by("server/README.md", "a/work/b is a path of ours, and todo is a word\n"), Rules{});
  EXPECT_EQ(broken_by("server/README.md", std::string(7, '<') + " HEAD\n"), Rules{"conflict"});
}

TEST(TestHabits, SleepsEmptySkipsAndEmptyAssertionsAreFound) {
  EXPECT_EQ(broken_by("tests/unit/a.cpp", "std::this_thread::sleep_for(1s);\n"), Rules{"sleep"});
  EXPECT_EQ(broken_by("tests/unit/a.cpp", "GTEST_SKIP();\n"), Rules{"skip-reason"});
  EXPECT_EQ(broken_by("tests/unit/a.cpp", "EXPECT_TRUE(true);\n"), Rules{"empty-assertion"});
  EXPECT_EQ(broken_by("tests/unit/a.cpp", "GTEST_SKIP() << \"no CAN here\";\nEXPECT_TRUE(true_north);\nEXPECT_EQ(1, 12);\n"), Rules{});
}

TEST(Generated, NamesTheCommandThatMakesIt) {
  EXPECT_EQ(broken_by("control/contract/params.gen.md", "# Parameters\n"), Rules{"generated"});
  EXPECT_EQ(broken_by("control/contract/params.gen.md", "<!-- made by deploy/dev gen -->\n"), Rules{});
}

TEST(TreeRules, ExtrasGapsAndDeadSourcesAreFound) {
  const auto rules_of = [](const std::vector<File>& files) {
    std::set<std::string> rules;
    for (const auto& finding : check_tree(files)) rules.insert(finding.rule);
    return rules;
  };
  const std::vector<File> good = {
      {"README.md", ""}, {"LICENSE", ""}, {"deploy/dev", "", true}, {"deploy/README.md", ""}, {".ci/run", "", true}};
  const auto with = [&](const File& more) {
    auto files = good;
    files.push_back(more);
    return files;
  };
  EXPECT_EQ(rules_of(good), Rules{});
  EXPECT_EQ(rules_of(with({"notes.txt", ""})), Rules{"top-level"});
  EXPECT_EQ(rules_of(with({"db/x.sql", ""})), Rules{"readme"});
  EXPECT_EQ(rules_of(with({"deploy/tools/a.cpp", ""})), Rules{"dead-source"});
  EXPECT_EQ(rules_of(with({"deploy/golden.csv", std::string((2U << 20U) + 1, 'x')})), Rules{"size"});
  auto no_bit = good;
  no_bit[2].runnable = false;
  EXPECT_EQ(rules_of(no_bit), Rules{"run-bit"});
}

TEST(TreeRules, CirclesAreFound) {
  using Circles = std::set<std::string>;
  const auto circles = [](const std::vector<File>& files) {
    Circles told;
    for (const auto& finding : check_circles(files)) told.insert(finding.path + ' ' + finding.what);
    return told;
  };
  const auto arrow = [](const char* from, const char* to) { return File{from, std::string("#include \"") + to + "\"\n"}; };
  EXPECT_EQ(circles({arrow("db/a/x.hpp", "db/a/y.hpp"), arrow("db/a/y.cpp", "db/a/x.hpp"), {"db/a/y.hpp", ""}}),
            Circles{"db/a/ x -> y -> x"});
  EXPECT_EQ(circles({arrow("db/a/x.hpp", "db/b/y.hpp"), arrow("db/b/z.cpp", "db/a/w.hpp"), {"db/b/y.hpp", ""}, {"db/a/w.hpp", ""}}),
            Circles{"db/ a/ -> b/ -> a/"});
  EXPECT_EQ(circles({{"web/src/a/x.ts", "import { y } from '../b/y';\n"}, {"web/src/b/y.tsx", "import type { x } from '../a/x';\n"}}),
            Circles{"web/src/ a/ -> b/ -> a/"});
  EXPECT_EQ(circles({arrow("db/a/x.hpp", "db/a/y.hpp"), arrow("db/a/x.cpp", "db/a/x.hpp"), {"db/a/y.hpp", "// #include \"db/a/x.hpp\"\n"}}),
            Circles{});
  EXPECT_EQ(circles({arrow("db/a.cpp", "db/a/x.hpp"), {"db/a/x.hpp", ""}}), Circles{});  // a file with the name of its folder
}

}  // namespace
}  // namespace hoist::tidy
