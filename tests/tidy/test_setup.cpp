// The set-up's check of the Node that npm brings (deploy/lib/setup.sh), on a program that only leaves a trace when it is run.
#include <gtest/gtest.h>
#include <sys/utsname.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "tests/support/shell.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::tidy {
namespace {

namespace fs = std::filesystem;

test::ShellResult shell(const std::string& script) { return test::run_shell("bash -c '" + script + "' 2>&1"); }

std::string machine() {
  utsname name{};
  ::uname(&name);
  return name.machine;
}

class NpmNode : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "deploy/lib");
    fs::create_directories(program().parent_path());
    for (const char* name : {"common.sh", "setup.sh"})
      fs::copy(fs::path(HOIST_SOURCE_DIR) / "deploy/lib" / name, folder_ / "deploy/lib" / name);
    std::ofstream(program()) << "#!/bin/sh\ntouch \"" << (folder_ / "was-run").string() << "\"\necho v22.0.0\n";
    fs::permissions(program(), fs::perms::owner_all);
  }
  fs::path program() const { return folder_ / "web/node_modules/node/bin/node"; }
  void pin(const std::string& hash) const { std::ofstream(folder_ / "deploy/lib/node.sha256") << machine() << " " << hash << " 22.0.0\n"; }
  // A machine whose own Node is too old; what the verbs would run afterwards.
  test::ShellResult use() const {
    return shell("cd " + folder_.path().string() +
                 " && source deploy/lib/common.sh && node_major() { echo 18; } && use_newest_node && which node");
  }
  test::TemporaryFolder folder_;
};

TEST_F(NpmNode, AnotherProgramThanThePinnedOneIsNotRun) {
  pin(std::string(64, '0'));
  const test::ShellResult outcome = use();
  EXPECT_NE(outcome.exit_code, 0);
  EXPECT_NE(outcome.output.find("not the one that deploy/lib/node.sha256 names"), std::string::npos) << outcome.output;
  EXPECT_FALSE(fs::exists(folder_ / "was-run"));
  EXPECT_FALSE(fs::exists(program())) << "npm run would find it as well";
}

TEST_F(NpmNode, AMachineWithoutAHashGetsNone) {
  std::ofstream(folder_ / "deploy/lib/node.sha256") << "pdp11 " << std::string(64, '0') << " 22.0.0\n";
  EXPECT_NE(use().exit_code, 0);
  EXPECT_FALSE(fs::exists(program()));
}

TEST_F(NpmNode, ThePinnedOneIsUsed) {
  pin(shell("sha256sum <" + program().string()).output.substr(0, 64));
  const test::ShellResult outcome = use();
  EXPECT_EQ(outcome.exit_code, 0) << outcome.output;
  EXPECT_EQ(outcome.output, program().string() + "\n");
}

TEST_F(NpmNode, TheInstalledOneIsCheckedBeforeItCountsAsInstalled) {
  pin(std::string(64, '0'));
  std::ofstream(folder_ / "web/package-lock.json") << "{}";
  const test::ShellResult outcome =
      shell("cd " + folder_.path().string() + " && source deploy/lib/common.sh && npm() { :; } && install_npm_packages web");
  EXPECT_NE(outcome.exit_code, 0) << outcome.output;
  EXPECT_FALSE(fs::exists(folder_ / "web/node_modules/.hoist-lock"));
}

// A new version brings new hashes.
TEST(NpmNodePins, AreOfTheVersionThatTheConsoleNames) {
  std::ifstream file(fs::path(HOIST_SOURCE_DIR) / "web/package.json");
  const std::string package{std::istreambuf_iterator<char>(file), {}};
  std::ifstream pins(fs::path(HOIST_SOURCE_DIR) / "deploy/lib/node.sha256");
  int machines = 0;
  for (std::string line; std::getline(pins, line);) {
    if (line.starts_with("#")) continue;
    const std::string version = line.substr(line.rfind(' ') + 1);
    EXPECT_NE(package.find("\"node\": \"" + version + "\""), std::string::npos) << line;
    ++machines;
  }
  EXPECT_EQ(machines, 2);
}

}  // namespace
}  // namespace hoist::tidy
