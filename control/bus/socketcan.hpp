// A CAN interface of the Linux kernel (CAN_RAW).
//
// Behaviour of the kernel, and our reaction (Linux 6.1):
//   link set down        read says ENETDOWN once, then nothing; the socket stays good: wait for the link, ask for it every 200 ms
//   interface removed    read says ENODEV, write ENXIO: close, open again by name every 200 ms
//   transmit queue full  write says ENOBUFS while poll still says writable: the rest is dropped and counted, never retried,
//                        because a command of the previous step is stale
//   slow reader          the kernel drops frames silently: a receive buffer of 1 MiB, and SO_RXQ_OVFL counts losses
//   bus-off              an error frame; up() is false until CAN_ERR_RESTARTED, "active again", or the link has been down and up.
//                        A socket that is opened later gets no error frame, but the carrier is off (no IFF_RUNNING)
#pragma once
#include <linux/can.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>

#include "control/bus/can_port.hpp"

namespace hoist::bus {

class SocketCanPort final : public CanPort {
 public:
  // `interface` is a name of at most 15 characters (see valid_interface_name).
  SocketCanPort(std::string_view interface, PortUse use);
  ~SocketCanPort() override;
  SocketCanPort(const SocketCanPort&) = delete;
  SocketCanPort& operator=(const SocketCanPort&) = delete;

  std::size_t receive(std::span<contract::CanFrame> out, std::uint64_t now_ns) noexcept override;
  std::size_t send(std::span<const contract::CanFrame> frames, std::uint64_t now_ns) noexcept override;
  [[nodiscard]] bool up() const noexcept override { return fd_ >= 0 && link_up_ && counters_.state != BusState::off; }
  [[nodiscard]] const PortCounters& counters() const noexcept override { return counters_; }
  [[nodiscard]] const char* problem() const noexcept override { return problem_.load(std::memory_order_relaxed); }
  [[nodiscard]] const char* remark() const noexcept override { return remark_.load(std::memory_order_relaxed); }

  // Handles one error frame of the kernel. Public for tests: kernels and drivers send different ones.
  void on_error_frame(const can_frame& frame) noexcept;

  [[nodiscard]] static bool valid_interface_name(std::string_view name) noexcept;
  // Empty when this kernel has CAN sockets, otherwise why not.
  [[nodiscard]] static std::string kernel_problem();

  // Limits, each with its reason.
  static constexpr std::uint64_t kRetryNs = 200'000'000;  // looking for an interface that went away or is down
  static constexpr std::size_t kBatch = 32;               // frames in one system call; a full bus brings 23 in a step
  static constexpr std::size_t kBatchesPerStep = 16;      // bounds the work of one step even on a flood
  // Longest queue of the interface (txqueuelen): two steps with all that the core sends to running nodes in one (two drive commands, heartbeat,
  // relay, one SDO request, SYNC). What waits in a longer one on a disturbed bus is older than the drives' deadline.
  static constexpr int kQueueFrames = 12;
  static constexpr int kReceiveBytes = 1 << 20;  // about 1300 frames; the default holds 278 (measured)

 private:
  void open_socket(std::uint64_t now_ns) noexcept;
  void close_socket(std::uint64_t now_ns, const char* why) noexcept;
  void look_at_link(std::uint64_t now_ns) noexcept;
  void on_link_down(std::uint64_t now_ns) noexcept;
  void on_errno(int error, std::uint64_t now_ns) noexcept;
  void set_state(BusState state) noexcept;
  void count_overflow(msghdr& message) noexcept;

  std::array<char, 16> name_{};
  PortUse use_;
  int fd_ = -1;
  bool link_up_ = false;
  bool ever_open_ = false;
  std::uint64_t deadline_ns_ = 0;  // next try to open, or next look at a link that is down
  std::uint32_t kernel_drops_ = 0;
  PortCounters counters_;
  std::atomic<const char*> problem_{"not opened yet"}, remark_{""};
  std::array<can_frame, kBatch> batch_{};
  std::array<iovec, kBatch> vectors_{};
  std::array<mmsghdr, kBatch> messages_{};
  alignas(cmsghdr) std::array<std::array<unsigned char, 32>, kBatch> controls_{};
};

}  // namespace hoist::bus
