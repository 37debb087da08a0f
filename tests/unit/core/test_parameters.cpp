// Parameter sets (hazard H27), neutral, pose: all or nothing, checked here independently of the server.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "control/core/serve/param_keeper.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::ParamName;

std::uint32_t id_of(ParamName name) { return contract::kParams[contract::param_index(name)].id; }

bool same(const contract::Params& a, const contract::Params& b) {
  for (std::size_t i = 0; i < contract::kParamCount; ++i)
    if (contract::get_param(a, i) != contract::get_param(b, i)) return false;
  return true;
}

bool is_moving_now(const ScriptedHoist& hoist) { return hoist.state.mode == Mode::user; }

bool all_changes(const ScriptedHoist& hoist, contract::InEffect in_effect) {
  return std::ranges::all_of(hoist.events, [&](const contract::Event& event) {
    return event.kind != EventKind::parameter_changed || event.code == static_cast<std::uint32_t>(in_effect);
  });
}

struct Row {
  ParamName name;
  double value;
};

// Stages the rows and commits them; the answer to the commit.
std::uint32_t set(ScriptedHoist& hoist, const std::vector<Row>& rows, std::uint32_t role = kEngineer, std::uint32_t client = 7) {
  std::uint32_t n = 0;
  for (const Row& row : rows) hoist.send(CommandKind::stage_parameter, client, id_of(row.name), n++, row.value);
  return hoist.ask(CommandKind::commit_parameters, client, n, role);
}

TEST(Parameters, ASetIsTakenOverAtOnceWithOneVersion) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const auto version = hoist.out.record.parameter_version;
  EXPECT_EQ(set(hoist, {{ParamName::lean_gain_filtered_units, 40}, {ParamName::lean_range_rad, 0.12}}), 0U);
  EXPECT_EQ(hoist.out.record.parameter_version, version + 1);
  EXPECT_TRUE(hoist.out.params_changed);
  EXPECT_EQ(hoist.state.params.lean_gain_filtered_units, 40);
  EXPECT_EQ(hoist.count(EventKind::parameter_changed), 2);
  const auto& last = hoist.events[hoist.events.size() - 2];
  EXPECT_EQ(last.kind, EventKind::parameter_changed);
  EXPECT_EQ(last.value, 0.12);
  EXPECT_NEAR(last.before, contract::Params{}.lean_range_rad, 1e-12);
  EXPECT_NEAR(hoist.state.derived.range.dx_max_m, 0.8 * std::tan(0.12), 1e-12) << "what follows from them follows at once";
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
  EXPECT_EQ(hoist.ask(CommandKind::stage_parameter, 8, tau, 1, 8), refusal_bit(Refusal::out_of_order)) << "another client's set";
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 8, 1, kEngineer), refusal_bit(Refusal::out_of_order));
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 7, 2, kEngineer), refusal_bit(Refusal::out_of_order)) << "not as many as staged";
  // The rows that were refused are not part of the set.
  hoist.seal = {};
  hoist.seal.add(tau, 9);
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 7, 1, kEngineer), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 7, 1, kEngineer), refusal_bit(Refusal::out_of_order)) << "committed once";
}

TEST(Parameters, WhileMovingOnlyLiveOnesChange) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(6, 100);
  EXPECT_EQ(set(hoist, {{ParamName::lean_range_rad, 0.12}}), refusal_bit(Refusal::only_when_stopped));
  EXPECT_EQ(set(hoist, {{ParamName::lean_gain_direct_units, 3}, {ParamName::lean_range_rad, 0.12}}),
            refusal_bit(Refusal::only_when_stopped));
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 2);
  EXPECT_EQ(set(hoist, {{ParamName::lean_gain_direct_units, 3}}), 0U);
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 3);
}

TEST(Parameters, NodeParametersReachEveryNodeOfTheKindAtStartAndOnChange) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  // And what must hold its default, which these nodes did not have: five objects of a drive, three of the input node.
  EXPECT_EQ(hoist.drive_left.written.size(), 4U + 5U);
  EXPECT_EQ(hoist.drive_right.written.size(), 4U + 5U);
  EXPECT_EQ(hoist.tilt_base.written.size(), 2U);
  EXPECT_EQ(hoist.io.written.size(), 3U);
  EXPECT_EQ(set(hoist, {{ParamName::drive_velocity_gain_v_s_rad, 0.2}}), 0U);
  EXPECT_NE(hoist.out.record.blocked_bits & refusal_bit(Refusal::nodes_missing), 0U) << "no start before the drives have it";
  hoist.step(10);
  ASSERT_EQ(hoist.drive_left.written.size(), 10U);
  ASSERT_EQ(hoist.drive_right.written.size(), 10U);
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
  EXPECT_EQ(hoist.ask(CommandKind::commit_parameters, 7, n, kEngineer), 0U) << "all in the step of the commit";
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

// ----- H27: seal, version, damage -----

