#include "db/store/write_lock.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <string>
#include <system_error>
#include <thread>

#include "db/store/owner.hpp"

namespace hoist::db {
namespace {

constexpr auto kLockTry = std::chrono::milliseconds(20);

// " (process 123)", or nothing when the file does not say.
std::string holder_of(int descriptor) {
  std::array<char, 16> text{};
  const ssize_t got = ::pread(descriptor, text.data(), text.size(), 0);
  std::string digits;
  for (ssize_t i = 0; i < got && text[static_cast<std::size_t>(i)] >= '0' && text[static_cast<std::size_t>(i)] <= '9'; ++i)
    digits += text[static_cast<std::size_t>(i)];
  return digits.empty() ? digits : " (process " + digits + ")";
}

}  // namespace

Result<std::shared_ptr<WriteLock>> WriteLock::take(const std::filesystem::path& file) {
  // Two names of one file are one file.
  std::error_code error;
  std::filesystem::path target = std::filesystem::weakly_canonical(file, error);
  if (error) target = file;
  const std::string name = target.string() + ".lock";
  const int descriptor = ::open(name.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
  const auto failed = [&name](int code) {
    const ErrorKind kind = code == EROFS ? ErrorKind::read_only : ErrorKind::io;
    return Error{kind, "the lock " + name + " cannot be taken: " + std::generic_category().message(code), {}};
  };
  if (descriptor < 0) return failed(errno);
  std::shared_ptr<WriteLock> lock(new WriteLock(descriptor));
  (void)give_to_owner(name, file);
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(kLockWait_ms);
  while (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EINTR) continue;
    if (errno != EWOULDBLOCK) return failed(errno);
    if (std::chrono::steady_clock::now() >= end)
      return Error{ErrorKind::busy,
                   "another hoist-server" + holder_of(descriptor) + " records into " + file.string() +
                       ": stop that one first, or give this one another file (--db)",
                   {}};
    std::this_thread::sleep_for(kLockTry);
  }
  // Only for the message of a refusal: recording does not depend on it.
  const std::string process = std::to_string(::getpid()) + "\n";
  [[maybe_unused]] const bool noted =
      ::ftruncate(descriptor, 0) == 0 && ::pwrite(descriptor, process.data(), process.size(), 0) == static_cast<ssize_t>(process.size());
  return lock;
}

WriteLock::~WriteLock() { ::close(descriptor_); }

}  // namespace hoist::db
