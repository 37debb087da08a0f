#include "control/bus/capture.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

namespace hoist::bus {

std::unique_ptr<Capture> Capture::open(const std::string& path, const std::string& interface, std::int64_t utc_offset_ns,
                                       std::string& error) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (fd < 0) {
    error = path + ": " + std::strerror(errno);
    return nullptr;
  }
  return std::unique_ptr<Capture>(new Capture(fd, interface, utc_offset_ns));
}

Capture::Capture(int fd, std::string interface, std::int64_t utc_offset_ns) : fd_(fd), utc_offset_ns_(utc_offset_ns) {
  interface.copy(interface_.data(), interface_.size() - 1);
  thread_ = std::thread([this] { run(); });
}

Capture::~Capture() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
  ::close(fd_);
}

void Capture::put(const contract::CanFrame& frame, Direction direction, std::uint64_t time_ns) noexcept {
  const std::uint64_t head = head_.load(std::memory_order_relaxed);
  if (head - tail_.load(std::memory_order_acquire) == kRoom) {
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  (*slots_)[head % kRoom] = {frame, time_ns, direction};
  head_.store(head + 1, std::memory_order_release);
}

void Capture::flush() {
  std::unique_lock lock(mutex_);
  const std::uint64_t all = head_.load(std::memory_order_acquire);
  wake_.notify_one();
  idle_.wait(lock, [this, all] { return tail_.load(std::memory_order_acquire) >= all; });
}

void Capture::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    const bool last = ending_;
    lock.unlock();
    empty_ring();
    lock.lock();
    idle_.notify_all();
    if (last) return;
    if (!ending_) wake_.wait_for(lock, std::chrono::milliseconds(kWriteEvery_ms));
  }
}

void Capture::empty_ring() {
  std::array<char, kBlock>& block = *block_;
  std::uint64_t tail = tail_.load(std::memory_order_relaxed);
  const std::uint64_t head = head_.load(std::memory_order_acquire);
  while (tail != head) {
    std::size_t size = 0;
    std::uint64_t count = 0;
    for (; tail != head && size + kLogLineMax <= block.size(); ++tail, ++count) {
      const Slot& slot = (*slots_)[tail % kRoom];
      LogEntry entry;
      entry.time_us = static_cast<std::uint64_t>(static_cast<std::int64_t>(slot.time_ns) + utc_offset_ns_) / 1000U;
      entry.frame = slot.frame;
      entry.interface = interface_;
      entry.direction = slot.direction;
      size += format_log_line(entry, std::span<char>(block).subspan(size));
    }
    for (std::size_t done = 0; done < size && failure() == 0;) {
      const ssize_t put = ::write(fd_, block.data() + done, size - done);
      if (put > 0)
        done += static_cast<std::size_t>(put);
      else if (errno != EINTR)
        failure_.store(errno == 0 ? EIO : errno);
    }
    (failure() == 0 ? written_ : dropped_).fetch_add(count, std::memory_order_relaxed);
    tail_.store(tail, std::memory_order_release);
  }
}

}  // namespace hoist::bus