TEST(Parameters, H27ASetThatArrivedDamagedOrLateIsRefusedWhole) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const std::uint32_t gain = id_of(ParamName::lean_gain_filtered_units);
  const auto commit = [&](std::uint64_t seal) {
    hoist.send(CommandKind::stage_parameter, 7, gain, 0, 40);
    const std::uint32_t id = hoist.send(CommandKind::commit_parameters, 7, 1, kEngineer);
    hoist.commands.back().bits = seal;
    hoist.step();
    return hoist.answer(id);
  };
  contract::ParamSetSeal meant;
  meant.add(gain, 40);
  contract::ParamSetSeal other_value;
  other_value.add(gain, 40.000000001);
  const auto version = static_cast<std::uint32_t>(hoist.state.parameter_version);
  EXPECT_EQ(commit(0), refusal_bit(Refusal::set_outdated)) << "no seal is none";
  EXPECT_EQ(commit(other_value.value()), refusal_bit(Refusal::set_outdated)) << "not what was meant";
  EXPECT_EQ(commit(meant.value(version + 1)), refusal_bit(Refusal::set_outdated)) << "made for other parameters";
  for (unsigned bit = 0; bit < 32; ++bit) ASSERT_NE(commit(meant.value() ^ (1ULL << bit)), 0U) << bit;
  EXPECT_EQ(hoist.state.params.lean_gain_filtered_units, 50);
  EXPECT_EQ(hoist.state.parameter_version, version);
  EXPECT_EQ(commit(meant.value(version)), 0U);
  EXPECT_EQ(commit(meant.value(version)), refusal_bit(Refusal::set_outdated)) << "another client was faster";
}

TEST(Parameters, H27EveryBitThatFlipsInMemoryIsFoundAndMended) {
  for (std::size_t bit = 0; bit < sizeof(contract::Params) * 8; bit += 7) {
    ScriptedHoist hoist;
    hoist.state.params.lean_gain_direct_units = 3;
    install_params(hoist.state, hoist.state.params);
    ASSERT_TRUE(hoist.ready());
    const contract::Params before = hoist.state.params;
    auto* bytes = reinterpret_cast<unsigned char*>(bit % 2 == 0 ? &hoist.state.params : &hoist.state.seal.copy);
    bytes[bit / 8] = static_cast<unsigned char>(bytes[bit / 8] ^ (1U << (bit % 8)));
    hoist.step();
    ASSERT_EQ(hoist.state.mode, Mode::fault) << bit;
    ASSERT_TRUE(hoist.has_fault(contract::Fault::parameters_corrupt));
    ASSERT_TRUE(same(hoist.state.params, before)) << "the copy that was whole is in force";
    ASSERT_TRUE(hoist.out.params_changed);
  }
}

TEST(Parameters, H27DamageInBothCopiesLeavesTheDefaults) {
  ScriptedHoist hoist;
  hoist.state.params.lean_gain_direct_units = 3;
  install_params(hoist.state, hoist.state.params);
  ASSERT_TRUE(hoist.ready());
  hoist.state.params.speed_m_s_max = 6.5;
  hoist.state.seal.copy.speed_m_s_max = 65;
  hoist.step();
  EXPECT_EQ(hoist.state.mode, Mode::fault);
  EXPECT_TRUE(same(hoist.state.params, contract::Params{}));
  EXPECT_TRUE(hoist.state.defaults_after_damage) << "nobody chose them, and nobody stores them";
  hoist.step(200);
  ASSERT_EQ(hoist.ask(CommandKind::acknowledge, 7, 0, kEngineer), 0U);
  ASSERT_TRUE(hoist.reach(Mode::standby));
  EXPECT_TRUE(hoist.state.defaults_after_damage);
  ASSERT_EQ(set(hoist, {{ParamName::lean_gain_direct_units, 4}}), 0U);
  EXPECT_FALSE(hoist.state.defaults_after_damage) << "a client that sets one has seen the others";
}

// The gains as the laws see them, and what follows from the table, decide as much as the table does.
TEST(Parameters, H27DamageBesideTheTableIsFoundAndMendedToo) {
  struct Case {
    const char* name;
    double& (*where)(CoreState&);
  };
  for (const Case& c : {Case{"a gain", [](CoreState& s) -> double& { return s.live.lean_gain_direct_units; }},
                        Case{"a cap", [](CoreState& s) -> double& { return s.live.speed_cap_norm; }},
                        Case{"motor", [](CoreState& s) -> double& { return s.derived.left_motor_per_m; }},
                        Case{"track", [](CoreState& s) -> double& { return s.derived.odometry.track_m; }},
                        Case{"range", [](CoreState& s) -> double& { return s.derived.range.dx_max_m; }},
                        Case{"neutral", [](CoreState& s) -> double& { return s.derived.neutral.dpsi0_rad; }},
                        Case{"struts", [](CoreState& s) -> double& { return s.derived.geometry.strut_length_m; }},
                        Case{"zero", [](CoreState& s) -> double& { return s.derived.right_zero.beta_rad; }},
                        Case{"their copy", [](CoreState& s) -> double& { return s.seal.derived.right_counts_per_s_max; }}}) {
    SCOPED_TRACE(c.name);
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    const double sound = c.where(hoist.state);
    c.where(hoist.state) = sound + 0.01;
    hoist.step();
    EXPECT_EQ(hoist.state.mode, Mode::fault);
    EXPECT_TRUE(hoist.has_fault(contract::Fault::parameters_corrupt));
    EXPECT_EQ(c.where(hoist.state), sound);
  }
}

