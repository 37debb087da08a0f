#include "control/run/watchdog.hpp"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <charconv>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace hoist::run {
namespace {
constexpr std::uint64_t kLookAtMost_ns = 100'000'000;
}

Notifier::Notifier(std::string socket, std::uint64_t watchdog_us) : socket_(std::move(socket)), period_ns_(kLookAtMost_ns) {
  if (watchdog_us > 0 && watchdog_us * 1000 / 4 < period_ns_) period_ns_ = watchdog_us * 1000 / 4;
  if (!socket_.empty()) descriptor_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
}
Notifier::~Notifier() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Notifier Notifier::from_environment() {
  const char* socket = std::getenv("NOTIFY_SOCKET");
  const char* watchdog = std::getenv("WATCHDOG_USEC");
  std::uint64_t watchdog_us = 0;
  if (watchdog != nullptr) std::from_chars(watchdog, watchdog + std::strlen(watchdog), watchdog_us);
  return {socket == nullptr ? std::string() : std::string(socket), watchdog_us};
}

void Notifier::tell(std::string_view word) const noexcept {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (descriptor_ < 0 || socket_.size() < 2 || socket_.size() >= sizeof address.sun_path) return;
  std::memcpy(address.sun_path, socket_.data(), socket_.size());
  if (address.sun_path[0] == '@') address.sun_path[0] = '\0';
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + socket_.size());
  static_cast<void>(::sendto(descriptor_, word.data(), word.size(), MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&address), size));
}

bool Notifier::look(std::uint64_t steps) noexcept {
  if (steps == seen_) return false;
  seen_ = steps;
  tell(ready_told_ ? "WATCHDOG=1" : "READY=1\nWATCHDOG=1");
  ready_told_ = true;
  return true;
}

}  // namespace hoist::run
