// Parameter sets (hazard H27), neutral, pose: all or nothing, checked here whatever the server checked.
#include <gtest/gtest.h>

#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::CommandKind;
using contract::EventKind;
using contract::Mode;
using contract::ParamName;
using contract::Refusal;
using contract::refusal_bit;

constexpr std::uint32_t kTherapist = 1, kEngineer = 2;

std::uint32_t id_of(ParamName name) { return contract::kParams[contract::param_index(name)].id; }

bool same(const contract::Params& a, const contract::Params& b) {
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    if (contract::get_param(a, i) != contract::get_param(b, i)) return false;
  return true;
}

struct Row {
  ParamName name;
  double value;
};

// Stages the rows and commits them; the answer to the commit.
std::uint32_t set(ScriptedHoist& hoist, std::initializer_list<Row> rows, std::uint32_t role = kEngineer, std::uint32_t client = 7) {
  std::uint32_t n = 0;
  for (const Row& row : rows) hoist.send(CommandKind::stage_parameter, client, id_of(row.name), n++, row.value);
  return hoist.ask(CommandKind::commit_parameters, client, n, role);
}

TEST(Parameters, ASetIsTakenOverAtOnceWithOneVersion) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const auto version = hoist.out.record.parameter_version;
  EXPECT_EQ(set(hoist, {{ParamName::lean_gain_filtered_units, 40}, {ParamName::lean_range_rad, 0.2}}), 0U);
  EXPECT_EQ(hoist.out.record.parameter_version, version + 1);
  EXPECT_TRUE(hoist.out.params_changed);
  EXPECT_EQ(hoist.state.params.lean_gain_filtered_units, 40);
  EXPECT_EQ(hoist.count(EventKind::parameter_changed), 2);
  const auto& last = hoist.events[hoist.events.size() - 2];
  EXPECT_EQ(last.kind, EventKind::parameter_changed);
  EXPECT_EQ(last.value, 0.2);
  EXPECT_NEAR(last.before, 0.174532925, 1e-12);
  EXPECT_NEAR(hoist.state.derived.range.dx_max_m, 0.8 * std::tan(0.2), 1e-12) << "what follows from them follows at once";
  hoist.step();
  EXPECT_FALSE(hoist.out.params_changed);
}

TEST(Parameters, H27EachWrongSetIsRefusedWhole) {
  struct Case {
    const char* name;
    std::vector<Row> rows;
    Refusal refusal;
    std::uint32_t role;
  };
  const Case cases[] = {
      {"not a number", {{ParamName::lean_gain_filtered_units, NAN}}, Refusal::out_of_order, kEngineer},
      {"two right, one beyond",
       {{ParamName::lean_gain_filtered_units, 40}, {ParamName::lean_tau_normal_s, 61}, {ParamName::turn_gain_direct_units, 3}},
       Refusal::out_of_order,
       kEngineer},
      {"contradiction", {{ParamName::battery_low_v, 21.5}}, Refusal::inconsistent_set, kEngineer},
      {"faster driving than top speed", {{ParamName::speed_m_s_max, 0.2}}, Refusal::inconsistent_set, kEngineer},
      {"therapist at the limits",
       {{ParamName::lean_gain_filtered_units, 40}, {ParamName::speed_m_s_max, 0.5}},
       Refusal::not_allowed,
       kTherapist},
      {"viewer", {{ParamName::lean_gain_filtered_units, 40}}, Refusal::not_allowed, 0},
      {"role that does not exist", {{ParamName::lean_gain_filtered_units, 40}}, Refusal::not_allowed, 3},
  };
  for (const Case& c : cases) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    const contract::Params before = hoist.state.params;
    const auto version = hoist.state.parameter_version;
    std::uint32_t n = 0;
    for (const Row& row : c.rows) hoist.send(CommandKind::stage_parameter, 7, id_of(row.name), n++, row.value);
    const std::uint32_t bits = hoist.ask(CommandKind::commit_parameters, 7, n, c.role);
    EXPECT_NE(bits & refusal_bit(c.refusal), 0U) << c.name << " " << bits;
    EXPECT_TRUE(same(hoist.state.params, before)) << c.name;
    EXPECT_EQ(hoist.state.parameter_version, version) << c.name;
    EXPECT_EQ(hoist.count(EventKind::parameter_changed), 0) << c.name;
    EXPECT_FALSE(hoist.out.params_changed) << c.name;
  }
}