TEST(Parameters, H27DamageWhileWalkingStopsOnTheRampOfSoundOnes) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(7, 300);
  ASSERT_GT(hoist.command_m_s(), 0.3);
  hoist.worst_deceleration_m_s2 = 0;
  hoist.state.params.protective_deceleration_m_s2 = 40;
  hoist.step();
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  hoist.lean(0);
  EXPECT_TRUE(hoist.reach(Mode::fault, 300));
  EXPECT_LE(hoist.worst_deceleration_m_s2, 1.0 + 1e-9);
}

// ----- H27: gains while walking -----

TEST(Gains, H27NeverMoveFasterThanTwentyPercentASecond) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(6, 100);
  ASSERT_EQ(
      set(hoist, {{ParamName::lean_gain_direct_units, 4}, {ParamName::lean_tau_normal_s, 5}, {ParamName::reversal_gain_norm, 0.0004}}), 0U);
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 4) << "the table holds what was set";
  contract::Params last = hoist.state.live;
  int ticks = 0;
  while (hoist.state.slewing && ticks < 3000) {
    hoist.step();
    ++ticks;
    for (std::size_t i = 0; i < contract::kParamCount; ++i) {
      const auto& info = contract::kParams[i];
      const double from = contract::get_param(last, i), to = contract::get_param(hoist.state.live, i);
      ASSERT_LE(std::abs(to - from), 0.2 * kTick_s * std::max(std::abs(from), 0.05 * (info.max - info.min)) * 1.0001) << info.name;
      ASSERT_GE(to, info.min);
      ASSERT_LE(to, info.max);
    }
    last = hoist.state.live;
  }
  EXPECT_TRUE(same(hoist.state.live, hoist.state.params)) << "and they arrive";
  EXPECT_NEAR(ticks * kTick_s, std::log(2.0) / 0.2, 0.3) << "twice or half as much takes 3.5 s";
  // Each arrival is an event of the step from which on the new value acts.
  EXPECT_EQ(hoist.count(EventKind::parameter_settled), 3);
  EXPECT_TRUE(all_changes(hoist, contract::InEffect::gradually));
  const contract::Event last_settled = hoist.events.back();
  EXPECT_EQ(last_settled.kind, EventKind::parameter_settled);
  EXPECT_EQ(last_settled.tick, hoist.state.tick);
  EXPECT_EQ(last_settled.value, contract::get_param(hoist.state.params, *contract::find_param_id(last_settled.item)));
}

TEST(Gains, AnArrivalIsToldOfTheNewestValueOnlyAndAlsoWhenTheDriveEnds) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  ASSERT_EQ(set(hoist, {{ParamName::lean_gain_direct_units, 4}}), 0U);
  hoist.step(20);
  ASSERT_EQ(set(hoist, {{ParamName::lean_gain_direct_units, 2}}), 0U);
  EXPECT_EQ(hoist.count(EventKind::parameter_settled), 0);
  ASSERT_EQ(hoist.ask(CommandKind::request_mode, 7, static_cast<std::uint32_t>(Mode::standby)), 0U);
  ASSERT_TRUE(hoist.reach(Mode::standby, 500));
  hoist.step(2);
  ASSERT_EQ(hoist.count(EventKind::parameter_settled), 1);
  const auto settled = std::ranges::find(hoist.events, EventKind::parameter_settled, &contract::Event::kind);
  EXPECT_EQ(settled->item, id_of(ParamName::lean_gain_direct_units));
  EXPECT_EQ(settled->value, 2);
}

TEST(Gains, H27AJumpOfAGainIsNoJumpOfTheSpeed) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(5, 200);
  float wish = hoist.out.record.speed_wish_m_s;
  ASSERT_EQ(set(hoist, {{ParamName::lean_gain_direct_units, 10}, {ParamName::lean_gain_filtered_units, 100}}), 0U);
  for (int i = 0; i < 400; ++i) {
    hoist.step();
    ASSERT_LE(std::abs(hoist.out.record.speed_wish_m_s - wish), 0.005F) << i;
    wish = hoist.out.record.speed_wish_m_s;
  }
}

TEST(Gains, OnStandbyAndForCapsThereIsNothingToWaitFor) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(set(hoist, {{ParamName::lean_gain_direct_units, 4}}), 0U);
  EXPECT_EQ(hoist.state.live.lean_gain_direct_units, 4);
  ASSERT_EQ(hoist.ask_mode(Mode::user), 0U);
  ASSERT_TRUE(hoist.run_until_powered());
  ASSERT_EQ(set(hoist, {{ParamName::speed_cap_norm, 0.2}}), 0U);
  EXPECT_EQ(hoist.state.live.speed_cap_norm, 0.2) << "a lower cap must not wait; the limiter makes it gentle";
  EXPECT_EQ(hoist.count(EventKind::parameter_settled), 0);
  EXPECT_TRUE(all_changes(hoist, contract::InEffect::at_once));
}

TEST(Gains, DrivesHearOfTheirGainsInSmallSteps) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  const std::size_t written = hoist.drive_left.written.size();
  ASSERT_EQ(set(hoist, {{ParamName::drive_velocity_gain_v_s_rad, 0.2}}), 0U);
  hoist.step(500);
  ASSERT_GT(hoist.drive_left.written.size(), written + 5);
  float last = 0.12F;
  for (std::size_t i = written; i < hoist.drive_left.written.size(); ++i) {
    const auto [object, value] = hoist.drive_left.written[i];
    ASSERT_EQ(object, 0x220001U);
    ASSERT_LE(value - last, 0.012F);
    last = value;
  }
  EXPECT_EQ(last, 0.2F);
}

