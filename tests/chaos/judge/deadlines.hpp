// What the hoist must find, and by when: conditions of the true machine and patient, and of the frames that crossed the core's border, each with
// the alarms that answer it and its time. They hold whether one fault is active or five; what cannot be seen is excused by numbers, and only for
// as long as those numbers hold.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <deque>
#include <limits>
#include <string_view>
#include <utility>

#include "control/contract/faults.hpp"
#include "tests/chaos/judge/board.hpp"
#include "tests/chaos/judge/ears.hpp"
#include "tests/chaos/judge/seen.hpp"
#include "tests/chaos/judge/truth.hpp"

namespace hoist::chaos {

enum class Rule : std::uint8_t {
  silent_drive_left,
  silent_drive_right,
  silent_io,
  silent_tilt_left,
  silent_tilt_right,
  silent_tilt_base,
  bus_gone,
  two_of_one,
  flood,
  left_drive_fails,
  right_drive_fails,
  left_drive_drops,
  right_drive_drops,
  blind_encoder,
  nonsense,
  beyond_stops,
  stuck,
  invalid,
  wrong_lean,
  half_led,
  touched,
  falling,
  lying,
  leaning,
  dragged,
  rolls_away,
  lies_stopped,
  empty,
  high,
  weak,
  uneven,
  steep,
  sloping,
  no_commands,
  no_server,
  beside_command,
  runaway,
  late,
  chain_open,
  unpowered,
  over_voltage,
  slipping,
  unheard,
  zero_lost,
  count
};
inline constexpr std::size_t kRuleCount = static_cast<std::size_t>(Rule::count);

struct RuleInfo {
  Rule rule;
  std::string_view what;  // as the violation is reported
  double within_s;        // from the condition to the alarm
  contract::FaultBits answers;
  double braking_m_s2 = 0;    // when the time is over the wheels must be on their way to rest with this; 0: nothing has to stop
  bool rest_answers = false;  // a mode that does not move answers it, too
};
[[nodiscard]] const RuleInfo& rule_info(Rule rule);

/// What a kind of fault is judged by: the rules that it can bring about, or the invariants that must not notice it.
struct Judged {
  Kind kind;
  std::string_view by;
};
[[nodiscard]] const Judged& judged_by(Kind kind);

/// Sees when something that swings has come back by some distance from where it was farthest out, within some time.
class Swings {
 public:
  bool back(double left_m, double least_m, double within_s = std::numeric_limits<double>::infinity()) {
    const double out_m = to_left_ ? left_m : -left_m;
    now_s_ += 0.01;  // of a control step
    // Places that a later one has passed will never be the farthest again.
    while (!out_.empty() && out_.back().second <= out_m) out_.pop_back();
    while (!out_.empty() && now_s_ - out_.front().first > within_s) out_.pop_front();
    out_.emplace_back(now_s_, out_m);
    if (out_.front().second - out_m <= least_m) return false;
    to_left_ = !to_left_;
    took_s_ = now_s_ - out_.front().first;
    out_.assign(1, {now_s_, -out_m});
    return true;
  }
  /// From where it was farthest out until it had come back, the last time.
  [[nodiscard]] double took_s() const { return took_s_; }

 private:
  std::deque<std::pair<double, double>> out_;  // when, and how far out: farther and farther back in time
  double now_s_ = 0, took_s_ = 0;
  bool to_left_ = true;
};

class Deadlines {
 public:
  Deadlines(const sim::World& world, const Board& board, const Ears& ears) : world_(world), board_(board), ears_(ears) {}

  /// After a step of the world, with or without a core: what it did to the hoist.
  void see(const Truth& truth);
  /// After that, when the core ran: the rule that was broken in it, or Rule::count. `raised`: alarms told of in this step; one that was acknowledged
  /// in the step in which it was found was in force, too.
  [[nodiscard]] Rule after_step(const Told& told, const Truth& truth, contract::FaultBits raised);
  /// The rule whose time ended in this step and that demands rest; Rule::count for none. The one that brakes hardest.
  [[nodiscard]] Rule due() const { return due_; }
  /// I7: why no motion may begin now, by what has been so for long enough to be known; empty when nothing bars it.
  [[nodiscard]] std::string_view start_barred(contract::Mode to) const;
  /// A new core after a crash.
  void restart();
  /// A hold-to-run command reached the core that may act: with the time of the record that its client had seen; or a release.
  void held(double seen_s) { held_s_ = seen_s, holds_ = true; }
  void released() { holds_ = false; }
  /// The motion ends for another reason: its end was asked for, or its driver is signed out. Commands that then fail to come need no alarm of
  /// their own; the wheels have their time all the same.
  void ending() { ends_ = true; }
  /// The lease holder acknowledged: bumpers pressed now may be driven away from.
  void acknowledged() { acknowledged_bumpers_ = ears_.bumpers(); }

