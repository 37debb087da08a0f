// EMERGENCY_STOP and FAULT (hazard table 2.3; H22, H27): how they are entered, what is reset, and who may end them.
#include <gtest/gtest.h>

#include "control/core/modes/mode_list.hpp"
#include "control/core/supervise/release.hpp"
#include "control/core/supervise/service.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

// Stops the hoist once with this fault, removes the fault and acknowledges, if possible.
template <typename Break, typename Mend>
void stop_once(ScriptedHoist& hoist, Break&& break_it, Mend&& mend_it) {
  break_it(hoist);
  hoist.step(10);
  mend_it(hoist);
  hoist.step(300);
  static_cast<void>(acknowledge_as(hoist, kTherapist));
  hoist.step(10);
}
void unplug(ScriptedHoist& hoist) { hoist.tilt_left.silent = true; }
void plug(ScriptedHoist& hoist) { hoist.tilt_left.silent = false; }
void lie(ScriptedHoist& hoist) { hoist.tilt_left.alpha_deg = hoist.tilt_left.alpha_now_deg = 25; }
void tell_the_truth(ScriptedHoist& hoist) { hoist.tilt_left.alpha_deg = hoist.tilt_left.alpha_now_deg = 0; }

// The walking hoist of these tests: integrators full, wheels turning.
ScriptedHoist walking() {
  ScriptedHoist hoist;
  EXPECT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(7, 300);
  EXPECT_GT(hoist.out.record.lean_filtered_units, 3.0F);
  return hoist;
}

TEST(EmergencyStop, TheOpenChainLeadsThereWithinOneStepAndNothingIsCommanded) {
  ScriptedHoist hoist = walking();
  hoist.io.switches = 1;
  hoist.step();
  EXPECT_EQ(hoist.state.mode, Mode::emergency_stop);
  EXPECT_TRUE(hoist.has_fault(Fault::emergency_stop));
  EXPECT_EQ(hoist.out.record.stop_cause, static_cast<int>(Fault::emergency_stop) + 1);
  for (int i = 0; i < 200; ++i) {
    ASSERT_EQ(hoist.command_m_s(), 0.0);
    ASSERT_NE(hoist.drive_left.last_control, 0x0F) << "the drives are told to let go";
    hoist.step();
  }
}

TEST(EmergencyStop, ForgetsIntegratorsLimiterAndLease) {
  ScriptedHoist hoist = walking();
  const std::uint32_t epoch = hoist.state.lease.epoch;
  hoist.io.switches = 1;
  hoist.step();
  EXPECT_EQ(hoist.out.record.lean_filtered_units, 0.0F);
  EXPECT_EQ(hoist.out.record.turn_filtered_units, 0.0F);
  EXPECT_TRUE(hoist.state.limiter.at_rest());
  EXPECT_EQ(hoist.state.lease.holder, 0U);
  EXPECT_NE(hoist.state.lease.epoch, epoch);
}

TEST(EmergencyStop, IsLeftOnlyWithTheChainClosedAndAnAcknowledgement) {
  ScriptedHoist hoist = walking();
  hoist.lean(0);
  hoist.io.switches = 1;
  hoist.step(300);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), refusal_bit(Refusal::no_lease)) << "nobody drives after an emergency stop";
  ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
  EXPECT_EQ(acknowledge_as(hoist, kEngineer), refusal_bit(Refusal::emergency_stop_open));
  EXPECT_EQ(hoist.state.mode, Mode::emergency_stop);
  hoist.io.switches = 0;
  hoist.step(1000);
  EXPECT_EQ(hoist.state.mode, Mode::emergency_stop) << "never by itself";
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::init) << "everything is checked again";
  EXPECT_EQ(hoist.state.latched, 0U);
  EXPECT_TRUE(hoist.reach(Mode::standby));
}

// The button pressed for a second and released for another; then the lease is taken again.
void press_and_release(ScriptedHoist& hoist) {
  hoist.io.switches = 1;
  hoist.step(100);
  hoist.io.switches = 0;
  hoist.step(100);
  ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
}