// ----- H27: values on trial -----

// Stages and commits rows that go back after `seconds` unless confirmed.
std::uint32_t attempt(ScriptedHoist& hoist, std::initializer_list<Row> rows, double seconds, std::uint32_t role = kEngineer) {
  std::uint32_t n = 0;
  for (const Row& row : rows) hoist.send(CommandKind::stage_parameter, 7, id_of(row.name), n++, row.value);
  return hoist.ask(CommandKind::commit_parameters, 7, n, role, seconds);
}

TEST(TrialOfSettings, GoesBackByItselfWithWhatWasThereBefore) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  ASSERT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 4}}, 20), 0U);
  EXPECT_NEAR(hoist.out.record.settings_trial_s, 20, 0.02);
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 4);
  EXPECT_EQ(kept_param(hoist.state, contract::param_index(ParamName::lean_gain_direct_units)), 2) << "a restart would not find it";
  const auto version = hoist.state.parameter_version;
  hoist.server_up = false;  // no client is left to confirm
  hoist.step(1990);
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 4);
  hoist.step(15);
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 2);
  EXPECT_EQ(hoist.state.parameter_version, version + 1);
  EXPECT_EQ(hoist.count(EventKind::parameters_reverted), 1);
  EXPECT_EQ(hoist.out.record.settings_trial_s, 0.0F);
  EXPECT_EQ(hoist.state.mode, Mode::user) << "walking goes on";
}

TEST(TrialOfSettings, StaysWhenConfirmed) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  ASSERT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 4}}, 5), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::confirm_parameters, 7, 0, 0), refusal_bit(Refusal::not_allowed)) << "a viewer does not decide";
  EXPECT_EQ(hoist.ask(CommandKind::confirm_parameters, 7, 1, kTherapist), refusal_bit(Refusal::set_outdated)) << "another set was seen";
  const auto version = static_cast<std::uint32_t>(hoist.state.parameter_version);
  EXPECT_EQ(hoist.ask(CommandKind::confirm_parameters, 7, version, kTherapist), 0U);
  EXPECT_TRUE(hoist.out.params_changed) << "from now on it is to be stored";
  EXPECT_EQ(hoist.ask(CommandKind::confirm_parameters, 7, 0, kTherapist), refusal_bit(Refusal::out_of_order));
  hoist.step(1000);
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 4);
  EXPECT_EQ(kept_param(hoist.state, contract::param_index(ParamName::lean_gain_direct_units)), 4);
  EXPECT_EQ(hoist.count(EventKind::parameters_reverted), 0);
}

TEST(TrialOfSettings, IsUndoneOnRequest) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 4}, {ParamName::turn_gain_direct_units, 3}}, 60), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::revert_parameters, 7, 0, kTherapist), 0U);
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 2);
  EXPECT_EQ(hoist.state.params.turn_gain_direct_units, 2);
  EXPECT_EQ(hoist.ask(CommandKind::revert_parameters, 7, 0, kTherapist), refusal_bit(Refusal::out_of_order));
}

TEST(TrialOfSettings, ASecondTrialGoesBackToBeforeTheFirstAndWhatIsMeantStays) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 4}}, 5), 0U);
  ASSERT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 5}, {ParamName::turn_gain_direct_units, 3}}, 5), 0U);
  ASSERT_EQ(set(hoist, {{ParamName::turn_gain_direct_units, 6}, {ParamName::lean_range_rad, 0.12}}), 0U);
  hoist.step(600);
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 2);
  EXPECT_EQ(hoist.state.params.turn_gain_direct_units, 6);
  EXPECT_EQ(hoist.state.params.lean_range_rad, 0.12);
}

TEST(TrialOfSettings, IsOnlyForWhatMayChangeWhileMovingAndForASensibleTime) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  // So none of these rows ever goes back into the room of another.
  for (const contract::ParamRoom& room : contract::kParamRooms)
    for (const ParamName name : {room.smaller, room.larger})
      EXPECT_EQ(attempt(hoist, {{name, contract::get_param(hoist.state.params, contract::param_index(name))}}, 20),
                refusal_bit(Refusal::only_when_stopped))
          << "it would have to go back during a walk";
  EXPECT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 4}}, 0.5), refusal_bit(Refusal::out_of_range));
  EXPECT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 4}}, 121), refusal_bit(Refusal::out_of_range));
  EXPECT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 4}}, -1), refusal_bit(Refusal::out_of_range));
  EXPECT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 4}}, NAN), refusal_bit(Refusal::not_finite));
  EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 2);
}

TEST(TrialOfSettings, H27DamageEndsItWithWhatWasThereBefore) {
  for (const bool in_copy : {false, true}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    ASSERT_EQ(attempt(hoist, {{ParamName::lean_gain_direct_units, 4}, {ParamName::drive_velocity_gain_v_s_rad, 0.15}}, 60), 0U);
    hoist.step(2000);
    ASSERT_EQ(hoist.drive_left.written.back().second, 0.15F) << "the drives know it";
    contract::Params& hit = in_copy ? hoist.state.seal.copy : hoist.state.params;
    hit.lean_range_rad = 0.3;
    hoist.step();
    EXPECT_TRUE(hoist.has_fault(contract::Fault::parameters_corrupt));
    EXPECT_EQ(hoist.state.params.lean_gain_direct_units, 2) << "a damage keeps nothing that was only tried";
    EXPECT_EQ(kept_param(hoist.state, contract::param_index(ParamName::lean_gain_direct_units)), 2);
    EXPECT_EQ(hoist.state.trial.left_s, 0);
    EXPECT_EQ(hoist.count(EventKind::parameters_reverted), 1);
    EXPECT_FALSE(hoist.state.defaults_after_damage);
    hoist.step(50);
    for (const FakeDrive* drive : {&hoist.drive_left, &hoist.drive_right})
      EXPECT_EQ(drive->written.back().second, 0.12F) << "and they are told";
  }
}

