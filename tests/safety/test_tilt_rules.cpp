// The monitors of the tilt sensors and of the hanging patient against their rules (monitor_bench.hpp).
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "tests/safety/monitor_bench.hpp"

namespace hoist::core::test {
namespace {

// ----- patient_hanging

constexpr int kSwingTicks = 80;    // a step is back within these
constexpr int kLoadedTicks = 100;  // how long the hoist must be loaded

class HangingRule {
 public:
  HangingRule(int lean_ticks, int still_ticks) : lean_ticks_(lean_ticks), still_ticks_(still_ticks) {}

  /// How often each clause decided, over a whole run.
  struct Cases {
    int leaning = 0;    // ticks: the lean alone raises the alarm
    int drawn = 0;      // alarms whose drawn time was reached last
    int loaded = 0;     // alarms whose loaded time was reached last
    int unloaded = 0;   // ticks: drawn long enough, not loaded long enough
    int late_step = 0;  // steps that took nearly kSwingTicks
    int drifted = 0;    // ticks: as far as a step, but too slowly
    int went_on = 0;    // ticks: as far as a step, but the way of the last one
    int same_way = 0;   // steps to the side of the last one, after a turn
  };
  [[nodiscard]] const Cases& cases() const { return cases_; }

  bool hangs(const MonitorBench& at, bool alarm) {
    const auto mean_deg = [](double left_rad, double right_rad, double base_rad) {
      return (left_rad + right_rad - 2 * base_rad) / 2 / kDeg;
    };
    const Estimate& sensed = at.sensed;
    const double forward_deg = mean_deg(sensed.left_strut.alpha_rad(), sensed.right_strut.alpha_rad(), sensed.base.alpha_rad());
    const double right_deg = mean_deg(sensed.left_strut.beta_rad(), sensed.right_strut.beta_rad(), sensed.base.beta_rad());
    const double lean_deg = std::hypot(forward_deg, right_deg);
    const int age =
        std::max({sensed.left_strut.fresh().age_ticks(), sensed.right_strut.fresh().age_ticks(), sensed.base.fresh().age_ticks()});
    const bool known = age < 3;
    const bool waits = at.held_back && sensed.odometry.standing_still;
    const bool stepped = known && swings(at.params.strut_length_m * right_deg * kDeg, at.params.hang_sway_m, waits ? 0 : 1);
    const bool rolling = std::fabs(sensed.odometry.speed_m_s) > at.params.hang_speed_m_s || at.held_back;
    const bool is_loaded = at.mode == Mode::user || lean_deg > 0.0524 / kDeg;
    const double limit_deg = at.params.hang_tilt_rad / kDeg;
    leans_.step(at.moving && known && lean_deg > limit_deg);
    const bool is_drawn = at.moving && known && (waits || (rolling && !stepped));
    drawn_.step(is_drawn);
    loaded_.step(is_drawn && is_loaded);
    upright_s_ = !at.moving && known && lean_deg <= limit_deg / 2 ? upright_s_ + kTick_s : 0;
    const bool leaning = leans_.ticks >= lean_ticks_;
    const bool dragged = drawn_.ticks >= still_ticks_ && loaded_.ticks >= kLoadedTicks;
    if (!alarm) count(leaning, dragged);
    return (alarm && upright_s_ < 5) || leaning || dragged;
  }

 private:
  /// So far to one side within kSwingTicks outside of waits; twice to the same side only with a turn of half as much between. The ticks since the
  /// last swing are taken ten at a time: of this ten and the seven before it each place counts.
  bool swings(double side_m, double least_m, int ticks) {
    swing_ticks_ += ticks;
    places_.emplace_back(swing_ticks_ / 10, side_m);
    double right_m = 0, left_m = 0, drift_m = 0, back_m = 0;
    bool late = false;
    for (const auto& [ten, place_m] : places_) {
      const double way_m = side_m - place_m;
      back_m = std::max(back_m, to_right_ ? -way_m : way_m);
      drift_m = std::max(drift_m, std::fabs(way_m));
      if (ten <= swing_ticks_ / 10 - kSwingTicks / 10) continue;
      late = late || (std::fabs(way_m) >= least_m && ten <= swing_ticks_ / 10 - kSwingTicks / 10 + 1);
      right_m = std::max(right_m, way_m);
      left_m = std::max(left_m, -way_m);
    }
    turned_ = turned_ || back_m >= least_m / 2;
    const bool right = right_m >= least_m && (turned_ || !to_right_), left = left_m >= least_m && (turned_ || to_right_);
    if (drift_m >= least_m && std::max(right_m, left_m) < least_m) ++cases_.drifted;
    if (std::max(right_m, left_m) >= least_m && !right && !left) ++cases_.went_on;
    if (!right && !left) return false;
    if (right == to_right_ && swung_) ++cases_.same_way;
    if (late) ++cases_.late_step;
    swung_ = true;
    to_right_ = right;
    turned_ = false;
    places_.assign(1, {0, side_m});
    swing_ticks_ = 0;
    return true;
  }

