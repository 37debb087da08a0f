// A walking patient between the struts: a body of some mass with legs that push, eyes that follow a line on the floor, and a reaction
// time. Model and figures: SOURCES 3 ("patient 75 kg, leg force <= 70 N, reaction 0.2 s, pelvis yaw lag 0.25 s, ..."), which are
// assumptions about people, not measurements of these patients.
//
// The patient does not know the mode. When the drives release their brakes the patient stands for a second. A hoist that then moves off by
// itself, or ignores a lean, leads until the drives are switched off. A patient whose lean or turn the hoist opposes yields, tries a small
// lean once the hoist stands, and leads again if the hoist answers it.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <string_view>

#include "control/contract/reference_path.hpp"
#include "firmware/sim/gait_variation.hpp"
#include "firmware/sim/model.hpp"
#include "firmware/sim/random.hpp"
#include "firmware/sim/scenario.hpp"

namespace hoist::sim {

/// Usual values of patients (assumed), from which random ones are drawn evenly.
struct PatientRange {
  double least{}, most{};
};
struct PatientRanges {
  PatientRange mass_kg{50.0, 100.0};
  PatientRange wish_m_s{0.20, 0.60};
  PatientRange leg_force_n{60.0, 80.0};
  PatientRange compensation_norm{0.7, 0.9};
  PatientRange drive_per_s{2.2, 3.2};  ///< drive_n_s_m / mass_kg
  PatientRange speed_lead_m_s{0.08, 0.14};
  PatientRange reaction_s{0.15, 0.35};
  PatientRange yaw_lag_s{0.2, 0.35};
  PatientRange look_ahead_m{0.6, 0.9};
  PatientRange foresight_s{0.3, 0.7};
  PatientRange sway_forward_m{0.008, 0.015};
  PatientRange sway_lateral_m{0.02, 0.04};
  PatientRange sway_yaw_deg{3.0, 7.0};
  PatientRange stride_hz{0.38, 0.48};
  PatientRange reach_m{0.13, 0.20};  ///< not drawn: of full leans from 8 to 12 degrees (lean_for)
};
inline constexpr PatientRanges kUsualPatients{};

struct PatientParams {
  double mass_kg{75.0};
  double wish_m_s{0.30};  ///< the speed this patient likes to walk
  double leg_force_n{70.0};
  double compensation_norm{0.8};  ///< share of the spring's push that the legs take
  double drive_n_s_m{220.0};      ///< legs: newtons for each m/s that is missing
  double speed_lead_m_s{0.12};    ///< walks at most this much faster (or slower) than the frame
  double reaction_s{0.2};
  double yaw_lag_s{0.25};
  double yaw_limit_rad{30.0 * kDegree_rad};
  double look_ahead_m{0.75};     ///< 0.6 to 0.9
  double foresight_s{0.5};       ///< how far ahead the patient feels where the hoist is turning
  double turn_habit_per_s{1.2};  ///< what the patient has learnt: turn rate of the hoist for each radian of pelvis
  double sway_forward_m{0.012};  ///< at step frequency
  double sway_lateral_m{0.03};   ///< at stride frequency
  double sway_yaw_rad{5.0 * kDegree_rad};
  double stride_hz{0.42};  ///< stride frequency = this + slope x speed
  double stride_hz_per_m_s{0.5};
  double comfort_m{0.105};  ///< where a lean becomes uncomfortable: 7.5 degrees, three quarters of a range of 10
  double reach_m{0.165};    ///< of each strut, for lean, turn and sway together, in a hoist that answers as usual: 11.7 degrees
  // Led by another (assumed; with zeros the pelvis only goes along).
  double anticipation_norm{0.0};  ///< share of the turn of a leading patient that one who follows makes towards the line ahead
  double trailing_s{0.0};         ///< by how much the pelvis trails behind a turning hoist: hip and harness are not stiff
  // A leg that is held (assumed): one step takes longer than the other, by this share of their mean.
  double limp_norm{0.0};
  double lean_left_m{0.0};  ///< a one-sided lean: the pelvis is held this far to the left, and the springs push it back a little
  GaitVariation variation{};
  /// How long this patient opposes a hoist led by another (assumed). A stubborn one never yields, which is harder for the machine, so the
  /// random sessions use those.
  double yields_after_s{1.0};
  static constexpr double kStubborn_s = 1e9;
  /// Leads as long as the brakes are open, also when the hoist does not answer: for a hoist that moves as recorded (hoist twin).
  bool always_leads{false};

