// The simulator's end of lock-step (control/contract/step_line.hpp): one hoist-control at a time, whose serial line this is.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "control/contract/step_line.hpp"
#include "firmware/sim/serial_line.hpp"

namespace hoist::sim {

class LockStep {
 public:
  /// `silence_ms`: longest wait for an answer.
  explicit LockStep(int silence_ms = contract::kStepSilence_ms) : silence_ms_(silence_ms) {}
  ~LockStep();
  LockStep(const LockStep&) = delete;
  LockStep& operator=(const LockStep&) = delete;

  /// Listens at `path`. Empty when it worked, otherwise the sentence for people.
  [[nodiscard]] std::string open(const std::string& path);

  // The line between two steps, for the pump: as SerialLine.
  [[nodiscard]] SerialLine::Presence presence();
  std::size_t read(std::span<char> bytes);
  std::size_t write(std::span<const char> bytes);

  /// Accepts a waiting core if none is connected, and sends the connected one its step. Without a core nothing happens.
  void give();
  /// Waits for the answer to that step. `waiting`: none yet; call again, simulated time stands still. A core that left, hangs or answers
  /// invalid data is disconnected, and why() says which. Only time waited here counts as silence, so a suspended computer does not
  /// disconnect the programs.
  enum class Answer : std::uint8_t { done, waiting, lost };
  [[nodiscard]] Answer take(int within_ms);
  [[nodiscard]] const char* why() const { return why_; }

 private:
  void accept();
  [[nodiscard]] Answer lose(const char* why);
  [[nodiscard]] bool valid(std::size_t size) const;

  int silence_ms_;
  std::string path_;
  int listener_{-1};
  int core_{-1};
  bool was_there_{false};
  bool given_{false};  // a step is unanswered
  int waited_ms_{};
  std::uint32_t step_{};
  std::uint32_t room_{};  // offered with it
  const char* why_{""};
  std::array<char, contract::kStepPacketMax> out_{};  // header and what the gateway says
  std::size_t out_size_{};                            // of the text
  std::array<char, contract::kStepPacketMax + 1> packet_{};
  std::array<char, 2 * contract::kStepTextMax> in_{};  // what the core says and the gateway has not taken yet
  std::size_t in_size_{};
};

}  // namespace hoist::sim