TEST(TrialOfSettings, H27DamageInWhatIsToComeBackIsFoundBeforeItIsInForce) {
  for (const double wrong : {static_cast<double>(NAN), 50.0, 0.6}) {  // none, out of its range, does not fit the others
    SCOPED_TRACE(wrong);
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    ASSERT_EQ(set(hoist, {{ParamName::speed_m_s_max, 0.4}}), 0U);
    ASSERT_EQ(attempt(hoist, {{ParamName::remote_speed_m_s_max, 0.2}}, 60), 0U);
    hoist.state.trial.before.remote_speed_m_s_max = wrong;
    hoist.ask(CommandKind::revert_parameters, 7, 0, kTherapist);
    EXPECT_EQ(hoist.state.params.remote_speed_m_s_max, 0.2);
    EXPECT_EQ(contract::check_param_set(hoist.state.params), nullptr);
    EXPECT_TRUE(hoist.has_fault(contract::Fault::parameters_corrupt));
    EXPECT_EQ(hoist.state.mode, Mode::fault);
  }
}

// What no single order of two values says: the drives' own ramp against the hardest stop, at the wheel.
TEST(Parameters, H27ADriveRampBelowTheHardestStopIsRefused) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const auto inconsistent = refusal_bit(Refusal::inconsistent_set);
  EXPECT_EQ(set(hoist, {{ParamName::drive_acceleration_rad_s2, 400}}), inconsistent) << "1.33 m/s2 at the wheel, bumper stop 1.5";
  EXPECT_EQ(set(hoist, {{ParamName::drive_acceleration_rad_s2, 410}}), 0U) << "a tenth less passes";
  EXPECT_EQ(set(hoist, {{ParamName::wheel_radius_m, 0.09}}), inconsistent) << "a smaller wheel is slower, too";
  EXPECT_EQ(set(hoist, {{ParamName::wheel_left_scale_norm, 0.95}}), inconsistent);
  EXPECT_EQ(set(hoist, {{ParamName::wheel_right_scale_norm, 0.95}}), inconsistent);
  EXPECT_EQ(set(hoist, {{ParamName::wheel_radius_m, 0.09}, {ParamName::drive_acceleration_rad_s2, 450}}), 0U);
  EXPECT_EQ(set(hoist, {{ParamName::bumper_deceleration_m_s2, 1.0}, {ParamName::drive_acceleration_rad_s2, 410}}), 0U);
  EXPECT_EQ(set(hoist, {{ParamName::drive_acceleration_rad_s2, 390}}), inconsistent) << "1.17 m/s2, protective stop 1.0 and room above it";
  EXPECT_EQ(set(hoist, {{ParamName::protective_deceleration_m_s2, 0.8}, {ParamName::drive_acceleration_rad_s2, 325}}), 0U);
  EXPECT_NE(set(hoist, {{ParamName::protective_deceleration_m_s2, 0.79}}), 0U) << "gentler than letting go";
}

// H15, H16: full speed is reached below the lean that counts as a fall or as hanging; a therapist may not widen the range into the guards.
TEST(Parameters, H27FullSpeedStaysBelowTheGuardsAgainstFallsAndHanging) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const auto inconsistent = refusal_bit(Refusal::inconsistent_set);
  const auto refused = [&](const std::vector<Row>& rows, ParamName named) {
    EXPECT_EQ(set(hoist, rows), inconsistent);
    EXPECT_EQ(hoist.events.back().item, id_of(named));
  };
  refused({{ParamName::lean_range_rad, 0.16}}, ParamName::lean_range_rad);
  refused({{ParamName::lean_dead_band_norm, 0.1}, {ParamName::hang_tilt_rad, 0.17}}, ParamName::hang_tilt_rad);
  refused({{ParamName::lean_range_rad, 0.22}, {ParamName::hang_tilt_rad, 0.25}}, ParamName::lean_range_rad);
  EXPECT_EQ(set(hoist, {{ParamName::lean_range_rad, 0.16}, {ParamName::hang_tilt_rad, 0.18}}), 0U);
  refused({{ParamName::fall_tilt_rad, 0.15}, {ParamName::fall_static_tilt_rad, 0.17}}, ParamName::fall_static_tilt_rad);
  EXPECT_EQ(set(hoist, {{ParamName::lean_range_rad, 0.14}}), 0U);
  EXPECT_EQ(set(hoist, {{ParamName::hang_tilt_rad, 0.16}}), 0U);
}