  /// A random patient: every parameter drawn evenly from its usual range; the same seed gives the same person.
  [[nodiscard]] static PatientParams random(std::uint64_t seed);
  /// Comfort and reach in a hoist that asks for this lean for full speed: three quarters of it are comfortable, and a sixth more than it can
  /// be reached, short of the struts' stop.
  void lean_for(double full_lean_m) {
    comfort_m = 0.745 * full_lean_m;
    reach_m = std::fmin(1.17 * full_lean_m, 0.20);
  }
};

enum class PatientState : std::uint8_t { standing, waiting, leading, following, trying, tripping, collapsing, hanging };
std::string_view patient_state_name(PatientState state);

/// What reaches the patient's senses.
struct PatientSenses {
  PlatformMotion platform;
  HarnessForce springs;  ///< as pushed on the platform; the body feels the opposite
  bool brakes_released{false};
  bool held{true};  ///< by a strap at least
};

class Patient {
 public:
  /// scenario must outlive the patient (rows of kScenarios do).
  Patient(const PatientParams& params, const Scenario& scenario);

  /// One millisecond.
  void step_1ms(const PatientSenses& senses);

  [[nodiscard]] const HarnessMotion& harness() const { return harness_; }
  [[nodiscard]] PatientState state() const { return state_; }
  /// The feet stick to the floor (freezing of gait), while the patient means to walk.
  [[nodiscard]] bool frozen() const { return !fallen() && uneven_.frozen(); }
  /// Arc length along the line that the patient has come to.
  [[nodiscard]] double progress_m() const { return progress_m_; }
  /// Weight borne by the harness: a large part when the legs give way.
  [[nodiscard]] double carried_n() const { return fallen() ? kCarried_norm * params_.mass_kg * kGravity_m_s2 : 0.0; }
  /// True once the straight line has been walked to its end.
  [[nodiscard]] bool arrived() const { return arrived_; }
  [[nodiscard]] const PatientParams& params() const { return params_; }
  [[nodiscard]] const Scenario& scenario() const { return *scenario_; }
  [[nodiscard]] const contract::ReferencePath& path() const { return path_; }

  /// Falls stiffly over its feet, toward this side: 0 forward over a caught foot, pi backward and +-pi/2 sideways over a slipped one.
  void trip(double toward_rad = 0.0) { fall(PatientState::tripping, toward_rad); }
  /// The legs give way, as in a faint, and the weight pulls toward this side.
  void collapse(double toward_rad = 0.0) { fall(PatientState::collapsing, toward_rad); }
  /// 0.163 m = 11.5 degrees on a strut of 0.8 m: past 10, short of the stop.
  static constexpr double kHang_m = 0.163;
  /// Hangs in the harness, this far forward of the middle, feet dragging, without a gait.
  void hang(double forward_m = kHang_m) {
    if (std::isfinite(forward_m) && !fallen()) hang_m_ = forward_m;
    fall(PatientState::hanging, 0.0);
  }
  /// The feet stick to the floor for this long.
  void freeze_feet(double seconds) { uneven_.freeze(seconds); }
  void set_wish(double wish_m_s) { params_.wish_m_s = wish_m_s; }
  /// Lets a test hold the pelvis turned (rad, left positive) while standing or walking instead of looking at the line.
  void hold_turn(double yaw_rad) { held_turn_rad_ = yaw_rad, holds_turn_ = true; }
  void release_turn() { holds_turn_ = false; }
  /// Helped back between the struts, standing upright.
  void stand_in_the_middle() {
    x_m_ = x_rate_m_s_ = y_m_ = y_rate_m_s_ = yaw_rad_ = yaw_rate_rad_s_ = 0.0;
    harness_ = {};
  }
  /// Back at the start mark with another scenario, standing.
  void restart(const Scenario& scenario);

