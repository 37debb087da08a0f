#include "firmware/sim/unix_listener.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace hoist::sim {

std::string listen_at(const std::string& path, int type, int backlog, int& listener) {
  sockaddr_un address{};
  if (path.empty() || path.size() >= sizeof(address.sun_path)) return "the socket's path must have 1 to 107 characters";
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const auto* generic = reinterpret_cast<const sockaddr*>(&address);

  struct stat present {};
  if (::lstat(path.c_str(), &present) == 0) {
    if (!S_ISSOCK(present.st_mode)) return path + " exists and is no socket; it stays";
    const int probe = ::socket(AF_UNIX, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const bool alive = probe >= 0 && (::connect(probe, generic, sizeof(address)) == 0 || errno == EAGAIN);
    if (probe >= 0) ::close(probe);
    if (alive) return "another program answers at " + path;
    ::unlink(path.c_str());
  }
  const int fd = ::socket(AF_UNIX, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return std::string("no socket: ") + std::strerror(errno);
  const mode_t before = ::umask(0177);
  const bool bound = ::bind(fd, generic, sizeof(address)) == 0;
  ::umask(before);
  if (!bound || ::listen(fd, backlog) != 0) {
    const std::string why = path + ": " + std::strerror(errno);
    ::close(fd);
    return why;
  }
  listener = fd;
  return {};
}

}  // namespace hoist::sim
