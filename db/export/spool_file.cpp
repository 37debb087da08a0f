#include "db/export/spool_file.hpp"

#include <fcntl.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

namespace hoist::db {
namespace {

// How often the disk's free space is asked for.
constexpr std::uint64_t kJudgedEach_bytes = std::uint64_t{16} << 20;

Error failed(std::string_view doing) {
  const ErrorKind kind = errno == ENOSPC || errno == EDQUOT ? ErrorKind::disk_full : ErrorKind::io;
  return {kind, "the export could not be " + std::string(doing) + ": " + std::strerror(errno), {}};
}

// Some file systems have no O_TMPFILE: there the name goes at once.
int open_nameless(const std::filesystem::path& folder) {
  const int file = ::open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
  if (file >= 0 || (errno != EOPNOTSUPP && errno != EISDIR && errno != ENOENT)) return file;
  std::string name = (folder / ".export-XXXXXX").string();
  const int named = ::mkostemp(name.data(), O_CLOEXEC);
  if (named >= 0) ::unlink(name.c_str());
  return named;
}

}  // namespace

Result<std::shared_ptr<SpoolFile>> SpoolFile::create(const std::filesystem::path& folder, std::uint64_t limit_bytes) {
  const int file = open_nameless(folder.empty() ? std::filesystem::path(".") : folder);
  if (file < 0) return failed("begun");
  return std::shared_ptr<SpoolFile>(new SpoolFile(file, limit_bytes));
}

SpoolFile::~SpoolFile() { ::close(file_); }

Status room_for_export(int file, std::uint64_t size, std::uint64_t limit_bytes) {
  if (size > limit_bytes)
    return Error{ErrorKind::bad_value, "the export is larger than " + std::to_string(limit_bytes >> 20) + " MiB: ask for less", "format"};
  struct statvfs disk {};
  if (::fstatvfs(file, &disk) == 0 && std::uint64_t{disk.f_bavail} * disk.f_frsize < kSpoolKeepFree_bytes + kJudgedEach_bytes)
    return Error{ErrorKind::disk_full, "the disk has no room for this export", {}};
  return {};
}

Status SpoolFile::append(std::string_view bytes) {
  const std::uint64_t size = size_ + bytes.size();
  if (size >= judged_ || size > limit_bytes_) {
    if (Status room = room_for_export(file_, size, limit_bytes_); !room) return room;
    judged_ = size + kJudgedEach_bytes;
  }
  while (!bytes.empty()) {
    const ssize_t count = ::pwrite(file_, bytes.data(), bytes.size(), static_cast<off_t>(size_));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return failed("written");
    size_ += static_cast<std::uint64_t>(count);
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return {};
}

Result<std::string> SpoolFile::read(std::uint64_t offset, std::size_t length) const {
  std::string bytes(length, '\0');
  std::size_t done = 0;
  while (done < length) {
    const ssize_t count = ::pread(file_, bytes.data() + done, length - done, static_cast<off_t>(offset + done));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return failed("read");
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  bytes.resize(done);
  return bytes;
}

}  // namespace hoist::db
