#include "control/bus/socketcan.hpp"

#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "control/contract/can_frame.hpp"

namespace hoist::bus {

using contract::CanFrame;

namespace {

// Not in the headers of older systems (Linux 6.0 added it); the bit is part of the kernel's interface.
constexpr canid_t kErrorCounters = 0x200U;
constexpr std::size_t kTxErrorByte = 6, kRxErrorByte = 7;

constexpr canid_t kErrorsHeard = CAN_ERR_TX_TIMEOUT | CAN_ERR_CRTL | CAN_ERR_PROT | CAN_ERR_TRX | CAN_ERR_ACK | CAN_ERR_BUSOFF |
                                 CAN_ERR_BUSERROR | CAN_ERR_RESTARTED | kErrorCounters;

// For the core: data frames with 11-bit ids. All of those, because the recording must be complete, and a second master or a babbling node
// must be seen. Our nodes send no extended frames or remote requests: the kernel filters them out.
constexpr can_filter kCoreFilter{0, CAN_EFF_FLAG | CAN_RTR_FLAG};

can_frame to_kernel(const CanFrame& frame) {
  can_frame out{};
  out.can_id = frame.id | ((frame.flags & CanFrame::kExtended) != 0 ? CAN_EFF_FLAG : 0U) |
               ((frame.flags & CanFrame::kRemote) != 0 ? CAN_RTR_FLAG : 0U);
  out.can_dlc = frame.dlc;
  std::memcpy(out.data, frame.data.data(), sizeof out.data);
  return out;
}
CanFrame from_kernel(const can_frame& frame) {
  CanFrame out;
  const bool extended = (frame.can_id & CAN_EFF_FLAG) != 0;
  out.id = frame.can_id & (extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  out.dlc = frame.can_dlc;
  out.flags =
      static_cast<std::uint8_t>((extended ? CanFrame::kExtended : 0) | ((frame.can_id & CAN_RTR_FLAG) != 0 ? CanFrame::kRemote : 0));
  // Bytes beyond the length are undefined.
  if ((out.flags & CanFrame::kRemote) == 0) std::memcpy(out.data.data(), frame.data, frame.can_dlc);
  return out;
}
bool can_exist(const CanFrame& frame) {
  return frame.dlc <= 8 && (frame.flags & CanFrame::kError) == 0 &&
         frame.id <= ((frame.flags & CanFrame::kExtended) != 0 ? CAN_EFF_MASK : CAN_SFF_MASK);
}

}  // namespace

bool SocketCanPort::valid_interface_name(std::string_view name) noexcept {
  if (name.empty() || name.size() >= IFNAMSIZ || name == "." || name == "..") return false;
  return std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c <= '~' && c != '/' && c != ':'; });
}

std::string SocketCanPort::kernel_problem() {
  const int fd = ::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW);
  if (fd < 0) {
    if (errno == EAFNOSUPPORT || errno == EPROTONOSUPPORT) return "this computer's kernel has no CAN sockets (modules can and can-raw)";
    return std::string("CAN sockets: ") + std::strerror(errno);
  }
  ::close(fd);
  return {};
}

SocketCanPort::SocketCanPort(std::string_view interface, PortUse use) : use_(use) {
  interface.copy(name_.data(), name_.size() - 1);
  for (std::size_t i = 0; i < kBatch; ++i) {
    vectors_[i] = {&batch_[i], sizeof batch_[i]};
    messages_[i].msg_hdr.msg_iov = &vectors_[i];
    messages_[i].msg_hdr.msg_iovlen = 1;
  }
}

SocketCanPort::~SocketCanPort() {
  if (fd_ >= 0) ::close(fd_);
}

