// Every mode against every request, the guards of a start, stops and how they are left (hazard table 2.3).
#include <gtest/gtest.h>

#include <functional>

#include "control/core/modes/mode_list.hpp"
#include "control/core/supervise/supervisor.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

// A hoist brought into a mode, with client 7 as the driver.
ScriptedHoist in_mode(Mode mode) {
  ScriptedHoist hoist;
  switch (mode) {
    case Mode::init:
      hoist.tilt_left.silent = true;
      hoist.step(150);
      EXPECT_EQ(hoist.ask(CommandKind::take_lease), 0U);
      break;
    case Mode::standby:
      EXPECT_TRUE(hoist.ready());
      break;
    case Mode::user:
    case Mode::remote:
    case Mode::guided:
      EXPECT_TRUE(hoist.start(mode));
      break;
    case Mode::protective_stop:
      EXPECT_TRUE(hoist.ready());
      hoist.ask(CommandKind::stop);
      hoist.step(120);
      break;
    case Mode::calibrate:
      EXPECT_TRUE(hoist.ready());
      EXPECT_EQ(hoist.ask_mode(Mode::calibrate), 0U);
      break;
    case Mode::fault:
      EXPECT_TRUE(hoist.ready());
      raise_fault(hoist.state, Fault::control_fault);
      hoist.step(120);
      break;
    case Mode::emergency_stop:
      EXPECT_TRUE(hoist.ready());
      hoist.io.switches = 1;
      hoist.step(120);
      EXPECT_EQ(hoist.ask(CommandKind::take_lease), 0U) << "the emergency stop took it from everybody";
      break;
  }
  EXPECT_EQ(hoist.state.mode, mode);
  return hoist;
}

constexpr Mode kAll[] = {Mode::init,      Mode::standby, Mode::user,           Mode::remote, Mode::protective_stop,
                         Mode::calibrate, Mode::fault,   Mode::emergency_stop, Mode::guided};

TEST(Modes, EveryRequestInEveryModeDoesWhatTheTableSays) {
  for (const Mode from : kAll) {
    for (const Mode to : kAll) {
      ScriptedHoist hoist = in_mode(from);
      const bool listed = find_transition(from, to, Asker::driver) != nullptr;
      const std::uint32_t bits = hoist.ask_mode(to);
      // A request for STANDBY in STANDBY is granted without effect.
      const bool nothing = from == Mode::standby && to == Mode::standby;
      EXPECT_EQ(bits == 0, listed || nothing) << static_cast<int>(from) << " -> " << static_cast<int>(to) << " bits " << bits;
      if (listed || nothing) {
        EXPECT_TRUE(hoist.reach(to, 50));
      } else {
        hoist.step(50);
        EXPECT_EQ(hoist.state.mode, from) << static_cast<int>(from) << " -> " << static_cast<int>(to);
      }
    }
  }
}

TEST(Modes, MotionToMotionIsForbiddenAndSaysSo) {
  ScriptedHoist hoist = in_mode(Mode::user);
  EXPECT_NE(hoist.ask_mode(Mode::remote) & refusal_bit(Refusal::not_standby), 0U);
  ScriptedHoist other = in_mode(Mode::remote);
  EXPECT_NE(other.ask_mode(Mode::user) & refusal_bit(Refusal::not_standby), 0U);
}

TEST(Modes, StopIsDoneFromEveryModeByAnyone) {
  for (const Mode from : kAll) {
    ScriptedHoist hoist = in_mode(from);
    EXPECT_EQ(hoist.ask(CommandKind::stop, 99), 0U) << "client 99 has no lease";
    EXPECT_TRUE(hoist.has_fault(Fault::stop_pressed));
    // Where the drives are off there is nothing to stop; STOP is reported and latched.
    if (from == Mode::fault || from == Mode::emergency_stop) {
      EXPECT_EQ(hoist.state.mode, from);
      continue;
    }
    EXPECT_EQ(hoist.state.mode, Mode::protective_stop) << static_cast<int>(from);
    EXPECT_EQ(hoist.out.record.stop_cause, static_cast<int>(Fault::stop_pressed) + 1);
  }
}