TEST(EmergencyStop, TheNodesAreMetAnewAfterwards) {
  ScriptedHoist hoist = walking();
  hoist.lean(0);
  press_and_release(hoist);
  const std::uint32_t asked = hoist.drive_left.sdo_requests;
  ASSERT_EQ(acknowledge_as(hoist, kTherapist), 0U);
  ASSERT_TRUE(hoist.reach(Mode::standby));
  EXPECT_GT(hoist.drive_left.sdo_requests, asked + 3) << "what it is, and its parameters";
}

TEST(EmergencyStop, ComesFromEveryMode) {
  for (const Mode from : {Mode::standby, Mode::user, Mode::remote, Mode::guided, Mode::protective_stop, Mode::calibrate, Mode::fault}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    if (is_moving(from) || from == Mode::calibrate) {
      ASSERT_EQ(hoist.ask_mode(from), 0U);
    }
    if (from == Mode::protective_stop) hoist.ask(CommandKind::stop);
    if (from == Mode::fault) raise_fault(hoist.state, Fault::control_fault);
    hoist.step();
    ASSERT_EQ(hoist.state.mode, from);
    hoist.io.switches = 1;
    hoist.step();
    EXPECT_EQ(hoist.state.mode, Mode::emergency_stop) << static_cast<int>(from);
  }
  ScriptedHoist starting;
  starting.tilt_left.silent = true;
  starting.io.switches = 1;
  starting.step(100);
  EXPECT_EQ(starting.state.mode, Mode::emergency_stop) << "pressed when the hoist is switched on";
  EXPECT_FALSE(starting.has_fault(Fault::tilt_left_lost)) << "there is one alarm, and it is the button";
}

// Leaving the emergency stop needs no role, so it must not bypass the engineer.
TEST(EmergencyStop, H22_H27TheButtonLeadsNobodyAroundTheEngineer) {
  for (const Fault fault : {Fault::control_fault, Fault::parameters_corrupt}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    raise_fault(hoist.state, fault);
    hoist.step(120);
    ASSERT_EQ(hoist.state.mode, Mode::fault);
    hoist.io.switches = 1;
    hoist.step(100);
    ASSERT_EQ(hoist.state.mode, Mode::emergency_stop);
    hoist.io.switches = 0;
    hoist.step(100);
    ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
    EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U) << "the button's own stop is over";
    EXPECT_FALSE(hoist.has_fault(Fault::emergency_stop));
    EXPECT_EQ(hoist.state.mode, Mode::fault);
    EXPECT_TRUE(hoist.has_fault(fault));
    hoist.step(200);
    EXPECT_EQ(acknowledge_as(hoist, kTherapist), refusal_bit(Refusal::not_allowed));
    EXPECT_EQ(acknowledge_as(hoist, kEngineer), 0U);
    EXPECT_TRUE(hoist.reach(Mode::standby));
    EXPECT_EQ(hoist.state.latched, 0U);
  }
}

TEST(EmergencyStop, H22TheButtonDoesNotForgetHowOftenAFaultHasStopped) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  const auto press = [&hoist] {
    hoist.step(200);
    press_and_release(hoist);
    ASSERT_EQ(acknowledge_as(hoist, kTherapist), 0U);
  };
  for (int i = 0; i < 2; ++i) stop_once(hoist, unplug, plug);
  press();
  ASSERT_TRUE(hoist.reach(Mode::standby));
  unplug(hoist);
  hoist.step(10);
  plug(hoist);
  ASSERT_TRUE(hoist.reach(Mode::fault, 300));
  press();
  ASSERT_EQ(hoist.state.mode, Mode::fault);
  EXPECT_TRUE(hoist.has_fault(Fault::tilt_left_lost)) << "what it was about is still told";
  hoist.step(200);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U) << "and a plug is still the therapist's to mend";
  EXPECT_TRUE(hoist.reach(Mode::standby));
}