void SocketCanPort::open_socket(std::uint64_t now_ns) noexcept {
  deadline_ns_ = now_ns + kRetryNs;
  const int fd = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (fd < 0) {
    problem_ = "no CAN socket can be made";
    return;
  }
  ifreq request{};
  std::memcpy(request.ifr_name, name_.data(), name_.size());
  if (::ioctl(fd, SIOCGIFINDEX, &request) != 0) {
    problem_ = "there is no such interface";
    ::close(fd);
    return;
  }
  const can_err_mask_t errors = kErrorsHeard;
  const int on = 1, bytes = kReceiveBytes;
  // Set before bind(), so that no frame arrives unfiltered. The system may limit the buffer; the counter of lost frames shows when that
  // mattered.
  bool good = use_ == PortUse::tool || ::setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, &kCoreFilter, sizeof kCoreFilter) == 0;
  good = good && ::setsockopt(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) == 0;
  good = good && ::setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on) == 0;
  if (::setsockopt(fd, SOL_SOCKET, SO_RCVBUFFORCE, &bytes, sizeof bytes) != 0) [[maybe_unused]]
    const int refused = ::setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &bytes, sizeof bytes);
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = request.ifr_ifindex;
  good = good && ::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  if (!good) {
    problem_ = "the interface cannot be used as a CAN interface";
    ::close(fd);
    return;
  }
  fd_ = fd;
  kernel_drops_ = 0;
  if (ever_open_) ++counters_.reopened;
  ever_open_ = true;
  set_state(BusState::active);
  std::memcpy(request.ifr_name, name_.data(), name_.size());
  const bool long_queue = ::ioctl(fd_, SIOCGIFTXQLEN, &request) == 0 && request.ifr_qlen > kQueueFrames;
  static_assert(kQueueFrames == 12, "as the text says");
  remark_ = long_queue ? "the interface may hold more than 12 frames, so that commands leave late: set txqueuelen 12" : "";
  look_at_link(now_ns);
}

void SocketCanPort::close_socket(std::uint64_t now_ns, const char* why) noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  link_up_ = false;
  problem_ = why;
  deadline_ns_ = now_ns + kRetryNs;
}

void SocketCanPort::on_link_down(std::uint64_t now_ns) noexcept {
  link_up_ = false;
  problem_ = "the interface is down";
  deadline_ns_ = now_ns + kRetryNs;
}

// The kernel notifies a socket of a link going down, but not of it coming up.
void SocketCanPort::look_at_link(std::uint64_t now_ns) noexcept {
  deadline_ns_ = now_ns + kRetryNs;
  ifreq request{};
  std::memcpy(request.ifr_name, name_.data(), name_.size());
  if (::ioctl(fd_, SIOCGIFFLAGS, &request) != 0) return close_socket(now_ns, "there is no such interface");
  if ((request.ifr_flags & IFF_UP) == 0) return on_link_down(now_ns);
  if ((request.ifr_flags & IFF_RUNNING) == 0) {
    link_up_ = false;
    return set_state(BusState::off);
  }
  link_up_ = true;
  // Bringing a link up restarts its controller.
  set_state(BusState::active);
}

void SocketCanPort::set_state(BusState state) noexcept {
  if (state == BusState::off && counters_.state != BusState::off) ++counters_.bus_offs;
  counters_.state = state;
  if (state == BusState::off)
    problem_ = "the controller is off the bus (bus-off): check wiring and termination, then restart the interface";
  else if (link_up_)
    problem_ = "";
}

