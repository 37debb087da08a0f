// The core's end of lock-step (control/contract/step_line.hpp): gives the control thread its steps, and is the serial device of an SlcanPort.
#pragma once
#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "control/bus/serial_device.hpp"
#include "control/contract/step_line.hpp"

namespace hoist::bus {

class StepLine final : public SerialDevice {
 public:
  /// `silence_ms`: after how long a wait a connected simulator counts as hung. The path must fit a Unix socket (valid_path).
  explicit StepLine(std::string path, int silence_ms = contract::kStepSilence_ms);
  ~StepLine() override;
  StepLine(const StepLine&) = delete;
  StepLine& operator=(const StepLine&) = delete;
  [[nodiscard]] static bool valid_path(const std::string& path) noexcept;

  /// Waits for the next step. True: the simulator started it. False: no simulator, and one period of the steady clock has passed, so that
  /// the core notices the dead bus and continues. `ending` shortens the wait for a simulator that hangs.
  bool wait(const std::atomic<bool>& ending) noexcept;
  /// The step is done: its answer goes to the simulator.
  void done() noexcept;
  /// The simulator gives the steps.
  [[nodiscard]] bool coupled() const noexcept { return coupled_; }

  const char* open() noexcept override;
  void close() noexcept override { open_ = false; }
  ssize_t read(std::span<char> text) noexcept override;
  ssize_t write(std::span<const char> text) noexcept override;

 private:
  static constexpr std::uint64_t kRetry_ns = 200'000'000;  // between two attempts to connect
  static constexpr int kSilenceEnding_ms = 500;            // longest wait of a program that is ending
  enum class Got : std::uint8_t { step, nothing, gone };
  void connect(std::uint64_t now_ns) noexcept;
  void disconnect(const char* why) noexcept;
  [[nodiscard]] Got take() noexcept;

  std::string path_;
  int silence_ms_;
  int fd_ = -1;
  bool coupled_ = false;  // connected, and the first step has come
  bool open_ = false;     // as SlcanPort sees it: from open() until the connection ends
  const char* problem_ = "the simulator is not there";
  std::uint64_t retry_ns_ = 0, due_ns_ = 0;              // steady clock: next attempt; end of this period without simulator
  std::uint32_t step_ = 0;                               // newest one taken
  std::array<char, contract::kStepPacketMax + 1> in_{};  // one more, to detect a longer packet
  std::size_t in_at_ = 0, in_size_ = 0;
  std::array<char, contract::kStepPacketMax> out_{};
  std::size_t out_size_ = 0, out_room_ = 0;  // of the text
};

}  // namespace hoist::bus
