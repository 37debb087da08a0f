// Twins of simulated patients whose values are known: what the fit finds again, what the twin's walks are worth, and what is refused.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"
#include "deploy/tools/hoist/study/record_runs.hpp"
#include "deploy/tools/hoist/study/virtual_run.hpp"
#include "deploy/tools/hoist/twin/what_if.hpp"
#include "firmware/sim/patient_family.hpp"
#include "firmware/sim/random.hpp"
#include "tests/support/seeds.hpp"
#include "tests/support/shell.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::tool::twin {
namespace {

using test::TemporaryFolder;

const sim::Scenario& eight() { return *sim::find_scenario("figure-eight"); }

// A random patient who limps to one side.
sim::PatientParams person(std::uint64_t seed) {
  sim::PatientParams p = sim::PatientParams::random(seed);
  p.limp_norm = sim::Random(seed ^ 0x6C696D70ULL).uniform(-0.2, 0.2);
  return p;
}

study::VirtualRun led(const sim::PatientParams& patient, std::uint64_t seed, double laps = 2.0) {
  loop::ClosedLoopOptions options;
  options.world.seed = seed;
  options.world.patient = patient;
  options.world.scenario = &eight();
  return study::walk_led(options, laps);
}

LedSession session_of(const sim::PatientParams& patient, std::uint64_t seed) {
  const study::VirtualRun run = led(patient, seed);
  EXPECT_EQ(run.unfinished, "") << seed;
  auto session = led_session_of(run.records, eight(), contract::Params{});
  EXPECT_TRUE(session.ok()) << seed << ": " << (session.ok() ? "" : session.error().message);
  return session.ok() ? std::move(*session) : LedSession{};
}

double told(const WalkOutcome& walk, Told which) { return walk.told[static_cast<std::size_t>(which)].value_or(-99); }

constexpr std::uint64_t kFirst = 1;
std::uint64_t last_seed() { return tests::thorough() ? 2 : 1; }

/// How far a fitted value may be from the true one.
struct Bound {
  const char* name;
  double most;
};
constexpr std::array kBounds{Bound{"delay_s", 0.08}, Bound{"stiffness_n_m", 15.0}, Bound{"cadence_steps_min", 2.0},
                             Bound{"asymmetry_norm", 0.03}, Bound{"turning_lead_s", 0.10}};

double true_value(const sim::PatientParams& p, const LedSession& session, std::string_view name) {
  if (name == "delay_s") return p.reaction_s + p.yaw_lag_s;
  if (name == "stiffness_n_m") return 300.0 * (1.0 - p.compensation_norm);
  if (name == "asymmetry_norm") return p.limp_norm;
  if (name == "turning_lead_s") return p.foresight_s;
  return 120.0 * (p.stride_hz + p.stride_hz_per_m_s * session.mean_speed_m_s());
}

/// A patient, what a recorded walk of it gives, and held-out walks: other seeds, and other settings.
struct Subject {
  std::string name;
  sim::PatientParams truth;
  std::uint64_t seed = 0;
};

void print_values(const Subject& subject, const LedSession& session, const Fit& fit) {
  std::printf("%s: led %.0f s, not explained %.2f mm and %.3f deg; %d of %d starts\n", subject.name.c_str(), session.led_s(),
              1000 * fit.rms_lean_m, fit.rms_turn_rad * 57.2958, fit.starts_agreed, fit.starts);
  for (const Bound& bound : kBounds)
    std::printf("  %-18s true %8.3f fitted %8.3f +- %6.3f\n", bound.name, true_value(subject.truth, session, bound.name),
                fit[bound.name].value, fit[bound.name].spread);
}

void expect_held_out(const Subject& subject, const sim::PatientParams& twin, const contract::Params& params, const char* what) {
  const WalkOutcome real = walk_twin(subject.truth, eight(), params, 900 + subject.seed),
                    mine = walk_twin(twin, eight(), params, 700 + subject.seed);
  EXPECT_EQ(real.unfinished + mine.unfinished, "") << subject.name;
  const double speed = told(real, Told::speed_rms_m_s);
  std::printf("  held out, %s: C %.3f, twin %.3f; speed %.3f, twin %.3f m/s\n", what, told(real, Told::c), told(mine, Told::c), speed,
              told(mine, Told::speed_rms_m_s));
  EXPECT_NEAR(told(mine, Told::c), told(real, Told::c), kCheckC) << subject.name << ", " << what;
  EXPECT_NEAR(told(mine, Told::speed_rms_m_s), speed, kCheckSpeed_norm * speed) << subject.name << ", " << what;
}

Fit fit_of(const Subject& subject, const LedSession& session) {
  Fit fit = fit_patient(session, 1);
  print_values(subject, session, fit);
  return fit;
}

// On truth: simulated patients with known values, and walks that the fit has not seen.
TEST(Twin, KnownPatientsAreFoundAgainAndTheirTwinsWalkAsTheyDo) {
  for (std::uint64_t seed = kFirst; seed <= last_seed(); ++seed) {
    const Subject subject{"patient " + std::to_string(seed), person(seed), seed};
    const LedSession session = session_of(subject.truth, 50 + seed);
    if (session.steps.empty()) continue;
    const Fit fit = fit_of(subject, session);
    for (const Bound& bound : kBounds)
      EXPECT_NEAR(fit[bound.name].value, true_value(subject.truth, session, bound.name), bound.most) << seed << bound.name;
    expect_held_out(subject, fit.patient, {}, "same settings");
    contract::Params other;
    other.lean_tau_normal_s = 6.0, other.turn_gain_filtered_units = 40.0;
    expect_held_out(subject, fit.patient, other, "other settings");
  }
}

// Strides that vary and wander are no part of the twin; its walks shall be those of the patient all the same.
TEST(Twin, TheTwinOfAnUnevenPatientWalksAsThePatientDoes) {
  if (!tests::thorough()) GTEST_SKIP() << "long: --thorough";
  Subject subject{"healthy", sim::kPatientFamily[0].params, 1};
  ASSERT_EQ(sim::kPatientFamily[0].name, subject.name);
  subject.truth.variation.seed = 1;
  const LedSession session = session_of(subject.truth, 51);
  ASSERT_FALSE(session.steps.empty());
  const Fit fit = fit_of(subject, session);
  subject.truth.variation.seed = 101;
  expect_held_out(subject, fit.patient, {}, "same settings");
}

// What other settings do to the twin is what they do to the patient it was fitted to.
TEST(Twin, AChangeDoesToTheTwinWhatItDoesToThePatient) {
  const sim::PatientParams truth = person(3);
  const LedSession session = session_of(truth, 53);
  const Fit fit = fit_patient(session, 1);
  contract::Params weaker = session.params;
  weaker.lean_gain_filtered_units = 30;
  const WhatIf tried = what_if(fit, eight(), session.params, weaker, 5, 1);
  const auto lean = static_cast<std::size_t>(Told::lean_mean_norm);
  const Spread change = change_of(tried.before, tried.after, lean);
  ASSERT_EQ(change.walks, 5);
  EXPECT_TRUE(clear(change));
  const double real = told(walk_twin(truth, eight(), weaker, 31), Told::lean_mean_norm) -
                      told(walk_twin(truth, eight(), session.params, 31), Told::lean_mean_norm);
  std::printf("mean lean: %+.3f of the twin, %+.3f of the patient\n", change.mean, real);
  EXPECT_GT(real, 0.02) << "less gain takes more lean; otherwise nothing was tested";
  EXPECT_NEAR(change.mean, real, 0.3 * real);
  const WhatIf same = what_if(fit, eight(), session.params, session.params, 2, 1);
  EXPECT_EQ(change_of(same.before, same.after, lean).mean, 0.0);
}

TEST(Twin, OneDifferenceIsNotClearAndFewWalksNeverAre) {
  EXPECT_TRUE(clear({1.0, 1.0, 5}));
  EXPECT_FALSE(clear({0.8, 1.0, 5})) << "twice the standard error is 0.89";
  EXPECT_FALSE(clear({1.0, 0.0, 4}));
  EXPECT_FALSE(clear({0.0, 0.0, 10}));
}

db::SessionId stored(db::Database& database, const study::VirtualRun& run, std::string_view exercise) {
  db::SessionWriter writer = std::move(*db::SessionWriter::create(database));
  db::SessionStart start;
  start.started_utc_ns = 1'790'000'000'000'000'000;
  if (!exercise.empty()) start.exercise_json = std::string(exercise);
  const auto session = study::record_run(writer, run, start);
  EXPECT_TRUE(session.ok());
  return *session;
}
std::string eight_json() {
  return db::exercise_json(contract::usual_exercise(contract::ExerciseShape::eight), db::ExerciseNames::stored).dump();
}

TEST(Twin, SessionsThatCannotBearOneAreRefusedWithTheReason) {
  TemporaryFolder folder;
  db::Database database = std::move(*db::Database::open(folder / "r.db"));
  const auto why = [&](const study::VirtualRun& run, std::string_view exercise) {
    const auto session = read_led_session(database, stored(database, run, exercise));
    return session.ok() ? std::string("none") : session.error().message;
  };
  const study::VirtualRun whole = led(person(1), 51);
  EXPECT_EQ(why(whole, eight_json()), "none");
  EXPECT_NE(why(whole, "").find("[no_exercise]"), std::string::npos);
  EXPECT_NE(why(whole, R"({"shape":"eight","centre_m":1.2,"radius_m":0.8})").find("[other_exercise]"), std::string::npos);
  study::VirtualRun driven = whole;
  for (contract::TickRecord& r : driven.records)
    if (r.mode == static_cast<std::uint8_t>(contract::Mode::user)) r.mode = static_cast<std::uint8_t>(contract::Mode::remote);
  EXPECT_NE(why(driven, eight_json()).find("[not_led]"), std::string::npos);
  study::VirtualRun broken = whole;
  broken.records[broken.records.size() / 2].mode = static_cast<std::uint8_t>(contract::Mode::standby);
  EXPECT_NE(why(broken, eight_json()).find("[led_again]"), std::string::npos);
  study::VirtualRun gap = whole;
  const auto middle = gap.records.begin() + static_cast<std::ptrdiff_t>(gap.records.size() / 2);
  gap.records.erase(middle, middle + 100);
  EXPECT_NE(why(gap, eight_json()).find("[no_figure]: Part of this walk is not recorded."), std::string::npos) << why(gap, eight_json());
  study::VirtualRun brief = whole;
  brief.records.resize(2500);
  EXPECT_NE(why(brief, eight_json()).find("[too_short]"), std::string::npos);
}

std::string run(const std::string& command, int expected) {
  const test::ShellResult result = test::run_shell(command + " 2>&1");
  EXPECT_EQ(result.exit_code, expected) << command << "\n" << result.output;
  return result.output;
}

TEST(Twin, TheCommandFitsTriesAndRefuses) {
  TemporaryFolder folder;
  const std::string db = (folder / "r.db").string();
  {
    db::Database database = std::move(*db::Database::open(db));
    EXPECT_EQ(stored(database, led(person(1), 51), eight_json()), 1);
    EXPECT_EQ(stored(database, led(person(1), 52), eight_json()), 2);
    EXPECT_EQ(stored(database, led(person(2), 53), eight_json()), 3);
  }
  const std::string tool = std::string(HOIST_BINARY_DIR) + "/bin/hoist twin ";
  const std::string fitted = run(tool + db + " 1 --against 2 --against 3", 3);
  for (const Bound& bound : kBounds) EXPECT_NE(fitted.find(bound.name), std::string::npos) << bound.name;
  EXPECT_NE(fitted.find("SIMULATED hoist"), std::string::npos) << fitted;
  EXPECT_NE(fitted.find("Session 2: C "), std::string::npos) << fitted;
  EXPECT_NE(fitted.find("does NOT walk as the session did"), std::string::npos) << "session 3 is of another person";
  const std::string wish = db + " 1 --set lean_gain_filtered_units=30 --walks 1";
  const std::string tried = run(tool + wish, 0);
  EXPECT_NE(tried.find("lean_gain_filtered_units: 50 -> 30"), std::string::npos);
  EXPECT_NE(tried.find("What a twin cannot tell"), std::string::npos);
  if (tests::thorough()) EXPECT_EQ(tried, run(tool + wish, 0));
  const std::string begin = tool + db + " 1 --set ";
  EXPECT_NE(run(begin + "lean_gain_filtered_units=300", 2).find("lean_gain_filtered_units must be a number from 0 to 100"),
            std::string::npos);
  EXPECT_NE(run(begin + "no_such=3", 2).find("no_such"), std::string::npos);
  EXPECT_NE(run(begin + "remote_speed_m_s_max=0.6 --set speed_m_s_max=0.5", 2).find("must not exceed speed_m_s_max"), std::string::npos);
  run(tool + db + " 9", 1);
  run(tool + db, 2);
  run(tool + db + " 1 --set", 2);
}

}  // namespace
}  // namespace hoist::tool::twin