// A hand is slower than what an open chain does to the nodes.
TEST(EmergencyStop, H22AFaultThatAHandAnswersWithTheButtonCounts) {
  using Do = void (*)(ScriptedHoist&);
  struct Cause {
    const char* name;
    Do breaks, mends;
    bool at_once = false;  // mended as soon as the stop has begun
  };
  // The last two are also what an open chain looks like.
  const Cause causes[] = {{"a plug", unplug, plug},
                          {"a drive's fault", [](ScriptedHoist& h) { h.drive_left.fault = true; }, [](ScriptedHoist&) {}},
                          {"a stray current", [](ScriptedHoist& h) { h.drive_left.current_a = 1.5; },
                           [](ScriptedHoist& h) { h.drive_left.current_a = 0; }, true}};
  for (const Cause& cause : causes) {
    for (const int hand_ticks : {10, 17, 18, 19, 20, 21, 22, 60, 95, 96, 97, 98, 99, 100, 101, 102}) {
      SCOPED_TRACE(::testing::Message() << cause.name << ", " << hand_ticks);
      ScriptedHoist hoist;
      ASSERT_TRUE(hoist.ready());
      for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(hoist.state.mode, Mode::standby) << i;
        cause.breaks(hoist);
        ASSERT_TRUE(hoist.reach(Mode::protective_stop, 20));
        if (cause.at_once) cause.mends(hoist);
        hoist.step(hand_ticks - 1);
        cause.mends(hoist);
        press_and_release(hoist);
        hoist.step(150);
        ASSERT_EQ(acknowledge_as(hoist, kTherapist), 0U);
        hoist.step(150);
      }
      EXPECT_EQ(hoist.state.mode, hand_ticks >= 20 ? Mode::fault : Mode::standby);
    }
  }
}

TEST(EmergencyStop, ARelayThatOpensWithoutAWordIsOneToo) {
  ScriptedHoist hoist = walking();
  hoist.drive_left.supply_v = hoist.drive_right.supply_v = 8;  // motors that still turn feed a little back
  hoist.step(90);
  EXPECT_NE(hoist.state.mode, Mode::emergency_stop) << "an input node that comes back closes the relay within a second";
  hoist.step(20);
  EXPECT_EQ(hoist.state.mode, Mode::emergency_stop);
  hoist.lean(0);
  hoist.step(100);
  ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), refusal_bit(Refusal::emergency_stop_open)) << "the motors still have no power";
  hoist.drive_left.supply_v = hoist.drive_right.supply_v = 25;
  hoist.step(10);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U);
}

TEST(EmergencyStop, OneDriveWithoutSupplyOrEmptyBatteriesAreNone) {
  ScriptedHoist one = walking();
  one.drive_left.supply_v = 0.3;
  one.step(200);
  EXPECT_NE(one.state.mode, Mode::emergency_stop);
  ScriptedHoist empty = walking();
  empty.io.battery_a_v = empty.io.battery_b_v = 5;
  empty.step(20);
  empty.drive_left.supply_v = empty.drive_right.supply_v = 10;
  empty.step(200);
  EXPECT_NE(empty.state.mode, Mode::emergency_stop);
}

TEST(EmergencyStop, ASilentInputNodeDoesNotCloseTheChain) {
  ScriptedHoist hoist = walking();
  hoist.lean(0);
  hoist.io.switches = 1;
  hoist.step(100);
  hoist.io.silent = true;
  hoist.step(100);
  ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
  EXPECT_NE(acknowledge_as(hoist, kTherapist) & refusal_bit(Refusal::emergency_stop_open), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::emergency_stop);
}

// H22: "three times -> FAULT", for every fault of the machine.
TEST(OutOfService, H22TheThirdStopForTheSameFaultIsTheLast) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  stop_once(hoist, lie, tell_the_truth);
  ASSERT_EQ(hoist.state.mode, Mode::standby);
  stop_once(hoist, lie, tell_the_truth);
  ASSERT_EQ(hoist.state.mode, Mode::standby);
  hoist.time_ns += 400'000'000'000;  // still within ten minutes
  hoist.step(100);
  lie(hoist);
  hoist.step(100);
  EXPECT_TRUE(hoist.has_fault(Fault::tilt_implausible));
  EXPECT_TRUE(hoist.has_fault(Fault::control_fault));
  EXPECT_TRUE(hoist.reach(Mode::fault, 150)) << "once it has stood for a second";
  hoist.step();
  EXPECT_EQ(hoist.drive_left.status, 0x21) << "the drives are off";
  EXPECT_TRUE(hoist.has_fault(Fault::tilt_implausible)) << "what it was about is still told";
  tell_the_truth(hoist);
  hoist.step(200);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), refusal_bit(Refusal::not_allowed));
  EXPECT_NE(hoist.ask_mode(Mode::user) & refusal_bit(Refusal::fault_mode), 0U);
  EXPECT_EQ(acknowledge_as(hoist, kEngineer), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::init);
  EXPECT_TRUE(hoist.reach(Mode::standby));
  EXPECT_EQ(hoist.state.latched, 0U);
  stop_once(hoist, lie, tell_the_truth);
  EXPECT_EQ(hoist.state.mode, Mode::standby) << "the count starts again";
}

