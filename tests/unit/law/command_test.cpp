// `hoist laws` as the built program, as in an external check.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "deploy/tools/hoist/laws/law_list.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/law/golden.hpp"

namespace hoist::test {
namespace {

using nlohmann::json;

struct Outcome {
  int exit_code{};
  std::vector<std::string> lines;
  std::string text;
};

/// Runs the program through the shell with files for input and output, so that no pipe can fill up.
Outcome run(const std::string& arguments, const std::string& input) {
  const test::TemporaryFolder folder;
  std::ofstream(folder / "in", std::ios::binary) << input;
  const std::string command = "'" HOIST_PROGRAM "' " + arguments + " < '" + (folder / "in").string() + "' > '" + (folder / "out").string() +
                              "' 2> '" + (folder / "err").string() + "'";
  const int status = std::system(command.c_str());
  Outcome outcome;
  outcome.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  std::ifstream out(folder / "out");
  std::string line;
  while (std::getline(out, line)) outcome.lines.push_back(line);
  for (const auto* file : {"out", "err"}) {
    std::ifstream stream(folder / file);
    outcome.text += (std::ostringstream() << stream.rdbuf()).str();
  }
  return outcome;
}

TEST(HoistLaws, AnswersEveryGoldenCaseInOrder) {
  for (const auto& file : golden_files()) {
    if (!is_law(file)) continue;
    SCOPED_TRACE(file.function);
    std::string input;
    for (const auto& golden : file.cases) input += line_of(golden).dump() + "\n";
    const Outcome outcome = run("laws " + file.function, input);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.text;
    ASSERT_EQ(outcome.lines.size(), file.cases.size());
    for (std::size_t i = 0; i < file.cases.size(); ++i) {
      const json printed = json::parse(outcome.lines[i]);
      EXPECT_EQ(difference(printed, file.cases[i].at("out"), file.abs_tol, file.rel_tol), "") << file.cases[i].at("id");
      // Printed so that every double survives the round trip: bit for bit what was computed.
      EXPECT_EQ(printed, tool::compute_law(*tool::find_law(file.function), line_of(file.cases[i]), json::object()));
    }
  }
}

TEST(HoistLaws, RefusesALineByFieldAndGoesOn) {
  const std::string good = R"({"u":0.5,"v":0,"vf":0})";
  const std::vector<std::pair<std::string, std::string>> bad = {
      {R"({"v":0,"vf":0})", "u: missing"},
      {R"({"u":null,"v":0,"vf":0})", "u: null"},
      {R"({"u":"0.5","v":0,"vf":0})", "u: is string"},
      {R"({"u":true,"v":0,"vf":0})", "u: is boolean"},
      {R"({"u":1.0000001,"v":0,"vf":0})", "u: 1.0000001, must be within [-1.0, 1.0]"},
      {R"({"u":"inf","v":0,"vf":0})", "u: inf"},
      {R"({"u":0.5,"v":"-inf","vf":0})", "v: -inf"},
      {R"({"u":0.5,"v":0,"vf":0,"wf":1})", "wf: unknown"},
      {R"({"u":0.5,"v":0,"vf":0,"params":{"tau_x":1}})", "tau_x: unknown"},
      {R"({"u":0.5,"v":0,"vf":0,"params":{"tau_n":0}})", "tau_n: 0.0, must be > 0.0"},
      {R"({"u":0.5,"v":0,"vf":0,"params":[1]})", "params: must be an object"},
      {"[1,2]", "the line: is array"},
      {"", "the line: not valid JSON"},
      {"{\"u\":0.5,", "the line: not valid JSON"},
      {"{\"u\":\xff}", "the line: not valid JSON"},
      {R"({"u":1e999,"v":0,"vf":0})", "the line: not valid JSON"},
  };
  std::string input;
  for (const auto& [line, reason] : bad) input += good + "\n" + line + "\n";
  const Outcome outcome = run("laws trans_step", input);
  EXPECT_EQ(outcome.exit_code, 1);
  ASSERT_EQ(outcome.lines.size(), 2 * bad.size());
  for (std::size_t i = 0; i < bad.size(); ++i) {
    EXPECT_EQ(json::parse(outcome.lines[2 * i]).at("v").get<double>(), 1.0249875041656245);
    const json answer = json::parse(outcome.lines[2 * i + 1]);
    ASSERT_TRUE(answer.contains("error")) << answer;
    EXPECT_EQ(answer.size(), 1U) << "an error line must carry no result";
    EXPECT_NE(answer["error"].get<std::string>().find(bad[i].second), std::string::npos) << answer;
  }
}

// Each input field of each law: removed, and replaced by text. The answer must only name that field.
TEST(HoistLaws, NamesTheFieldThatIsMissingOrOfTheWrongKind) {
  const std::set<std::string> optional = {"P0", "K1", "K2", "window", "L"};
  for (const auto& file : golden_files()) {
    if (!is_law(file)) continue;
    const auto& law = *tool::find_law(file.function);
    const json whole = line_of(file.cases.front());
    for (const auto& [name, value] : whole.items()) {
      if (name == "params") continue;
      SCOPED_TRACE(file.function + "." + name);
      for (const bool take_away : {true, false}) {
        json line = whole;
        if (take_away) {
          if (optional.contains(name)) continue;
          line.erase(name);
        } else {
          line[name] = json{{"not", "this"}};
        }
        try {
          const json out = tool::compute_law(law, line, json::object());
          ADD_FAILURE() << "accepted: " << out.dump().substr(0, 200);
        } catch (const tool::Refusal& refusal) {
          EXPECT_EQ(std::string(refusal.what()).rfind(name + ":", 0), 0U) << refusal.what();
        }
      }
    }
  }
}

TEST(HoistLaws, RefusesColumnsOfDifferentLength) {
  for (const auto& [law, line, reason] : std::vector<std::tuple<std::string, std::string, std::string>>{
           {"xcorr0", R"({"x":[1,2],"y":[1]})", "y: has 1 elements"},
           {"odo_seq", R"({"dEL":[1],"dER":[1,2],"Kpm":1,"dww":1})", "dER: has 2 elements"},
           {"tilt_seq", R"({"rate":[1],"phi_s":[],"phi0":0,"b0":0,"K1":0,"K2":0,"dt":1})", "phi_s: has 0 elements"},
           {"delta32", R"({"now":2147483648,"before":0})", "now: "},
           {"delta32", R"({"now":0.5,"before":0})", "now: 0.5, must be a whole number"},
           {"path_pose", R"({"shape":"eight","c":1,"R":1.5,"s":0})", "R: 1.5"},
           {"path_pose", R"({"shape":"round","s":0})", "shape: \"round\""},
           {"table_mean", R"({"rows":[[1,2],[1]]})", "rows[1]: has 1 elements"},
           {"trans_seq", R"({"u":[0.1,null]})", "u[1]: null"}}) {
    SCOPED_TRACE(law + " " + line);
    try {
      const json out = tool::compute_law(*tool::find_law(law), json::parse(line), json::object());
      ADD_FAILURE() << out;
    } catch (const tool::Refusal& refusal) {
      EXPECT_NE(std::string(refusal.what()).find(reason), std::string::npos) << refusal.what();
    }
  }
}

TEST(HoistLaws, TakesParametersForAllLinesAndForOne) {
  const Outcome outcome = run(R"(laws trans_step --json '{"vf_max": 3}')", R"({"u":1,"v":0,"vf":10})"
                                                                           "\n"
                                                                           R"({"u":1,"v":0,"vf":10,"params":{"vf_max":4}})"
                                                                           "\n"
                                                                           R"({"u":1,"v":0,"vf":60,"params":{"vf_max":null}})"
                                                                           "\n");
  EXPECT_EQ(outcome.exit_code, 0);
  ASSERT_EQ(outcome.lines.size(), 3U);
  EXPECT_EQ(json::parse(outcome.lines[0]).at("vf"), 3.0);
  EXPECT_EQ(json::parse(outcome.lines[1]).at("vf"), 4.0);
  EXPECT_GT(json::parse(outcome.lines[2]).at("vf"), 59.0);
}

TEST(HoistLaws, ExplainsItself) {
  const Outcome list = run("laws --list", "");
  EXPECT_EQ(list.exit_code, 0);
  for (const auto& file : golden_files()) {
    if (!is_law(file)) continue;
    bool named = false;
    for (const auto& line : list.lines) named = named || line.rfind(file.function + " ", 0) == 0;
    EXPECT_TRUE(named) << file.function;
    const Outcome help = run("laws " + file.function + " --help", "");
    EXPECT_EQ(help.exit_code, 0);
    EXPECT_NE(help.text.find("in:"), std::string::npos);
  }
  EXPECT_EQ(run("--help", "").exit_code, 0);
  EXPECT_EQ(run("laws --help", "").exit_code, 0);
  EXPECT_EQ(run("laws nothing_like_this", "").exit_code, 2);
  EXPECT_EQ(run("nothing_like_this", "").exit_code, 2);
  EXPECT_EQ(run("laws trans_step --json nonsense", "").exit_code, 2);
  EXPECT_EQ(run("laws trans_step --jsonn '{}'", "").exit_code, 2);
  const Outcome silent = run("laws trans_step", "");
  EXPECT_EQ(silent.exit_code, 0);
  EXPECT_TRUE(silent.lines.empty());
}

}  // namespace
}  // namespace hoist::test
