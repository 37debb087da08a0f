// Impossible angles (H7) against their rule, written a second time from its description (control/core/monitor/tilt_implausible.hpp, still_strut.hpp,
// DECISIONS 159, details and signal of the fault): three tilt sensors that go anywhere, and two struts that swing by themselves.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/safety/monitor_bench.hpp"

namespace hoist::core::test {
namespace {

// Between two digits of the sensors, so that rounding never decides.
constexpr double kSteepest_deg = 18.5005, kFastest_deg_s = 200.05, kApart_deg = 4.0005, kTwisted_deg = 25.0005;

// In degrees and steps.
class ImplausibleRule {
 public:
  enum Cause { none, steep, fast, apart, twist, left_still, right_still };
  struct Verdict {
    bool fault;
    int code;
    Cause cause;
  };

  Verdict judge(const MonitorBench& at) {
    const Estimate& s = at.sensed;
    const std::array tilts{&s.left_strut, &s.right_strut, &s.base};
    const double left_forward = (s.left_strut.alpha_rad() - s.base.alpha_rad()) / kDeg;
    const double right_forward = (s.right_strut.alpha_rad() - s.base.alpha_rad()) / kDeg;
    const double left_aside = (s.left_strut.beta_rad() - s.base.beta_rad()) / kDeg;
    const double right_aside = (s.right_strut.beta_rad() - s.base.beta_rad()) / kDeg;
    double lean = 0, rate = 0;
    for (const double angle : {left_forward, right_forward, left_aside, right_aside, s.base.alpha_rad() / kDeg, s.base.beta_rad() / kDeg})
      lean = std::max(lean, std::fabs(angle));
    bool stale = false;
    for (const TiltSensor* tilt : tilts) {
      stale = stale || tilt->fresh().age_ticks() >= 3;
      if (tilt->fresh().age_ticks() > 0) continue;  // a rate is of this step or none
      rate = std::max({rate, std::fabs(tilt->alpha_rate_rad_s()) / kDeg, std::fabs(tilt->beta_rate_rad_s()) / kDeg});
    }
    const bool stay_apart = apart_.step(std::fabs(left_aside - right_aside) > kApart_deg) >= 10;
    const bool twisted = twisted_.step(std::fabs(left_forward - right_forward) > kTwisted_deg) >= 10;
    const bool swings_count = at.moving && std::fabs(s.odometry.speed_m_s) > 0.1 && !stale;
    left_.step(left_aside, swings_count);
    right_.step(right_aside, swings_count);
    const bool left_hangs = left_still_.step(left_.still_beside(right_)) >= 150;
    const bool right_hangs = right_still_.step(right_.still_beside(left_)) >= 150;
    // A limit of the angles tells more than a twist, and a twist more than a still strut.
    Cause cause = none;
    if (right_hangs) cause = right_still;
    if (left_hangs) cause = left_still;
    if (twisted) cause = twist;
    if (stay_apart) cause = apart;
    if (rate > kFastest_deg_s) cause = fast;
    if (lean > kSteepest_deg) cause = steep;
    const int code = cause == twist ? 1 : cause == left_still ? 2 : cause == right_still ? 3 : 0;
    // The impact of a fall excuses what begins with it.
    const bool excused =
        (at.latched & contract::fault_bit(Fault::fall_detected)) != 0 && (at.latched & contract::fault_bit(Fault::tilt_implausible)) == 0;
    return {cause != none && at.mode != Mode::init && !excused, code, cause};
  }

 private:
  // How far a strut swings about where it has been in the last two seconds: mean square over one second.
  struct Swing {
    double mean = 0, square = 0;
    void step(double aside, bool counts) {
      if (!counts) mean = aside, square = 0;
      mean += (aside - mean) / 201;
      square += ((aside - mean) * (aside - mean) - square) / 101;
    }
    // Half a degree of the twin, a tenth of its mean square.
    [[nodiscard]] bool still_beside(const Swing& twin) const { return twin.square > 0.25 && square < twin.square / 10; }
  };