// A machine that stored its settings before goes on with them, and a preset brings it to today's.
TEST(Parameters, H27OlderSettingsGoOnUntilTheyAreChanged) {
  contract::Params older;
  older.lean_range_rad = older.hang_tilt_rad = 0.174532925;
  for (const contract::PresetInfo& preset : contract::kPresets) {
    SCOPED_TRACE(preset.name);
    ScriptedHoist hoist(older);
    ASSERT_TRUE(hoist.ready());
    EXPECT_EQ(set(hoist, {{ParamName::speed_cap_norm, 0.5}}), 0U);
    EXPECT_EQ(set(hoist, {{ParamName::lean_range_rad, older.lean_range_rad}, {ParamName::speed_cap_norm, 0.6}}), 0U)
        << "nothing of it changes";
    EXPECT_EQ(set(hoist, {{ParamName::lean_range_rad, 0.17}}), refusal_bit(Refusal::inconsistent_set));
    EXPECT_EQ(set(hoist, {{ParamName::lean_range_rad, older.lean_range_rad}, {ParamName::hang_tilt_rad, 0.17}}),
              refusal_bit(Refusal::inconsistent_set));
    EXPECT_EQ(hoist.events.back().item, id_of(ParamName::hang_tilt_rad));
    std::vector<Row> rows;
    for (const contract::PresetValue& value : contract::kPresetValues)
      if (value.preset == preset.name) rows.push_back({value.param, value.value});
    EXPECT_EQ(set(hoist, rows), 0U);
    for (const contract::ParamRoom& room : contract::kParamRooms) EXPECT_TRUE(contract::leaves_room(room, hoist.state.params));
  }
  for (const contract::ParamRoom& room : contract::kParamRooms) EXPECT_TRUE(contract::leaves_room(room, contract::Params{}));
}

// A running node that refuses a value: walking continues, and the value is repeated until taken. Only then can a motion start again.
TEST(Parameters, ANodeThatTakesNoValueStopsNobody) {
  for (const bool aborts : {false, true}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::user));
    hoist.lean_gently(4, 100);
    hoist.drive_left.sdo_aborts = aborts;
    hoist.drive_left.sdo_deaf = !aborts;
    ASSERT_EQ(set(hoist, {{ParamName::drive_velocity_gain_v_s_rad, 0.125}}), 0U);
    hoist.step(400);
    EXPECT_EQ(hoist.state.mode, Mode::user) << aborts;
    EXPECT_EQ(hoist.state.latched, 0U) << aborts;
    EXPECT_FALSE(hoist.state.master.all_running()) << aborts;
    hoist.drive_left.sdo_aborts = hoist.drive_left.sdo_deaf = false;
    hoist.drive_left.written.clear();
    hoist.step(150);
    ASSERT_EQ(hoist.drive_left.written.size(), 1U) << aborts;
    EXPECT_FLOAT_EQ(hoist.drive_left.written[0].second, 0.125F);
    EXPECT_TRUE(hoist.state.master.all_running()) << aborts;
    EXPECT_EQ(hoist.state.mode, Mode::user) << aborts;
  }
}

// A start requested in the step of a change waits until the nodes have it.
TEST(Parameters, NothingStartsBeforeTheNodesHaveTheirValues) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.send(CommandKind::stage_parameter, 7, id_of(ParamName::drive_current_limit_a), 0, 5.0);
  const std::uint32_t commit = hoist.send(CommandKind::commit_parameters, 7, 1, kEngineer);
  const std::uint32_t start = hoist.send(CommandKind::request_mode, 7, static_cast<std::uint32_t>(Mode::user));
  hoist.step(100);
  EXPECT_EQ(hoist.answer(commit), 0U);
  EXPECT_EQ(hoist.answer(start), refusal_bit(Refusal::nodes_missing));
  EXPECT_EQ(hoist.state.latched, 0U);
  EXPECT_EQ(hoist.ask_mode(Mode::user), 0U);
}

// The end of a trial must leave a consistent set, with any permanent changes meanwhile.
TEST(Parameters, H27WhatGoesBackFitsWhatWasSetMeanwhile) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  ASSERT_EQ(set(hoist, {{ParamName::remote_speed_m_s_max, 0.5}}), 0U);
  ASSERT_EQ(attempt(hoist, {{ParamName::remote_speed_m_s_max, 0.2}}, 20), 0U);
  EXPECT_EQ(set(hoist, {{ParamName::speed_m_s_max, 0.3}}), refusal_bit(Refusal::inconsistent_set)) << "0.5 would come back";
  EXPECT_EQ(set(hoist, {{ParamName::speed_m_s_max, 0.3}, {ParamName::remote_speed_m_s_max, 0.25}}), 0U);
  hoist.step(2100);
  EXPECT_EQ(contract::check_param_set(hoist.state.params), nullptr);
  EXPECT_EQ(hoist.state.params.remote_speed_m_s_max, 0.25);
}

