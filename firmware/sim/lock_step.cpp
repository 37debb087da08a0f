#include "firmware/sim/lock_step.hpp"

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

#include "firmware/sim/unix_listener.hpp"

namespace hoist::sim {

using contract::StepHeader;

LockStep::~LockStep() {
  if (core_ >= 0) ::close(core_);
  if (listener_ < 0) return;
  ::close(listener_);
  ::unlink(path_.c_str());
}

std::string LockStep::open(const std::string& path) {
  if (std::string why = listen_at(path, SOCK_SEQPACKET, 1, listener_); !why.empty()) return why;
  path_ = path;
  return {};
}

SerialLine::Presence LockStep::presence() {
  const bool there = core_ >= 0;
  return {there, std::exchange(was_there_, there) != there};
}

std::size_t LockStep::read(std::span<char> bytes) {
  const std::size_t count = std::min(bytes.size(), in_size_);
  std::memcpy(bytes.data(), in_.data(), count);
  std::memmove(in_.data(), in_.data() + count, in_size_ - count);
  in_size_ -= count;
  return count;
}

std::size_t LockStep::write(std::span<const char> bytes) {
  const std::size_t count = std::min(bytes.size(), contract::kStepTextMax - out_size_);
  std::memcpy(out_.data() + sizeof(StepHeader) + out_size_, bytes.data(), count);
  out_size_ += count;
  return count;
}

void LockStep::accept() {
  core_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  step_ = 0;
  out_size_ = in_size_ = 0;
}

LockStep::Answer LockStep::lose(const char* why) {
  ::close(core_);
  core_ = -1;
  given_ = false;
  in_size_ = 0;
  why_ = why;
  return Answer::lost;
}

void LockStep::give() {
  if (core_ < 0) accept();
  if (core_ < 0) return;
  room_ = static_cast<std::uint32_t>(std::min(contract::kStepTextMax, in_.size() - in_size_));
  const StepHeader header{contract::kStepMagic, ++step_, room_};
  std::memcpy(out_.data(), &header, sizeof header);
  const ssize_t sent = ::send(core_, out_.data(), sizeof header + out_size_, MSG_NOSIGNAL | MSG_DONTWAIT);
  out_size_ = 0;
  given_ = true;
  waited_ms_ = 0;
  if (sent < 0) static_cast<void>(lose("has gone"));
}

bool LockStep::valid(std::size_t size) const {
  StepHeader header;
  if (size < sizeof header || size > sizeof header + room_) return false;
  std::memcpy(&header, packet_.data(), sizeof header);
  return header.magic == contract::kStepMagic && header.step == step_ && header.room == 0;
}

LockStep::Answer LockStep::take(int within_ms) {
  if (!given_) return Answer::done;
  pollfd wait{core_, POLLIN, 0};
  static_cast<void>(::poll(&wait, 1, within_ms));
  const ssize_t size = ::recv(core_, packet_.data(), packet_.size(), MSG_DONTWAIT);
  if (size < 0 && (errno == EAGAIN || errno == EINTR)) {
    waited_ms_ += within_ms;
    return waited_ms_ < silence_ms_ ? Answer::waiting : lose("does not answer");
  }
  if (size <= 0) return lose("has gone");
  if (!valid(static_cast<std::size_t>(size))) return lose("is of another version: its answer is malformed");
  const std::size_t text = static_cast<std::size_t>(size) - sizeof(StepHeader);
  std::memcpy(in_.data() + in_size_, packet_.data() + sizeof(StepHeader), text);
  in_size_ += text;
  given_ = false;
  return Answer::done;
}

}  // namespace hoist::sim
