// Whether the true motion is the one that patient and therapist were promised: how fast, which way, and when it fades. All figures are those of the
// plant, of the frames and of the parameters in force.
#pragma once
#include <array>
#include <deque>
#include <string_view>

#include "control/contract/faults.hpp"
#include "tests/chaos/judge/ears.hpp"
#include "tests/chaos/judge/seen.hpp"
#include "tests/chaos/judge/truth.hpp"

namespace hoist::chaos {

/// A motion that is no longer asked for: what may be left of it. It may grow until its end is known, and only fades after that.
class Fading {
 public:
  /// Each step keeps `keep_norm` of what is left, but takes off no more than `most_per_s` a second. Returns by how much the motion is above that;
  /// negative as long as the motion is asked for.
  double beyond(bool asked, double motion, double keep_norm, double most_per_s);

 private:
  double unasked_s_ = 0, left_ = 0;
};

/// Seconds in a row.
class Lasts {
 public:
  bool longer(bool holds, double least_s);

 private:
  double held_s_ = 0;
};

class Motion {
 public:
  struct Broken {
    std::string_view what = {};
    double value = 0;
  };
  explicit Motion(const Ears& ears) : ears_(&ears) {}

  /// After a step that the core ran: the first promise that it broke. `sound`: no part is broken, nor was until just now. `free`: nothing from
  /// outside turns or holds a wheel.
  [[nodiscard]] Broken after_step(const Told& told, const Truth& truth, bool sound, bool free);
  /// An exercise was asked for, with this speed: the last one is the one that begins.
  void exercise(double speed_m_s) { exercise_m_s_ = speed_m_s; }
  void restart() { *this = Motion(*ears_); }

 private:
  struct View {
    const contract::Params& params;
    const Truth& truth;
    contract::Mode mode;
    double speed_m_s, yaw_rate_rad_s;  // by the wheels
    double gives_m_s;                  // how far a servo gives way to what pushes its wheel
  };
  [[nodiscard]] bool too_fast(const View& view);
  [[nodiscard]] bool beside_its_drive(const View& view);
  [[nodiscard]] bool turns_against(const View& view);
  [[nodiscard]] bool goes_against(const View& view);
  [[nodiscard]] double asked_for_m_s(const View& view);
  [[nodiscard]] bool beyond_the_lean(const View& view);
  [[nodiscard]] bool sensors_heard() const;
  [[nodiscard]] double told_lean_rad() const;
  [[nodiscard]] bool drags(const View& view);
  [[nodiscard]] bool slopes(const View& view) const;
  [[nodiscard]] bool told_rightly(const Truth& truth) const;
  void take_gains(const View& view);
  void take_drives();

  const Ears* ears_;
  contract::Params gains_{};  // as they were when this motion began
  bool gains_glide_ = true, asked_known_ = false;
  double follow_s_ = 0;  // how long both drives have followed
  double exercise_m_s_ = 0;
  std::array<Lasts, 2> beside_{};
  struct {
    double may_m_s = -1, lower_s = 0;  // what it had when it began to follow
    Lasts faster;
  } promised_;
  struct {
    Fading turn, lean;
    Lasts turns, goes;
  } against_;
  struct {
    double filtered_m_s = 0, turned_m_s = 0, may_m_s = 0;
    std::deque<double> lately_m_s;
    Lasts faster;
  } asked_;
  struct {
    std::deque<double> lately_rad;
    double share_norm = 1, may_m_s = -1;
    Lasts drags;
  } lag_;
};

}  // namespace hoist::chaos