TEST(OutOfService, H22TheThirdLateStepWhileWalkingBrakesFirst) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(hoist.ask_mode(Mode::user), 0U);
    ASSERT_TRUE(hoist.run_until_powered());
    hoist.lean_gently(7, 300);
    hoist.worst_deceleration_m_s2 = 0;
    hoist.lateness_s = 0.05F;
    hoist.step();
    ASSERT_EQ(hoist.state.mode, Mode::protective_stop) << "from motion the way leads through the ramp";
    hoist.lean(0);
    hoist.step(300);
    EXPECT_LE(hoist.worst_deceleration_m_s2, 1.0 + 1e-9);
    if (i < 2) {
      ASSERT_EQ(acknowledge_as(hoist, kTherapist), 0U);
    }
    hoist.step(100);
  }
  EXPECT_EQ(hoist.state.mode, Mode::fault);
}

TEST(OutOfService, WhatPeopleDoIsNeverCounted) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 6; ++i) {
    stop_once(
        hoist, [](ScriptedHoist& h) { h.ask(CommandKind::stop); }, [](ScriptedHoist&) {});
    ASSERT_EQ(hoist.state.mode, Mode::standby);
    stop_once(
        hoist, [](ScriptedHoist& h) { h.io.bumpers = 1; }, [](ScriptedHoist& h) { h.io.bumpers = 0; });
    ASSERT_EQ(hoist.state.mode, Mode::standby);
  }
  EXPECT_FALSE(hoist.has_fault(Fault::control_fault));
}

TEST(OutOfService, StopsFarApartOrForDifferentFaultsDoNotCountTogether) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 2; ++i) {
    stop_once(hoist, lie, tell_the_truth);
    stop_once(hoist, unplug, plug);
    ASSERT_EQ(hoist.state.mode, Mode::standby);
  }
  hoist.time_ns += 601'000'000'000;
  hoist.step(100);
  stop_once(hoist, lie, tell_the_truth);
  EXPECT_EQ(hoist.state.mode, Mode::standby) << "ten minutes later";
}

TEST(OutOfService, ATherapistMayLeaveWhatAPlugExplains) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  for (int i = 0; i < 2; ++i) stop_once(hoist, unplug, plug);
  ASSERT_EQ(hoist.state.mode, Mode::standby);
  unplug(hoist);
  hoist.step(10);
  plug(hoist);
  ASSERT_TRUE(hoist.reach(Mode::fault, 300));
  hoist.step(200);
  EXPECT_EQ(acknowledge_as(hoist, kTherapist), 0U);
  EXPECT_TRUE(hoist.reach(Mode::standby));
}

TEST(OutOfService, StaysWhileTheHoistIsPushed) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  raise_fault(hoist.state, Fault::control_fault);
  hoist.step(120);
  ASSERT_EQ(hoist.state.mode, Mode::fault);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0.2;
  hoist.step(10);
  EXPECT_EQ(acknowledge_as(hoist, kEngineer), refusal_bit(Refusal::moving));
  EXPECT_EQ(hoist.state.mode, Mode::fault);
}

