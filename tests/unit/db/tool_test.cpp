// The commands of `hoist` that write files, as processes.
#include <gtest/gtest.h>
#include <pty.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string>

#include "tests/support/shell.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db::test {
namespace {

namespace fs = std::filesystem;
using hoist::test::run_shell;
using hoist::test::ShellResult;

constexpr int kRefused = 1, kBadUsage = 2;

std::string bytes_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// A folder with one recorded session in hoist.db, which no program has open.
class Tool : public testing::Test {
 protected:
  void SetUp() override {
    auto database = Database::open(folder_ / "hoist.db");
    ASSERT_TRUE(database.ok());
    auto writer = SessionWriter::create(*database);
    ASSERT_TRUE(writer.ok() && writer->begin(start_of_walk()).ok());
    Walk walk(1);
    std::vector<contract::TickRecord> records;
    for (std::uint64_t tick = 0; tick < 300; ++tick) records.push_back(walk.record(tick));
    ASSERT_TRUE(writer->append_ticks(records).ok() && writer->end(CloseReason::finished, kStartUtc_ns).ok());
  }
  // In the folder; `before` is for the shell.
  ShellResult tool(const std::string& arguments, const std::string& before = "") const {
    return run_shell("cd '" + folder_.path().string() + "' && " + before + std::string(HOIST_BINARY_DIR) + "/bin/hoist " + arguments +
                     " 2>&1");
  }
  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_.path())) found.insert(entry.path().filename());
    return found;
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  TemporaryFolder folder_;
};

TEST_F(Tool, NoOutputReplacesADatabaseOrAFileBesideIt) {
  fs::create_hard_link(folder_ / "hoist.db", folder_ / "same.db");
  fs::create_symlink("hoist.db", folder_ / "link.db");
  write("hoist.db.key", "the key of the names");
  const std::set<std::string> files = names();
  const std::string before = bytes_of(folder_ / "hoist.db");
  for (const char* name :
       {"hoist.db", "same.db", "link.db", "./hoist.db", "hoist.db-wal", "hoist.db-shm", "hoist.db.seal", "hoist.db.key"}) {
    for (const char* command :
         {"export hoist.db 1 --out ", "export hoist.db --bundle files --out ", "replay hoist.db 1 --set fault_stops_max=2 --out "}) {
      const ShellResult refused = tool(std::string(command) + name);
      EXPECT_EQ(refused.exit_code, kRefused) << name;
      EXPECT_NE(refused.output.find("is a database of Hoist, or belongs to one"), std::string::npos) << name << ": " << refused.output;
    }
    EXPECT_TRUE(bytes_of(folder_ / "hoist.db") == before) << name;
  }
  EXPECT_EQ(names(), files);
  EXPECT_EQ(bytes_of(folder_ / "hoist.db.key"), "the key of the names");
}

TEST_F(Tool, AnEarlierFileIsReplacedByAWholeOneOnly) {
  write("x.csv", "an earlier one");
  fs::permissions(folder_ / "x.csv", fs::perms(0644));
  const std::set<std::string> files = names();
  // No file may grow beyond 128 blocks of 512 bytes, as on a full disk.
  const ShellResult full = tool("export hoist.db 1 --out x.csv", "trap '' XFSZ && ulimit -f 128 && ");
  EXPECT_EQ(full.exit_code, kRefused);
  EXPECT_NE(full.output.find("cannot write"), std::string::npos) << full.output;
  EXPECT_EQ(bytes_of(folder_ / "x.csv"), "an earlier one");
  // Of a build that this one cannot run again.
  EXPECT_EQ(tool("replay hoist.db 1 --set fault_stops_max=2 --out x.csv").exit_code, kRefused);
  EXPECT_EQ(bytes_of(folder_ / "x.csv"), "an earlier one");
  EXPECT_EQ(names(), files);
  const std::string printed = tool("export hoist.db 1").output;
  EXPECT_EQ(tool("export hoist.db 1 --out x.csv").exit_code, 0);
  EXPECT_EQ(bytes_of(folder_ / "x.csv"), printed);
  EXPECT_EQ(fs::status(folder_ / "x.csv").permissions(), fs::perms(0600));
  EXPECT_EQ(names(), files);
  // A pipe stays a pipe.
  ASSERT_EQ(::mkfifo((folder_ / "pipe").c_str(), 0600), 0);
  EXPECT_EQ(tool("export hoist.db 1 --out pipe", "{ cat pipe & } && ").output, printed);
  EXPECT_TRUE(fs::is_fifo(folder_ / "pipe"));
}

