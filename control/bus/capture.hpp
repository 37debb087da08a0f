// Writes every frame that passes a port to a file in candump's log format, without the control thread ever waiting for a disk: a bounded
// ring, and a thread that empties it. What finds no room is dropped and counted.
#pragma once
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "control/bus/can_port.hpp"
#include "control/bus/candump_log.hpp"

namespace hoist::bus {

class Capture {
 public:
  static constexpr std::size_t kRoom = 16384;       // 7 s of a full bus (2252 frames a second): longer than a disk's delay
  static constexpr int kWriteEvery_ms = 50;         // how often the thread looks
  static constexpr std::size_t kBlock = 64 * 1024;  // bytes given to the file at once

  // Appends to `path`. `interface` is the name written into each line, `utc_offset_ns` what must be added to the steady clock to get the time
  // of day. Null with the reason when the file cannot be opened.
  static std::unique_ptr<Capture> open(const std::string& path, const std::string& interface, std::int64_t utc_offset_ns,
                                       std::string& error);
  // Writes what is left.
  ~Capture();
  Capture(const Capture&) = delete;
  Capture& operator=(const Capture&) = delete;

  // Called by one thread only. Never blocks.
  void put(const contract::CanFrame& frame, Direction direction, std::uint64_t time_ns) noexcept;
  // Returns once everything put before is in the file, or lost. For tests and the end of a program.
  void flush();

  [[nodiscard]] std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }
  [[nodiscard]] std::uint64_t written() const noexcept { return written_.load(std::memory_order_relaxed); }
  // errno of a failed write, else 0. Nothing is written after it, so that a recording has no hidden gap.
  [[nodiscard]] int failure() const noexcept { return failure_.load(std::memory_order_relaxed); }

 private:
  struct Slot {
    contract::CanFrame frame{};
    std::uint64_t time_ns = 0;
    Direction direction = Direction::unknown;
  };
  Capture(int fd, std::string interface, std::int64_t utc_offset_ns);
  void run();
  void empty_ring();

  int fd_;
  std::array<char, 16> interface_{};
  std::int64_t utc_offset_ns_;
  std::unique_ptr<std::array<Slot, kRoom>> slots_ = std::make_unique<std::array<Slot, kRoom>>();
  std::unique_ptr<std::array<char, kBlock>> block_ = std::make_unique<std::array<char, kBlock>>();
  alignas(64) std::atomic<std::uint64_t> head_{0};  // frames put, by the control thread
  alignas(64) std::atomic<std::uint64_t> tail_{0};  // frames taken, by the writing thread
  std::atomic<std::uint64_t> dropped_{0}, written_{0};
  std::atomic<int> failure_{0};
  std::mutex mutex_;
  std::condition_variable wake_, idle_;
  bool ending_ = false;
  std::thread thread_;
};

// A port whose frames are also recorded.
class CapturePort final : public CanPort {
 public:
  CapturePort(std::unique_ptr<CanPort> port, std::unique_ptr<Capture> capture) : port_(std::move(port)), capture_(std::move(capture)) {}
  std::size_t receive(std::span<contract::CanFrame> out, std::uint64_t now_ns) noexcept override {
    const std::size_t count = port_->receive(out, now_ns);
    for (const contract::CanFrame& frame : out.first(count)) capture_->put(frame, Direction::received, now_ns);
    return count;
  }
  std::size_t send(std::span<const contract::CanFrame> frames, std::uint64_t now_ns) noexcept override {
    const std::size_t taken = port_->send(frames, now_ns);
    for (const contract::CanFrame& frame : frames.first(taken)) capture_->put(frame, Direction::sent, now_ns);
    return taken;
  }
  [[nodiscard]] bool up() const noexcept override { return port_->up(); }
  [[nodiscard]] const PortCounters& counters() const noexcept override { return port_->counters(); }
  [[nodiscard]] const char* problem() const noexcept override { return port_->problem(); }
  [[nodiscard]] const char* remark() const noexcept override { return port_->remark(); }
  [[nodiscard]] const Capture& capture() const noexcept { return *capture_; }

 private:
  std::unique_ptr<CanPort> port_;
  std::unique_ptr<Capture> capture_;
};

}  // namespace hoist::bus
