// The stopping distance shown, against the true one: random patients, commands, turns and times of the cut, with the real step and the
// shipped nodes. HOIST_STOP_CUTS=2000 runs more cuts of each kind (deploy/dev stops).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "firmware/sim/random.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/seeds.hpp"

namespace hoist::tests {
namespace {

using contract::Mode;

int cuts() { return asked_for("HOIST_STOP_CUTS", seeds_for(120, 120, 24)); }
/// At each corner of a range. There only the nearest counts: the mean excess of so few is drawn by the shortest stops.
int cuts_at_a_corner() { return asked_for("HOIST_STOP_CUTS", seeds_for(120, 60, 8)) / 4; }

enum class Cut { link_driving, stop_walking, computer_driving, computer_walking, link_guided, end_driving };

struct Sum {
  int cuts = 0, passed = 0;
  double promised_m = 0, rolled_m = 0, excess_norm = 0, worst_m = -1;
  std::uint64_t worst_seed = 0;
};

// One cut at a random moment: what was promised and what was rolled. False when the hoist did not come to move.
bool one_cut(Cut cut, std::uint64_t seed, const contract::Params& params, double& promised_m, double& rolled_m) {
  sim::Random random(seed);
  const bool driving = cut == Cut::link_driving || cut == Cut::computer_driving || cut == Cut::link_guided || cut == Cut::end_driving;
  ClosedLoopOptions options;
  options.world.seed = seed;
  options.world.patient = sim::PatientParams::random(seed);
  options.world.scenario = sim::find_scenario(driving ? "stand" : (random.next() % 2 == 0 ? "figure-eight" : "straight"));
  options.params = params;
  options.params.remote_speed_m_s_max = random.uniform(0.10, 0.60);
  ClosedLoop loop(options);
  if (cut == Cut::link_guided) {
    const double speed_m_s = random.uniform(0.1, 0.6);
    const auto shape = random.next() % 2 == 0 ? contract::GuidedShape::eight : contract::GuidedShape::straight;
    if (!loop.start_guided({shape, random.next() % 2 == 0, random.uniform(1.5, 3.0), 1.0, speed_m_s, 1})) return false;
  } else if (!loop.start(driving ? Mode::remote : Mode::user)) {
    return false;
  }
  if (cut == Cut::link_guided) {
    // Also where it slows for a bend, speeds up behind it, or comes to its end.
    loop.hold_stick(0.0, 0.0);
    loop.run(random.uniform(1.0, 14.0));
  } else if (driving) {
    // The stick moves a few times, then the cut.
    loop.hold_stick(0.0, 0.0);
    loop.run(0.2);
    const auto changes = 1 + random.next() % 4;
    for (std::uint64_t i = 0; i < changes; ++i) {
      const double turn_norm = random.next() % 2 == 0 ? 0.0 : random.uniform(-1.0, 1.0);
      loop.hold_stick(random.uniform(-1.0, 1.0), turn_norm);
      loop.run(random.uniform(0.1, 1.5));
    }
  } else {
    loop.run(random.uniform(2.0, 14.0));
  }
  if (cut == Cut::end_driving) {
    // The distance shown at release; then the mode is ended, at once or during the ramp.
    loop.let_go();
    loop.run(0.02);
  }
  const contract::TickRecord& record = loop.record();
  if (std::fabs(record.speed_m_s) < 0.03F) return false;
  const auto speed_m_s = static_cast<double>(record.speed_m_s), command_m_s = static_cast<double>(record.speed_command_m_s);
  const double true_m_s = loop.world().plant().platform().speed_m_s;
  promised_m = static_cast<double>(cut == Cut::computer_driving || cut == Cut::computer_walking ? record.worst_stop_distance_m
                                                                                                : record.stop_distance_m);
  switch (cut) {
    case Cut::link_driving:
    case Cut::link_guided:
      loop.fall_silent();
      break;
    case Cut::stop_walking:
      loop.ask(contract::CommandKind::stop);
      break;
    case Cut::computer_driving:
    case Cut::computer_walking:
      loop.kill_core();
      break;
    case Cut::end_driving:
      break;
  }
  const int end_at = cut == Cut::end_driving ? static_cast<int>(random.next() % 20) : -1;
  // Distance of the axle's centre until standstill.
  rolled_m = 0;
  double still_s = 0;
  sim::PlatformMotion before = loop.world().plant().platform();
  for (int i = 0; i < 400 && still_s < 0.3; ++i) {
    if (i == end_at) loop.ask(contract::CommandKind::request_mode, static_cast<std::uint32_t>(Mode::standby));
    loop.step();
    const sim::PlatformMotion now = loop.world().plant().platform();
    rolled_m += std::hypot(now.x_m - before.x_m, now.y_m - before.y_m);
    still_s = std::fabs(now.speed_m_s) < 0.003 ? still_s + 0.01 : 0.0;
    before = now;
  }
  if (std::getenv("HOIST_STOP_PRINT") != nullptr)
    std::printf("cut %d,%llu,%.5f,%.5f,%.5f,%.5f,%.5f\n", static_cast<int>(cut), static_cast<unsigned long long>(seed), promised_m,
                rolled_m, speed_m_s, command_m_s, true_m_s);
  return true;
}

void judge(Cut cut, const char* name, int wanted, double excess_most = 0.23, const contract::Params& params = {}) {
  Sum sum;
  std::uint64_t seed = static_cast<std::uint64_t>(cut) * 1'000'000;
  const int most = wanted * 3;
  for (int tried = 0; tried < most && sum.cuts < wanted; ++tried) {
    double promised_m = 0, rolled_m = 0;
    if (!one_cut(cut, ++seed, params, promised_m, rolled_m)) continue;
    ++sum.cuts;
    sum.promised_m += promised_m;
    sum.rolled_m += rolled_m;
    sum.excess_norm += promised_m / rolled_m - 1.0;
    if (rolled_m - promised_m > sum.worst_m) {
      sum.worst_m = rolled_m - promised_m;
      sum.worst_seed = seed;
    }
    if (rolled_m > promised_m) ++sum.passed;
  }
  ASSERT_EQ(sum.cuts, wanted);
  std::printf(
      "%s: %d cuts, promised %.3f m, rolled %.3f m on average, excess %.1f %% of the way, %.1f %% on average; nearest %.1f mm (seed %llu), "
      "passed %d\n",
      name, sum.cuts, sum.promised_m / sum.cuts, sum.rolled_m / sum.cuts, 100.0 * (sum.promised_m / sum.rolled_m - 1.0),
      100.0 * sum.excess_norm / sum.cuts, -1000.0 * sum.worst_m, static_cast<unsigned long long>(sum.worst_seed), sum.passed);
  EXPECT_EQ(sum.passed, 0) << "seed " << sum.worst_seed << " rolled " << sum.worst_m << " m farther than promised";
  EXPECT_LT(sum.excess_norm / sum.cuts, excess_most);
}

TEST(StopDistance, H17TheLinkDiesWhileSomebodyDrives) { judge(Cut::link_driving, "link, driving", cuts()); }
TEST(StopDistance, H17TheLinkDiesInAnExercise) { judge(Cut::link_guided, "link, guided", cuts()); }
// After release only a few centimetres remain, so the margin is a larger share.
TEST(StopDistance, H17DrivingIsLetGoAndEnded) { judge(Cut::end_driving, "let go and ended", cuts(), 0.60); }
TEST(StopDistance, H17StopWhileThePatientWalks) { judge(Cut::stop_walking, "stop, walking", cuts()); }
// An engineer may change gains in motion: the shown distance holds at every corner of their ranges.
TEST(StopDistance, H27HoldsWithWhateverGainsTheDrivesMayHave) {
  using contract::ParamName;
  const auto& gain = contract::kParams[contract::param_index(ParamName::drive_velocity_gain_v_s_rad)];
  const auto& integral = contract::kParams[contract::param_index(ParamName::drive_velocity_integral_v_rad)];
  for (const double gain_v_s_rad : {gain.min, gain.max})
    for (const double integral_v_rad : {integral.min, integral.max})
      for (const Cut cut : {Cut::link_driving, Cut::stop_walking, Cut::computer_driving, Cut::computer_walking, Cut::link_guided}) {
        contract::Params params;
        params.drive_velocity_gain_v_s_rad = gain_v_s_rad;
        params.drive_velocity_integral_v_rad = integral_v_rad;
        judge(cut, "corner", cuts_at_a_corner(), 0.80, params);
      }
}
// A cap for the patient, the fastest turn, and what an engineer may set between command and motion.
TEST(StopDistance, H17HoldsForEveryCapAndWhateverShapesTheRamps) {
  for (const double cap_norm : {0.3, 0.6, 0.8, 1.0})
    for (const double slow_age_s : {0.05, 0.15})
      for (const double jerk_m_s3 : {0.5, 3.0, 10.0})
        for (const Cut cut : {Cut::link_driving, Cut::link_guided}) {
          // An exercise that is faster than the cap is refused.
          if (cut == Cut::link_guided && cap_norm < 1.0) continue;
          contract::Params params;
          params.speed_cap_norm = cap_norm;
          params.remote_slow_age_s = slow_age_s;
          params.jerk_m_s3_max = jerk_m_s3;
          params.remote_yaw_rate_rad_s_max = params.yaw_rate_rad_s_max;
          std::printf("cap %g, slow from %g s, jerk %g m/s3, ", cap_norm, slow_age_s, jerk_m_s3);
          judge(cut, cut == Cut::link_driving ? "driving" : "guided", cuts_at_a_corner(), 0.30, params);
        }
}
TEST(StopDistance, H21TheComputerDiesWhileSomebodyDrives) { judge(Cut::computer_driving, "computer, driving", cuts()); }
TEST(StopDistance, H21TheComputerDiesWhileThePatientWalks) { judge(Cut::computer_walking, "computer, walking", cuts()); }

}  // namespace
}  // namespace hoist::tests