// A service that runs as another user must be able to open what root has put in its folder.
TEST_F(Tool, WhatRootMakesBelongsToTheOwnerOfTheFileOrFolder) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can give files away";
  constexpr uid_t kService = 4321;
  const auto service_owns_all = [&](const char* when) {
    for (const std::string& name : names()) {
      struct stat found {};
      ASSERT_EQ(::stat((folder_ / name).c_str(), &found), 0);
      EXPECT_EQ(found.st_uid, kService) << name << " " << when;
      EXPECT_EQ(found.st_gid, kService) << name << " " << when;
    }
  };
  TemporaryFolder stick;
  ASSERT_EQ(tool("backup hoist.db " + stick.path().string()).exit_code, 0);
  const std::string backup = fs::directory_iterator(stick.path())->path();
  const auto give = [](const fs::path& path) { ASSERT_EQ(::chown(path.c_str(), kService, kService), 0); };
  give(folder_.path());
  for (const std::string& name : names()) give(folder_ / name);
  fs::remove(folder_ / "hoist.db.lock");
  EXPECT_EQ(tool("restore hoist.db " + backup).exit_code, 0);
  service_owns_all("after a restore");
  for (const std::string& name : names()) fs::remove(folder_ / name);
  EXPECT_EQ(tool("restore hoist.db " + backup).exit_code, 0);
  service_owns_all("after a restore into an empty folder");
  ASSERT_TRUE(Database::open(folder_ / "pulled.db").ok());
  EXPECT_EQ(tool("user add accounts.db erika Erika engineer --create", "echo four words not together | ").exit_code, 0);
  EXPECT_TRUE(names().contains("pulled.db.seal") && names().contains("accounts.db"));
  service_owns_all("after a new file");
}

TEST_F(Tool, LostOutputIsNoSuccess) {
  ASSERT_EQ(tool("user add accounts.db erika Erika engineer --create", "echo four words not together | ").exit_code, 0);
  for (const char* command : {"--help", "sessions hoist.db", "metrics hoist.db all", "metrics --list", "export hoist.db 1",
                              "sql hoist.db 'SELECT 1'", "user list accounts.db", "audit list accounts.db"}) {
    EXPECT_EQ(tool(std::string(command) + " >/dev/null").exit_code, 0) << command;
    const ShellResult lost = tool(std::string(command) + " 3>&1 >/dev/full 2>&3 #");
    EXPECT_EQ(lost.exit_code, kRefused) << command;
    EXPECT_NE(lost.output.find("the output could not be written whole"), std::string::npos) << command << ": " << lost.output;
  }
  EXPECT_EQ(tool("sql hoist.db >/dev/full", "echo 'SELECT 1;' | ").exit_code, kRefused);
}

TEST_F(Tool, ABackupHoldsTheAccountsAndSaysWhatItDoesNotHold) {
  ASSERT_EQ(tool("user add accounts.db erika Erika engineer --create", "echo four words not together | ").exit_code, 0);
  const TemporaryFolder without, with;
  const auto folder_in = [](const TemporaryFolder& stick) { return fs::directory_iterator(stick.path())->path(); };
  EXPECT_EQ(tool("backup hoist.db " + without.path().string() + " --identity-key").exit_code, kRefused) << "there is no key";
  write("hoist.db.key", "the key of the names");
  const ShellResult plain = tool("backup hoist.db " + without.path().string());
  ASSERT_EQ(plain.exit_code, 0) << plain.output;
  EXPECT_NE(plain.output.find("in it: recordings.db, accounts.db\nnot in it: hoist.db.key, "), std::string::npos) << plain.output;
  EXPECT_FALSE(fs::exists(folder_in(without) / "hoist.db.key"));
  const ShellResult whole = tool("backup hoist.db " + with.path().string() + " --identity-key");
  ASSERT_EQ(whole.exit_code, 0) << whole.output;
  EXPECT_NE(whole.output.find("in it: recordings.db, accounts.db, hoist.db.key\n"), std::string::npos) << whole.output;
  EXPECT_EQ(whole.output.find("not in it"), std::string::npos);
  EXPECT_EQ(bytes_of(folder_in(with) / "hoist.db.key"), "the key of the names");
  EXPECT_EQ(tool("user list " + (folder_in(with) / "accounts.db").string()).output, tool("user list accounts.db").output);
  const ShellResult restored = tool("restore hoist.db " + folder_in(without).string());
  EXPECT_EQ(restored.exit_code, 0);
  EXPECT_NE(restored.output.find("not put back: accounts.db "), std::string::npos) << restored.output;
}

TEST_F(Tool, AnOptionIsNeverTakenForAFile) {
  const std::set<std::string> files = names();
  for (const char* command :
       {"restore --help hoist.db", "restore hoist.db --help", "user add --help karl Karl engineer", "backup --help ."}) {
    const ShellResult help = tool(command);
    EXPECT_EQ(help.exit_code, 0) << command;
    EXPECT_TRUE(help.output.starts_with("usage: hoist")) << command;
  }
  for (const char* command :
       {"restore --db hoist.db", "restore hoist.db --yes", "user add --db karl Karl engineer", "backup hoist.db --all"})
    EXPECT_EQ(tool(command, "echo four words not together | ").exit_code, kBadUsage) << command;
  EXPECT_EQ(names(), files);
}

