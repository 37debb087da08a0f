#include "firmware/sim/serial_line.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

namespace hoist::sim {
namespace {

std::string reason(const std::string& what) { return what + ": " + std::strerror(errno); }

}  // namespace

SerialLine::~SerialLine() {
  if (!link_.empty()) {
    // Only our own link goes; another simulator may have taken the place meanwhile.
    std::array<char, 256> target{};
    const ssize_t length = ::readlink(link_.c_str(), target.data(), target.size());
    if (length > 0 && std::string(target.data(), static_cast<std::size_t>(length)) == path_) ::unlink(link_.c_str());
  }
  for (const int fd : {watch_, slave_, master_})
    if (fd >= 0) ::close(fd);
}

std::string SerialLine::open(const std::string& link) {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (master_ < 0) return reason("no pseudo terminal");
  std::array<char, 128> name{};
  if (::grantpt(master_) != 0 || ::unlockpt(master_) != 0 || ::ptsname_r(master_, name.data(), name.size()) != 0)
    return reason("the pseudo terminal cannot be prepared");
  path_ = name.data();
  slave_ = ::open(path_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC | O_NONBLOCK);
  if (slave_ < 0) return reason(path_ + " cannot be opened");
  termios settings{};
  if (::tcgetattr(slave_, &settings) != 0) return reason("terminal settings");
  ::cfmakeraw(&settings);
  if (::tcsetattr(slave_, TCSANOW, &settings) != 0) return reason("terminal settings");
  watch_ = ::inotify_init1(IN_NONBLOCK | IN_CLOEXEC);
  if (watch_ >= 0 && ::inotify_add_watch(watch_, path_.c_str(), IN_OPEN | IN_CLOSE) < 0) {
    ::close(watch_);
    watch_ = -1;
  }
  if (link.empty()) return {};

  struct stat present {};
  if (::lstat(link.c_str(), &present) == 0 && !S_ISLNK(present.st_mode)) return link + " exists and is no symbolic link; it stays";
  const std::string fresh = link + ".new." + std::to_string(::getpid());
  ::unlink(fresh.c_str());
  if (::symlink(path_.c_str(), fresh.c_str()) != 0) return reason(fresh + " cannot be made");
  if (::rename(fresh.c_str(), link.c_str()) != 0) {
    const std::string why = reason(link + " cannot be put in place");
    ::unlink(fresh.c_str());
    return why;
  }
  link_ = link;
  return {};
}

SerialLine::Presence SerialLine::presence() {
  if (watch_ < 0) return {true, !std::exchange(was_there_, true)};
  alignas(inotify_event) std::array<char, 1024> buffer{};
  bool left = false;
  for (;;) {
    const ssize_t size = ::read(watch_, buffer.data(), buffer.size());
    if (size <= 0) break;
    for (std::size_t at = 0; at + sizeof(inotify_event) <= static_cast<std::size_t>(size);) {
      inotify_event event{};
      std::memcpy(&event, buffer.data() + at, sizeof(event));
      at += sizeof(event) + event.len;
      if ((event.mask & IN_OPEN) != 0) ++openings_;
      if ((event.mask & IN_CLOSE) != 0) {
        if (openings_ > 0) --openings_;
        left = left || openings_ == 0;
      }
    }
  }
  const bool there = openings_ > 0;
  if (left) {
    // Drops data that the last user had not read, and its lock. Data that the next user has already written stays.
    ::tcflush(slave_, there ? TCIFLUSH : TCIOFLUSH);
    ::ioctl(slave_, TIOCNXCL);
  }
  const bool changed = there != was_there_ || (left && there);
  was_there_ = there;
  return {there, changed};
}

std::size_t SerialLine::read(std::span<char> bytes) {
  const ssize_t got = ::read(master_, bytes.data(), bytes.size());
  return got > 0 ? static_cast<std::size_t>(got) : 0;
}

std::size_t SerialLine::write(std::span<const char> bytes) {
  const ssize_t put = ::write(master_, bytes.data(), bytes.size());
  return put > 0 ? static_cast<std::size_t>(put) : 0;
}

}  // namespace hoist::sim