TEST(Modes, ProtectiveStopIsLeftOnlyByAcknowledgement) {
  ScriptedHoist hoist = in_mode(Mode::protective_stop);
  hoist.step(2000);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop) << "never by itself";
  EXPECT_NE(hoist.ask(CommandKind::acknowledge, 8), 0U) << "not without the lease";
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::standby) << "and never back into motion";
  EXPECT_EQ(hoist.state.latched, 0U);
}

TEST(Modes, AcknowledgementWaitsForOneSecondOfStandstill) {
  ScriptedHoist hoist = in_mode(Mode::user);
  hoist.lean_gently(6, 300);
  hoist.ask(CommandKind::stop);
  EXPECT_NE(hoist.ask(CommandKind::acknowledge) & refusal_bit(Refusal::moving), 0U);
  while (hoist.state.still.ticks == 0) hoist.step();
  hoist.step(90);
  EXPECT_NE(hoist.ask(CommandKind::acknowledge) & refusal_bit(Refusal::moving), 0U);
  hoist.lean(0);
  hoist.step(20);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
}

TEST(Modes, AcknowledgementIsRefusedWhileTheCauseIsThere) {
  ScriptedHoist hoist = in_mode(Mode::standby);
  hoist.tilt_left.silent = true;
  hoist.step(150);
  ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), refusal_bit(Refusal::cause_not_cleared));
  hoist.tilt_left.silent = false;
  hoist.step(150);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
}

// H13: after the stop only away from what is touched, at 0.1 m/s, in REMOTE and nowhere else.
TEST(Bumpers, H13OnlyAwayFromWhatIsTouchedAndSlowly) {
  struct Case {
    std::uint8_t bumpers;
    bool forward, backward;
  };
  for (const Case& c : {Case{1, false, true}, {2, true, false}, {3, false, false}, {4, true, true}, {8, true, true}, {9, false, true}}) {
    SCOPED_TRACE(int{c.bumpers});
    for (const double stick : {1.0, -1.0}) {
      ScriptedHoist hoist = in_mode(Mode::standby);
      hoist.io.bumpers = c.bumpers;
      hoist.step(150);
      ASSERT_EQ(hoist.state.mode, Mode::protective_stop);
      ASSERT_EQ(hoist.ask(CommandKind::acknowledge), 0U) << "acknowledged while it touches";
      hoist.step(50);
      ASSERT_EQ(hoist.state.mode, Mode::standby);
      EXPECT_EQ(hoist.out.record.bumpers_acknowledged, c.bumpers);
      EXPECT_EQ(hoist.ask_mode(Mode::user), refusal_bit(Refusal::bumper_start)) << "the patient cannot see what it touches";
      ASSERT_EQ(hoist.ask_mode(Mode::remote), 0U);
      ASSERT_TRUE(hoist.run_until_powered());
      for (int i = 0; i < 200; ++i) {
        if (i % 4 == 0) hoist.hold(stick, 0.7);
        hoist.step();
        ASSERT_EQ(hoist.state.mode, Mode::remote);
        ASSERT_EQ(hoist.out.record.yaw_rate_command_rad_s, 0.0F) << "nothing turns";
        ASSERT_LE(std::abs(hoist.command_m_s()), 0.1 + 1e-4);
        ASSERT_LE(hoist.command_m_s() * stick, (stick > 0 ? c.forward : c.backward) ? 0.1 + 1e-4 : 0.0);
      }
      if (stick > 0 ? c.forward : c.backward) {
        EXPECT_NEAR(hoist.command_m_s(), 0.1 * stick, 1e-3) << "and that way it does go";
        EXPECT_EQ(hoist.out.record.speed_cause, static_cast<int>(contract::SpeedCause::bumper));
      }
    }
  }
}