  void count(bool leaning, bool dragged) {
    cases_.leaning += leaning && !dragged ? 1 : 0;
    cases_.drawn += dragged && drawn_.ticks == still_ticks_ ? 1 : 0;
    cases_.loaded += dragged && loaded_.ticks == kLoadedTicks ? 1 : 0;
    cases_.unloaded += drawn_.ticks >= still_ticks_ && !dragged ? 1 : 0;
  }

  int lean_ticks_, still_ticks_;
  Streak leans_, drawn_, loaded_;
  double upright_s_ = 0;
  bool turned_ = true, swung_ = false;
  int swing_ticks_ = 0;                                   // since the swing began, without waits
  std::vector<std::pair<int, double>> places_{{0, 0.0}};  // in which ten ticks, where
  bool to_right_ = true;
  Cases cases_;
};

// Where the patient leans, how the harness sways, and what the sensors make of it.
class SwayingPatient {
 public:
  explicit SwayingPatient(Random& random) : random_(random) {}

  void step(MonitorBench& bench, bool upright) {
    const double lean_deg = forward_deg_.step(), aside_deg = aside_deg_.step(), sway_deg = sway_deg_.step();
    const double twist_deg = twist_deg_.step(), base_deg = base_deg_.step();
    phase_ += 2 * std::numbers::pi / period_ticks_.step();
    drift_deg_ += drift_deg_per_tick_.step();
    if (std::fabs(drift_deg_) > 2) drift_deg_ = 0;
    const double forward_deg = upright ? lean_deg / 3 : lean_deg;
    const double right_deg = (upright ? aside_deg / 3 : aside_deg) + drift_deg_ + sway_deg * std::sin(phase_);
    const double noise_deg = 0.001 * random_.below(10);
    ++counter_;
    angles(bench.sensed.left_strut, 0, {forward_deg + base_deg + twist_deg + noise_deg, right_deg - base_deg + twist_deg / 2});
    angles(bench.sensed.right_strut, 1, {forward_deg + base_deg - twist_deg, right_deg - base_deg - twist_deg / 2});
    angles(bench.sensed.base, 2, {base_deg, -base_deg});
  }

 private:
  void angles(TiltSensor& sensor, std::size_t number, TiltSample sample) {
    sensor.next_tick();
    sample.counter = counter_;
    if (silent_ticks_[number] == 0 && random_.once_in(2500)) silent_ticks_[number] = 1 + random_.below(12);
    if (silent_ticks_[number] == 0) return send_angles(sensor, sample);
    --silent_ticks_[number];
  }

