#include "db/store/owner.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace hoist::db {

Status give_to_owner(const std::filesystem::path& made, const std::filesystem::path& like) {
  if (::geteuid() != 0) return {};
  const std::filesystem::path folder = made.has_parent_path() ? made.parent_path() : std::filesystem::path(".");
  struct stat owner {};
  if ((like.empty() || ::stat(like.c_str(), &owner) != 0) && ::stat(folder.c_str(), &owner) != 0) return {};
  // By a descriptor, and never of a file with a second name: the folder's owner may have put a link in its place meanwhile. O_PATH, because closing
  // any other descriptor would drop this process's locks on a database.
  const int descriptor = ::open(made.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC);
  if (descriptor < 0) return {};
  struct stat now {};
  const bool plain = ::fstat(descriptor, &now) == 0 && S_ISREG(now.st_mode) && now.st_nlink == 1;
  const bool same = now.st_uid == owner.st_uid && now.st_gid == owner.st_gid;
  const int failed = !plain || same || ::fchownat(descriptor, "", owner.st_uid, owner.st_gid, AT_EMPTY_PATH) == 0 ? 0 : errno;
  ::close(descriptor);
  if (failed == 0) return {};
  return Error{ErrorKind::io, made.string() + " could not be given to its owner: " + std::generic_category().message(failed), {}};
}

}  // namespace hoist::db