TEST(Bumpers, H13OneThatTouchesAnewStopsAgain) {
  ScriptedHoist hoist = in_mode(Mode::standby);
  hoist.io.bumpers = 1;
  hoist.step(150);
  ASSERT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
  ASSERT_EQ(hoist.ask_mode(Mode::remote), 0U);
  ASSERT_TRUE(hoist.run_until_powered());
  hoist.drive_for(100, -1.0);
  hoist.io.bumpers = 0;
  hoist.drive_for(100, -1.0);
  EXPECT_LT(hoist.command_m_s(), -0.2) << "free again";
  hoist.io.bumpers = 1;
  hoist.drive_for(2, -1.0);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop) << "the acknowledgement was for that touch";
  hoist.io.bumpers = 3;
  hoist.step(150);
  ASSERT_EQ(hoist.ask(CommandKind::acknowledge), 0U);
  hoist.io.bumpers = 7;
  hoist.step(2);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop) << "another bumper is another touch";
}

TEST(Modes, EveryGuardOfAStartRefusesAndNamesItself) {
  struct Case {
    const char* name;
    Refusal refusal;
    std::function<void(ScriptedHoist&)> spoil;
  };
  const Case cases[] = {
      {"leaning", Refusal::not_neutral,
       [](ScriptedHoist& h) {
         h.lean(4);
         h.step(10);
       }},
      {"just upright again", Refusal::not_neutral,
       [](ScriptedHoist& h) {
         h.lean(4);
         h.step(10);
         h.lean(0);
         h.step(60);
       }},
      {"sensor settles", Refusal::sensors_settling,
       [](ScriptedHoist& h) {
         h.tilt_base.status = 1;
         h.step(3);
       }},
      {"pushed by hand", Refusal::moving,
       [](ScriptedHoist& h) {
         h.drive_left.forced_m_s = h.drive_right.forced_m_s = 0.1;
         h.step(5);
       }},
      {"node parameters not written", Refusal::nodes_missing,
       [](ScriptedHoist& h) {
         h.state.master.params_changed(contract::Params{}, [] {
           contract::Params p;
           p.drive_velocity_gain_v_s_rad = 0.2;
           return p;
         }());
         h.drive_left.sdo_deaf = true;
         h.step(3);
       }},
      {"a node that follows other rules", Refusal::node_version,
       [](ScriptedHoist& h) {
         h.tilt_left.revision = kRevision + 0x00010000;
         h.state.master.meet_all_again();
         h.step(60);
       }},
      {"battery empty", Refusal::battery_empty_start,
       [](ScriptedHoist& h) {
         h.io.battery_a_v = h.io.battery_b_v = 10.5;
         h.step(400);
       }},
      {"bumper", Refusal::bumper_start,
       [](ScriptedHoist& h) {
         h.io.bumpers = 4;
         h.step(3);
       }},
      {"stick out of the middle", Refusal::stick_not_neutral,
       [](ScriptedHoist& h) {
         h.hold(0.5);
         h.step();
       }},
      {"fault", Refusal::fault_active, [](ScriptedHoist& h) { h.ask(CommandKind::stop); }},
  };
  for (const Mode mode : {Mode::user, Mode::remote, Mode::guided}) {
    for (const Case& c : cases) {
      ScriptedHoist hoist = in_mode(Mode::standby);
      c.spoil(hoist);
      const std::uint32_t bits = hoist.ask_mode(mode);
      EXPECT_NE(bits & refusal_bit(c.refusal), 0U) << c.name;
      EXPECT_NE(hoist.out.record.blocked_bits & refusal_bit(c.refusal), 0U) << c.name;
      EXPECT_FALSE(is_moving(hoist.state.mode)) << c.name;
      hoist.step(30);
      EXPECT_EQ(hoist.drive_left.target_m_s, 0) << c.name;
    }
  }
}

