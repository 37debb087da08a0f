// Short times of lost grip: wet patches, with a push of the frame, as by the paper's fifth subject.
#pragma once

#include <array>
#include <cstdint>

#include "firmware/sim/plant.hpp"
#include "firmware/sim/random.hpp"

namespace hoist::sim {

/// One such moment: how long, how much each wheel still grips, and how the frame is shoved and twisted (left positive).
struct SlipBurst {
  double seconds{0.5};
  std::array<double, 2> grip_norm{0.05, 0.05};
  double push_n{};
  double twist_n_m{};
};

class SlipBursts {
 public:
  /// `at_random`: a burst every few seconds, from now on, the same ones for the same seed. Each is shorter than a second, so the walk continues.
  SlipBursts(std::uint64_t seed, bool at_random) : random_(seed ^ 0x536C6970ULL), at_random_(at_random) {
    pause_s_ = random_.uniform(3.0, 9.0);
  }
  void set_at_random(bool at_random) { at_random_ = at_random; }

  /// Begins at once and replaces a running one.
  void begin(const SlipBurst& burst) { burst_ = burst, left_s_ = burst.seconds, fresh_ = true; }

  /// One millisecond, before the plant's own.
  void step_1ms(Plant& plant) {
    constexpr double kStep_s = 0.001;
    if (left_s_ > 0.0) {
      if (fresh_) {
        plant.set_grip(Side::left, burst_.grip_norm[0]);
        plant.set_grip(Side::right, burst_.grip_norm[1]);
        plant.set_shove(burst_.push_n, burst_.twist_n_m);
        fresh_ = false;
      }
      left_s_ -= kStep_s;
      if (left_s_ > 0.0) return;
      plant.set_grip(Side::left, plant.params().grip_norm);
      plant.set_grip(Side::right, plant.params().grip_norm);
      plant.set_shove(0.0, 0.0);
      return;
    }
    if (!at_random_) return;
    pause_s_ -= kStep_s;
    if (pause_s_ > 0.0) return;
    pause_s_ = random_.uniform(3.0, 9.0);
    begin(draw(random_));
  }

  /// A random burst: one wheel or both, a little or nearly no grip, with a twist to either side.
  [[nodiscard]] static SlipBurst draw(Random& random) {
    SlipBurst burst;
    burst.seconds = random.uniform(0.2, 0.8);
    const std::uint64_t which = random.next() % 3;  // left, right, both
    burst.grip_norm[0] = which == 1 ? 0.7 : random.uniform(0.01, 0.10);
    burst.grip_norm[1] = which == 0 ? 0.7 : random.uniform(0.01, 0.10);
    burst.push_n = random.uniform(-20.0, 40.0);
    burst.twist_n_m = random.uniform(8.0, 25.0) * (random.next() % 2 == 0 ? 1.0 : -1.0);
    return burst;
  }

 private:
  Random random_;
  bool at_random_;
  SlipBurst burst_;
  double left_s_{};
  double pause_s_{};
  bool fresh_{false};
};

}  // namespace hoist::sim