void SocketCanPort::on_error_frame(const can_frame& frame) noexcept {
  const canid_t what = frame.can_id;
  // Frames with counters or recovery only are no errors. Unknown classes of later kernels are ignored.
  const bool good_news = (what & CAN_ERR_CRTL) != 0 && frame.data[1] == CAN_ERR_CRTL_ACTIVE;
  if ((what & kErrorsHeard & ~(CAN_ERR_RESTARTED | kErrorCounters | CAN_ERR_CRTL)) != 0 || ((what & CAN_ERR_CRTL) != 0 && !good_news))
    ++counters_.bus_errors;
  if ((what & kErrorCounters) != 0 && frame.can_dlc > kRxErrorByte) {
    counters_.tx_errors = frame.data[kTxErrorByte];
    counters_.rx_errors = frame.data[kRxErrorByte];
  }
  if ((what & CAN_ERR_CRTL) != 0) {
    const std::uint8_t control = frame.data[1];
    if ((control & CAN_ERR_CRTL_RX_OVERFLOW) != 0) ++counters_.overflows;
    if ((control & CAN_ERR_CRTL_ACTIVE) != 0)
      set_state(BusState::active);
    else if (counters_.state != BusState::off) {
      if ((control & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0)
        set_state(BusState::passive);
      else if ((control & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0)
        set_state(BusState::warning);
    }
  }
  if ((what & CAN_ERR_RESTARTED) != 0) set_state(BusState::active);
  if ((what & CAN_ERR_BUSOFF) != 0) set_state(BusState::off);
}

void SocketCanPort::on_errno(int error, std::uint64_t now_ns) noexcept {
  switch (error) {
    case EAGAIN:
    case EINTR:
    case ENOBUFS:  // queue full: dropped and counted by the caller
      return;
    case ENETDOWN:
      return on_link_down(now_ns);
    default:  // ENODEV, ENXIO: the interface is gone; other errors: reopen
      return close_socket(now_ns, "the interface has gone away");
  }
}

void SocketCanPort::count_overflow(msghdr& message) noexcept {
  for (cmsghdr* header = CMSG_FIRSTHDR(&message); header != nullptr; header = CMSG_NXTHDR(&message, header)) {
    if (header->cmsg_level != SOL_SOCKET || header->cmsg_type != SO_RXQ_OVFL) continue;
    std::uint32_t drops = 0;  // since the socket was made, modulo 2^32
    std::memcpy(&drops, CMSG_DATA(header), sizeof drops);
    counters_.overflows += drops - kernel_drops_;
    kernel_drops_ = drops;
  }
}

std::size_t SocketCanPort::receive(std::span<CanFrame> out, std::uint64_t now_ns) noexcept {
  if (fd_ < 0) {
    if (now_ns >= deadline_ns_) open_socket(now_ns);
    if (fd_ < 0) return 0;
  } else if (!link_up_ && now_ns >= deadline_ns_) {
    look_at_link(now_ns);
    if (fd_ < 0) return 0;
  }
  std::size_t count = 0;
  for (std::size_t round = 0; round < kBatchesPerStep; ++round) {
    for (std::size_t i = 0; i < kBatch; ++i) {
      messages_[i].msg_hdr.msg_control = controls_[i].data();
      messages_[i].msg_hdr.msg_controllen = controls_[i].size();
    }
    const int got = ::recvmmsg(fd_, messages_.data(), kBatch, MSG_DONTWAIT, nullptr);
    if (got < 0) {
      on_errno(errno, now_ns);
      break;
    }
    for (std::size_t i = 0; i < static_cast<std::size_t>(got); ++i) {
      count_overflow(messages_[i].msg_hdr);
      const can_frame& frame = batch_[i];
      if (messages_[i].msg_len != sizeof frame || frame.can_dlc > CAN_MAX_DLEN) {
        ++counters_.refused;
      } else if ((frame.can_id & CAN_ERR_FLAG) != 0) {
        on_error_frame(frame);
      } else if (count < out.size()) {
        out[count++] = from_kernel(frame);
        ++counters_.received;
      } else {
        ++counters_.refused;
      }
    }
    if (static_cast<std::size_t>(got) < kBatch) break;
  }
  return count;
}

std::size_t SocketCanPort::send(std::span<const CanFrame> frames, std::uint64_t now_ns) noexcept {
  std::size_t taken = 0;
  while (up() && taken < frames.size()) {
    std::size_t filled = 0;
    for (; filled < kBatch && taken + filled < frames.size() && can_exist(frames[taken + filled]); ++filled) {
      batch_[filled] = to_kernel(frames[taken + filled]);
      messages_[filled].msg_hdr.msg_control = nullptr;
      messages_[filled].msg_hdr.msg_controllen = 0;
    }
    if (filled == 0) break;
    const int put = ::sendmmsg(fd_, messages_.data(), static_cast<unsigned>(filled), MSG_DONTWAIT);
    if (put < 0) {
      on_errno(errno, now_ns);
      break;
    }
    taken += static_cast<std::size_t>(put);
    if (static_cast<std::size_t>(put) < filled) break;  // the queue is full; the rest would be stale when sent
  }
  counters_.sent += static_cast<std::uint32_t>(taken);
  counters_.send_refused += static_cast<std::uint32_t>(frames.size() - taken);
  return taken;
}

}  // namespace hoist::bus