  Streak apart_, twisted_, left_still_, right_still_;
  Swing left_, right_;
};

// Places of the struts against the floor and of the chassis.
struct Place {
  double left_forward_deg, left_aside_deg, right_forward_deg, right_aside_deg, base_forward_deg, base_aside_deg;
};

const std::vector<Place> kPlaces =
    {
        {0, 0, 0, 0, 0, 0},          {0, 0, 0, 0, 0, 0},        {0, 0, 0, 0, 0, 0},
        {18.8, 0, 0, 0, 0, 0},  // beyond the stops: each angle of each strut, below it, and of the chassis
        {0, 18.8, 0, 18.2, 0, 0},    {0, 0, -18.8, 0, 0, 0},    {0, -18.2, 0, -18.8, 0, 0},
        {18.2, 0, 18.2, 18.2, 0, 0}, {18, 0, 18, 0, 18.8, 0},   {0, -18, 0, -18, 0, -18.8},
        {6, 0, 6, 0, -12.8, 0},      {0, 6, 0, 6, 0, -12.8},    {12.7, 0, -12.7, 0, 0, 0},  // the struts twisted, nearly and more
        {-12.7, 0, 12.7, 0, 0, 0},   {12.3, 0, -12.3, 0, 0, 0}, {0, 2.1, 0, -2.1, 0, 0},    // and apart
        {0, -2.1, 0, 2.1, 0, 0},     {0, 1.9, 0, -1.9, 0, 0},   {0, 3, 0, 0, 0, 2},
};

class H7Patient {
 public:
  H7Patient(Random& random, bool goes_anywhere) : random_(random), goes_anywhere_(goes_anywhere) {}

  void step(MonitorBench& bench) {
    const Place& to = kPlaces[place_.step()];
    const bool turns = twisted_.step();
    const double pace_deg = pace_deg_.step(), size_left_deg = left_deg_.step(), size_right_deg = right_deg_.step();
    phase_ += 6.2832 / stride_ticks_.step();
    std::array<double, 6> goal{to.left_forward_deg, to.left_aside_deg,   to.right_forward_deg,
                               to.right_aside_deg,  to.base_forward_deg, to.base_aside_deg};
    if (!goes_anywhere_) goal = {turns ? 13.0 : 0.0, 0, turns ? -13.0 : 0.0, 0, 0, 0};
    for (std::size_t k = 0; k < 6; ++k) at_deg_[k] += std::clamp(goal[k] - at_deg_[k], -pace_deg, pace_deg);
    const double swing = goes_anywhere_ ? 0 : std::sin(phase_), floor_deg = goes_anywhere_ ? 0 : 0.3 * std::sin(0.37 * phase_);
    const std::array forward_deg{at_deg_[0], at_deg_[2], at_deg_[4]};
    const std::array aside_deg{at_deg_[1] + size_left_deg * swing + floor_deg, at_deg_[3] + size_right_deg * swing + floor_deg,
                               at_deg_[5] + floor_deg};
    const std::array tilts{&bench.sensed.left_strut, &bench.sensed.right_strut, &bench.sensed.base};
    ++counter_;
    for (std::size_t k = 0; k < 3; ++k) {
      tilts[k]->next_tick();
      if (silent_ticks_[k] == 0 && random_.once_in(goes_anywhere_ ? 60 : 900)) silent_ticks_[k] = 1 + random_.below(4);
      if (silent_ticks_[k] > 0) {
        --silent_ticks_[k];
        continue;
      }
      send_angles(*tilts[k], {.alpha_deg = forward_deg[k], .beta_deg = aside_deg[k], .counter = counter_});
    }
  }

 private:
  static std::vector<std::size_t> each_place() {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < kPlaces.size(); ++i) all.push_back(i);
    return all;
  }