// Every transition starts with empty filters, ramps and integrators.
TEST(Transitions, EveryEntryBeginsFromZero) {
  for (const Transition& row : kTransitions) {
    SCOPED_TRACE(std::string(contract::kModes[static_cast<std::size_t>(row.from)].name) + " -> " +
                 std::string(contract::kModes[static_cast<std::size_t>(row.to)].name));
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    // Arbitrary old state of a mode: entering the mode must clear it.
    CoreState& state = hoist.state;
    state.mode = row.from;
    state.in_mode = {};
    state.in_mode.powered = true;
    state.in_mode.leaving = row.guard == Guard::ramp_first;
    state.in_mode.ticks = 77;
    state.in_mode.epoch = state.lease.epoch;
    state.lean.v_f_units = 9;
    state.turn.omega_f_units = -9;
    const bool walks = is_moving(row.from) && row.guard != Guard::ramp_first;
    if (walks) state.limiter.start_from(state.params, 0.4, 0.1);
    state.still.ticks = kStillTicks;
    state.clear.ticks = 10;
    if (row.guard == Guard::ready_with_a_path) state.guided.load({});
    if (row.guard == Guard::only_silence) {
      state.conditions = state.latched = contract::fault_bit(Fault::drive_left_lost);
      state.in_mode.silent.ticks = kGoneTicks;
    }
    switch (row.asker) {
      case Asker::core:
        finish_mode(state);
        break;
      case Asker::fault:
        raise_fault(state, Fault::stop_pressed);
        break;
      case Asker::breakdown:
        raise_fault(state, Fault::control_fault);
        serve_breakdown(state);
        break;
      case Asker::hardware:
        judge_faults(state, contract::fault_bit(Fault::emergency_stop));
        break;
      case Asker::driver: {
        ASSERT_EQ(request_mode(state, row.to), 0U);
        if (row.guard == Guard::ramp_first) finish_mode(state);
        break;
      }
      case Asker::engineer:
        ASSERT_EQ(begin_service(state), 0U);
        break;
      case Asker::acknowledgement: {
        ASSERT_EQ(press_release(state, {0, 0, contract::Role::engineer, 0}), 0U);
        break;
      }
    }
    ASSERT_EQ(state.mode, row.to);
    EXPECT_EQ(state.lean.v_f_units, 0);
    EXPECT_EQ(state.lean.v_units, 0);
    EXPECT_EQ(state.turn.omega_f_units, 0);
    EXPECT_EQ(state.in_mode.ticks, 0U);
    EXPECT_FALSE(state.in_mode.leaving);
    EXPECT_FALSE(state.in_mode.powered);
    EXPECT_EQ(state.still.ticks, 0);
    EXPECT_EQ(state.clear.ticks, row.to == Mode::init ? 0 : state.clear.ticks);
    // Only a stop takes over a rolling hoist; every other mode begins at rest.
    if (row.to != Mode::protective_stop) {
      EXPECT_TRUE(state.limiter.at_rest());
      EXPECT_EQ(state.limiter.acceleration_m_s2(), 0);
    }
    if (is_moving(row.to)) {
      EXPECT_EQ(row.from, Mode::standby);
    }
  }
}

// Every transition outside the table is refused without effect.
TEST(Transitions, WhatTheTableDoesNotHaveIsRefusedWithEveryReason) {
  for (const contract::ModeInfo& from : contract::kModes)
    for (const contract::ModeInfo& to : contract::kModes) {
      const auto from_mode = static_cast<Mode>(from.value), to_mode = static_cast<Mode>(to.value);
      if (find_transition(from_mode, to_mode, Asker::driver) != nullptr) continue;
      if (from_mode == Mode::standby && to_mode == Mode::standby) continue;
      ScriptedHoist hoist;
      ASSERT_TRUE(hoist.ready());
      hoist.state.mode = from_mode;
      const std::uint32_t bits = request_mode(hoist.state, to_mode);
      EXPECT_NE(bits, 0U) << from.name << " -> " << to.name;
      EXPECT_EQ(hoist.state.mode, from_mode);
      if (to.moving) {
        EXPECT_NE(bits & refusal_bit(Refusal::not_standby), 0U);
      }
      if (to.moving && from_mode == Mode::fault) {
        EXPECT_NE(bits & refusal_bit(Refusal::fault_mode), 0U);
      }
      if (to.moving && from_mode == Mode::emergency_stop) {
        EXPECT_NE(bits & refusal_bit(Refusal::emergency_stop_open), 0U);
      }
    }
}

// H1, caps per patient: 20, 50, 80 and 100 % bind in every mode in which wheels may turn.
TEST(Caps, BindInEveryMovingMode) {
  for (const double cap : {0.2, 0.5, 0.8, 1.0})
    for (const Mode mode : {Mode::user, Mode::remote}) {
      contract::Params p;
      p.remote_speed_m_s_max = 0.6;
      p.speed_cap_norm = cap;
      ScriptedHoist hoist(p);
      ASSERT_TRUE(hoist.start(mode));
      double fastest_m_s = 0;
      if (mode == Mode::user) hoist.lean_gently(9, 0);
      for (int i = 0; i < 1500; ++i) {
        if (mode == Mode::remote && i % 4 == 0) hoist.hold(1.0);
        hoist.step();
        fastest_m_s = std::max(fastest_m_s, std::abs(hoist.command_m_s()));
      }
      EXPECT_LE(fastest_m_s, cap * p.speed_m_s_max + 1e-3) << cap;
      EXPECT_GE(fastest_m_s, std::min(cap * p.speed_m_s_max, 0.6) - 0.02) << cap << ": and no lower";
    }
}

