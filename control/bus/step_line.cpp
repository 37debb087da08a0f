#include "control/bus/step_line.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace hoist::bus {

using contract::StepHeader;

namespace {
constexpr int kLook_ms = 20;  // how often a wait looks whether the program is to end

std::uint64_t steady_ns() noexcept {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return static_cast<std::uint64_t>(now.tv_sec) * 1'000'000'000U + static_cast<std::uint64_t>(now.tv_nsec);
}
bool readable(int fd, std::uint64_t within_ns) noexcept {
  pollfd wait{fd, POLLIN, 0};  // a negative fd only waits
  const timespec limit{static_cast<time_t>(within_ns / 1'000'000'000U), static_cast<long>(within_ns % 1'000'000'000U)};
  return ::ppoll(&wait, 1, &limit, nullptr) > 0;
}
}  // namespace

bool StepLine::valid_path(const std::string& path) noexcept { return !path.empty() && path.size() < sizeof(sockaddr_un::sun_path); }

StepLine::StepLine(std::string path, int silence_ms) : path_(std::move(path)), silence_ms_(silence_ms) {}
StepLine::~StepLine() {
  if (fd_ >= 0) ::close(fd_);
}

void StepLine::connect(std::uint64_t now_ns) noexcept {
  retry_ns_ = now_ns + kRetry_ns;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path_.data(), std::min(path_.size(), sizeof address.sun_path - 1));
  fd_ = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd_ < 0) return;
  if (::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
  disconnect(errno == EACCES ? "the simulator's socket may not be opened by this user" : "the simulator is not there");
}

void StepLine::disconnect(const char* why) noexcept {
  ::close(fd_);
  fd_ = -1;
  coupled_ = open_ = false;
  problem_ = why;
  step_ = 0;
  in_at_ = in_size_ = out_size_ = out_room_ = 0;
}

StepLine::Got StepLine::take() noexcept {
  const ssize_t size = ::recv(fd_, in_.data(), in_.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) return Got::nothing;
  if (size <= 0) {
    disconnect("the simulator has gone away");
    return Got::gone;
  }
  StepHeader header;
  if (static_cast<std::size_t>(size) >= sizeof header) std::memcpy(&header, in_.data(), sizeof header);
  if (static_cast<std::size_t>(size) < sizeof header || static_cast<std::size_t>(size) > contract::kStepPacketMax ||
      header.magic != contract::kStepMagic || header.step != step_ + 1 || header.room > contract::kStepTextMax) {
    disconnect("the simulator is of another version: its steps are malformed");
    return Got::gone;
  }
  step_ = header.step;
  in_at_ = sizeof header;
  in_size_ = static_cast<std::size_t>(size);
  out_size_ = 0;
  out_room_ = header.room;
  coupled_ = true;
  return Got::step;
}

bool StepLine::wait(const std::atomic<bool>& ending) noexcept {
  // Only time waited here counts as silence, so a suspended computer does not disconnect the programs.
  for (int waited_ms = 0; coupled_; waited_ms += kLook_ms) {
    const Got got = take();
    if (got == Got::step) return true;
    if (got == Got::gone) break;
    if (waited_ms >= (ending.load(std::memory_order_relaxed) ? std::min(kSilenceEnding_ms, silence_ms_) : silence_ms_)) {
      disconnect("the simulator does not answer");
      retry_ns_ = steady_ns() + kRetry_ns;
      break;
    }
    static_cast<void>(readable(fd_, std::uint64_t{kLook_ms} * 1'000'000));
  }
  const std::uint64_t now_ns = steady_ns();
  // A period that could not take place is left out, as in real time.
  const std::uint64_t next_ns = due_ns_ + contract::kStepPeriod_ns;
  due_ns_ = next_ns > now_ns && next_ns < now_ns + contract::kStepPeriod_ns ? next_ns : now_ns + contract::kStepPeriod_ns;
  for (std::uint64_t at_ns = now_ns; at_ns < due_ns_; at_ns = steady_ns()) {
    if (fd_ < 0 && at_ns >= retry_ns_) connect(at_ns);
    if (readable(fd_, due_ns_ - at_ns) && take() == Got::step) return true;
  }
  return false;
}

void StepLine::done() noexcept {
  if (!coupled_) return;
  const StepHeader header{contract::kStepMagic, step_, 0};
  std::memcpy(out_.data(), &header, sizeof header);
  const ssize_t sent = ::send(fd_, out_.data(), sizeof header + out_size_, MSG_NOSIGNAL | MSG_DONTWAIT);
  out_size_ = out_room_ = 0;
  if (sent < 0) disconnect("the simulator has gone away");
}

const char* StepLine::open() noexcept {
  if (!coupled_) return problem_;
  open_ = true;
  in_at_ = in_size_;  // as a serial line that is flushed when it is opened
  return nullptr;
}

ssize_t StepLine::read(std::span<char> text) noexcept {
  if (!open_) return 0;
  if (in_at_ == in_size_) {
    errno = EAGAIN;
    return -1;
  }
  const std::size_t count = std::min(text.size(), in_size_ - in_at_);
  std::memcpy(text.data(), in_.data() + in_at_, count);
  in_at_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t StepLine::write(std::span<const char> text) noexcept {
  if (!open_) {
    errno = EIO;
    return -1;
  }
  const std::size_t count = std::min(text.size(), out_room_ - out_size_);
  if (count == 0) {
    errno = EAGAIN;
    return -1;
  }
  std::memcpy(out_.data() + sizeof(StepHeader) + out_size_, text.data(), count);
  out_size_ += count;
  return static_cast<ssize_t>(count);
}

}  // namespace hoist::bus
