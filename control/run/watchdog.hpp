// Notifies the service manager (systemd) that this program is ready and alive: text datagrams to the socket in NOTIFY_SOCKET, as in
// sd_notify(3), without its library.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace hoist::run {

class Notifier {
 public:
  /// `socket`: NOTIFY_SOCKET, empty without a service manager; an abstract name begins with '@'. `watchdog_us`: WATCHDOG_USEC, 0 for none.
  Notifier(std::string socket, std::uint64_t watchdog_us);
  ~Notifier();
  Notifier(const Notifier&) = delete;
  Notifier& operator=(const Notifier&) = delete;
  /// From the environment.
  [[nodiscard]] static Notifier from_environment();

  /// Whether a service manager expects notifications.
  [[nodiscard]] bool listened_to() const { return descriptor_ >= 0; }
  /// Sends one notification; never blocks. A failed one is lost, and the service manager's watchdog acts.
  void tell(std::string_view word) const noexcept;
  /// How often to look(): a quarter of the time that the service manager waits, at most 100 ms.
  [[nodiscard]] std::uint64_t period_ns() const { return period_ns_; }

  /// Feeds the watchdog if `steps` has grown since the last call. READY comes with the first. Returns whether anything was sent.
  bool look(std::uint64_t steps) noexcept;

 private:
  std::string socket_;
  std::uint64_t period_ns_;
  std::uint64_t seen_ = 0;
  bool ready_told_ = false;
  int descriptor_ = -1;
};

}  // namespace hoist::run