  Random& random_;
  Spells<double> forward_deg_{random_, 300, {0, 0, 2, 2, 2.97, 3.03, 4, 4, 7, 12, -4, -12}};
  Spells<double> aside_deg_{random_, 400, {0, 0, 0, 0, 0, 2, -7.5}};
  Spells<double> sway_deg_{random_, 500, {0, 0, 0, 0.1, 0.2, 0.35, 0.6}};
  Spells<double> period_ticks_{random_, 500, {60, 120, 300, 350, 400, 900}};
  // 6 mm at 0.8 m are 0.4297 degrees: a drift that comes back so far in just the time of a step, and one that needs a tick more.
  static constexpr double kInTime_deg = 0.4302 / kSwingTicks, kTooSlow_deg = 0.4302 / (kSwingTicks + 1);
  // The harness never stands: of two equal places, rounding would decide which is the farthest.
  Spells<double> drift_deg_per_tick_{
      random_, 300, {0.002, -0.002, 0.002, -0.002, kTooSlow_deg, -kTooSlow_deg, kInTime_deg, -kInTime_deg, 0.006, -0.006}};
  Spells<double> twist_deg_{random_, 200, {0, 5, -8}};
  Spells<double> base_deg_{random_, 300, {0, 0, 1.5, -2}};
  std::array<std::uint32_t, 3> silent_ticks_{};
  double phase_ = 0, drift_deg_ = 0;
  std::uint8_t counter_ = 0;
};

TEST(HangingRule, H16EachStepOfARandomPatientIsJudgedByTheRule) {
  int ended = 0;
  HangingRule::Cases all;
  for (unsigned seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    const int lean_ticks = 60 + static_cast<int>(random.below(60)), still_ticks = 150 + static_cast<int>(random.below(50));
    bench.params.hang_tilt_s = about_steps_s(random, lean_ticks);
    bench.params.hang_still_s = about_steps_s(random, still_ticks);
    PatientHanging monitor;
    HangingRule rule(lean_ticks, still_ticks);
    SwayingPatient patient(random);
    Spells<Mode> mode(random, 600, {Mode::user, Mode::remote, Mode::remote, Mode::guided});
    Spells<bool> resting(random, 1200, {false, true}), moving(random, 700, {true, true, true, false}),
        held_back(random, 400, {false, false, true});
    Spells<double> speed_m_s(random, 400, {0.3, 0.3, 0.15, 0.15, -0.2, 0.06, 0, 0});
    bool alarm = false;
    for (int i = 0; i < 5000; ++i) {
      SCOPED_TRACE(i);
      const bool rests = resting.step();
      patient.step(bench, rests);
      bench.mode = mode.step();
      bench.moving = moving.step() && !rests;
      bench.held_back = held_back.step();
      bench.sensed.odometry.speed_m_s = speed_m_s.step();
      bench.sensed.odometry.standing_still = std::fabs(bench.sensed.odometry.speed_m_s) < kStandstill_m_s;
      bench.latched = contract::fault_bit(Fault::io_lost) | (alarm ? contract::fault_bit(Fault::patient_hanging) : 0);
      const bool expected = rule.hangs(bench, alarm);
      ASSERT_EQ(monitor.check(bench.view()), expected);
      ended += !expected && alarm ? 1 : 0;
      alarm = expected && !random.once_in(400);
    }
    const HangingRule::Cases& cases = rule.cases();
    all.leaning += cases.leaning;
    all.drawn += cases.drawn;
    all.loaded += cases.loaded;
    all.unloaded += cases.unloaded;
    all.late_step += cases.late_step;
    all.drifted += cases.drifted;
    all.went_on += cases.went_on;
    all.same_way += cases.same_way;
  }
  EXPECT_GT(all.leaning, 20);
  EXPECT_GT(all.drawn, 20);
  EXPECT_GT(all.loaded, 10);
  EXPECT_GT(all.unloaded, 1000);
  EXPECT_GT(all.late_step, 20);
  EXPECT_GT(all.drifted, 100);
  EXPECT_GT(all.went_on, 100);
  EXPECT_GT(all.same_way, 20);
  EXPECT_GT(ended, 5);
}

// ----- tilt_sensor_fault

class SensorFaultRule {
 public:
  /// `turn_deg_s`: of the chassis, as far as it is known; `spun`: it is faster than a hoist turns, and the wheels do not deny it.
  bool faulty(const TiltSensor& tilt, const TiltSample& sent, double turn_deg_s, bool spun, double limit_deg, const TiltRates* rates) {
    if (rates != nullptr && !spun) {
      pitch_deg_ += (rates->pitch_deg_s - turn_deg_s * std::sin(sent.beta_deg * kDeg)) * kTick_s;
      roll_deg_ += (rates->roll_deg_s + turn_deg_s * std::sin(sent.alpha_deg * kDeg)) * kTick_s;
    }
    pitch_deg_ *= 0.999;  // a memory of ten seconds
    roll_deg_ *= 0.999;
    const bool drifts = std::max(std::fabs(pitch_deg_), std::fabs(roll_deg_)) > limit_deg;
    if (tilt.heard().age_ticks() >= 5) {
      bad_ticks_ = 0;
      return drifts;
    }
    const bool useless = (sent.status & 1) == 0 || (sent.status & 8) != 0;
    if (useless) {
      bad_ticks_ = std::min(bad_ticks_ + 1, 5);
    } else if (tilt.fresh().age_ticks() == 0) {
      bad_ticks_ = 0;
    }
    return drifts || bad_ticks_ == 5 || (sent.status & 16) != 0;
  }

