// The word to the service manager (systemd) that this program is ready and alive: datagrams of text to the socket that NOTIFY_SOCKET names,
// as sd_notify(3) describes them. Nothing is linked for it.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace hoist::run {

class Notifier {
 public:
  /// `socket`: NOTIFY_SOCKET, empty when nobody listens; an abstract name begins with '@'. `watchdog_us`: WATCHDOG_USEC, 0 for none.
  Notifier(std::string socket, std::uint64_t watchdog_us);
  ~Notifier();
  Notifier(const Notifier&) = delete;
  Notifier& operator=(const Notifier&) = delete;
  /// From the environment.
  [[nodiscard]] static Notifier from_environment();

  /// Whether a service manager asked to be told.
  [[nodiscard]] bool listened_to() const { return descriptor_ >= 0; }
  /// Sends one word; never waits. What cannot be sent is lost: the service manager then does what it must.
  void tell(std::string_view word) const noexcept;
  /// How often to look(): a quarter of the time that the service manager waits, at most 100 ms.
  [[nodiscard]] std::uint64_t period_ns() const { return period_ns_; }

  /// Tells that the steps go on, but only if they do: `steps` must have grown since the last call. READY comes with the first of them.
  /// Whether anything was told.
  bool look(std::uint64_t steps) noexcept;

 private:
  std::string socket_;
  std::uint64_t period_ns_;
  std::uint64_t seen_ = 0;
  bool ready_told_ = false;
  int descriptor_ = -1;
};

}  // namespace hoist::run
