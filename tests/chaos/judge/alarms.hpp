// What the screens say: how long an alarm stays, the words for its cause, and what the record shows of hands, wheels and motors, against the truth.
#pragma once
#include <array>
#include <cstdint>
#include <functional>
#include <string_view>
#include <utility>

#include "control/contract/faults.hpp"
#include "control/contract/signals.hpp"
#include "tests/chaos/judge/board.hpp"
#include "tests/chaos/judge/ears.hpp"
#include "tests/chaos/judge/seen.hpp"
#include "tests/chaos/judge/truth.hpp"

namespace hoist::chaos {

class Alarms {
 public:
  /// What is broken, a figure, and the name of what it is about.
  using Broken = std::function<void(std::string_view what, double value, std::string_view name)>;
  Alarms(const sim::World& world, const Board& board, const Ears& ears, Broken broken)
      : world_(world), board_(board), ears_(ears), broken_(std::move(broken)) {}

  /// After every millisecond of the world.
  void see_millisecond();
  /// An alarm begins or ends in this step. `before`: the mode in which the step began.
  void raised(contract::Fault fault);
  /// `upright`: the sensors show the true lean, so that the hoist may say whether the patient hangs.
  void cleared(contract::Fault fault, contract::Mode before, const Truth& truth, bool lean_known);
  void acknowledged() { acknowledged_s_ = world_.time_s(); }
  /// The holder's hand, as the core has just been told it: the record that its client had seen, and whether the stick is held.
  void hand(double seen_s, bool held);
  void hand_gone() { known_ = false; }
  /// After each step that the core ran. `from`: who was in control before it; `free`: control was given back, or the server began anew, in it.
  void after_step(const Told& told, const Truth& truth, std::uint32_t from, bool free);
  void restart();

 private:
  void watch_driver(const contract::TickRecord& record, const Truth& truth, std::uint32_t from, bool free);
  void watch_hand(const contract::TickRecord& record);
  void watch_words(const contract::TickRecord& record, const Truth& truth);
  [[nodiscard]] bool sensor_failed() const;
  void watch_wheels(const contract::TickRecord& record);

  const sim::World& world_;
  const Board& board_;
  const Ears& ears_;
  Broken broken_;
  std::array<double, contract::kFaultPlaces> raised_s_{};
  double acknowledged_s_ = -100;
  double turns_s_ = 0;  // how long a wheel has turned
  double limit_a_ = 0;  // of the motors' current
  std::array<int, 2> above_ms_{};
  std::array<double, 2> stands_s_{};  // how long a wheel has been blocked, and nothing else of its drive is broken
  double seen_s_ = 0, told_s_ = 0;    // the newest record that the hand had seen; when the core was told of the hand
  bool known_ = false, held_ = false;
};

}  // namespace hoist::chaos