 private:
  double pitch_deg_ = 0, roll_deg_ = 0;
  int bad_ticks_ = 0;
};

// A tilt sensor that is silent, repeats itself, and marks its samples, for a while each.
struct FitfulTilt {
  explicit FitfulTilt(Random& random)
      : silent(random, 9, {false, false, false, false, true}),
        repeats(random, 8, {false, false, false, true}),
        status(random, 8, {3, 3, 3, 3, 1, 2, 11, 7, 9}),
        alpha_deg(random, 300, {0, 10, -8}),
        beta_deg(random, 300, {0, 6, -5}) {}

  /// One step of its angles; `sent` is the last frame that said anything.
  void step(TiltSensor& sensor, bool self_test_failed, TiltZero zero) {
    sensor.next_tick();
    const TiltSample next{alpha_deg.step(), beta_deg.step(), static_cast<std::uint8_t>(status.step() | (self_test_failed ? 16 : 0)),
                          static_cast<std::uint8_t>(sent.counter + (repeats.step() ? 0 : 1))};
    if (silent.step()) return;
    // Neither an invalid nor a repeated sample brings angles.
    const bool fresh = (next.status & 1) != 0 && (next.counter != counter_taken || !known);
    if (fresh) {
      counter_taken = next.counter;
      known = true;
      sent = next;
    }
    sent.status = next.status;
    sent.counter = next.counter;
    send_angles(sensor, next, zero);
  }

  Spells<bool> silent, repeats;
  Spells<std::uint8_t> status;
  Spells<double> alpha_deg, beta_deg;
  TiltSample sent{.status = 0};
  std::uint8_t counter_taken = 0;
  bool known = false;
};

TEST(SensorFaultRule, H8EachStepOfThreeRandomSensorsIsJudgedByTheRule) {
  int found = 0;
  for (unsigned seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    bench.params.drift_rad_max = 0.27;
    TiltSensorFault monitor;
    std::array<SensorFaultRule, 3> rules;
    std::array<FitfulTilt, 3> tilts{FitfulTilt(random), FitfulTilt(random), FitfulTilt(random)};
    const std::array sensors{&bench.sensed.left_strut, &bench.sensed.right_strut, &bench.sensed.base};
    Spells<Mode> mode(random, 400, {Mode::user, Mode::remote, Mode::standby, Mode::init});
    Spells<double> turn_deg_s(random, 300, {0, 0, 30, -34, 57, -57, 57.5, -57.5});
    Spells<bool> turn_silent(random, 60, {false, false, true}), drive_silent(random, 200, {false, false, true});
    Spells<double> wheels_deg_s(random, 200, {0, 28, -28, 29, -29, 58});
    // Of one sensor only, so that each is found by itself.
    Spells<double> pitch_deg_s(random, 300, {0, 0, 12, -12}), roll_deg_s(random, 300, {0, 0, 12, -12});
    Spells<bool> sends_rates(random, 300, {true, true, true, false});
    Spells<int> failed(random, 100, {-1, -1, -1, -1, -1, -1, 0, 1, 2});
    const std::size_t drifting = seed % 3;
    double turn_known_deg_s = 0;
    for (int i = 0; i < 2000; ++i) {
      SCOPED_TRACE(i);
      bench.mode = mode.step();
      const int fails = failed.step();
      std::array<TiltRates, 3> rates{};
      std::array<bool, 3> has_rates{};
      rates[drifting] = {0, pitch_deg_s.step(), roll_deg_s.step()};
      has_rates[drifting] = sends_rates.step();
      rates[2].yaw_deg_s = turn_deg_s.step();
      has_rates[2] = !turn_silent.step();
      for (std::size_t k = 0; k < 3; ++k) {
        // A zero that is taken off changes nothing here.
        tilts[k].step(*sensors[k], fails == static_cast<int>(k), {0.05, -0.05});
        if (has_rates[k]) send_rates(*sensors[k], rates[k]);
      }
      const bool deaf = drive_silent.step();
      for (DriveSensor* drive : {&bench.sensed.left_drive, &bench.sensed.right_drive}) {
        drive->next_tick();
        if (drive != &bench.sensed.left_drive || !deaf) send_state(*drive, 0, 0);
      }
      bench.sensed.odometry.yaw_rate_rad_s = wheels_deg_s.step() * kDeg;
      if (has_rates[2]) turn_known_deg_s = rates[2].yaw_deg_s;
      const double turn = bench.sensed.base.rates_fresh().age_ticks() < 5 ? turn_known_deg_s : 0;
      const bool wheels_agree = bench.sensed.left_drive.fresh().age_ticks() >= 5 || std::fabs(bench.sensed.odometry.yaw_rate_rad_s) > 0.5;
      const bool spun = std::fabs(turn) > 57.3 && wheels_agree;
      bool expected = false;
      for (std::size_t k = 0; k < 3; ++k) {
        const bool bad = rules[k].faulty(*sensors[k], tilts[k].sent, turn, spun, 0.27 / kDeg, has_rates[k] ? &rates[k] : nullptr);
        expected = expected || bad;
      }
      expected = expected && bench.mode != Mode::init;
      ASSERT_EQ(monitor.check(bench.view()), expected);
      found += expected ? 1 : 0;
    }
  }
  EXPECT_GT(found, 1000);
}

// ----- tilt_frozen

class FrozenRule {
 public:
  bool frozen(const MonitorBench& at) {
    const Estimate& s = at.sensed;
    const std::array<double, 4> now{s.left_strut.alpha_rad(), s.right_strut.alpha_rad(), s.left_strut.beta_rad(), s.right_strut.beta_rad()};
    const bool rolling = std::max(std::fabs(s.odometry.wheel_left_m_s), std::fabs(s.odometry.wheel_right_m_s)) > 0.1;
    const bool both_new = s.left_strut.fresh().age_ticks() == 0 && s.right_strut.fresh().age_ticks() == 0;
    equal_.step(now == before_ && rolling && both_new);
    before_ = now;
    bool stands = equal_.ticks >= 30;
    for (const TiltSensor* tilt : {&s.left_strut, &s.right_strut, &s.base}) {
      if (tilt->heard().age_ticks() >= 5) continue;
      stands = stands || tilt->repeated_frames() >= 3 || (tilt->has(tilt_status::kValid) && tilt->same_rates() >= 20);
    }
    const int left = s.left_strut.lively_samples(), right = s.right_strut.lively_samples();
    // A stuck chip's twin has 15 lively samples of thirty, and two more for each that the chip has.
    constexpr std::array kTwinOf{15, 17, 19, 21, 23, 25, 27, 29};
    const auto glides = [&](int own, int twin) { return own >= 0 && own < 8 && twin >= kTwinOf[static_cast<std::size_t>(own)]; };
    if (rolling && both_new && (glides(left, right) || glides(right, left))) stands = true;
    return stands && at.mode != Mode::init;
  }

