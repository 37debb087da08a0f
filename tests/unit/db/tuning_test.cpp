// Suggested settings: the formulas, what sessions give, and what is refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>

#include "control/contract/shared_memory.hpp"
#include "db/advice/tuning.hpp"
#include "tests/support/shell.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db {
namespace {

using contract::Mode;
using contract::ParamName;
using test::TemporaryFolder;

/// Lean or turn of a patient who sways evenly while standing: a sine's 95 % point is 0.997 of its amplitude.
NormCounts sway(double amplitude_norm, double middle_norm, double seconds = 30) {
  NormCounts out;
  for (int i = 0; i < static_cast<int>(std::lround(seconds * 100)); ++i)
    out.add(middle_norm + amplitude_norm * std::sin(2 * std::numbers::pi * 0.5 * i * 0.01));
  return out;
}

TEST(Tuning, TheDeadBandHoldsTheSwayOfStanding) {
  const Suggestion calm = band_advice(sway(0.08, 0.02), 0.05);
  EXPECT_EQ(calm.why, NoAdvice::none);
  EXPECT_NEAR(calm.measured, 0.0798, 0.0005);
  EXPECT_DOUBLE_EQ(calm.suggested, 0.12) << "1.25 x 0.0798 + 0.02 = 0.1198";
  EXPECT_GT(calm.effect_now, 0.5);
  EXPECT_EQ(calm.effect_then, 0.0);
  EXPECT_DOUBLE_EQ(band_advice(sway(0.01, 0.001), 0.2).suggested, kBandLeast_norm);
  EXPECT_DOUBLE_EQ(band_advice(sway(0.4, 0), 0.05).suggested, kBandMost_norm);
  EXPECT_DOUBLE_EQ(band_advice(sway(0.032, 0), 0.05).suggested, 0.05) << "one step is no difference";
}

TEST(Tuning, ABandIsRefusedWithItsReason) {
  EXPECT_EQ(band_advice(sway(0.05, 0, 9.9), 0.05).why, NoAdvice::little_standing);
  EXPECT_EQ(band_advice(NormCounts{}, 0.05).why, NoAdvice::little_standing);
  EXPECT_EQ(band_advice(sway(0.02, 0.11), 0.05).why, NoAdvice::not_upright);
  EXPECT_EQ(band_advice(sway(0.02, -0.11), 0.05).why, NoAdvice::not_upright);
  EXPECT_EQ(band_advice(sway(0.005, 0), 0.05).why, NoAdvice::no_sway) << "an empty harness";
}

TEST(Tuning, CountsGiveTheSameAsSorting) {
  NormCounts counts;
  std::vector<double> values;
  for (int i = 0; i < 2001; ++i) {
    values.push_back(std::round(std::sin(i * 0.37) * 7000 + 1500) / 10000);
    counts.add(values.back());
  }
  const double beyond = static_cast<double>(std::ranges::count_if(values, [](double v) { return std::fabs(v) >= 0.5; })) / 2001.0;
  std::ranges::sort(values);
  const double middle = values[1000];
  EXPECT_DOUBLE_EQ(counts.middle(), middle);
  EXPECT_DOUBLE_EQ(counts.share_beyond(0.5), beyond);
  for (double& value : values) value = std::fabs(value - middle);
  std::ranges::sort(values);
  EXPECT_NEAR(counts.apart(0.95), values[1900], 1e-12);
}

TEST(Tuning, AGainBringsTheLeanIntoItsRangeInSteps) {
  const auto lean = [](double mean_norm, double filtered_units) {
    return gain_advice(mean_norm, 2, filtered_units, ParamName::lean_gain_filtered_units);
  };
  EXPECT_DOUBLE_EQ(lean(0.3, 50).suggested, 50);
  EXPECT_DOUBLE_EQ(lean(kEaseLeast_norm, 50).suggested, 50);
  EXPECT_DOUBLE_EQ(lean(kEaseMost_norm, 50).suggested, 50);
  const Suggestion hard = lean(0.6, 50);
  EXPECT_DOUBLE_EQ(hard.suggested, 62.5) << "a quarter at most";
  EXPECT_NEAR(hard.effect_then, 0.6 * 52 / 64.5, 1e-12);
  EXPECT_DOUBLE_EQ(lean(0.1, 50).suggested, 37.5);
  EXPECT_DOUBLE_EQ(lean(0.6, 95).suggested, 100) << "never beyond the parameter's range";
  EXPECT_DOUBLE_EQ(lean(0.1, 0).suggested, 0) << "nor below it";
}

/// A walk as recorded: 20 s standing, 40 s walking along a bend of 10 degrees a second, with a stride of 1.6 s.
struct Made {
  std::function<void(double t, contract::TickRecord&)> change = [](double, contract::TickRecord&) {};
  bool parameters = true;
};
std::vector<double> defaults() {
  std::vector<double> values;
  for (const contract::ParamInfo& info : contract::kParams) values.push_back(info.default_value);
  return values;
}
void append(SessionWriter& writer, std::span<const contract::TickRecord> records) {
  for (; !records.empty(); records = records.subspan(std::min<std::size_t>(1000, records.size())))
    EXPECT_TRUE(writer.append_ticks(records.first(std::min<std::size_t>(1000, records.size()))).ok());
}
SessionId record(const Made& made, Database& database) {
  SessionWriter writer = std::move(*SessionWriter::create(database));
  const std::vector<double> values = defaults();
  SessionStart start;
  start.started_utc_ns = test::kStartUtc_ns;
  start.start_time_ns = test::kStart_ns;
  start.core_start_time_ns = 1;
  start.layout_hash = contract::layout_hash();
  if (made.parameters) start.parameter_values = values;
  const SessionId session = *writer.begin(start);
  test::Walk walk(3);
  std::vector<contract::TickRecord> records;
  for (std::uint64_t tick = 0; tick < 6000; ++tick) {
    contract::TickRecord r = walk.record(tick);
    const double t = static_cast<double>(tick) * 0.01;
    const bool walks = t >= 20;
    const auto stride = static_cast<float>(std::sin(2 * std::numbers::pi * t / 1.6));
    r.mode = static_cast<std::uint8_t>(walks ? Mode::user : Mode::standby);
    r.standing_still = walks ? 0 : 1;
    r.tilt_left_age_ticks = r.tilt_right_age_ticks = r.tilt_base_age_ticks = 0;
    r.parameter_version = 7;
    r.lean_norm = walks ? 0.55F : 0.06F * stride;
    r.turn_norm = walks ? 0.15F : 0.02F * stride;
    r.speed_m_s = walks ? 0.3F : 0.0F;
    r.fused_yaw_rate_rad_s = walks ? 0.17F : 0.0F;
    r.yaw_rate_command_rad_s = walks ? 0.17F + 0.02F * stride : 0.0F;
    r.dy_m = walks ? 0.03F * stride : 0.0F;
    made.change(t, r);
    records.push_back(r);
  }
  append(writer, records);
  EXPECT_TRUE(writer.end(CloseReason::finished, start.started_utc_ns + 60'000'000'000).ok());
  return session;
}
TuningAdvice advice_for(const Made& made) {
  TemporaryFolder folder;
  Database database = std::move(*Database::open(folder / "r.db"));
  const SessionId session = record(made, database);
  const auto advice = tuning_advice(database, session);
  EXPECT_TRUE(advice.ok()) << advice.error().message;
  return advice.ok() ? *advice : TuningAdvice{};
}
enum : std::size_t { kLeanBand, kTurnBand, kLeanGain, kTurnGain, kCadence };

TEST(Tuning, ASessionGivesWhatItsNoiseSays) {
  const TuningAdvice advice = advice_for({});
  EXPECT_NEAR(advice.standing_s, 18, 0.05);
  EXPECT_NEAR(advice.walking_s, 40, 0.05);
  for (const Suggestion& suggestion : advice.suggestions) EXPECT_EQ(suggestion.why, NoAdvice::none);
  EXPECT_DOUBLE_EQ(advice.suggestions[kLeanBand].suggested, 0.08);
  EXPECT_DOUBLE_EQ(advice.suggestions[kTurnBand].suggested, 0.03);
  EXPECT_DOUBLE_EQ(advice.suggestions[kLeanGain].suggested, 62.5);
  EXPECT_DOUBLE_EQ(advice.suggestions[kTurnGain].suggested, 37.5);
  EXPECT_DOUBLE_EQ(advice.suggestions[kCadence].suggested, 1.0);
  EXPECT_NEAR(advice.suggestions[kCadence].measured, 0.02 / std::sqrt(2.0), 0.0005);
  for (std::size_t i = 0; i < kTuningRules.size(); ++i) {
    const contract::ParamInfo& info = contract::kParams[contract::param_index(kTuningRules[i].param)];
    EXPECT_GE(advice.suggestions[i].suggested, info.min);
    EXPECT_LE(advice.suggestions[i].suggested, info.max);
  }
}

/// The patient's standby of 90 s that ends where the walk begins; in its first 25 s the patient is helped into the harness.
struct Before {
  double neutral_lean_m = 0;
  std::uint64_t apart_ticks = 1;
};
TuningAdvice advice_after(const Before& before) {
  TemporaryFolder folder;
  Database database = std::move(*Database::open(folder / "r.db"));
  SessionWriter writer = std::move(*SessionWriter::create(database));
  std::vector<double> values = defaults();
  SessionStart start;
  start.subject = "P-1";
  start.started_utc_ns = test::kStartUtc_ns;
  start.start_time_ns = test::kStart_ns;
  start.core_start_time_ns = 1;
  start.layout_hash = contract::layout_hash();
  start.standby = true;
  values[contract::param_index(ParamName::neutral_lean_m)] = before.neutral_lean_m;
  start.parameter_values = values;
  test::Walk walk(3);
  std::vector<contract::TickRecord> records;
  const auto add = [&](std::uint64_t tick, double lean_norm, Mode mode) {
    contract::TickRecord r = walk.record(tick);
    r.mode = static_cast<std::uint8_t>(mode);
    r.standing_still = mode == Mode::standby ? 1 : 0;
    r.tilt_left_age_ticks = r.tilt_right_age_ticks = r.tilt_base_age_ticks = 0;
    r.parameter_version = 7;
    r.lean_norm = static_cast<float>(lean_norm);
    records.push_back(r);
  };
  const auto store = [&] {
    append(writer, records);
    records.clear();
  };
  const auto stride = [](std::uint64_t tick) { return std::sin(2 * std::numbers::pi * static_cast<double>(tick) * 0.01 / 1.6); };
  EXPECT_TRUE(writer.begin(start).ok());
  for (std::uint64_t tick = 0; tick < 9000; ++tick) add(tick, tick < 2500 ? 0.9 : 0.06 * stride(tick), Mode::standby);
  store();
  EXPECT_TRUE(writer.end(CloseReason::finished, start.started_utc_ns + 90'000'000'000).ok());
  const std::uint64_t first = 8999 + before.apart_ticks;
  start.standby = false;
  start.started_utc_ns += 100'000'000'000;
  start.start_time_ns += first * test::kTick_ns;
  values = defaults();
  start.parameter_values = values;
  const SessionId session = *writer.begin(start);
  for (std::uint64_t tick = first; tick < first + 1000; ++tick) add(tick, 0.3, Mode::user);
  store();
  EXPECT_TRUE(writer.end(CloseReason::finished, start.started_utc_ns + 10'000'000'000).ok());
  const auto advice = tuning_advice(database, session);
  EXPECT_TRUE(advice.ok()) << advice.error().message;
  return advice.ok() ? *advice : TuningAdvice{};
}

TEST(Tuning, TheStandbyJustBeforeTheWalkTellsHowThePatientStands) {
  const TuningAdvice advice = advice_after({});
  EXPECT_NEAR(advice.standing_s, 58, 0.1) << "its last minute, without a second at both ends";
  EXPECT_EQ(advice.suggestions[kLeanBand].why, NoAdvice::none);
  EXPECT_DOUBLE_EQ(advice.suggestions[kLeanBand].suggested, 0.08);
  EXPECT_EQ(advice_after({.neutral_lean_m = 0.01}).standing_s, 0) << "lean means something else";
  EXPECT_EQ(advice_after({.apart_ticks = 400}).standing_s, 0) << "the walk does not follow it";
}

TEST(Tuning, WhatASessionCannotBearIsRefusedWithItsReason) {
  const auto why = [](std::size_t which, const Made& made) { return advice_for(made).suggestions[which].why; };
  // Motion of the wheels, a stale sensor, and gaps end a time of standing.
  EXPECT_EQ(why(kLeanBand, {[](double t, contract::TickRecord& r) { r.standing_still = t < 11.5 ? 0 : r.standing_still; }}),
            NoAdvice::little_standing);
  EXPECT_EQ(why(kTurnBand, {[](double t, contract::TickRecord& r) { r.tilt_left_age_ticks = t < 11.5 ? 3 : 0; }}),
            NoAdvice::little_standing);
  EXPECT_EQ(why(kLeanBand, {[](double t, contract::TickRecord& r) { r.lean_norm += t < 20 ? 0.2F : 0.0F; }}), NoAdvice::not_upright);
  // Driven by the therapist is not led by the patient.
  const Made driven{[](double, contract::TickRecord& r) {
    if (r.mode == static_cast<std::uint8_t>(Mode::user)) r.mode = static_cast<std::uint8_t>(Mode::remote);
  }};
  EXPECT_EQ(why(kLeanGain, driven), NoAdvice::little_walking);
  EXPECT_EQ(why(kTurnGain, driven), NoAdvice::no_turning);
  EXPECT_EQ(why(kTurnGain, {[](double, contract::TickRecord& r) { r.fused_yaw_rate_rad_s = 0.08F; }}), NoAdvice::no_turning);
  EXPECT_EQ(why(kCadence, {[](double, contract::TickRecord& r) { r.dy_m = 0; }}), NoAdvice::no_rhythm);
  EXPECT_EQ(why(kLeanGain, {[](double t, contract::TickRecord& r) { r.parameter_version = t < 50 ? 7 : 8; }}), NoAdvice::settings_changed);
  EXPECT_EQ(why(kLeanGain, {[](double, contract::TickRecord&) {}, false}), NoAdvice::not_recorded);
}

// The command prints what the formulas give; `next` names one changed setting for each answer.
TEST(Tuning, TheCommandTellsAndRefuses) {
  TemporaryFolder folder;
  const std::string file = (folder / "r.db").string();
  {
    Database database = std::move(*Database::open(file));
    record({}, database);
  }
  const std::string tool = std::string(HOIST_BINARY_DIR) + "/bin/hoist tune-advice ";
  const auto run = [](const std::string& command, int expected) {
    const hoist::test::ShellResult result = hoist::test::run_shell(command + " 2>&1");
    EXPECT_EQ(result.exit_code, expected) << command << "\n" << result.output;
    return result.output;
  };
  const std::string told = run(tool + file + " 1", 0);
  EXPECT_NE(told.find("lean_gain_filtered_units: 50 -> 62.5"), std::string::npos) << told;
  EXPECT_NE(told.find("Advice only"), std::string::npos);
  const auto rows = nlohmann::json::parse(run(tool + file + " 1 --json", 0));
  EXPECT_EQ(rows["items"][0]["name"], "lean_dead_band_norm");
  EXPECT_EQ(rows["items"][0]["suggested"], 0.08);
  EXPECT_NE(run(tool + "next " + file + " 1", 0).find("walk next with   :  lean_gain_filtered_units=60"), std::string::npos);
  EXPECT_NE(run(tool + "next " + file + " 1 better worse", 0).find("lean_gain_filtered_units=60  lean_tau_normal_s=12"), std::string::npos);
  EXPECT_NE(run(tool + "next " + file + " 1 perhaps", 2).find("better, worse or same"), std::string::npos);
  run(tool + file + " 9", 1);
  run(tool + file, 2);
}

}  // namespace
}  // namespace hoist::db
