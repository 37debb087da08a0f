// The patient alone, on a platform that the test moves.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "firmware/sim/patient.hpp"
#include "firmware/sim/patient_family.hpp"
#include "firmware/sim/plant.hpp"

namespace hoist::sim {
namespace {

// A platform that follows the lean perfectly, or does what the test says, with the real springs.
class Stage {
 public:
  explicit Stage(std::string_view scenario = "straight", const PatientParams& params = {})
      : patient(params, *find_scenario(scenario)), springs_({}, 1) {
    const contract::PathPose start = patient.path().pose(0.0);
    platform.x_m = start.x_m;
    platform.y_m = start.y_m;
    platform.psi_rad = start.psi_rad;
  }
  void run(double seconds) {
    const int ticks = static_cast<int>(std::lround(seconds * 1000.0));
    for (int i = 0; i < ticks; ++i) {
      patient.step_1ms({platform, springs_.harness_force(patient.harness()), released});
      if (follows) {
        // Speed in proportion to the lean, as a well-behaved hoist would in the end: 0.3 m/s at 3 cm.
        const double goal_m_s = std::clamp(10.0 * patient.harness().dx_m, -0.6, 0.6);
        const double most_m_s = follows_m_s2 * 0.001;
        const double change_m_s = std::clamp(goal_m_s - platform.speed_m_s, -most_m_s, most_m_s);
        platform.acceleration_m_s2 = change_m_s / 0.001;
        platform.speed_m_s += change_m_s;
      }
      if (answer_per_s2 > 0.0) {
        // Speed that rises under a lean and decays, as in Algorithm 1.
        platform.acceleration_m_s2 = answer_per_s2 * patient.harness().dx_m - 0.1 * platform.speed_m_s;
        platform.speed_m_s = std::max(platform.speed_m_s + platform.acceleration_m_s2 * 0.001, 0.0);
      }
      platform.x_m += platform.speed_m_s * std::cos(platform.psi_rad) * 0.001;
      platform.y_m += platform.speed_m_s * std::sin(platform.psi_rad) * 0.001;
      largest_lean_rad = std::max(largest_lean_rad, std::fabs(std::atan(patient.harness().dx_m / 0.8)));
    }
  }
  Patient patient;
  PlatformMotion platform;
  bool released{false};
  bool follows{false};
  double follows_m_s2{0.5};
  double answer_per_s2{};
  double largest_lean_rad{};