TEST(Parameters, StagingNamesWhatIsWrong) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const std::uint32_t tau = id_of(ParamName::lean_tau_normal_s);
  EXPECT_EQ(hoist.ask(CommandKind::stage_parameter, 7, tau, 0, NAN), refusal_bit(Refusal::not_finite));
  EXPECT_EQ(hoist.events.back().item, tau);
  EXPECT_EQ(hoist.ask(CommandKind::stage_parameter, 7, tau, 0, 60.001), refusal_bit(Refusal::out_of_range));
  EXPECT_EQ(hoist.ask(CommandKind::stage_parameter, 7, 9999, 0, 1), refusal_bit(Refusal::unknown_item));
  EXPECT_EQ(hoist.ask(CommandKind::stage_parameter, 7, tau, 5, 1), refusal_bit(Refusal::out_of_order));
  EXPECT_EQ(hoist.ask(CommandKind::stage_parameter, 7, tau, 0, 9), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::stage_parameter, 7, tau, 1, 8), refusal_bit(Refusal::inconsistent_set)) << "the same row twice";
  EXPECT_EQ(hoist.ask(CommandKind::stage_parameter, 8, tau, 1, 8), refusal_bit(Refusal::out_of_order)) << "somebody else's set";
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 8, 1, kEngineer), refusal_bit(Refusal::out_of_order));
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 7, 2, kEngineer), refusal_bit(Refusal::out_of_order)) << "not as many as staged";
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 7, 1, kEngineer), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 7, 1, kEngineer), refusal_bit(Refusal::out_of_order)) << "committed once";
}

TEST(Parameters, WhileMovingOnlyLiveOnesChange) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(6, 100);
  EXPECT_EQ(set(hoist, {{ParamName::lean_range_rad, 0.2}}), refusal_bit(Refusal::only_when_stopped));
  EXPECT_EQ(set(hoist, {{ParamName::lean_gain_direct_units, 3}, {ParamName::lean_range_rad, 0.2}}),
            refusal_bit(Refusal::only_when_stopped));
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 2);
  EXPECT_EQ(set(hoist, {{ParamName::lean_gain_direct_units, 3}}), 0U);
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 3);
}

TEST(Parameters, NodeParametersReachEveryNodeOfTheKindAtStartAndOnChange) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  EXPECT_EQ(hoist.drive_left.written.size(), 4U);
  EXPECT_EQ(hoist.drive_right.written.size(), 4U);
  EXPECT_EQ(hoist.tilt_base.written.size(), 2U);
  EXPECT_EQ(hoist.io.written.size(), 0U);
  EXPECT_EQ(set(hoist, {{ParamName::drive_velocity_gain_v_s_rad, 0.2}}), 0U);
  EXPECT_NE(hoist.out.record.blocked_bits & refusal_bit(Refusal::nodes_missing), 0U) << "no start before the drives have it";
  hoist.step(10);
  ASSERT_EQ(hoist.drive_left.written.size(), 5U);
  ASSERT_EQ(hoist.drive_right.written.size(), 5U);
  EXPECT_EQ(hoist.drive_left.written.back().first, 0x220001U);
  EXPECT_EQ(hoist.drive_left.written.back().second, 0.2F);
  EXPECT_EQ(hoist.out.record.blocked_bits & refusal_bit(Refusal::nodes_missing), 0U);
}

TEST(Parameters, ANodeThatRefusesItsParametersIsNotUsed) {
  ScriptedHoist hoist;
  hoist.drive_left.sdo_aborts = true;
  hoist.step(600);
  EXPECT_EQ(hoist.state.mode, Mode::init);
  EXPECT_LT(hoist.drive_left.sdo_requests, 12U) << "it is asked again only after a rest";
  hoist.drive_left.sdo_aborts = false;
  EXPECT_TRUE(hoist.to_standby());
}

TEST(Parameters, ADeafNodeIsAskedThreeTimesAndThenRests) {
  ScriptedHoist hoist;
  hoist.tilt_left.sdo_deaf = true;
  hoist.step(100);
  EXPECT_EQ(hoist.tilt_left.sdo_requests, 3U);
  EXPECT_EQ(hoist.state.mode, Mode::init);
}

