// hoist backup, hoist restore: a database of recordings copied and checked, and put back.
#include "db/store/backup.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <cstdio>
#include <string>

#include "control/contract/program_version.hpp"
#include "db/store/restore_remains.hpp"
#include "deploy/tools/hoist/command.hpp"
#include "deploy/tools/hoist/recording_file.hpp"

namespace hoist::tool {

namespace {

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

}  // namespace

int run_backup(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(
        "usage: hoist backup DB FOLDER\n\nCopies a database of recordings into FOLDER/hoist-COMPUTER-DATE and checks the copy; the server "
        "may be "
        "recording\ninto it meanwhile. Prints the backup's name. The copy holds health data: keep it as safe as the hoist's own storage.\n",
        stdout);
    return kDone;
  }
  if (arguments.size() != 2) return bad_usage("backup", "name a database and a folder");
  ::umask(077);
  db::Result<db::Database> database = db::Database::attach(std::string(arguments[0]));
  if (!database) return refuse("backup", database.error());
  std::array<char, 65> name{};
  (void)::gethostname(name.data(), name.size() - 1);
  const db::BackupOptions options{.folder = std::string(arguments[1]),
                                  .device = db::clean_device(name.data()),
                                  .program = std::string(contract::program_version()),
                                  .utc_ns = utc_ns()};
  const auto written = db::back_up(*database, options, &show_progress);
  end_progress();
  if (!written) return refuse("backup", written.error());
  std::printf("%s\n%llu sessions, every page and blob checked\n", (*written)->folder.c_str(),
              static_cast<unsigned long long>((*written)->sessions));
  return kDone;
}

int run_restore(std::span<const std::string_view> arguments) {
  if (arguments.size() == 1 && arguments[0] == "--help") {
    std::fputs(
        "usage: hoist restore DB BACKUP\n\nChecks a backup (a folder that hoist backup or the server has written) and puts it in the place "
        "of DB, "
        "which is\nkept as DB.replaced-DATE. Stop the server first: while it runs, it restores itself (Sessions, or POST /api/v1/jobs).\n",
        stdout);
    return kDone;
  }
  if (arguments.size() != 2) return bad_usage("restore", "name a database and a backup");
  ::umask(077);
  const std::string file(arguments[0]);
  auto lock = db::WriteLock::take(file);
  if (!lock) return refuse("restore", lock.error());
  db::tidy_after_restore(file);
  const auto prepared = db::prepare_restore(std::string(arguments[1]), file, &show_progress);
  end_progress();
  if (!prepared) return refuse("restore", prepared.error());
  const auto aside = db::finish_restore(**prepared, file, utc_ns());
  if (!aside) return refuse("restore", aside.error());
  if (aside->empty())
    std::printf("%s\n", file.c_str());
  else
    std::printf("%s; what it was is in %s\n", file.c_str(), aside->c_str());
  return kDone;
}

}  // namespace hoist::tool
