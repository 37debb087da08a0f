// A patient of the family walks in one mode, in virtual time, with a therapist where the mode needs one. Nothing breaks: an unasked
// stop is counted with its cause.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "control/contract/params.hpp"
#include "deploy/tools/hoist/study/therapist.hpp"
#include "deploy/tools/loop/closed_loop.hpp"
#include "firmware/sim/patient_family.hpp"

namespace hoist::family {

struct WalkOptions {
  const sim::FamilyMember* member = &sim::kPatientFamily.front();
  contract::Mode mode = contract::Mode::user;
  std::uint64_t seed = 1;
  double length_s = 600.0;
  contract::Params params{};
};

struct WalkTally {
  double moving_s = 0;                 ///< in the mode
  double rolling_s = 0;                ///< of those, faster than 0.02 m/s
  std::map<std::string, int> unasked;  ///< unasked stops, by cause
  int frozen = 0;                      ///< stops of a hoist led by another whose patient's feet were frozen: rightly not dragged on
  int refused = 0;                     ///< starts that were not granted within 10 s

  void add(const WalkTally& other);
  [[nodiscard]] int unasked_all() const;
};

/// The hoist, this patient and a therapist, started anew after each stop.
class Walk {
 public:
  explicit Walk(const WalkOptions& options);

  /// Waits until the mode is in force. False, and counted, when the start was refused.
  bool start();
  /// One control step; the therapist drives in REMOTE and holds in GUIDED, and lets go now and then. False once the mode has ended.
  bool step();
  /// From now on the therapist drives or holds and does not let go.
  void hold_on() { lets_go_s_ = 1e9, holds_s_ = 0.0; }
  [[nodiscard]] loop::ClosedLoop& loop() { return *loop_; }
  /// Why the mode ended: the name of the fault, or how it ended without one; empty for an exercise that is done.
  [[nodiscard]] std::string cause() const;
  /// The patient's feet are frozen, or were until a moment ago.
  [[nodiscard]] bool froze_lately() const { return loop_->time_s() - froze_s_ < kLately_s; }

 private:
  static constexpr double kLately_s = 3.0;
  void drive();

  WalkOptions options_;
  std::unique_ptr<loop::ClosedLoop> loop_;
  std::unique_ptr<tool::study::Therapist> therapist_;
  sim::Random hand_;
  double lets_go_s_ = 0, holds_s_ = 0;
  std::size_t events_at_start_ = 0;
  double froze_s_ = -100.0;
};

/// Walks for length_s, from stop to stop. `see` is called after every step.
[[nodiscard]] WalkTally walk(const WalkOptions& options, const std::function<void(Walk&)>& see = {});

}  // namespace hoist::family
