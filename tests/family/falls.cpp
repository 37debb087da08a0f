#include "tests/family/falls.hpp"

#include <algorithm>
#include <cmath>

namespace hoist::family {

namespace {

constexpr double kStrut_m = 0.80;   // of the simulated machine
constexpr double kSwing_m = 0.006;  // of the harness sideways: the swing back of a step
constexpr double kWalksLeast_s = 10.0, kWalksMost_s = 20.0, kWatched_s = 12.0;
constexpr double kAtRest_m_s = 0.02, kRested_s = 2.0;
constexpr int kTries = 20;

// A body that sinks straight down: it hangs a little forward of the middle and so drives a hoist that it leads; behind a hoist led by
// another its feet drag, here with 21 N (assumed: a tenth of the weight on the floor, friction 0.3).
constexpr double kSinks_m = 0.03, kDragged_m = -0.07;

void begin(sim::Patient& patient, FallKind kind, bool led_by_another) {
  constexpr double kBack_rad = sim::kPi, kAside_rad = sim::kPi / 2.0;
  switch (kind) {
    case FallKind::forward:
      return patient.trip();
    case FallKind::backward:
      return patient.trip(kBack_rad);
    case FallKind::left:
      return patient.trip(kAside_rad);
    case FallKind::right:
      return patient.trip(-kAside_rad);
    case FallKind::faint_forward:
      return patient.collapse();
    case FallKind::faint_backward:
      return patient.collapse(kBack_rad);
    case FallKind::faint_aside:
      return patient.collapse(kAside_rad);
    case FallKind::faint_down:
      return patient.hang(led_by_another ? kDragged_m : kSinks_m);
  }
}

// When a stop is owed, by the body alone.
class Owed {
 public:
  void see_1ms(const TrueLean& body, double speed_m_s, double since_s) {
    lying_s_ = body.lean_rad() > kLying_rad ? lying_s_ + 0.001 : 0.0;
    hanging_s_ = body.lean_rad() > kFallTilt_rad ? hanging_s_ + 0.001 : 0.0;
    drawn_s_ = std::fabs(speed_m_s) > kDrawn_m_s && !swings(body.aside_m()) ? drawn_s_ + 0.001 : 0.0;
    const bool falls = (body.lean_rad() > kFallTilt_rad && body.outward_rad_s() > kFallRate_rad_s) || lying_s_ > kLying_s;
    if (falls) owe(since_s, since_s + kFallBudget_s, true);
    if (hanging_s_ > 0.0) owe(since_s, since_s + kHangBudget_s - hanging_s_, false);
    if (drawn_s_ > kHangBudget_s) owe(since_s - kHangBudget_s, since_s, false);
    // A lean that ends owes nothing more.
    if (owes_ && !fall_ && hanging_s_ == 0.0 && drawn_s_ == 0.0) owes_ = false;
  }
  [[nodiscard]] bool owes() const { return owes_; }
  [[nodiscard]] bool fall() const { return owes_ && fall_; }
  [[nodiscard]] double from_s() const { return from_s_; }
  [[nodiscard]] double by_s() const { return by_s_; }

 private:
  void owe(double from_s, double by_s, bool fall) {
    if (owes_ && by_s_ <= by_s) return;
    owes_ = true, fall_ = fall, from_s_ = from_s, by_s_ = by_s;
  }
  // A body that goes limp swings back once more, which looks like half a step: the time without steps begins with its last swing.
  bool swings(double aside_m) {
    const double out_m = to_left_ ? aside_m : -aside_m;
    farthest_m_ = std::max(farthest_m_, out_m);
    if (farthest_m_ - out_m < kSwing_m) return false;
    to_left_ = !to_left_;
    farthest_m_ = -out_m;
    return true;
  }
  double lying_s_ = 0, hanging_s_ = 0, drawn_s_ = 0, farthest_m_ = -1.0;
  bool to_left_ = true;
  double from_s_ = 0, by_s_ = 0;
  bool owes_ = false, fall_ = false;
};

}  // namespace

void TrueLean::see(const sim::HarnessMotion& harness, double seconds) {
  const double forward_rad = std::atan(harness.dx_m / kStrut_m), aside_rad = std::atan(harness.dy_m / kStrut_m);
  const double now_rad = std::hypot(forward_rad, aside_rad);
  aside_m_ = harness.dy_m;
  rate_rad_s_ = first_ ? 0.0 : (now_rad - lean_rad_) / seconds;
  lean_rad_ = now_rad;
  first_ = false;
}

FallResult fall(const WalkOptions& options, FallKind kind, const std::function<void(Walk&, double since_s)>& see) {
  FallResult result;
  for (int tried = 0; tried < kTries; ++tried) {
    WalkOptions mine = options;
    mine.seed = options.seed + static_cast<std::uint64_t>(tried) * 7'919;
    Walk one(mine);
    if (!one.start()) continue;
    loop::ClosedLoop& loop = one.loop();
    sim::Random random(mine.seed);
    const double fall_s = loop.time_s() + random.uniform(kWalksLeast_s, kWalksMost_s);
    bool walks = true;
    while (walks && loop.time_s() < fall_s) walks = one.step();
    if (!walks) continue;
    TrueLean body;
    Owed owed;
    double ended_s = -1.0;
    begin(loop.world().patient(), kind, contract::led_by_hand(options.mode));
    one.hold_on();
    const double begun_s = loop.time_s();
    loop.on_millisecond([&] {
      if (ended_s >= 0.0) return;
      const double since_s = loop.time_s() - begun_s;
      body.see(loop.world().patient().harness(), 0.001);
      owed.see_1ms(body, loop.world().plant().platform().speed_m_s, since_s);
      const bool alarm = loop.fault(contract::Fault::fall_detected) || loop.fault(contract::Fault::patient_hanging);
      if (alarm || loop.mode() != options.mode) ended_s = since_s;
    });
    double rested_s = 0.0;
    while (loop.time_s() - begun_s < kWatched_s && ended_s < 0.0 && rested_s < kRested_s) {
      one.step();
      rested_s = std::fabs(loop.world().plant().platform().speed_m_s) < kAtRest_m_s ? rested_s + core::kTick_s : 0.0;
      if (see) see(one, loop.time_s() - begun_s);
    }
    result.lean_rad = body.lean_rad();
    result.fall = owed.fall();
    if (owed.owes()) result.owed_from_s = owed.from_s(), result.owed_by_s = owed.by_s();
    const bool ended = ended_s >= 0.0;
    result.found_s = ended ? ended_s : loop.time_s() - begun_s;
    const bool late = owed.owes() && result.found_s > owed.by_s();
    result.end = late ? FallEnd::late : ended ? FallEnd::found : FallEnd::at_rest;
    return result;
  }
  return result;
}

}  // namespace hoist::family