// A serial line has no checksum: a single answer "loader" or "another version" may be corrupted.
TEST(Modes, OneGarbledAnswerKeepsNoNodeFromWork) {
  for (const auto& [sub, bits] : {std::pair<std::uint8_t, std::uint32_t>{2, contract::kLoaderProduct}, {3, 0x00400000U}}) {
    ScriptedHoist hoist = in_mode(Mode::standby);
    hoist.drive_left.garbled_sub = sub;
    hoist.drive_left.garble = bits;
    hoist.state.master.meet_all_again();
    hoist.step(100);
    EXPECT_EQ(hoist.drive_left.garble, 0U) << "it was asked";
    EXPECT_EQ(hoist.out.record.blocked_bits & (refusal_bit(Refusal::nodes_missing) | refusal_bit(Refusal::node_version)), 0U)
        << static_cast<int>(sub);
  }
}

TEST(Modes, ANewerProgramOfTheSameRulesIsWelcome) {
  ScriptedHoist hoist = in_mode(Mode::standby);
  hoist.tilt_left.revision = kRevision + 3;
  hoist.state.master.meet_all_again();
  hoist.step(60);
  EXPECT_EQ(hoist.ask_mode(Mode::user), 0U);
}

TEST(Modes, ARefusalNamesAllReasonsAtOnce) {
  ScriptedHoist hoist = in_mode(Mode::standby);
  hoist.lean(4);
  hoist.tilt_left.status = 1;
  hoist.step(5);
  const std::uint32_t bits = hoist.ask_mode(Mode::user, 8);
  EXPECT_EQ(bits, refusal_bit(Refusal::not_neutral) | refusal_bit(Refusal::sensors_settling) | refusal_bit(Refusal::no_lease));
}

TEST(Modes, StandbyKeepsTheDrivesOffAndMotionEnablesThem) {
  ScriptedHoist hoist = in_mode(Mode::standby);
  EXPECT_EQ(hoist.drive_left.status, 0x21);
  ASSERT_EQ(hoist.ask_mode(Mode::user), 0U);
  ASSERT_TRUE(hoist.run_until_powered());
  EXPECT_EQ(hoist.drive_left.status, 0x27);
  EXPECT_EQ(hoist.ask_mode(Mode::standby), 0U);
  hoist.step(5);
  EXPECT_EQ(hoist.drive_left.status, 0x21);
}

TEST(Modes, FiltersStartFromZeroOnEveryEntry) {
  ScriptedHoist hoist = in_mode(Mode::user);
  hoist.lean_gently(7, 400);
  EXPECT_GT(hoist.out.record.lean_filtered_units, 3.0F);
  hoist.lean(0);
  hoist.ask_mode(Mode::standby);
  ASSERT_TRUE(hoist.reach(Mode::standby));
  hoist.step(120);
  ASSERT_EQ(hoist.ask_mode(Mode::user), 0U);
  for (int i = 0; i < 100; ++i) {
    hoist.step();
    ASSERT_EQ(hoist.out.record.lean_filtered_units, 0.0F);
    ASSERT_EQ(hoist.command_m_s(), 0.0);
  }
}

TEST(Modes, NothingBuildsUpBeforeTheDrivesRun) {
  ScriptedHoist hoist = in_mode(Mode::standby);
  ASSERT_EQ(hoist.ask_mode(Mode::user), 0U);
  hoist.drive_left.status = 0x40;  // takes longer than the other
  hoist.lean(1.9);
  hoist.step();
  EXPECT_EQ(hoist.out.record.lean_filtered_units, 0.0F);
  ASSERT_TRUE(hoist.run_until_powered());
  hoist.step(20);
  EXPECT_GT(hoist.out.record.lean_filtered_units, 0.0F);
}

TEST(Modes, LeavingMotionRampsGentlyFirst) {
  ScriptedHoist hoist = in_mode(Mode::user);
  hoist.lean_gently(8, 500);
  const double v = hoist.command_m_s();
  ASSERT_GT(v, 0.3);
  hoist.worst_deceleration_m_s2 = 0;
  EXPECT_EQ(hoist.ask_mode(Mode::standby), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::user) << "the ramp comes first";
  int ticks = 0;
  while (hoist.state.mode == Mode::user && ticks < 1000) {
    hoist.step();
    ++ticks;
  }
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_NEAR(ticks * 0.01, v / 0.5, 0.3);
  EXPECT_LE(hoist.worst_deceleration_m_s2, 0.5 + 1e-9);
}

