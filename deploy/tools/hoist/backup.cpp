// hoist backup, hoist restore: a database of recordings copied and checked, and put back.
#include "db/store/backup.hpp"

#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>
#include <vector>

#include "control/contract/program_version.hpp"
#include "db/store/identity_key.hpp"
#include "db/store/restore_remains.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

namespace {

namespace fs = std::filesystem;

std::int64_t utc_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::system_clock::now().time_since_epoch()).count();
}

// On a terminal only; a line is no place for progress in a log.
bool show_progress(double share) {
  static int told = -1;
  const int percent = static_cast<int>(share * 100);
  if (::isatty(STDERR_FILENO) == 1 && percent != told) std::fprintf(stderr, "\r%3d %%", told = percent);
  return true;
}
void end_progress() {
  if (::isatty(STDERR_FILENO) == 1) std::fputs("\r      \r", stderr);
}

constexpr const char* kBackupHelp =
    "usage: hoist backup DB FOLDER [--identity-key]\n\n"
    "Copies a database of recordings, and accounts.db beside it (accounts and audit log), into FOLDER/hoist-COMPUTER-DATE and checks the\n"
    "copies; the server may be recording meanwhile. Prints the backup's name and what is in it. The copy holds health data: keep it as "
    "safe\n"
    "as the hoist's own storage.\n\n"
    "  --identity-key  with DB.key, too. Without that key the names of patients cannot be read any more: keep a copy of it in another "
    "place.\n"
    "                  Who has a backup with the key can read them.\n\n"
    "Not in it: the server's certificates and tokens, and what hoist-control keeps (its parameters).\n";
constexpr const char* kRestoreHelp =
    "usage: hoist restore DB BACKUP\n\n"
    "Checks a backup (a folder that hoist backup or the server has written) and puts its recordings in the place of DB, which is kept as\n"
    "DB.replaced-DATE. Stop the server first: while it runs, it restores itself (Sessions, or POST /api/v1/jobs).\n\n"
    "Accounts and the key of the names are put back by hand, while the server is stopped, where the present ones are lost. Beside DB:\n\n"
    "  rm -f accounts.db-wal accounts.db-shm\n"
    "  install -m 600 -o hoist -g hoist BACKUP/accounts.db accounts.db\n"
    "  install -m 600 -o hoist -g hoist BACKUP/DB.key DB.key\n";

// The words that are no option; nothing after an answer that was printed, with its exit code.
struct Words {
  std::vector<std::string> places;
  bool identity_key = false;
  std::optional<int> answered;
};
Words read_words(std::string_view command, const char* help, std::span<const std::string_view> arguments) {
  Words words;
  for (const std::string_view argument : arguments) {
    if (argument == "--help") {
      std::fputs(help, stdout);
      words.answered = kDone;
      return words;
    }
    if (command == "backup" && argument == "--identity-key")
      words.identity_key = true;
    else if (argument.starts_with("--"))
      words.answered = bad_usage(command, "there is no option " + std::string(argument));
    else
      words.places.emplace_back(argument);
    if (words.answered) return words;
  }
  if (words.places.size() != 2)
    words.answered = bad_usage(command, command == "backup" ? "name a database and a folder" : "name a database and a backup");
  return words;
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

}  // namespace

int run_backup(std::span<const std::string_view> arguments) {
  const Words words = read_words("backup", kBackupHelp, arguments);
  if (words.answered) return *words.answered;
  const fs::path file = words.places[0], key = db::IdentityKey::beside(file);
  std::error_code ignored;
  const bool has_key = fs::exists(key, ignored);
  if (words.identity_key && !has_key) return refuse("backup", {db::ErrorKind::not_found, "there is no key " + key.string(), {}});
  db::Result<db::Database> database = db::Database::attach(file);
  if (!database) return refuse("backup", database.error());
  std::array<char, 65> name{};
  (void)::gethostname(name.data(), name.size() - 1);
  db::BackupOptions options{.folder = words.places[1],
                            .device = db::clean_device(name.data()),
                            .program = std::string(contract::program_version()),
                            .utc_ns = utc_ns(),
                            .databases = {fs::path(file).replace_filename("accounts.db")}};
  if (words.identity_key) options.files.push_back(key);
  const auto written = db::back_up(*database, options, &show_progress);
  end_progress();
  if (!written) return refuse("backup", written.error());
  std::vector<std::string> names;
  for (const db::BackupFile& one : (*written)->files) names.push_back(one.name);
  std::printf("%s\n%llu sessions, every page and blob checked\nin it: %s\n", (*written)->folder.c_str(),
              static_cast<unsigned long long>((*written)->sessions), list_of(names).c_str());
  if (has_key && !words.identity_key)
    std::printf("not in it: %s, without which the names of patients cannot be read (--identity-key)\n", key.filename().c_str());
  return kDone;
}

int run_restore(std::span<const std::string_view> arguments) {
  const Words words = read_words("restore", kRestoreHelp, arguments);
  if (words.answered) return *words.answered;
  const fs::path file = words.places[0], backup = words.places[1];
  auto lock = db::WriteLock::take(file);
  if (!lock) return refuse("restore", lock.error());
  db::tidy_after_restore(file);
  const auto prepared = db::prepare_restore(backup, file, &show_progress);
  end_progress();
  if (!prepared) return refuse("restore", prepared.error());
  const auto aside = db::finish_restore(**prepared, file, utc_ns());
  if (!aside) return refuse("restore", aside.error());
  if (aside->empty())
    std::printf("%s\n", file.c_str());
  else
    std::printf("%s; what it was is in %s\n", file.c_str(), aside->c_str());
  std::vector<std::string> left;
  std::error_code ignored;
  for (fs::directory_iterator entry(backup, ignored), end; !ignored && entry != end; entry.increment(ignored))
    if (const std::string name = entry->path().filename(); name != db::kBackupRecordings && name != db::kBackupManifest)
      left.push_back(name);
  if (!left.empty()) std::printf("not put back: %s (see hoist restore --help)\n", list_of(left).c_str());
  return kDone;
}

}  // namespace hoist::tool
