#include "deploy/tools/hoist/out_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "db/accounts/accounts.hpp"
#include "db/store/identity.hpp"

namespace hoist::tool {

namespace {

namespace fs = std::filesystem;

db::Error cannot_write(const fs::path& file, int code) {
  return {db::ErrorKind::io, "cannot write " + file.string() + ": " + std::generic_category().message(code), {}};
}

// Recordings or accounts, or what SQLite and Hoist keep beside such a file.
bool belongs_to_a_database(const std::string& file) {
  for (const std::string_view suffix : {"", "-wal", "-shm", "-journal", ".lock", ".seal", ".key"}) {
    if (!file.ends_with(suffix)) continue;
    const auto id = db::application_id(file.substr(0, file.size() - suffix.size()));
    if (id == db::kApplicationId || id == db::kAccountsApplicationId) return true;
  }
  return false;
}

}  // namespace

OutFile::~OutFile() {
  if (!part_.empty()) (void)::unlink(part_.c_str());
}

db::Status OutFile::open(const fs::path& file) {
  std::error_code error;
  if (fs::exists(file, error) && !fs::is_regular_file(file, error)) {
    file_ = file;
    stream_.reset(std::fopen(file.c_str(), "wb"));
    return stream_ ? db::Status() : cannot_write(file, errno);
  }
  // A link stays one.
  file_ = fs::weakly_canonical(file, error);
  if (error) file_ = file;
  if (belongs_to_a_database(file_))
    return db::Error{db::ErrorKind::bad_value, file.string() + " is a database of Hoist, or belongs to one: name another file", {}};
  std::string part = file_.string() + ".part-XXXXXX";
  const int descriptor = ::mkostemp(part.data(), O_CLOEXEC);  // mode 0600
  if (descriptor < 0) return cannot_write(file, errno);
  part_ = part;
  stream_.reset(::fdopen(descriptor, "wb"));
  if (stream_) return {};
  ::close(descriptor);
  return cannot_write(file, ENOMEM);
}

db::Status OutFile::finish() {
  // First: it tries again what an earlier write could not, and says why.
  if (std::fflush(stream_.get()) != 0) return cannot_write(file_, errno);
  if (std::ferror(stream_.get()) != 0) return cannot_write(file_, EIO);
  if (!part_.empty() && ::fsync(::fileno(stream_.get())) != 0) return cannot_write(file_, errno);
  if (std::fclose(stream_.release()) != 0) return cannot_write(file_, errno);
  if (part_.empty()) return {};
  if (::rename(part_.c_str(), file_.c_str()) != 0) return cannot_write(file_, errno);
  part_.clear();
  return {};
}

db::Status write_file(const fs::path& file, std::string_view content) {
  OutFile out;
  if (db::Status opened = out.open(file); !opened) return opened;
  (void)std::fwrite(content.data(), 1, content.size(), out.stream());
  return out.finish();
}

}  // namespace hoist::tool