// What a cap does not let the hoist drive is not built up either.
TEST(Caps, H27HoldNothingBackThatWouldComeWithoutALean) {
  for (const bool ends : {false, true}) {
    SCOPED_TRACE(ends ? "the cap ends under a slight lean" : "the patient stands upright");
    contract::Params p;
    p.speed_cap_norm = 0.2;
    const double cap_m_s = 0.2 * p.speed_m_s_max;
    ScriptedHoist hoist(p);
    ASSERT_TRUE(hoist.start(Mode::user));
    hoist.lean_gently(8, 500);
    ASSERT_NEAR(hoist.command_m_s(), cap_m_s, 1e-3);
    hoist.lean_gently(ends ? 0.9 : 0.0, 100);
    if (!ends) {
      hoist.step(100);
      EXPECT_LT(hoist.command_m_s(), 0.7 * cap_m_s) << "fades in 2 s";
      continue;
    }
    hoist.send(CommandKind::stage_parameter, 7, contract::kParams[static_cast<std::size_t>(contract::ParamName::speed_cap_norm)].id, 0,
               1.0);
    ASSERT_EQ(hoist.ask(CommandKind::commit_parameters, 7, 1, kTherapist), 0U);
    for (int i = 0; i < 300; ++i) {
      hoist.step();
      // Of 0.9 degrees the law makes 0.156 m/s in the end.
      ASSERT_LT(hoist.command_m_s(), 0.18) << i;
    }
  }
}

// And those of a slope, whose end no person chooses.
TEST(Caps, H9TheEndOfASlopeReleasesNoSpeed) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.lean_gently(8, 500);
  const auto floor = [&hoist](double alpha_deg) { hoist.tilt_base.alpha_deg = alpha_deg; };
  floor(6);
  hoist.lean_gently(14, 300);
  ASSERT_TRUE(hoist.has_fault(Fault::base_tilt_high));
  ASSERT_NEAR(hoist.command_m_s(), hoist.state.params.base_tilt_speed_m_s_max, 1e-3);
  hoist.lean_gently(6.9, 100);
  floor(0);
  hoist.lean_gently(0.9, 50);
  for (int i = 0; i < 300; ++i) {
    hoist.step();
    ASSERT_LT(hoist.command_m_s(), 0.25) << i;
  }
}

// An exercise is checked against the cap when it begins; a cap that is lowered later binds it as well.
TEST(Caps, BindAnExerciseThatWasBegunAtAHigherOne) {
  for (const double cap : {0.2, 0.5, 0.8}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.ready());
    const double asked_m_s = 0.6, most_m_s = cap * hoist.state.params.speed_m_s_max;
    ASSERT_EQ(hoist.ask_guided({contract::GuidedShape::straight, false, 100.0, 0, asked_m_s, 1}), 0U);
    ASSERT_TRUE(hoist.run_until_powered());
    hoist.drive_for(300, 0);
    ASSERT_NEAR(hoist.command_m_s(), asked_m_s, 1e-3);
    hoist.send(CommandKind::stage_parameter, 7, contract::kParams[static_cast<std::size_t>(contract::ParamName::speed_cap_norm)].id, 0,
               cap);
    ASSERT_EQ(hoist.ask(CommandKind::commit_parameters, 7, 1, kTherapist), 0U);
    hoist.drive_for(300, 0);
    double fastest_m_s = 0;
    for (int i = 0; i < 300; ++i) {
      hoist.drive_for(1, 0);
      fastest_m_s = std::max(fastest_m_s, std::abs(hoist.command_m_s()));
    }
    EXPECT_EQ(hoist.state.mode, Mode::guided);
    EXPECT_LE(fastest_m_s, most_m_s + 1e-3) << cap;
    EXPECT_GE(fastest_m_s, most_m_s - 0.02) << cap << ": and no lower";
  }
}

}  // namespace
}  // namespace hoist::core::test
