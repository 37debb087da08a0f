// What the figures of a session are computed from: the samples in a mode in which the wheels may turn, joined in order, and how the modes
// followed each other.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "control/contract/faults.hpp"
#include "control/contract/reference_path.hpp"
#include "db/metrics/task_end.hpp"

namespace hoist::db {

/// One control step: samples are counted, not clocked (the recorded times carry the jitter of the loop, the control law does not see it).
inline constexpr double kSample_s = 0.01;
/// The nearest whole number of them.
constexpr std::size_t samples_in(double seconds) { return static_cast<std::size_t>((seconds + kSample_s / 2) / kSample_s); }

/// One sample, from a recording.
struct WalkSample {
  std::uint64_t tick = 0;
  contract::Mode mode{};
  bool standing_still = false;
  double x_m = 0, y_m = 0, psi_rad = 0;  ///< where the hoist was
  double dpsi_rad = 0, dy_m = 0;         ///< equations (3) and (2)
  double speed_m_s = 0;
  double lean_norm = 0, dx_m = 0;
};

/// The task that the session is a repetition of, as it was recorded.
struct WalkTask {
  TaskEnd ends{};
  double goal = 0, edge_m = 0;
};

/// Parameters that figures refer to, as they were in force when the session began; absent where they are not recorded, or changed during it.
struct WalkSettings {
  double lean_dead_band_norm = 0, lean_range_rad = 0, strut_length_m = 0;
};

struct Walk {
  /// The exercise's line; absent for free walking.
  std::optional<contract::ReferencePath> path;
  std::optional<WalkTask> task;
  std::optional<WalkSettings> settings;
  bool settings_changed = false;
  /// Steps that were walked, or may have been, and are not recorded: those of gaps beside a moving sample.
  std::uint64_t missing_samples = 0;
  /// A new start mark, or another mode in charge, between two of the samples: they are not one walk.
  bool several_walks = false;
  bool from_mark = true;              ///< the first sample is at the start mark; false: the walk went on from an earlier recording
  bool has_sway = true;               ///< false: the recording has no dy_m
  bool has_lean = true;               ///< false: it has no lean_norm or dx_m
  std::optional<std::size_t> begun;   ///< the first sample in which a wheel turned
  std::uint64_t in_motion = 0;        ///< samples in which a wheel turned (standing_still 0)
  std::uint64_t in_motion_led = 0;    ///< of these, samples in which the patient led
  std::vector<contract::Mode> modes;  ///< of all samples, those that do not count too: each change once
  std::vector<std::uint64_t> tick;
  std::vector<contract::Mode> mode;
  std::vector<double> x_m, y_m, psi_rad, dpsi_rad, dy_m, speed_m_s, lean_norm, dx_m;

  void add(const WalkSample& sample) {
    if (modes.empty() || modes.back() != sample.mode) modes.push_back(sample.mode);
    if (!contract::kModes[static_cast<std::size_t>(sample.mode)].moving) return;
    in_motion += sample.standing_still ? 0 : 1;
    in_motion_led += !sample.standing_still && sample.mode == contract::Mode::user ? 1 : 0;
    if (!begun && !sample.standing_still) begun = count();
    tick.push_back(sample.tick);
    mode.push_back(sample.mode);
    x_m.push_back(sample.x_m);
    y_m.push_back(sample.y_m);
    psi_rad.push_back(sample.psi_rad);
    dpsi_rad.push_back(sample.dpsi_rad);
    dy_m.push_back(sample.dy_m);
    speed_m_s.push_back(sample.speed_m_s);
    lean_norm.push_back(sample.lean_norm);
    dx_m.push_back(sample.dx_m);
  }
  [[nodiscard]] std::size_t count() const { return tick.size(); }
};

/// Samples [first, end) of a walk, one after the other without a gap.
struct Stretch {
  std::size_t first = 0, end = 0;
  [[nodiscard]] std::size_t count() const { return end - first; }
};
/// The walk cut where samples are missing.
[[nodiscard]] std::vector<Stretch> whole_stretches(const Walk& walk);

}  // namespace hoist::db
