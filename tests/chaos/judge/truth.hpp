// The true state of machine and patient, once a step: the judge's own figures, from the plant alone.
#pragma once
#include <array>

#include "firmware/sim/world.hpp"
#include "tests/chaos/judge/units.hpp"

namespace hoist::chaos {

struct Truth {
  double time_s = 0;
  std::array<double, 2> wheel_m_s{};  // rim speeds
  std::array<double, 2> wheel_m_s2{};
  double fastest_m_s = 0;                    // of the two, without sign
  double speed_m_s = 0, yaw_rate_rad_s = 0;  // of the platform
  double acceleration_m_s2 = 0;              // of the mean of the wheels
  // The harness against the chassis: mean of both struts, positive forward and to the right; the outward rate of its length.
  double forward_rad = 0, right_rad = 0, lean_rad = 0, outward_rad_s = 0;
  double turn_rad = 0;     // half the difference of the struts: right ahead of left
  double side_m = 0;       // of the bar, to the left
  bool strap_off = false;  // one at least
  bool held = true;        // a strap holds the body; without one, bar and struts stand upright
  double chassis_rad = 0;  // lean of the chassis in any direction
  double chassis_forward_rad = 0, chassis_right_rad = 0;
  // What pushes each wheel along the floor from outside: body, stops, hands, slope, edges of the floor. Newtons, forward positive.
  std::array<double, 2> push_n{};
  double hardest_n = 0;  // of the two, without sign
  double shaken_n{};     // the same, fading within 0.3 s
  bool touches = false;  // a post pushes at the frame
  bool on_edge = false;  // of a sill or a step
};

class TruthSampler {
 public:
  /// Once every control step of 10 ms.
  [[nodiscard]] const Truth& sample(const sim::World& world);
  [[nodiscard]] const Truth& now() const { return now_; }

 private:
  Truth now_;
  bool begun_ = false;
};

}  // namespace hoist::chaos
