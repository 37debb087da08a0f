#include "control/run/stored_values.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

#include "control/contract/check.hpp"

namespace hoist::run {
namespace {
using nlohmann::json;

constexpr off_t kFileBytesMax = 1 << 20;  // our own files have about 3 kB; anything near this is not ours

// Over names and values, so that a hand-edited or half-written file is noticed. Not a defence against malice.
std::string checksum(const json& values) {
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(contract::hash_bytes(contract::kHashStart, values.dump())));
  return text;
}

// 0, or the error.
int sync_folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return errno;
  const int error = ::fsync(fd) == 0 ? 0 : errno;
  ::close(fd);
  return error;
}

int write_synced(int fd, const std::string& text) {
  const ssize_t written = ::write(fd, text.data(), text.size());
  if (written < 0) return errno;
  // A disk that fills up takes a part and reports no error.
  if (written != static_cast<ssize_t>(text.size())) return ENOSPC;
  return ::fsync(fd) == 0 ? 0 : errno;
}
}  // namespace

contract::StoreProblem store_problem(const Saved& saved) {
  using contract::StoreProblem;
  if (saved.problem.empty()) return StoreProblem::none;
  return saved.error == ENOSPC || saved.error == EDQUOT ? StoreProblem::disk_full : StoreProblem::failed;
}

Saved save_values(const std::string& path, const json& values) {
  const std::string text = json{{"product", "hoist"}, {"checksum", checksum(values)}, {"values", values}}.dump(1) + "\n";
  const std::string fresh = path + ".new";
  const auto failed = [&fresh](const char* what, int error) {
    return Saved{std::string(what) + " " + fresh + ": " + std::strerror(error), error};
  };
  const int fd = ::open(fresh.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
  if (fd < 0) return failed("cannot create", errno);
  const int error = write_synced(fd, text);
  ::close(fd);
  if (error != 0) {
    ::unlink(fresh.c_str());  // a partial file only takes room
    return failed("cannot write", error);
  }
  if (::rename(fresh.c_str(), path.c_str()) != 0) return failed("cannot put in place", errno);
  // The new name is on the disk only with its folder.
  if (const int unsynced = sync_folder_of(path); unsynced != 0) return failed("cannot sync the folder of", unsynced);
  return {};
}

StoredValues load_values(const std::string& path, const std::string& kind) {
  StoredValues stored;
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) {
    stored.missing = errno == ENOENT;
    if (!stored.missing) stored.problem = "cannot read " + path + ": " + std::strerror(errno);
    return stored;
  }
  if (status.st_size > kFileBytesMax) {
    stored.problem = path + " is too large to be a " + kind;
    return stored;
  }
  std::ifstream file(path);
  json document = json::parse(file, nullptr, false);
  if (!document.is_object() || !document.contains("values") || !document["values"].is_object() || !document.contains("checksum"))
    stored.problem = path + " is not a " + kind;
  else if (document["checksum"] != checksum(document["values"]))
    stored.problem = path + " was damaged or edited by hand (checksum)";
  else
    stored.values = std::move(document["values"]);
  return stored;
}

}  // namespace hoist::run
