// SLCAN, spoken in user space: the UART gateway of the paper, on a tty, a pty or in lock-step with the simulator. Strict, because the kernel's
// own driver lets a truncated line through with bytes of the line before it.
#pragma once
#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

#include "control/bus/can_port.hpp"
#include "control/bus/serial_device.hpp"
#include "control/contract/slcan_codec.hpp"

namespace hoist::bus {

class SlcanPort final : public CanPort {
 public:
  static constexpr std::uint32_t kDefaultBaud = 1'000'000;  // what a full bus needs (585 kbit/s) with room; 115200 is too slow
  // `baud` must pass valid_baud().
  explicit SlcanPort(std::string path, std::uint32_t baud = kDefaultBaud);
  explicit SlcanPort(std::shared_ptr<SerialDevice> device);
  ~SlcanPort() override;
  SlcanPort(const SlcanPort&) = delete;
  SlcanPort& operator=(const SlcanPort&) = delete;

  std::size_t receive(std::span<contract::CanFrame> out, std::uint64_t now_ns) noexcept override;
  std::size_t send(std::span<const contract::CanFrame> frames, std::uint64_t now_ns) noexcept override;
  // Also false while the adapter says that its controller is off the bus.
  [[nodiscard]] bool up() const noexcept override { return state_ == State::up && counters_.state != BusState::off; }
  [[nodiscard]] const PortCounters& counters() const noexcept override { return counters_; }
  [[nodiscard]] const char* problem() const noexcept override { return problem_.load(std::memory_order_relaxed); }

  [[nodiscard]] static bool valid_baud(std::uint32_t baud) noexcept;
  // "115200, 230400, ..." for refusals.
  [[nodiscard]] static std::string baud_list();

  // Limits, each with its reason.
  static constexpr std::uint64_t kRetryNs = 200'000'000;     // reopening a device that went away (SOURCES 4)
  static constexpr std::uint64_t kAnswerNs = 50'000'000;     // timeout of the answer to a `t` line
  static constexpr std::uint64_t kSetupNs = 500'000'000;     // C, S5, E1, O must be answered within this
  static constexpr std::uint64_t kLostNs = 5'000'000;        // half a step; a working adapter answers in less
  static constexpr std::uint32_t kWindow = 16;               // unanswered lines: two steps of the fullest traffic
  static constexpr std::uint32_t kSilencesBeforeSetup = 4;   // then the adapter is set up again
  static constexpr std::uint32_t kRefusalsBeforeSetup = 50;  // likewise: a tenth of a second of traffic, refused line by line
  static constexpr std::uint64_t kBusOffNs = 2'000'000'000;  // then the state is requested again: the line "active" may be lost
  static constexpr int kReadsPerStep = 4;                    // bounds the work of one step even on a babbling line

 private:
  enum class State : std::uint8_t { closed, setting_up, up };
  void open_device(std::uint64_t now_ns) noexcept;
  void close_device(std::uint64_t now_ns, const char* why) noexcept;
  void begin_setup(std::uint64_t now_ns) noexcept;
  void on_answer(bool accepted, std::uint64_t now_ns) noexcept;
  void on_state(const contract::SlcanLine& line, std::uint64_t now_ns) noexcept;
  void on_errors(std::string_view text) noexcept;
  void become_up() noexcept;
  void expect_nothing() noexcept;
  bool has_room(std::size_t lines, std::uint64_t now_ns) noexcept;
  bool flush() noexcept;

  std::shared_ptr<SerialDevice> device_;
  State state_ = State::closed;
  bool ever_open_ = false;
  std::uint64_t deadline_ns_ = 0;  // closed: next try; setting up: give up
  std::uint32_t setup_answers_ = 0;
  bool plain_setup_ = false;    // without E1: the adapter did not open when state lines were requested
  bool last_accepted_ = false;  // the newest answer to the set-up
  std::uint32_t unanswered_ = 0;
  std::uint64_t waiting_since_ns_ = 0;  // the first line sent after the newest answer; 0: none
  std::uint64_t left_out_ns_ = 0;       // the first step without room, all answers of the step before being there; 0: none
  std::uint32_t silences_ = 0;
  std::uint32_t refusals_ = 0;      // in a row, with no frame in between
  std::uint64_t off_since_ns_ = 0;  // when the controller was said to be off the bus
  contract::SlcanDecoder decoder_;
  PortCounters counters_;
  std::atomic<const char*> problem_{"not opened yet"};
  // The rest of a partial write: a line must be finished before the next one begins.
  std::array<char, 2048> pending_{};
  std::size_t pending_size_ = 0;
  std::uint64_t pending_since_ns_ = 0;
  std::array<char, 4096> read_buffer_{};
};

}  // namespace hoist::bus