TEST(Modes, TheTableHasNoWayIntoMotionButFromStandby) {
  for (const Transition& row : kTransitions) {
    if (is_moving(row.to)) {
      EXPECT_EQ(row.from, Mode::standby);
      EXPECT_EQ(row.asker, Asker::driver);
    }
    if (row.from == Mode::protective_stop && row.to == Mode::standby) {
      EXPECT_EQ(row.asker, Asker::acknowledgement);
    }
    if (is_moving(row.from) && row.to == Mode::standby) {
      EXPECT_EQ(row.guard, Guard::ramp_first);
    }
    if (row.to == Mode::init && row.from == Mode::standby) {
      EXPECT_EQ(row.asker, Asker::engineer);
    }
  }
}

TEST(Modes, ADriveThatDoesNotEnableStopsTheStart) {
  ScriptedHoist hoist = in_mode(Mode::standby);
  hoist.ask_mode(Mode::user);
  for (int i = 0; i < 80 && hoist.state.mode == Mode::user; ++i) {
    hoist.drive_right.status = 0x21;
    hoist.step();
    EXPECT_EQ(hoist.command_m_s(), 0);
  }
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_TRUE(hoist.has_fault(Fault::drive_right_fault));
}

TEST(Modes, AcknowledgingADriveFaultResetsTheDrive) {
  ScriptedHoist hoist = in_mode(Mode::user);
  hoist.drive_left.fault = true;
  ASSERT_TRUE(hoist.reach(Mode::protective_stop, 5));
  hoist.step(150);
  const std::uint32_t id = hoist.send(CommandKind::acknowledge);
  hoist.step(60);
  EXPECT_EQ(hoist.answer(id), 0U);
  EXPECT_EQ(hoist.state.mode, Mode::standby);
  EXPECT_EQ(hoist.state.latched, 0U);
}

// An acknowledgement covers only the causes shown at the press.
TEST(Modes, ACauseThatWasNotSeenIsNotReleased) {
  ScriptedHoist hoist = in_mode(Mode::user);
  hoist.io.bumpers = 1;
  ASSERT_TRUE(hoist.reach(Mode::protective_stop, 5));
  hoist.step(150);
  hoist.io.bumpers = 0;
  hoist.step(5);
  const contract::FaultBits seen = fault_bit(Fault::bumper_pressed);
  ASSERT_EQ(hoist.state.latched, seen);
  EXPECT_EQ(hoist.ask(CommandKind::stop, 99), 0U);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge, 7, seen), refusal_bit(Refusal::cause_not_seen));
  hoist.step(20);
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_EQ(hoist.state.latched, seen | fault_bit(Fault::stop_pressed)) << "both are still told";
  // With every other reason at once.
  hoist.io.bumpers = 1;
  hoist.tilt_left.silent = true;
  hoist.step(20);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge, 7, seen), refusal_bit(Refusal::cause_not_seen) | refusal_bit(Refusal::cause_not_cleared));
  hoist.io.bumpers = 0;
  hoist.tilt_left.silent = false;
  hoist.step(150);
  // After reading them; a surplus cause does no harm.
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge, 7, ~0U), 0U);
  EXPECT_TRUE(hoist.reach(Mode::standby, 5));
  EXPECT_EQ(hoist.state.latched, 0U);
}

