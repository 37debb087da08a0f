// Kinds of fault that wait for the moment in which they matter, and the dice of them: what people at the consoles do, and what touches.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>

#include "tests/chaos/dice.hpp"
#include "tests/chaos/faults.hpp"
#include "tests/support/closed_loop.hpp"

namespace hoist::chaos {

inline constexpr std::uint32_t kTherapist = 1, kStranger = 2;  // clients of the server

class Moments {
 public:
  Moments(tests::ClosedLoop& loop, Dice dice) : loop_(loop), dice_(dice) {}

  /// Each step of such a fault, before the control step.
  void go_on(const Fault& fault);
  /// It is over: what it has begun is brought to its end.
  void end(const Fault& fault);

 private:
  void touch(const Fault& fault);
  void pause_and_release();
  void lead_from_elsewhere();
  void press_too_early();
  void correct_a_setting();
  void commit(std::size_t row, double value);
  [[nodiscard]] bool may_start() const;

  tests::ClosedLoop& loop_;
  Dice dice_;
  int touch_steps_ = 0;     // of the touch: until it comes, and then until it goes
  bool touched_ = false;    // in this stop
  int quiet_steps_ = 0;     // until the next pause of the sound
  int stranger_steps_ = 0;  // since the other console has the control
  int button_steps_ = 0;    // since the button is held; below zero: not again yet
  // A setting that was changed by mistake, what it was, and when it is put right.
  std::optional<std::size_t> wrong_row_;
  double right_value_ = 0;
  int wrong_steps_ = 0;
};

}  // namespace hoist::chaos