 private:
  Plant springs_;
};

TEST(Patient, StandsStillBeforeTheBrakesLetGoAndForASecondAfter) {
  Stage stage;
  stage.run(3.0);
  EXPECT_EQ(stage.patient.state(), PatientState::standing);
  EXPECT_EQ(stage.largest_lean_rad, 0.0);
  EXPECT_EQ(stage.patient.harness().yaw_rad, 0.0);
  stage.released = true;
  stage.run(0.9);
  EXPECT_EQ(stage.patient.state(), PatientState::waiting);
  EXPECT_EQ(stage.largest_lean_rad, 0.0);
  stage.run(0.2);
  EXPECT_EQ(stage.patient.state(), PatientState::leading);
}

TEST(Patient, LeadsAFollowingPlatformToTheEndOfTheStraightAndStands) {
  Stage stage;
  stage.released = stage.follows = true;
  stage.run(60.0);
  EXPECT_EQ(stage.patient.state(), PatientState::leading);
  EXPECT_TRUE(stage.patient.arrived());
  EXPECT_NEAR(stage.platform.x_m, 10.0, 0.7);
  EXPECT_LT(std::fabs(stage.platform.speed_m_s), 0.01);
  EXPECT_LT(stage.largest_lean_rad, 10.0 * kDegree_rad);
  // Back upright, feet still.
  EXPECT_LT(std::fabs(stage.patient.harness().dx_m), 0.005);
  EXPECT_LT(std::fabs(stage.patient.harness().dy_m), 0.002);
}

TEST(Patient, LetsAHoistLeadThatMovesByItself) {
  Stage stage;
  stage.released = true;
  stage.platform.speed_m_s = 0.2;
  stage.run(0.5);
  EXPECT_EQ(stage.patient.state(), PatientState::following);
  stage.run(20.0);
  EXPECT_EQ(stage.patient.state(), PatientState::following);
  EXPECT_LT(stage.largest_lean_rad, 4.0 * kDegree_rad);
}

TEST(Patient, GivesUpLeadingAHoistThatDoesNotFollow) {
  Stage stage;
  stage.released = true;
  stage.run(1.5);
  EXPECT_EQ(stage.patient.state(), PatientState::leading);
  stage.run(5.0);
  EXPECT_EQ(stage.patient.state(), PatientState::following);
  EXPECT_LT(stage.largest_lean_rad, 10.5 * kDegree_rad);
  stage.run(3.0);
  EXPECT_LT(std::fabs(stage.patient.harness().dx_m), 0.01);  // upright again
  // Only switching the drives off restores the trust.
  stage.follows = true;
  stage.run(5.0);
  EXPECT_EQ(stage.patient.state(), PatientState::following);
  stage.released = false;
  stage.run(0.1);
  EXPECT_EQ(stage.patient.state(), PatientState::standing);
  stage.released = true;
  stage.run(1.2);
  EXPECT_EQ(stage.patient.state(), PatientState::leading);
}

// Full lean is 9 degrees in one preset and 13 in the other, with less speed there. The patient does not know which.
TEST(Patient, WalksMoreSlowlyWhereALeanBringsLess) {
  const auto fastest_m_s = [](double answer_per_s2, double driven_m_s) {
    PatientParams stubborn;
    stubborn.yields_after_s = PatientParams::kStubborn_s;
    Stage stage("straight", stubborn);
    stage.released = true;
    stage.run(driven_m_s > 0.0 ? 2.5 : 0.0);
    // The therapist drives slowly while the patient leans, then suddenly faster: that is no evidence of the effect of a lean.
    for (const double speed_m_s : {driven_m_s, 2.5 * driven_m_s}) {
      stage.platform.acceleration_m_s2 = 0.3;
      for (; stage.platform.speed_m_s < speed_m_s; stage.platform.speed_m_s += 0.003) stage.run(0.01);
      stage.platform.acceleration_m_s2 = 0.0;
      stage.run(driven_m_s > 0.0 ? 3.0 : 0.0);
    }
    stage.answer_per_s2 = answer_per_s2;
    stage.run(25.0);
    EXPECT_EQ(stage.patient.state(), PatientState::leading);
    EXPECT_LT(stage.largest_lean_rad, 10.0 * kDegree_rad);
    return stage.platform.speed_m_s;
  };
  EXPECT_GT(fastest_m_s(1.06, 0.0), 0.26);
  EXPECT_LT(fastest_m_s(0.23, 0.0), 0.22);
  EXPECT_GT(fastest_m_s(0.23, 0.0), 0.15);
  EXPECT_GT(fastest_m_s(1.06, 0.04), 0.26);
}

// A therapist drives, and the patient does not know it.
TEST(Patient, YieldsToAHoistThatAnotherLeads) {
  const auto set_off = [](double yields_after_s) {
    PatientParams params;
    params.yields_after_s = yields_after_s;
    Stage stage("straight", params);
    stage.released = stage.follows = true;
    stage.run(8.0);
    EXPECT_EQ(stage.patient.state(), PatientState::leading);
    stage.follows = false;
    stage.platform.acceleration_m_s2 = 0.0;
    return stage;
  };
  for (const double after_s : {0.6, 1.0, PatientParams::kStubborn_s}) {
    const auto expect_yielding = [after_s](Stage& stage) {
      stage.run(0.5);
      EXPECT_EQ(stage.patient.state(), PatientState::leading) << after_s;
      stage.run(2.5);
      EXPECT_EQ(stage.patient.state(), after_s < 10.0 ? PatientState::following : PatientState::leading) << after_s;
    };
    // Faster than wished, steadily, under a lean back.
    Stage fast = set_off(after_s);
    fast.platform.speed_m_s = 0.55;
    expect_yielding(fast);
    // Straight on under a pelvis that is turned to get back to the line.
    Stage astray = set_off(after_s);
    astray.platform.psi_rad = 0.6;
    expect_yielding(astray);
  }
  // A yielding patient is soon upright again.
  Stage stage = set_off(1.0);
  stage.platform.speed_m_s = 0.55;
  stage.run(6.0);
  EXPECT_LT(std::fabs(stage.patient.harness().dx_m), 0.03);
}

// A push, or slipping wheels, feel as if the therapist drove. A patient who has yielded tests it with a small lean.
TEST(Patient, WhoHasYieldedLeadsAgainWhenASmallLeanIsAnswered) {
  Stage stage;
  stage.released = stage.follows = true;
  stage.run(8.0);
  stage.follows = false;
  stage.platform.acceleration_m_s2 = 0.0;
  stage.platform.speed_m_s = 0.55;
  stage.run(3.0);
  ASSERT_EQ(stage.patient.state(), PatientState::following);
  stage.follows = true;
  stage.follows_m_s2 = 0.1;
  stage.largest_lean_rad = 0.0;
  double waited_s = 0.0;
  for (; stage.patient.state() != PatientState::leading && waited_s < 30.0; waited_s += 0.1) stage.run(0.1);
  EXPECT_LT(waited_s, 20.0);
  EXPECT_LT(stage.largest_lean_rad, 6.0 * kDegree_rad);
  stage.run(10.0);
  EXPECT_EQ(stage.patient.state(), PatientState::leading);
  EXPECT_GT(stage.platform.speed_m_s, 0.2);
}

// A therapist who drives with stops, at any time of the patient's trial.
TEST(Patient, WhoHasYieldedNeverLeadsAHoistThatIsDrivenWithPauses) {
  for (double pause_s = 2.0; pause_s < 12.0; pause_s += 0.5) {
    Stage stage;
    stage.released = stage.follows = true;
    stage.run(8.0);
    stage.follows = false;
    double starts_m_s2 = 0.5;
    const auto drive = [&](double to_m_s, double for_s) {
      const double begun_m_s = stage.platform.speed_m_s;
      for (double t = 0.0; t < for_s; t += 0.01) {
        const double goal_m_s = begun_m_s + std::clamp(to_m_s - begun_m_s, -0.5 * t, starts_m_s2 * t);
        stage.platform.acceleration_m_s2 = (goal_m_s - stage.platform.speed_m_s) / 0.01;
        stage.platform.speed_m_s = goal_m_s;
        stage.run(0.01);
      }
    };
    drive(0.55, 4.0);
    ASSERT_EQ(stage.patient.state(), PatientState::following);
    // The therapist starts briskly or gently.
    if (pause_s != std::floor(pause_s)) starts_m_s2 = 0.1;
    stage.largest_lean_rad = 0.0;
    bool tried = false;
    for (int i = 0; i < 4; ++i) {
      drive(0.0, pause_s);
      tried = tried || stage.patient.state() == PatientState::trying;
      drive(0.3, 4.0);
      EXPECT_EQ(stage.patient.state(), PatientState::following) << "paused for " << pause_s << " s";
    }
    EXPECT_TRUE(tried || pause_s < 4.5 || pause_s > 7.5) << pause_s;
    EXPECT_LT(stage.largest_lean_rad, 10.0 * kDegree_rad);
  }
}

TEST(Patient, TheScenarioOfStandingNeverSetsOff) {
  Stage stage("stand");
  stage.released = stage.follows = true;
  stage.run(20.0);
  EXPECT_EQ(stage.patient.state(), PatientState::waiting);
  EXPECT_EQ(stage.largest_lean_rad, 0.0);
}

TEST(Patient, SwayGrowsWithSpeedAndSwingsTwiceForwardForOnceSideways) {
  Stage stage;
  stage.released = true;
  stage.platform.speed_m_s = 0.3;
  stage.run(8.0);
  ASSERT_EQ(stage.patient.state(), PatientState::following);
  double lateral_m = 0.0;
  int crossings_forward = 0, crossings_lateral = 0;
  HarnessMotion last = stage.patient.harness();
  double mean_m = 0.0;
  for (int i = 0; i < 10000; ++i) {
    stage.run(0.001);
    mean_m += stage.patient.harness().dx_m / 10000.0;
  }
  for (int i = 0; i < 10000; ++i) {
    stage.run(0.001);
    const HarnessMotion& now = stage.patient.harness();
    lateral_m = std::max(lateral_m, std::fabs(now.dy_m));
    crossings_forward += (now.dx_m - mean_m > 0.0) != (last.dx_m - mean_m > 0.0) ? 1 : 0;
    crossings_lateral += (now.dy_m > 0.0) != (last.dy_m > 0.0) ? 1 : 0;
    last = now;
  }
  EXPECT_NEAR(lateral_m, 0.6 * 0.03, 0.008);  // a follower sways less
  // 0.42 + 0.5 x 0.3 = 0.57 Hz in 10 s: 11.4 crossings sideways, twice that forward.
  EXPECT_NEAR(crossings_lateral, 11, 2);
  EXPECT_NEAR(crossings_forward, 23, 3);
}

// What the fall guards of the core must catch: past 10 degrees with more than 25 deg/s outward (SOURCES 2.1).
void expect_fall(void (Patient::*how)(double), double toward_rad, double within_s) {
  Stage stage;
  stage.released = stage.follows = true;
  stage.run(6.0);
  ASSERT_EQ(stage.patient.state(), PatientState::leading);
  (stage.patient.*how)(toward_rad);
  double last_rad = 0.0, fastest_rad_s = 0.0, largest_rad = 0.0;
  bool past = false;
  for (double t = 0.0; t < within_s; t += 0.001) {
    stage.run(0.001);
    const HarnessMotion& harness = stage.patient.harness();
    const double lean_rad = std::atan((std::cos(toward_rad) * harness.dx_m + std::sin(toward_rad) * harness.dy_m) / 0.8);
    if (lean_rad > 10.0 * kDegree_rad) {
      past = true;
      fastest_rad_s = std::max(fastest_rad_s, (lean_rad - last_rad) / 0.001);
    }
    last_rad = lean_rad;
    largest_rad = std::max(largest_rad, lean_rad);
  }
  EXPECT_TRUE(past) << toward_rad;
  EXPECT_GT(fastest_rad_s, 25.0 * kDegree_rad) << toward_rad;
  EXPECT_LT(largest_rad, 18.0 * kDegree_rad) << toward_rad;  // the stop and its rubber hold
}
constexpr std::array kEverySide{0.0, kPi / 2.0, -kPi / 2.0, kPi};
TEST(Patient, AStumbleGoesQuicklyPastTenDegrees) {
  for (const double toward_rad : kEverySide) expect_fall(&Patient::trip, toward_rad, 3.0);
}
TEST(Patient, ACollapseGoesQuicklyPastTenDegrees) {
  for (const double toward_rad : kEverySide) expect_fall(&Patient::collapse, toward_rad, 3.0);
}

// The gait alone: the platform goes by itself, and the patient walks along.
struct Gait {
  double stride_cv = 0, size_cv = 0, mean_aside_m = 0, worst_rate_m_s = 0, frozen_s = 0;
  int strides = 0;
};
Gait gait_of(const PatientParams& params, double seconds) {
  Stage stage("straight", params);
  stage.released = true;
  stage.platform.speed_m_s = 0.3;
  stage.run(5.0);
  std::vector<double> times, sizes;
  double sum_m = 0.0, out_m = 0.0, crossed_s = -1.0;
  HarnessMotion last = stage.patient.harness();
  Gait gait;
  for (int i = 0; i < static_cast<int>(seconds * 1000.0); ++i) {
    stage.run(0.001);
    const HarnessMotion& now = stage.patient.harness();
    for (const double off_m_s : {(now.dx_m - last.dx_m) / 0.001 - (now.dx_rate_m_s + last.dx_rate_m_s) / 2.0,
                                 (now.dy_m - last.dy_m) / 0.001 - (now.dy_rate_m_s + last.dy_rate_m_s) / 2.0})
      gait.worst_rate_m_s = std::max(gait.worst_rate_m_s, std::fabs(off_m_s));
    sum_m += now.dy_m;
    out_m = std::max(out_m, now.dy_m);
    const double middle_m = sum_m / (i + 1);
    if (last.dy_m < middle_m && now.dy_m >= middle_m && (crossed_s < 0.0 || i * 0.001 - crossed_s > 0.4)) {
      if (crossed_s >= 0.0) times.push_back(i * 0.001 - crossed_s), sizes.push_back(out_m - middle_m);
      crossed_s = i * 0.001, out_m = middle_m;
    }
    gait.frozen_s += stage.patient.frozen() ? 0.001 : 0.0;
    last = now;
  }
  const auto cv = [](const std::vector<double>& values) {
    double sum = 0.0, squares = 0.0;
    for (const double value : values) sum += value, squares += value * value;
    const double mean = sum / static_cast<double>(values.size());
    return std::sqrt(std::max(0.0, squares / static_cast<double>(values.size()) - mean * mean)) / mean;
  };
  gait.strides = static_cast<int>(times.size());
  gait.stride_cv = cv(times), gait.size_cv = cv(sizes);
  gait.mean_aside_m = sum_m / (seconds * 1000.0);
  return gait;
}

TEST(PatientFamily, StridesVaryAsTheRowSaysAndThePlainPatientsDoNot) {
  const Gait even = gait_of({}, 120.0);
  EXPECT_GT(even.strides, 50);
  EXPECT_LT(even.stride_cv, 0.02);  // of the crossings of a mean that is still found
  for (const FamilyMember& member : kPatientFamily) {
    PatientParams params = member.params;
    params.variation.freezes_per_min = 0.0;
    EXPECT_LT(gait_of(params, 60.0).worst_rate_m_s, 0.02)
        << member.name;  // position and rate belong together: no jump for the sensors to feel
    // From stride to stride alone: what wanders inside a stride would move its crossings.
    params.variation.within_norm = params.variation.stand_sway_m = 0.0;
    const Gait gait = gait_of(params, 400.0);
    ASSERT_GT(gait.strides, 100) << member.name;
    EXPECT_GT(gait.stride_cv, 0.6 * params.variation.stride_time_norm) << member.name;
    EXPECT_LT(gait.stride_cv, 1.6 * params.variation.stride_time_norm + 0.04) << member.name;
    EXPECT_GT(gait.size_cv, 0.5 * params.variation.step_size_norm) << member.name;
    EXPECT_NEAR(gait.mean_aside_m, 0.85 * params.lean_left_m, 0.15 * params.lean_left_m + 0.004) << member.name;
  }
}

// A walk of a minute, as the studies measured them.
TEST(PatientFamily, AMinuteOfStridesVariesAsTheRowSays) {
  for (const FamilyMember& member : kPatientFamily) {
    GaitVariation variation = member.params.variation;
    if (variation.stride_time_norm == 0.0) continue;
    double sum = 0.0;
    constexpr int kWalks = 60;
    for (int walk = 1; walk <= kWalks; ++walk) {
      variation.seed = static_cast<std::uint64_t>(walk);
      UnevenGait gait(variation);
      std::vector<double> times_s;
      double phase_rad = 0.0, begun_s = 0.0;
      for (int ms = 0; ms < 60'000; ++ms) {
        gait.step_1ms(1.0, phase_rad, true);
        phase_rad += 2.0 * kPi * 0.8 * gait.tempo_norm() * 0.001;
        if (phase_rad < 2.0 * kPi) continue;
        phase_rad -= 2.0 * kPi;
        times_s.push_back(0.001 * ms - std::exchange(begun_s, 0.001 * ms));
      }
      double mean_s = 0.0, squares = 0.0;
      for (const double time_s : times_s) mean_s += time_s / static_cast<double>(times_s.size());
      for (const double time_s : times_s) squares += (time_s - mean_s) * (time_s - mean_s);
      sum += std::sqrt(squares / static_cast<double>(times_s.size() - 1)) / mean_s;
    }
    EXPECT_NEAR(sum / kWalks, variation.stride_time_norm, 0.1 * variation.stride_time_norm) << member.name;
  }
}

TEST(PatientFamily, StandingSwaysAsTheRowSaysAndTheSameSeedSwaysAlike) {
  const auto sway = [](std::uint64_t seed, std::vector<double>& places) {
    PatientParams params = find_patient("standing")->params;
    params.variation.seed = seed;
    Stage stage("stand", params);
    double squares = 0.0, aside_squares = 0.0;
    for (int i = 0; i < 60'000; ++i) {
      stage.run(0.01);
      const double dx_m = stage.patient.harness().dx_m, dy_m = stage.patient.harness().dy_m;
      squares += dx_m * dx_m;
      aside_squares += dy_m * dy_m;
      if (i % 100 == 0) places.push_back(dx_m);
    }
    EXPECT_NEAR(std::sqrt(aside_squares / squares), 0.6, 0.12);
    return std::sqrt(squares / 60'000);
  };
  std::vector<double> one, again, other;
  const double without_springs_m = find_patient("standing")->params.variation.stand_sway_m;
  for (const double rms_m : {sway(1, one), sway(1, again), sway(2, other)}) {
    EXPECT_GT(rms_m, 0.4 * without_springs_m);
    EXPECT_LT(rms_m, 0.7 * without_springs_m);
  }
  EXPECT_EQ(one, again);
  EXPECT_NE(one, other);
}

TEST(PatientFamily, FeetFreezeForSecondsAndGoOn) {
  PatientParams params = find_patient("parkinson")->params;
  const Gait gait = gait_of(params, 1800.0);
  // Every two minutes for about four seconds, and 5 s at least between two.
  EXPECT_GT(gait.frozen_s, 20.0);
  EXPECT_LT(gait.frozen_s, 120.0);
  // Held on the spot while the platform goes on: the springs carry the body along in the end.
  Stage stage("straight", params);
  stage.released = stage.follows = true;
  stage.run(3.0);
  ASSERT_EQ(stage.patient.state(), PatientState::leading);
  const double here_m = stage.platform.x_m;
  double slowest_m_s = 1.0;
  bool froze = false;
  for (int i = 0; i < 600'000 && !(froze && !stage.patient.frozen()); ++i) {
    stage.platform.x_m = here_m;  // an endless straight
    stage.run(0.001);
    if (!stage.patient.frozen()) continue;
    froze = true;
    slowest_m_s = std::min(slowest_m_s, std::fabs(stage.platform.speed_m_s));
  }
  EXPECT_TRUE(froze);
  EXPECT_LT(slowest_m_s, 0.05);
}

TEST(Patient, HangingStaysPastTenDegreesWithoutAGait) {
  Stage stage;
  stage.released = stage.follows = true;
  stage.run(6.0);
  stage.patient.hang();
  stage.follows = false;
  stage.platform.acceleration_m_s2 = 0.0;
  stage.run(3.0);
  const double lean_rad = std::atan(stage.patient.harness().dx_m / 0.8);
  EXPECT_GT(lean_rad, 10.0 * kDegree_rad);
  EXPECT_LT(lean_rad, 13.0 * kDegree_rad);
  const double before_m = stage.patient.harness().dy_m;
  stage.run(1.0);
  EXPECT_NEAR(stage.patient.harness().dy_m, before_m, 1e-4);
}

TEST(Patient, IsHelpedUprightOnceTheHoistStands) {
  Stage stage;
  stage.released = stage.follows = true;
  stage.run(6.0);
  stage.patient.trip();
  stage.follows = false;
  stage.platform.speed_m_s = 0.0;
  stage.platform.acceleration_m_s2 = 0.0;
  stage.run(2.5);
  EXPECT_EQ(stage.patient.state(), PatientState::tripping);
  stage.run(5.0);
  EXPECT_EQ(stage.patient.state(), PatientState::following);
  EXPECT_LT(std::fabs(stage.patient.harness().dx_m), 0.01);
}

TEST(Patient, RandomPatientsAreReproducibleAndInTheirRanges) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const PatientParams a = PatientParams::random(seed), b = PatientParams::random(seed);
    EXPECT_EQ(a.mass_kg, b.mass_kg);
    EXPECT_EQ(a.sway_yaw_rad, b.sway_yaw_rad);
    EXPECT_GE(a.mass_kg, 50.0);
    EXPECT_LE(a.mass_kg, 100.0);
    EXPECT_GE(a.wish_m_s, 0.20);
    EXPECT_LE(a.wish_m_s, 0.60);
  }
  EXPECT_NE(PatientParams::random(1).mass_kg, PatientParams::random(2).mass_kg);
}

TEST(Patient, LooksAlongTheLine) {
  Stage stage("figure-eight");
  stage.released = stage.follows = true;
  stage.run(3.0);
  // The right-hand arc comes first: the pelvis turns right once it is near.
  double most_right_rad = 0.0;
  for (int i = 0; i < 8000; ++i) {
    stage.run(0.001);
    most_right_rad = std::min(most_right_rad, stage.patient.harness().yaw_rad);
  }
  EXPECT_LT(most_right_rad, -10.0 * kDegree_rad);
  EXPECT_GT(stage.patient.progress_m(), 0.5);
}

}  // namespace
}  // namespace hoist::sim