 private:
  std::array<double, 4> before_{};
  Streak equal_;
};

// An angle that stands, changes its last digit, or changes its course in so many of a hundred samples.
class Course {
 public:
  explicit Course(Random& random)
      : random_(random), bends_percent_(random, 90, {0, 0, 3, 8, 50, 65, 95}), digit_(random, 50, {0, 0, 0, 1}) {}
  double step_deg() {
    const bool bends = random_.below(100) < bends_percent_.step();
    if (bends) slope_ = slope_ > 0 ? -3 - static_cast<int>(random_.below(4)) : 3 + static_cast<int>(random_.below(4));
    if (std::abs(at_) > 9000) slope_ = at_ > 0 ? -3 : 3;
    at_ += slope_;
    if (bends_percent_.step() == 0 && random_.once_in(30)) slope_ = 0;
    flips_ = !flips_;
    return (at_ + (flips_ ? digit_.step() : 0)) / 1000.0;
  }

 private:
  Random& random_;
  Spells<std::uint32_t> bends_percent_;
  Spells<int> digit_;
  int at_ = 0, slope_ = 0;
  bool flips_ = false;
};

TEST(FrozenRule, H6EachStepOfThreeRandomSensorsIsJudgedByTheRule) {
  int found = 0;
  for (unsigned seed = 1; seed <= 80; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    TiltFrozen monitor;
    FrozenRule rule;
    const std::array sensors{&bench.sensed.left_strut, &bench.sensed.right_strut, &bench.sensed.base};
    std::array<Course, 6> courses{Course(random), Course(random), Course(random), Course(random), Course(random), Course(random)};
    const auto spells = [&random](std::uint32_t ticks, std::vector<bool> values) { return Spells<bool>(random, ticks, std::move(values)); };
    std::array silent{spells(7, {false, false, false, false, false, false, false, false, true}),
                      spells(7, {false, false, false, false, false, false, false, false, true}), spells(7, {false, false, false, true})};
    std::array repeats{spells(6, {false, false, false, false, false, false, false, true}),
                       spells(6, {false, false, false, false, false, false, false, true}), spells(6, {false, false, false, true})};
    std::array same_rates{spells(30, {false, false, true}), spells(30, {false, false, true}), spells(30, {false, true})};
    std::array status{Spells<std::uint8_t>(random, 80, {3, 3, 1}), Spells<std::uint8_t>(random, 80, {3, 3, 1, 2}),
                      Spells<std::uint8_t>(random, 80, {3, 1, 2})};
    // In some runs nothing is missing, so that the slow rules come to their end.
    const bool steady = seed % 2 == 0;
    // All angles of the struts stand for a while, but perhaps the last digit of one.
    Spells<bool> stand(random, 90, {false, false, true});
    Spells<std::size_t> still_moves(random, 45, {9, 9, 0, 1, 2, 3});
    std::array<double, 6> angles_deg{};
    std::array<std::uint8_t, 3> counters{};
    Spells<Mode> mode(random, 300, {Mode::user, Mode::remote, Mode::init});
    Spells<double> left_m_s(random, 120, {0.3, 0.12, 0.07, -0.15, 0}), right_m_s(random, 120, {0.3, 0.12, 0.07, -0.15, 0});
    for (int i = 0; i < 1500; ++i) {
      SCOPED_TRACE(i);
      bench.mode = mode.step();
      bench.sensed.odometry.wheel_left_m_s = left_m_s.step();
      bench.sensed.odometry.wheel_right_m_s = right_m_s.step();
      const bool stands = stand.step();
      const std::size_t moves = still_moves.step();
      for (std::size_t a = 0; a < 6; ++a) {
        if (!stands) angles_deg[a] = courses[a].step_deg();
        if (stands && a == moves) angles_deg[a] += i % 2 == 0 ? 0.001 : -0.001;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        sensors[k]->next_tick();
        const bool same = same_rates[k].step();
        send_rates(*sensors[k], {same && !steady ? 0.0 : 0.01 * (i % 2), 0, 0});
        const bool gone = silent[k].step(), again = repeats[k].step();
        const std::uint8_t marks = status[k].step();
        if (!steady && gone) continue;
        if (steady || !again) ++counters[k];
        send_angles(*sensors[k], {angles_deg[2 * k], angles_deg[2 * k + 1], steady ? std::uint8_t{3} : marks, counters[k]});
      }
      const bool expected = rule.frozen(bench);
      ASSERT_EQ(monitor.check(bench.view()), expected);
      found += expected ? 1 : 0;
    }
  }
  EXPECT_GT(found, 1000);
}

// ----- base_tilt_high, base_tilted

TEST(BaseTiltRule, H9EachStepOfARandomFloorIsJudgedByTheRule) {
  int slopes = 0, steep = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    BaseTiltHigh high;
    BaseTilted tilted;
    Streak high_for, tilted_for;
    Spells<double> alpha_deg(random, 25, {0, 3, 4.5, 5.2, 6, 7, -8.5}), beta_deg(random, 25, {0, 0, 2, -3, -5.5});
    Spells<bool> silent(random, 12, {false, false, false, false, true});
    Spells<Mode> mode(random, 300, {Mode::user, Mode::standby, Mode::init});
    bool slow = false;
    std::uint8_t counter = 0;
    for (int i = 0; i < 1500; ++i) {
      SCOPED_TRACE(i);
      TiltSensor& base = bench.sensed.base;
      base.next_tick();
      const TiltSample sample{alpha_deg.step(), beta_deg.step(), 3, ++counter};
      if (!silent.step()) send_angles(base, sample);
      bench.mode = mode.step();
      const double lean_deg = base.fresh().age_ticks() >= 5 ? 0 : std::hypot(base.alpha_rad(), base.beta_rad()) / kDeg;
      // 5 degrees for 100 ms, and until one degree less; 8 degrees for 100 ms.
      slow = high_for.step(lean_deg > (slow ? 4.0 : 5.0)) >= 10;
      const bool stop = tilted_for.step(lean_deg > 8.0) >= 10, judged = bench.mode != Mode::init;
      ASSERT_EQ(high.check(bench.view()), slow && judged);
      ASSERT_EQ(tilted.check(bench.view()), stop && judged);
      slopes += slow ? 1 : 0;
      steep += stop ? 1 : 0;
    }
  }
  EXPECT_GT(slopes, 100);
  EXPECT_GT(steep, 100);
}

}  // namespace
}  // namespace hoist::core::test
