#include "server/link/simulator_line.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>

namespace hoist::server {

bool SimulatorLine::open(const std::string& path) {
  close();
  sockaddr_un address{};
  if (path.empty() || path.size() >= sizeof address.sun_path) return false;
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.data(), path.size());
  fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  // A Unix socket connects at once or not at all.
  if (fd_ >= 0 && ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return true;
  close();
  return false;
}

void SimulatorLine::close() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  read_.clear();
}

bool SimulatorLine::send(std::string_view request) {
  const std::string line = std::string(request) + "\n";
  return fd_ >= 0 && ::send(fd_, line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT) == static_cast<ssize_t>(line.size());
}

std::string SimulatorLine::answer() {
  std::array<char, 512> piece{};
  if (const ssize_t got = fd_ < 0 ? 0 : ::recv(fd_, piece.data(), piece.size(), MSG_DONTWAIT); got > 0)
    read_.append(piece.data(), static_cast<std::size_t>(got));
  const std::size_t end = read_.find('\n');
  if (end == std::string::npos) return {};
  std::string line = read_.substr(0, end);
  read_.erase(0, end + 1);
  return line;
}

}  // namespace hoist::server