  /// A wheel turns although nothing of the hoist can hold it: by a force above what brakes or servo give, by a bridge that is shorted, or by a
  /// drive whose encoder or processor has just failed. `resting`: the drives may be off.
  [[nodiscard]] bool beyond_the_hoist(const Truth& truth) const;
  /// A wheel is held by something, or was until just now, or hands that pushed the hoist let it go: its drive pulls at it and gives way only then.
  [[nodiscard]] bool comes_free() const;
  /// Whether the true state explains a stop for this alarm: each limit a tenth laxer than the alarm's own.
  [[nodiscard]] bool explained(contract::Fault cause) const;
  /// The lean that the frames of the three sensors tell is the true one.
  [[nodiscard]] bool lean_told_rightly() const;
  [[nodiscard]] bool battery_told_rightly() const;
  /// Speed that a wheel at rest may show: see README.md.
  [[nodiscard]] static double rest_m_s(const Truth& truth);

 private:
  void take_frames(const Truth& truth);
  void take_runaway(const Truth& truth);
  void take_bars(const Truth& truth);
  [[nodiscard]] bool in_force(contract::Fault fault) const { return in_force_s_[contract::fault_info(fault).bit] >= judged_s_; }
  [[nodiscard]] bool holds(Rule rule, const Truth& truth, contract::Mode mode) const;
  [[nodiscard]] bool silent(contract::Node node) const;
  [[nodiscard]] bool believes_lost_zero() const;
  [[nodiscard]] bool dragged(const Truth& truth) const;
  [[nodiscard]] bool answered(const RuleInfo& rule, double since_s, contract::Mode mode) const;
  [[nodiscard]] bool sensors_heard() const;
  [[nodiscard]] bool drives_follow() const;
  [[nodiscard]] bool stuck(contract::Node node) const { return board_.now(Kind::sensor_stuck, node); }

  const sim::World& world_;
  const Board& board_;
  const Ears& ears_;
  std::array<double, kRuleCount> since_s_ = none();
  std::array<double, 64> in_force_s_ = never();  // when each alarm was last in force
  double judged_s_ = 0;                          // of steps that the core ran
  double seen_s_ = 0;                            // of steps of the world
  double held_s_ = -100;
  bool holds_ = false, ends_ = false;
  std::uint8_t acknowledged_bumpers_ = 0;
  // Memories of the truth.
  std::array<double, 2> battery_v_{};  // both together, and their difference: over a second
  bool battery_known_ = false;
  bool hands_ = false;  // push now
  double braked_s_ = -100, pushed_s_ = -100, frozen_s_ = -100, blocked_s_ = -100, short_s_ = -100, blind_s_ = -100, touch_s_ = -100,
         leant_s_ = -100, sloped_s_ = -100, twisted_s_ = -100, slid_s_ = -100, zero_s_ = -100, wrong_s_ = -100, let_go_s_ = -100,
         battery_wrong_s_ = -100, free_until_s_ = -100;
  std::array<bool, 2> bridge_on_{};
  double coast_m_s_ = 0;  // what a wheel may still turn after a push, or without supply
  bool cut_ = false;
  bool zero_off_ = false;
  bool throws_forward_ = false;
  Swings sways_, steps_, wide_steps_;  // of the bar sideways
  double swung_s_ = 0, widely_s_ = -100;
  // Rolling without a step. The alarm's own limits are 6 mm, 2 s and 0.1 m/s.
  double drawn_s_ = 0, stepless_s_ = -100;
  double follow_s_ = 0;                           // how long both drives have followed
  bool muted_ = false, muted_in_motion_ = false;  // the computer's heartbeat is lost
  double moving_s_ = 0;                           // how long the mode has been one that moves
  std::array<double, 2> dropped_s_{};
  enum Bar : std::size_t { touching, fresh_touch, chain, silent_node, blind_sensor, no_battery, turning, unchecked, kBarCount };
  std::array<double, kBarCount> barred_s_{};         // how long each has barred a start
  std::array<double, 2> away_s_{}, unfed_left_s_{};  // a wheel that runs away behind a shorted bridge
  contract::Mode mode_{contract::Mode::init};
  Rule due_ = Rule::count;

  static constexpr std::array<double, kRuleCount> none() {
    std::array<double, kRuleCount> all{};
    all.fill(-1.0);
    return all;
  }
  static constexpr std::array<double, 64> never() {
    std::array<double, 64> all{};
    all.fill(-1000.0);
    return all;
  }
};

/// The judge's own: modes in which the wheels may turn.
[[nodiscard]] constexpr bool moves(contract::Mode mode) {
  return mode == contract::Mode::user || mode == contract::Mode::remote || mode == contract::Mode::guided;
}

}  // namespace hoist::chaos