 private:
  struct Memory {
    PlatformMotion platform;
    double spring_n{};
  };
  // One memory each 10 ms; the longest reaction that a patient may have.
  static constexpr std::size_t kMemories = 64;
  static constexpr int kThoughtTicks = 10;
  static constexpr double kCarried_norm = 0.4;  // assumed

  void think(const PatientSenses& senses);
  void decide(const PatientSenses& senses);
  void evaluate_leading(const PlatformMotion& now);
  void evaluate_trial(const PlatformMotion& now);
  void feel_answer(const PlatformMotion& now);
  void adapt(double answer_per_s2);
  void enter(PatientState state);
  void steer(const PlatformMotion& seen);
  void turn_along(const PlatformMotion& felt);
  void fall(PatientState how, double toward_rad);
  [[nodiscard]] double opposed_by(const PlatformMotion& now) const;
  [[nodiscard]] double fall_push_n(const PlatformMotion& platform);
  [[nodiscard]] double fall_aside_m_s2();
  [[nodiscard]] bool falls_aside() const { return fallen() && state_ != PatientState::hanging && fall_left_norm_ != 0.0; }
  [[nodiscard]] bool fallen() const { return state_ >= PatientState::tripping; }

  PatientParams params_;
  const Scenario* scenario_;
  contract::ReferencePath path_;
  PatientState state_{PatientState::standing};

  // The body against the platform, without the gait's sway.
  double x_m_{};
  double x_rate_m_s_{};
  double y_m_{};
  double y_rate_m_s_{};
  double yaw_rad_{};
  double yaw_rate_rad_s_{};
  HarnessMotion harness_;

  // Gait.
  UnevenGait uneven_;
  double phase_rad_{};
  double gait_norm_{};
  double gait_goal_norm_{};

  // Mind, at 100 Hz.
  std::array<Memory, kMemories> memories_{};
  std::size_t memory_at_{};
  int tick_{};
  double push_goal_m_s_{};   // speed the legs work for
  double compensation_n_{};  // spring force that the legs take over
  double yaw_goal_rad_{};
  double pace_m_s_{};  // wish, less in bends
  double progress_m_{};
  bool arrived_{false};
  double state_s_{};    // since the state began
  double ignored_s_{};  // how long a lean has been without effect
  double opposed_s_{};  // how long the hoist has done something else than it was led to
  double still_s_{};    // how long the platform has stood
  double begin_x_m_{};
  double begin_y_m_{};
  bool distrusts_{false};  // the hoist leads until the drives are off
  // What setting off has shown of this hoist; set by adapt().
  double reach_m_{};    // of each strut, for lean, turn and sway together
  double ease_norm_{};  // how fast bends are taken: 1 = as usual
  double fast_m_s_{};   // leaves room for a turn
  bool sets_off_{false};
  double set_off_s_{};
  double set_off_lean_m_s_{};  // lean x time since the hoist began to roll
  double trial_lean_m_{};      // in a trial: 0 once it is about standing upright again
  double trial_speed_m_s_{};   // fastest since then
  double hang_m_{kHang_m};
  double foot_ahead_m_{};  // of a stumbling patient: pelvis ahead of the foot that stays behind
  double foot_left_m_{};   // and to the left of it
  double fall_forward_norm_{1.0}, fall_left_norm_{};
  double held_turn_rad_{};
  bool holds_turn_{false};
};

}  // namespace hoist::sim