  Random& random_;
  bool goes_anywhere_;
  Spells<std::size_t> place_{random_, 40, each_place()};
  Spells<double> pace_deg_{random_, 60, {1.9, 1.9, 1.9, 0.4, 2.1}};  // 2 degrees in a step are 200 a second
  Spells<bool> twisted_{random_, 60, {false, false, false, false, false, false, true}};
  Spells<double> left_deg_{random_, 500, {0, 0.2, 0.65, 0.75, 1.2, 1.6}}, right_deg_{random_, 500, {0, 0.2, 0.65, 0.75, 1.2, 1.6}};
  Spells<double> stride_ticks_{random_, 600, {90, 110, 170}};
  std::array<double, 6> at_deg_{};
  std::array<std::uint32_t, 3> silent_ticks_{};
  double phase_ = 0;
  std::uint8_t counter_ = 0;
};

class ImplausibleRuleTest : public ::testing::Test {
 protected:
  void judge(unsigned seed, bool goes_anywhere) {
    SCOPED_TRACE(seed);
    Random random(seed);
    MonitorBench bench;
    bench.params.tilt_rad_max = kSteepest_deg * kDeg;
    bench.params.tilt_rate_rad_s_max = kFastest_deg_s * kDeg;
    bench.params.strut_apart_rad_max = kApart_deg * kDeg;
    bench.params.strut_twist_rad_max = kTwisted_deg * kDeg;
    H7Patient patient(random, goes_anywhere);
    TiltImplausible monitor;
    ImplausibleRule rule;
    Spells<Mode> mode(random, 300, {Mode::user, Mode::remote, Mode::guided, Mode::standby, Mode::init});
    Spells<bool> moving(random, 900, {true, true, true, true, false});
    Spells<double> speed_m_s(random, 900, {0.3, 0.11, -0.2, 0.3, 0.09, 0});
    constexpr contract::FaultBits kFall = contract::fault_bit(Fault::fall_detected), kOwn = contract::fault_bit(Fault::tilt_implausible),
                                  kAnother = contract::fault_bit(Fault::io_lost);
    Spells<contract::FaultBits> latched(random, 100, {0, 0, kAnother, kOwn, kFall, kFall | kAnother, kFall | kOwn});
    for (int i = 0; i < 2000; ++i) {
      patient.step(bench);
      bench.mode = mode.step();
      bench.moving = moving.step();
      bench.sensed.odometry.speed_m_s = speed_m_s.step();
      bench.latched = latched.step();
      const ImplausibleRule::Verdict expected = rule.judge(bench);
      ASSERT_EQ(monitor.check(bench.view()), expected.fault) << i << ", cause " << expected.cause;
      ASSERT_EQ(int{monitor.code()}, expected.code) << i << ", cause " << expected.cause;
      faults_[expected.cause] += expected.fault ? 1 : 0;
      excused_ += expected.cause != ImplausibleRule::none && !expected.fault && bench.mode != Mode::init ? 1 : 0;
    }
  }

  std::array<int, 7> faults_{};
  int excused_ = 0;
};

TEST_F(ImplausibleRuleTest, H7EachStepOfThreeSensorsThatGoAnywhereIsJudgedByTheRule) {
  for (unsigned seed = 1; seed <= 8; ++seed) ASSERT_NO_FATAL_FAILURE(judge(seed, true));
  for (const auto cause : {ImplausibleRule::steep, ImplausibleRule::fast, ImplausibleRule::apart, ImplausibleRule::twist})
    EXPECT_GT(faults_[cause], 100) << cause;
  EXPECT_GT(excused_, 100);
}

TEST_F(ImplausibleRuleTest, H7EachStepOfTwoStrutsThatSwingByThemselvesIsJudgedByTheRule) {
  for (unsigned seed = 1; seed <= 24; ++seed) ASSERT_NO_FATAL_FAILURE(judge(seed, false));
  for (const auto cause : {ImplausibleRule::twist, ImplausibleRule::left_still, ImplausibleRule::right_still})
    EXPECT_GT(faults_[cause], 100) << cause;
  EXPECT_GT(excused_, 100);
}

}  // namespace
}  // namespace hoist::core::test