// H17: a request that was held up on its way is not carried out: who asked may be gone. One whose sender tells no echo is taken at any age.
TEST(Modes, WhatBeginsMotionOrLeavesAStopIsRefusedWhenItsSenderSawAnOldStep_H17) {
  const auto ask = [](ScriptedHoist& hoist, contract::Command command, std::int64_t seen_ago_ns) {
    const std::uint32_t id = hoist.send(command.kind, 7, command.a, command.b, command.v0, command.v1, command.v2);
    if (seen_ago_ns != 0)
      contract::put_echo(hoist.commands.back(), static_cast<std::uint64_t>(static_cast<std::int64_t>(hoist.time_ns) - seen_ago_ns));
    hoist.step();
    return hoist.answer(id);
  };
  contract::Command guided;
  contract::put_guided(guided, {contract::GuidedShape::straight, false, 2.0, 0, 0.2, 1});
  const auto command_of = [](CommandKind kind, Mode mode = Mode::init) {
    contract::Command command;
    command.kind = kind;
    command.a = static_cast<std::uint32_t>(mode);
    return command;
  };
  contract::Command mark = command_of(CommandKind::set_pose), acknowledge = command_of(CommandKind::acknowledge);
  mark.v0 = 1.0;
  const auto user = command_of(CommandKind::request_mode, Mode::user), remote = command_of(CommandKind::request_mode, Mode::remote);
  constexpr std::int64_t kMs_ns = 1'000'000;
  for (const contract::Command& command : {user, remote, guided, mark, acknowledge}) {
    SCOPED_TRACE(static_cast<int>(command.kind));
    const auto begin = [&] {
      ScriptedHoist hoist;
      EXPECT_TRUE(hoist.ready());
      if (command.kind == CommandKind::acknowledge) {
        hoist.ask(CommandKind::stop, 99);
        hoist.step(150);
      }
      return hoist;
    };
    for (const std::int64_t ago_ns : {1100 * kMs_ns, 60'000 * kMs_ns, -100 * kMs_ns}) {
      ScriptedHoist hoist = begin();
      const Mode before = hoist.state.mode;
      EXPECT_EQ(ask(hoist, command, ago_ns), refusal_bit(Refusal::stale_command)) << ago_ns;
      hoist.step(20);
      EXPECT_EQ(hoist.state.mode, before) << ago_ns;
      EXPECT_EQ(hoist.state.sensed.odometry.pose.x_m, 0.0) << ago_ns;
    }
    for (const std::int64_t ago_ns : {std::int64_t{0}, 1 * kMs_ns, 900 * kMs_ns}) {
      ScriptedHoist hoist = begin();
      EXPECT_EQ(ask(hoist, command, ago_ns), 0U) << ago_ns;
    }
  }
  // What stops or ends a motion is taken at any age.
  ScriptedHoist hoist = in_mode(Mode::user);
  EXPECT_EQ(ask(hoist, command_of(CommandKind::request_mode, Mode::standby), 60'000 * kMs_ns), 0U);
  EXPECT_TRUE(hoist.reach(Mode::standby, 300));
}

// H13: the press was for what touched then, not for what touches when the drive is ready.
TEST(Modes, ABumperPressedWhileTheDriveIsAwaitedIsNotAcknowledged) {
  for (const bool let_go : {false, true}) {
    ScriptedHoist hoist = in_mode(Mode::user);
    hoist.drive_left.fault = true;
    hoist.drive_left.ignores_reset = true;
    if (let_go) hoist.io.bumpers = 1;
    ASSERT_TRUE(hoist.reach(Mode::protective_stop, 5));
    hoist.step(150);
    const std::uint32_t id = hoist.send(CommandKind::acknowledge);
    hoist.step(5);
    ASSERT_TRUE(hoist.state.acknowledgement.waits());
    if (let_go) {
      hoist.io.bumpers = 0;
      hoist.step(2);
    }
    hoist.io.bumpers = 1;
    hoist.step(2);
    hoist.drive_left.fault = false;
    for (int i = 0; i < 60 && hoist.answer(id) == ~0U; ++i) hoist.step();
    EXPECT_EQ(hoist.answer(id), 0U);
    EXPECT_EQ(hoist.state.acknowledgement.bumpers(), 0);
    hoist.step();
    EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
    EXPECT_TRUE(hoist.has_fault(Fault::bumper_pressed));
  }
}

void gone_for_a_moment(ScriptedHoist& hoist, FakeNode& node) {
  node.silent = true;
  hoist.step(8);
  node.silent = false;
  hoist.step(2);
}

// The press covered the causes at that time: STOP, or any cause during the wait for the drive, needs another one. So does a press whose lease was
// lost.
TEST(Modes, WhatStopsWhileTheDriveIsAwaitedIsNotAcknowledged) {
  struct Case {
    const char* name;
    std::function<void(ScriptedHoist&)> meanwhile;
    Refusal refusal;
    Fault stays;
  };
  const Case cases[] = {
      {"STOP by another client", [](ScriptedHoist& h) { h.ask(CommandKind::stop, 9); }, Refusal::cause_not_cleared, Fault::stop_pressed},
      {"STOP for the second time", [](ScriptedHoist& h) { h.ask(CommandKind::stop, 9); }, Refusal::cause_not_cleared, Fault::stop_pressed},
      {"a sensor gone for a moment", [](ScriptedHoist& h) { gone_for_a_moment(h, h.tilt_left); }, Refusal::cause_not_cleared,
       Fault::tilt_left_lost},
      {"the same cause once more", [](ScriptedHoist& h) { gone_for_a_moment(h, h.tilt_right); }, Refusal::cause_not_cleared,
       Fault::tilt_right_lost},
      {"the lease let go", [](ScriptedHoist& h) { h.ask(CommandKind::release_lease); }, Refusal::no_lease, Fault::drive_left_fault},
      {"the lease let go and taken again",
       [](ScriptedHoist& h) {
         h.ask(CommandKind::release_lease);
         h.ask(CommandKind::take_lease);
       },
       Refusal::no_lease, Fault::drive_left_fault},
  };
  for (const Case& c : cases) {
    ScriptedHoist hoist = in_mode(Mode::user);
    hoist.drive_left.fault = true;
    hoist.drive_left.ignores_reset = true;
    ASSERT_TRUE(hoist.reach(Mode::protective_stop, 5)) << c.name;
    if (c.name == cases[1].name) hoist.ask(CommandKind::stop, 9);
    if (c.name == cases[3].name) c.meanwhile(hoist);
    hoist.step(150);
    const std::uint32_t id = hoist.send(CommandKind::acknowledge);
    hoist.step(5);
    ASSERT_TRUE(hoist.state.acknowledgement.waits()) << c.name;
    c.meanwhile(hoist);
    hoist.drive_left.fault = false;
    for (int i = 0; i < 60 && hoist.answer(id) == ~0U; ++i) hoist.step();
    EXPECT_NE(hoist.answer(id) & refusal_bit(c.refusal), 0U) << c.name;
    EXPECT_EQ(hoist.state.mode, Mode::protective_stop) << c.name;
    EXPECT_TRUE(hoist.has_fault(c.stays)) << c.name;
    // It is not stuck: a press that names it releases it.
    hoist.step(150);
    if (hoist.state.lease.holder == 0) hoist.ask(CommandKind::take_lease);
    const std::uint32_t again = hoist.send(CommandKind::acknowledge);
    hoist.step(60);
    EXPECT_EQ(hoist.answer(again), 0U) << c.name;
    EXPECT_EQ(hoist.state.mode, Mode::standby) << c.name;
  }
}

TEST(Modes, AcknowledgingADriveThatStaysInFaultIsRefused) {
  ScriptedHoist hoist = in_mode(Mode::user);
  hoist.drive_left.fault = true;
  hoist.drive_left.ignores_reset = true;
  ASSERT_TRUE(hoist.reach(Mode::protective_stop, 5));
  hoist.step(150);
  const std::uint32_t id = hoist.send(CommandKind::acknowledge);
  hoist.step(60);
  EXPECT_EQ(hoist.answer(id), refusal_bit(Refusal::cause_not_cleared));
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
}

// H2: the last resort uses present measurements. A turn rate that the chassis no longer reports is not a present turn.
TEST(Modes, H2AHeldRateLetsNoStandingHoistGo) {
  for (const bool silent : {true, false}) {
    ScriptedHoist hoist = in_mode(Mode::user);
    hoist.tilt_base.yaw_rate_deg_s = 15;
    hoist.step(3);
    hoist.tilt_base.rates_silent = silent;
    ASSERT_EQ(hoist.ask(CommandKind::stop), 0U);
    hoist.step(400);
    EXPECT_EQ(hoist.state.in_mode.hold.cut(), !silent);
    EXPECT_EQ(hoist.has_fault(Fault::overspeed), !silent);
  }
}

// H2, H10: without its rates the chassis counts as lost, from the start and in motion; only rates show slip and a dead encoder.
TEST(Modes, H2_H10_AChassisWithoutItsRatesIsLost) {
  ScriptedHoist walking = in_mode(Mode::user);
  walking.lean_gently(4, 100);
  walking.tilt_base.rates_silent = true;
  walking.step(4);
  EXPECT_EQ(walking.state.mode, Mode::user);
  walking.step(2);
  EXPECT_EQ(walking.state.mode, Mode::protective_stop);
  EXPECT_EQ(walking.state.latched, contract::fault_bit(Fault::tilt_base_lost));
  ScriptedHoist hoist;
  hoist.tilt_base.rates_silent = true;
  hoist.step(300);
  EXPECT_EQ(hoist.state.mode, Mode::init);
  hoist.tilt_base.rates_silent = false;
  ASSERT_TRUE(hoist.ready());
  hoist.tilt_base.rates_silent = true;
  hoist.step(3);
  EXPECT_EQ(hoist.ask_mode(Mode::user), refusal_bit(Refusal::nodes_missing));
}

// H4, H8: a sensor without one valid sample counts as missing, for any order of invalid ones.
TEST(Modes, H8_InvalidAndRepeatedSamplesByTurnsAreNoSensor) {
  ScriptedHoist hoist = in_mode(Mode::user);
  int steps = 0;
  for (; hoist.state.mode == Mode::user && steps < 100; ++steps) {
    hoist.tilt_left.frozen = true;
    hoist.tilt_left.status = steps % 2 == 0 ? 2 : 3;
    hoist.step();
  }
  EXPECT_EQ(hoist.state.mode, Mode::protective_stop);
  EXPECT_LE(steps, 12);
}

// H12: no start without a battery voltage, on any path to STANDBY.
TEST(Modes, H12NothingStartsWithoutWordOfTheBattery) {
  ScriptedHoist hoist;
  hoist.io.battery_silent = true;
  hoist.step(150);
  ASSERT_EQ(hoist.state.mode, Mode::init);
  ASSERT_EQ(hoist.ask(CommandKind::take_lease), 0U);
  ASSERT_EQ(hoist.ask(CommandKind::stop), 0U);
  hoist.step(150);
  hoist.ask(CommandKind::acknowledge);
  hoist.step(150);
  EXPECT_NE(hoist.ask_mode(Mode::user) & refusal_bit(Refusal::nodes_missing), 0U);
  EXPECT_FALSE(hoist.state.in_mode.powered);
}

TEST(Modes, StoppingAHoistThatIsPushedByHandRampsFromItsSpeed) {
  ScriptedHoist hoist = in_mode(Mode::standby);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = 0.4;
  hoist.step(20);
  hoist.drive_left.forced_m_s = hoist.drive_right.forced_m_s = NAN;
  hoist.ask(CommandKind::stop);
  EXPECT_NEAR(hoist.state.limiter.speed_m_s(), 0.39, 0.02);
  hoist.step(100);
  EXPECT_EQ(hoist.state.limiter.speed_m_s(), 0);
  EXPECT_FALSE(hoist.has_fault(Fault::gate_refused));
}

}  // namespace
}  // namespace hoist::core::test
