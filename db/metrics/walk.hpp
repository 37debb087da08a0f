// What the figures of a session are computed from: its samples in order, and what they say of the walk as a whole. Only samples in a mode in
// which the wheels may turn count; the others tell how the modes followed each other. No sample is kept.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>

#include "control/contract/faults.hpp"
#include "db/metrics/no_figure.hpp"

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
/// Whether a sample counts.
[[nodiscard]] inline bool counts(const WalkSample& sample) { return contract::kModes[static_cast<std::size_t>(sample.mode)].moving; }

/// How the modes followed each other.
class ModeChanges {
 public:
  void add(contract::Mode mode);
  /// The patient led at some time.
  [[nodiscard]] bool led() const { return led_; }
  /// How often leading ended, but for the last end into STANDBY.
  [[nodiscard]] int interventions() const { return interventions_; }
  /// How often motion ended in a protective stop, a fault or an emergency stop.
  [[nodiscard]] int protective_stops() const { return protective_stops_; }

 private:
  std::optional<contract::Mode> mode_;
  bool led_ = false;
  bool perhaps_last_ = false;  // leading ended into STANDBY, and no motion has followed
  int interventions_ = 0, protective_stops_ = 0;
};

struct Walk {
  // What only the recording knows.
  /// Steps that were walked, or may have been, and are not recorded: those of gaps beside a moving sample.
  std::uint64_t missing_samples = 0;
  /// A new start mark, or another mode in charge, between two of the samples: they are not one walk.
  bool several_walks = false;
  bool from_mark = true;          ///< the first sample is at the start mark; false: the walk went on from an earlier recording
  bool has_sway = true;           ///< false: the recording has no dy_m
  bool has_lean = true;           ///< false: it has no lean_norm or dx_m
  bool settings_changed = false;  ///< between the session's begin and one of the samples

  // Of the samples that count.
  std::uint64_t samples = 0;
  std::uint64_t in_motion = 0;      ///< samples in which a wheel turned (standing_still 0)
  std::uint64_t in_motion_led = 0;  ///< of these, samples in which the patient led
  double walked_m = 0, fastest_m_s = 0;

  ModeChanges modes;

  void add(const WalkSample& sample);
};
/// Why there is no bout in it (bouts.hpp).
[[nodiscard]] inline NoFigure why_no_bout(const Walk& walk) { return walk.in_motion > 0 ? NoFigure::no_bout : NoFigure::no_motion; }

/// The runs of samples in which the hoist is faster than kBout_m_s, without a gap.
inline constexpr double kBout_m_s = 0.05;
class FastRun {
 public:
  /// For each sample that counts: its place in its run, 0 = a run begins; nothing when it is in none.
  std::optional<std::size_t> add(const WalkSample& sample);

 private:
  std::optional<std::uint64_t> tick_;
  std::size_t next_ = 0;
};

}  // namespace hoist::db