TEST(Parameters, TheWholeTableInOneSetLosesNoEvent) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  std::uint32_t n = 0;
  for (const auto& p : contract::kParams) {
    hoist.send(CommandKind::stage_parameter, 7, p.id, n++, p.default_value);
    if (n % 40 == 0) hoist.step();
  }
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 7, n, kEngineer), ~0U) << "the answer comes behind the changes";
  hoist.step(3);
  EXPECT_EQ(hoist.count(EventKind::parameter_changed), static_cast<int>(contract::kParamCount));
  EXPECT_EQ(hoist.count(EventKind::command_refused), 0);
  EXPECT_EQ(hoist.state.events.dropped(), 0U);
}

TEST(Parameters, LoadedOnlyWhenSoundAndBeforeTheFirstStep) {
  CoreState state;
  contract::Params p;
  p.lean_gain_direct_units = 4;
  p.speed_cap_norm = NAN;
  EXPECT_FALSE(load_params(state, p));
  p.speed_cap_norm = 0.1;
  EXPECT_FALSE(load_params(state, p)) << "below its range";
  p.speed_cap_norm = 0.5;
  p.remote_slow_age_s = 0.2;
  p.remote_stop_age_s = 0.2;
  EXPECT_FALSE(load_params(state, p)) << "contradiction";
  EXPECT_EQ(state.params.lean_gain_direct_units, 2);
  p.remote_stop_age_s = 0.25;
  EXPECT_TRUE(load_params(state, p));
  EXPECT_EQ(state.params.lean_gain_direct_units, 4);
  TickOutputs out;
  tick(state, TickInputs{}, kTick_s, out);
  EXPECT_FALSE(load_params(state, contract::Params{}));
}

TEST(Neutral, IsTheMeanOfTheLastSecond) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.lean(3, 2);
  hoist.step(50);
  EXPECT_EQ(hoist.ask(CommandKind::set_neutral), refusal_bit(Refusal::moving)) << "half upright, half leaning is no posture";
  hoist.step(110);
  EXPECT_EQ(hoist.ask(CommandKind::set_neutral), 0U);
  EXPECT_NEAR(hoist.state.params.neutral_lean_m, 0.8 * std::tan(3 * kDeg), 2e-4);
  EXPECT_GT(hoist.state.params.neutral_turn_rad, 0.02);
  EXPECT_EQ(hoist.count(EventKind::neutral_set), 1);
  EXPECT_EQ(hoist.count(EventKind::parameter_changed), 2);
  hoist.step(2);
  EXPECT_NEAR(hoist.out.record.lean_norm, 0, 0.01);
  EXPECT_NEAR(hoist.out.record.turn_norm, 0, 0.01);
}

TEST(Neutral, TooFarAwayOrNotStandingIsRefused) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.lean(8);  // 0.112 m
  hoist.step(120);
  EXPECT_EQ(hoist.ask(CommandKind::set_neutral), refusal_bit(Refusal::out_of_range));
  EXPECT_EQ(hoist.state.params.neutral_lean_m, 0);
  ScriptedHoist walking;
  ASSERT_TRUE(walking.start(Mode::user));
  EXPECT_EQ(walking.ask(CommandKind::set_neutral), refusal_bit(Refusal::only_when_stopped));
}

TEST(Pose, IsSetAtStandstillOnly) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, 1.5, -2.0, 0.7), 0U);
  EXPECT_FLOAT_EQ(hoist.out.record.x_m, 1.5F);
  EXPECT_FLOAT_EQ(hoist.out.record.y_m, -2.0F);
  EXPECT_FLOAT_EQ(hoist.out.record.psi_rad, 0.7F);
  EXPECT_EQ(hoist.out.record.distance_m, 0.0F);
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, NAN, 0, 0), refusal_bit(Refusal::not_finite));
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, 0, 2000, 0), refusal_bit(Refusal::out_of_range));
  EXPECT_FLOAT_EQ(hoist.out.record.x_m, 1.5F);
  hoist.drive_left.forced_m_s = 0.1;
  hoist.step(3);
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, 0, 0, 0), refusal_bit(Refusal::moving));
}

}  // namespace
}  // namespace hoist::core::test