TEST_F(Tool, AWrongWordMakesNoFileOfAccounts) {
  const std::set<std::string> files = names();
  const std::string password = "echo four words not together | ";
  EXPECT_EQ(tool("user add new.db").exit_code, kBadUsage);
  EXPECT_EQ(tool("user add new.db karl Karl engineer", password).exit_code, kRefused) << "mistyped, perhaps";
  EXPECT_EQ(tool("user add new.db karl Karl director --create", password).exit_code, kRefused);
  EXPECT_EQ(tool("user add new.db karl Karl engineer --create", "echo short | ").exit_code, kRefused);
  EXPECT_EQ(tool("user list new.db --create").exit_code, kBadUsage);
  EXPECT_EQ(names(), files);
  EXPECT_EQ(tool("user add new.db karl Karl engineer --create", password).exit_code, 0);
  EXPECT_EQ(tool("user add new.db erika Erika viewer", password).exit_code, 0);
}

// A filter that is not looked at lets out what it was meant to keep back: here a session of a simulated hoist.
TEST_F(Tool, AnOptionThatWouldChangeNothingIsRefused) {
  for (const char* filter :
       {"--no-simulated", "--tag x", "--from 2099-01-01", "--to 2000-01-01", "--subject P-1", "--exercise eight", "--visit 7"}) {
    const std::string option = filter;
    EXPECT_EQ(tool("export hoist.db 1 " + option).exit_code, kBadUsage) << option;
    EXPECT_EQ(tool("export hoist.db 1 --bundle files --out x.zip " + option).exit_code, kBadUsage) << option;
    EXPECT_EQ(tool("export hoist.db --bundle files --out x.zip " + option).exit_code, kRefused) << option << ": no session fits";
  }
  for (const char* option : {"--format json", "--columns mode", "--no-constant", "--no-comments"})
    EXPECT_EQ(tool(std::string("export hoist.db 1 --bundle files --out x.zip ") + option).exit_code, kBadUsage) << option;
  EXPECT_EQ(tool("report hoist.db --session 1 --no-simulated --out pages").exit_code, kBadUsage);
  EXPECT_FALSE(fs::exists(folder_ / "x.zip") || fs::exists(folder_ / "pages"));
  EXPECT_EQ(tool("export hoist.db 1 1 --bundle files --out x.zip").exit_code, 0);
  EXPECT_NE(tool("report hoist.db --session 1 --session 1 --out pages").output.find("1 of 1 reports"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "pages" / "group.html")) << "a group of one";
}

TEST_F(Tool, EachStatementOfSqlHasItsRowOfNames) {
  EXPECT_EQ(tool("sql hoist.db 'SELECT 1 AS a; SELECT 2 AS b, 3 AS c UNION ALL SELECT 4, 5'").output, "a\n1\nb,c\n2,3\n4,5\n");
}

// A terminal with `hoist user password` in it.
class Terminal {
 public:
  explicit Terminal(const std::string& accounts) {
    const std::string program = std::string(HOIST_BINARY_DIR) + "/bin/hoist";
    child_ = ::forkpty(&screen_, nullptr, nullptr, nullptr);
    if (child_ != 0) return;
    ::execl(program.c_str(), "hoist", "user", "password", accounts.c_str(), "erika", nullptr);
    ::_exit(127);
  }
  ~Terminal() { ::close(screen_); }
  // Reads until the program has printed this.
  bool shows(const std::string& text) {
    std::array<char, 256> piece{};
    while (shown_.find(text) == std::string::npos) {
      const ssize_t got = ::read(screen_, piece.data(), piece.size());
      if (got <= 0) return false;
      shown_.append(piece.data(), static_cast<std::size_t>(got));
    }
    return true;
  }
  void type(const std::string& text) const { ASSERT_EQ(::write(screen_, text.data(), text.size()), static_cast<ssize_t>(text.size())); }
  bool echoes() const {
    termios now{};
    return ::tcgetattr(screen_, &now) == 0 && (now.c_lflag & ECHO) != 0;
  }
  int end() const {
    int status = 0;
    ::waitpid(child_, &status, 0);
    return status;
  }
  const std::string& shown() const { return shown_; }

 private:
  int screen_ = -1;
  pid_t child_ = -1;
  std::string shown_;
};

TEST_F(Tool, APasswordIsTypedTwiceUnseenAndTheTerminalShowsWhatIsTypedAgain) {
  ASSERT_EQ(tool("user add accounts.db erika Erika engineer --create", "echo four words not together | ").exit_code, 0);
  {
    Terminal terminal(folder_ / "accounts.db");
    ASSERT_TRUE(terminal.shows("New password: "));
    EXPECT_FALSE(terminal.echoes());
    terminal.type("\x03");  // Ctrl-C
    const int status = terminal.end();
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == SIGINT);
    EXPECT_TRUE(terminal.echoes());
  }
  for (const bool same : {false, true}) {
    Terminal terminal(folder_ / "accounts.db");
    ASSERT_TRUE(terminal.shows("New password: "));
    terminal.type("another row of words\n");
    ASSERT_TRUE(terminal.shows("again: "));
    terminal.type(same ? "another row of words\n" : "another row of word\n");
    const int status = terminal.end();
    EXPECT_EQ(WEXITSTATUS(status), same ? 0 : kRefused);
    EXPECT_TRUE(terminal.echoes());
    EXPECT_EQ(terminal.shown().find("another row"), std::string::npos);
  }
}

}  // namespace
}  // namespace hoist::db::test