// H27: over random sequences of stages, commits, trials, damage and modes no wrong set is ever in force, and none is in force in part.
TEST(Parameters, H27NoBadSetInForceOverRandomSequences) {
  int accepted = 0, refused = 0;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937_64 random(seed);
    const auto below = [&random](std::size_t n) { return static_cast<std::size_t>(random() % n); };
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    for (int i = 0; i < 1500; ++i) {
      const contract::Params before = hoist.state.params;
      const auto version = hoist.state.parameter_version;
      contract::Params meant = before;
      const std::size_t rows = 1 + below(6);
      const std::uint32_t role = static_cast<std::uint32_t>(below(4));
      const bool walking = is_moving_now(hoist);
      for (std::size_t r = 0; r < rows; ++r) {
        const std::size_t index = below(contract::kParamCount);
        const auto& info = contract::kParams[index];
        const double share = static_cast<double>(below(1000)) / 800.0 - 0.1;
        const double value = below(30) == 0 ? NAN : info.min + share * (info.max - info.min);
        contract::set_param_unchecked(meant, index, value);
        hoist.send(CommandKind::stage_parameter, 7, below(40) == 0 ? 999 : info.id, static_cast<std::uint32_t>(r), value);
      }
      const double trial_s = below(4) == 0 ? 1.0 + static_cast<double>(below(3)) : 0.0;
      const std::uint32_t id = hoist.send(CommandKind::commit_parameters, 7, static_cast<std::uint32_t>(rows), role, trial_s);
      if (below(20) == 0) hoist.commands.back().bits ^= 1ULL << below(64);
      if (below(15) == 0) hoist.send(CommandKind::request_mode, 7, static_cast<std::uint32_t>(walking ? Mode::standby : Mode::user));
      if (below(10) == 0) hoist.send(CommandKind::acknowledge, 7, 0, kEngineer);
      hoist.step();
      const bool done = hoist.answer(id) == 0;
      (done ? accepted : refused) += 1;
      if (!done && version == hoist.state.parameter_version) {
        ASSERT_TRUE(same(hoist.state.params, before)) << "nothing of a refused set";
      }
      if (done && hoist.state.parameter_version == version + 1) {
        ASSERT_TRUE(same(hoist.state.params, meant)) << "all of a set that was taken";
      }
      for (std::size_t p = 0; p < contract::kParamCount; ++p) {
        const double now = contract::get_param(hoist.state.params, p), was = contract::get_param(before, p);
        ASSERT_EQ(contract::check_param(p, now), contract::ParamCheck::ok) << contract::kParams[p].name;
        ASSERT_EQ(contract::check_param(p, contract::get_param(hoist.state.live, p)), contract::ParamCheck::ok);
        if (now == was) continue;
        ASSERT_TRUE(!walking || contract::kParams[p].edit == contract::EditRule::live) << contract::kParams[p].name << " while walking";
      }
      ASSERT_EQ(contract::check_param_set(hoist.state.params), nullptr);
      hoist.events.clear();
    }
    ASSERT_FALSE(hoist.has_fault(contract::Fault::parameters_corrupt));
  }
  EXPECT_GT(accepted, 100) << "and the good ones are taken";
  EXPECT_GT(refused, 5000);
}

// H27: limits of motion and of monitors are changed in STANDBY by an engineer, never in motion.
TEST(Parameters, H27LimitsAndTripsAreForEngineersOnStandby) {
  for (const auto& row : contract::kParams) {
    const bool limit = (row.id >= 40 && row.id <= 47 && row.name != "speed_cap_norm") || (row.id >= 52 && row.id <= 53) ||
                       (row.id >= 60 && row.id <= 67) || (row.id >= 100 && row.id <= 130) || (row.id >= 170 && row.id <= 171);
    if (!limit) continue;
    EXPECT_EQ(row.edit, contract::EditRule::stopped) << row.name;
    EXPECT_EQ(row.role, contract::Role::engineer) << row.name;
  }
}

constexpr double kToday_s = 1'790'000'000.0;

std::uint32_t set_neutral(ScriptedHoist& hoist, double utc_s = kToday_s) { return hoist.ask(CommandKind::set_neutral, 7, 0, 0, utc_s); }

TEST(Neutral, IsTheMeanOfTheLastSecond) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.lean(3, 2);
  hoist.step(50);
  EXPECT_EQ(set_neutral(hoist), refusal_bit(Refusal::moving)) << "half upright, half leaning is no posture";
  hoist.step(110);
  for (const double never : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_EQ(set_neutral(hoist, never), refusal_bit(Refusal::out_of_range)) << never;
  EXPECT_EQ(hoist.count(EventKind::parameter_changed), 0);
  EXPECT_EQ(set_neutral(hoist), 0U);
  EXPECT_NEAR(hoist.state.params.neutral_lean_m, 0.8 * std::tan(3 * kDeg), 2e-4);
  EXPECT_GT(hoist.state.params.neutral_turn_rad, 0.02);
  EXPECT_EQ(hoist.count(EventKind::neutral_set), 1);
  EXPECT_EQ(hoist.count(EventKind::parameter_changed), 3);
  EXPECT_EQ(hoist.state.params.calibrated_neutral_s, kToday_s) << "as after the step of CALIBRATE";
  hoist.step(2);
  EXPECT_NEAR(hoist.out.record.lean_norm, 0, 0.01);
  EXPECT_NEAR(hoist.out.record.turn_norm, 0, 0.01);
}

// I7: posture seen under the old values does not count for the new ones, neither for a start nor for neutral.
TEST(Neutral, CountsAnewWhenTheValuesChangeThatItIsReadBy) {
  const Row rows[] = {
      {ParamName::neutral_lean_m, 0.05},      {ParamName::neutral_turn_rad, 0.1},     {ParamName::left_alpha_zero_rad, 0.04},
      {ParamName::strut_length_m, 0.6},       {ParamName::lean_range_rad, 0.12},      {ParamName::strut_spacing_m, 0.3},
      {ParamName::right_beta_zero_rad, 0.02}, {ParamName::base_alpha_zero_rad, 0.03}, {ParamName::turn_range_rad, 0.12}};
  for (const Row& row : rows) {
    const auto index = contract::param_index(row.name);
    for (const bool start : {false, true}) {
      ScriptedHoist hoist;
      ASSERT_TRUE(hoist.ready());
      hoist.send(CommandKind::stage_parameter, 7, id_of(row.name), 0, row.value);
      const std::uint32_t commit = hoist.send(CommandKind::commit_parameters, 7, 1, kEngineer);
      const std::uint32_t id = start ? hoist.send(CommandKind::request_mode, 7, static_cast<std::uint32_t>(Mode::user))
                                     : hoist.send(CommandKind::set_neutral, 7, 0, 0, kToday_s);
      hoist.step();
      ASSERT_EQ(hoist.answer(commit), 0U) << contract::kParams[index].name;
      EXPECT_NE(hoist.answer(id), 0U) << contract::kParams[index].name;
      EXPECT_TRUE(!start || (hoist.answer(id) & refusal_bit(Refusal::not_neutral)) != 0) << contract::kParams[index].name;
      hoist.step(98);
      EXPECT_NE(set_neutral(hoist), 0U) << contract::kParams[index].name << ": not a whole second yet";
    }
  }
  ScriptedHoist other;
  ASSERT_TRUE(other.ready());
  ASSERT_EQ(set(other, {{ParamName::lean_gain_filtered_units, 15}}), 0U);
  EXPECT_EQ(other.ask_mode(Mode::user), 0U) << "a gain changes nothing of what upright is";
}

// H22, I6: a start that waited while the loop was held is as old as what the loop remembers of the patient.
TEST(Neutral, H22CountsAnewAfterALoopThatWasHeld) {
  for (const bool skipped : {false, true}) {
    for (const bool badly : {false, true}) {
      ScriptedHoist hoist;
      ASSERT_TRUE(hoist.ready());
      const std::uint32_t id = hoist.send(CommandKind::request_mode, 7, static_cast<std::uint32_t>(Mode::user));
      if (skipped)
        hoist.tick_number += badly ? 5 : 2;
      else
        hoist.lateness_s = badly ? 0.04F : 0.02F;
      hoist.step();
      EXPECT_EQ(hoist.answer(id), badly ? refusal_bit(Refusal::not_neutral) : 0U) << skipped;
      if (!badly) continue;
      hoist.step(100);
      EXPECT_EQ(hoist.ask_mode(Mode::user), 0U);
    }
  }
}

TEST(Neutral, TooFarAwayOrNotStandingIsRefused) {
  for (const auto& [lean_deg, twist_deg] : {std::pair{8.0, 0.0}, {0.0, 20.0}}) {  // 0.112 m, 0.23 rad
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    hoist.lean(lean_deg, twist_deg);
    hoist.step(120);
    EXPECT_EQ(set_neutral(hoist), refusal_bit(Refusal::out_of_range));
    EXPECT_TRUE(same(hoist.state.params, contract::Params{}));
  }
  ScriptedHoist walking;
  ASSERT_TRUE(walking.start(Mode::user));
  EXPECT_EQ(set_neutral(walking), refusal_bit(Refusal::only_when_stopped));
}

TEST(Pose, IsSetAtStandstillOnly) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, 1.5, -2.0, 0.7), 0U);
  EXPECT_FLOAT_EQ(hoist.out.record.x_m, 1.5F);
  EXPECT_FLOAT_EQ(hoist.out.record.y_m, -2.0F);
  EXPECT_FLOAT_EQ(hoist.out.record.psi_rad, 0.7F);
  // The track that slip does not lead astray is put there, too.
  EXPECT_FLOAT_EQ(hoist.out.record.fused_x_m, 1.5F);
  EXPECT_FLOAT_EQ(hoist.out.record.fused_y_m, -2.0F);
  EXPECT_FLOAT_EQ(hoist.out.record.fused_psi_rad, 0.7F);
  EXPECT_EQ(hoist.out.record.distance_m, 0.0F);
  const auto told = std::ranges::find(hoist.events, contract::EventKind::pose_set, &contract::Event::kind);
  ASSERT_NE(told, hoist.events.end());
  EXPECT_EQ(told->code, hoist.out.record.start_mark);
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, NAN, 0, 0), refusal_bit(Refusal::not_finite));
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, 0, 2000, 0), refusal_bit(Refusal::out_of_range));
  EXPECT_FLOAT_EQ(hoist.out.record.x_m, 1.5F);
  hoist.drive_left.forced_m_s = 0.1;
  hoist.step(3);
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, 0, 0, 0), refusal_bit(Refusal::moving));
}

// A start refused during a walk may have set its pose before.
TEST(Pose, StaysWhileSomebodyWalksAlsoWhenTheHoistStands) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, -1.5, -1.5, 0), refusal_bit(Refusal::not_standby));
  ASSERT_EQ(hoist.ask(CommandKind::stop), 0U);
  hoist.step(100);
  ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_EQ(hoist.ask(CommandKind::set_pose, 7, 0, 0, -1.5, -1.5, 0), refusal_bit(Refusal::not_standby));
}

}  // namespace
}  // namespace hoist::core::test
