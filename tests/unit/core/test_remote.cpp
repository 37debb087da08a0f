// Lease, hold-to-run and the age of driving commands (hazards H17 to H21).
#include <gtest/gtest.h>

#include "control/core/output/limiter.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

TEST(Lease, OneHolderAndTheEpochRisesWithEveryChange) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.to_standby());
  EXPECT_EQ(hoist.ask(CommandKind::take_lease, 7), 0U);
  const auto epoch = hoist.state.lease.epoch;
  EXPECT_EQ(hoist.ask(CommandKind::take_lease, 7), 0U) << "again by the same client: nothing to do";
  EXPECT_EQ(hoist.state.lease.epoch, epoch);
  EXPECT_EQ(hoist.ask(CommandKind::take_lease, 8), refusal_bit(Refusal::no_lease));
  EXPECT_EQ(hoist.state.lease.holder, 7U);
  EXPECT_EQ(hoist.ask(CommandKind::take_lease, 8, 1), 0U) << "taking over at standstill";
  EXPECT_EQ(hoist.state.lease.holder, 8U);
  EXPECT_EQ(hoist.state.lease.epoch, epoch + 1);
  EXPECT_EQ(hoist.ask(CommandKind::release_lease, 7), refusal_bit(Refusal::no_lease)) << "only its holder releases";
  EXPECT_EQ(hoist.ask(CommandKind::release_lease, 8), 0U);
  EXPECT_EQ(hoist.state.lease.holder, 0U);
  EXPECT_EQ(hoist.state.lease.epoch, epoch + 2);
  EXPECT_EQ(hoist.ask(CommandKind::take_lease, 0), refusal_bit(Refusal::no_lease)) << "the server itself never drives";
  EXPECT_EQ(hoist.count(EventKind::lease_changed), 3);
}

// A hand-over is for one lease, by its holder, at standstill: a request that names another lease gives no control.
TEST(Lease, IsHandedOverOnceByItsHolderAtStandstill) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.to_standby());
  const auto hand_over = [&hoist](std::uint32_t client, std::uint32_t epoch) {
    const std::uint32_t id = hoist.send(CommandKind::take_lease, client, contract::kHandOver);
    hoist.commands.back().lease_epoch = epoch;
    hoist.step();
    return hoist.answer(id);
  };
  EXPECT_EQ(hand_over(8, hoist.state.lease.epoch), refusal_bit(Refusal::no_lease)) << "nobody has anything to give";
  ASSERT_EQ(hoist.ask(CommandKind::take_lease, 7), 0U);
  const auto epoch = hoist.state.lease.epoch;
  EXPECT_EQ(hand_over(8, epoch - 1), refusal_bit(Refusal::no_lease)) << "of an earlier lease";
  EXPECT_EQ(hand_over(8, epoch + 1), refusal_bit(Refusal::no_lease)) << "of a lease to come";
  EXPECT_EQ(hoist.state.lease.holder, 7U);
  EXPECT_EQ(hand_over(8, epoch), 0U);
  EXPECT_EQ(hoist.state.lease.holder, 8U);
  EXPECT_EQ(hoist.state.lease.epoch, epoch + 1);
  EXPECT_EQ(hand_over(9, epoch), refusal_bit(Refusal::no_lease)) << "the same again: it has another holder";
  EXPECT_EQ(hoist.state.lease.holder, 8U);
  EXPECT_EQ(hand_over(0, epoch + 1), refusal_bit(Refusal::no_lease)) << "never to the server";
}

TEST(Lease, TheServerReleasesForAClientThatIsGone) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  EXPECT_NE(hoist.ask(CommandKind::release_lease, 0, 9), 0U) << "client 9 does not hold it";
  EXPECT_EQ(hoist.state.lease.holder, 7U);
  EXPECT_EQ(hoist.ask(CommandKind::release_lease, 0, 7), 0U);
  EXPECT_EQ(hoist.state.lease.holder, 0U);
}

// H20: the second therapist gets control at standstill.
TEST(Lease, CannotBeTakenOverWhileMoving) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(100, 0.8);
  EXPECT_EQ(hoist.ask(CommandKind::take_lease, 8, 1), refusal_bit(Refusal::moving));
  EXPECT_EQ(hoist.ask(CommandKind::take_lease, 8, contract::kHandOver), refusal_bit(Refusal::moving));
  EXPECT_EQ(hoist.state.lease.holder, 7U);
}

// A second screen can end the motion of the first, softly and at once; it can start nothing.
TEST(Lease, AnyoneMayEndAMotionAndOnlyTheHolderBeginsOne) {
  for (const Mode mode : {Mode::user, Mode::remote}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(mode));
    if (mode == Mode::remote) hoist.drive_for(100, 0.8);
    EXPECT_EQ(hoist.ask(CommandKind::request_mode, 8, static_cast<std::uint32_t>(Mode::standby)), 0U);
    EXPECT_EQ(hoist.state.lease.holder, 7U) << "the lease stays where it is";
    EXPECT_TRUE(hoist.reach(Mode::standby, 300));
    EXPECT_LE(hoist.worst_deceleration_m_s2, 1.0) << "no harder than the driver's own end";
    EXPECT_NE(hoist.ask(CommandKind::request_mode, 8, static_cast<std::uint32_t>(Mode::user)) & refusal_bit(Refusal::no_lease), 0U);
  }
  ScriptedHoist stopped;
  ASSERT_TRUE(stopped.start(Mode::user));
  stopped.ask(CommandKind::stop, 8);
  ASSERT_TRUE(stopped.reach(Mode::protective_stop, 10));
  stopped.step(300);
  EXPECT_NE(stopped.ask(CommandKind::request_mode, 8, static_cast<std::uint32_t>(Mode::standby)) & refusal_bit(Refusal::no_lease), 0U)
      << "a stop is left by the holder's acknowledgement";
  EXPECT_EQ(stopped.state.mode, Mode::protective_stop);
}

// H20, H28: a former lease holder has no rights.
TEST(Lease, OldEpochsCannotStartOrDrive) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  contract::Command old;
  old.sequence = ++hoist.sequence;
  old.kind = CommandKind::request_mode;
  old.client = 7;
  old.lease_epoch = hoist.state.lease.epoch - 1;
  old.a = static_cast<std::uint32_t>(Mode::user);
  old.request_id = 555;
  hoist.commands.push_back(old);
  hoist.step();
  EXPECT_EQ(hoist.answer(555), refusal_bit(Refusal::no_lease));
  EXPECT_EQ(hoist.state.mode, Mode::standby);
}

// Each error of a driving command, one at a time, on a hoist that drives with valid ones.
TEST(Remote, WrongCommandsMoveNothingAndAreCounted) {
  struct Case {
    const char* name;
    void (*spoil)(contract::DriveCommand&, const ScriptedHoist&);
  };
  const Case cases[] = {
      {"other client", [](contract::DriveCommand& c, const ScriptedHoist&) { c.client = 8; }},
      {"old epoch", [](contract::DriveCommand& c, const ScriptedHoist&) { --c.lease_epoch; }},
      {"same sequence", [](contract::DriveCommand& c, const ScriptedHoist&) { --c.sequence; }},
      {"old sequence", [](contract::DriveCommand& c, const ScriptedHoist&) { c.sequence = 1; }},
      {"echo too old", [](contract::DriveCommand& c, const ScriptedHoist& h) { c.echo_time_ns = h.time_ns - 270'000'000; }},
      {"echo from the future", [](contract::DriveCommand& c, const ScriptedHoist& h) { c.echo_time_ns = h.time_ns + 50'000'000; }},
      {"not a number", [](contract::DriveCommand& c, const ScriptedHoist&) { c.speed_norm = NAN; }},
      {"infinite turn", [](contract::DriveCommand& c, const ScriptedHoist&) { c.yaw_norm = HUGE_VAL; }},
      {"beyond one", [](contract::DriveCommand& c, const ScriptedHoist&) { c.speed_norm = 1.0000001; }},
      {"below minus one", [](contract::DriveCommand& c, const ScriptedHoist&) { c.yaw_norm = -1.5; }},
  };
  for (const Case& c : cases) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(9, 0.0);
    const auto refused = hoist.out.record.commands_refused;
    for (int i = 0; i < 10; ++i) {
      hoist.hold(1.0, 0.5);
      c.spoil(hoist.drive_command, hoist);
      --hoist.drive_sequence;  // the next one is checked separately
      hoist.step();
      EXPECT_EQ(hoist.command_m_s(), 0.0) << c.name;
    }
    EXPECT_EQ(hoist.out.record.commands_refused, refused + 10) << c.name;
  }
}

TEST(Remote, AnythingButOneInHeldIsLettingGo) {
  for (const std::uint64_t held : {std::uint64_t{0}, std::uint64_t{2}, ~std::uint64_t{0}}) {
    ScriptedHoist hoist;
    ASSERT_TRUE(hoist.start(Mode::remote));
    hoist.drive_for(100, 1.0);
    ASSERT_GT(hoist.command_m_s(), 0.1);
    hoist.hold(1.0);
    hoist.drive_command.held = held;
    hoist.step(100);
    EXPECT_EQ(hoist.command_m_s(), 0.0);
    EXPECT_EQ(hoist.state.mode, Mode::remote);
  }
}

TEST(Remote, H17AgeSlowsThenStopsAndEndsRemote) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(401, 1.0);  // the last command comes with the last step
  const double cruise = hoist.command_m_s();
  ASSERT_NEAR(cruise, 0.30, 1e-3);
  hoist.worst_deceleration_m_s2 = 0;
  // The command has seen the record of the step before it: it is one step old when it is taken.
  for (int i = 2; i <= 15; ++i) {
    hoist.step();
    EXPECT_NEAR(hoist.command_m_s(), cruise, 1e-4) << "up to 150 ms nothing changes: " << i;
  }
  for (int i = 16; i < 25; ++i) hoist.step();
  EXPECT_LT(hoist.command_m_s(), cruise);
  EXPECT_FALSE(hoist.has_fault(Fault::remote_command_lost));
  hoist.step(2);
  EXPECT_TRUE(hoist.has_fault(Fault::remote_command_lost)) << "270 ms after the last command";
  EXPECT_EQ(hoist.state.in_mode.braking, Braking::remote);
  EXPECT_TRUE(hoist.reach(Mode::standby, 100));
  EXPECT_LE(hoist.worst_deceleration_m_s2, kRemoteDeceleration_m_s2 + 1e-9);
  EXPECT_EQ(hoist.command_m_s(), 0);
}

// For any network delay and command rate: from the telemetry that the last command echoes to braking at most 250 ms and a step.
TEST(Remote, H17TheDelayOfTheNetworkIsPartOfTheAge) {
  constexpr int kStop_ticks = 25;
  for (int delay_ticks = 0; delay_ticks <= 30; ++delay_ticks) {
    for (const int period_ticks : {1, 4, 7}) {
      SCOPED_TRACE(std::to_string(delay_ticks) + " steps late, each " + std::to_string(period_ticks));
      ScriptedHoist hoist;
      ASSERT_TRUE(hoist.start(Mode::remote));
      std::vector<std::pair<int, contract::DriveCommand>> air;
      int felt = -1000, now = 0;
      const auto link = [&](bool hand) {
        if (hand && now % period_ticks == 0) {
          hoist.hold(1.0);
          hoist.drive_fresh = false;
          air.emplace_back(now + delay_ticks, hoist.drive_command);
          felt = now;
        }
        for (const auto& [due, command] : air)
          if (due == now) hoist.drive_command = command, hoist.drive_fresh = true;
        hoist.step();
        ++now;
      };
      while (now < 400) link(true);
      const bool drove = hoist.command_m_s() > 0.05;
      // Beyond the limit driving ends; up to 140 ms of delay nothing is refused.
      ASSERT_FALSE(drove && delay_ticks > kStop_ticks);
      ASSERT_TRUE(hoist.state.mode == Mode::remote || delay_ticks > 14 || period_ticks > 4);
      while (now <= felt + kStop_ticks) link(false);
      EXPECT_TRUE(hoist.state.in_mode.leaving || hoist.command_m_s() == 0) << "age " << hoist.out.record.remote_age_s;
    }
  }
}

TEST(Remote, H17ALaterCommandWithAnOlderEchoMakesTheHandNoOlder) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(20, 0.5);
  hoist.hold(0.5);
  hoist.step();
  const auto age_s = hoist.out.record.remote_age_s;
  hoist.hold(0.5);
  hoist.drive_command.echo_time_ns -= 200'000'000;
  hoist.step();
  EXPECT_FLOAT_EQ(hoist.out.record.remote_age_s, age_s + 0.01F);
}

TEST(Remote, H18AStallFollowedByABurstOfOldCommandsDoesNotMoveTheHoist) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(200, 1.0);
  std::vector<contract::DriveCommand> burst;
  for (int i = 0; i < 50; ++i) {  // sent by the tablet, delayed by the network
    hoist.hold(1.0);
    hoist.drive_fresh = false;
    burst.push_back(hoist.drive_command);
    hoist.step();
  }
  hoist.step(60);
  ASSERT_EQ(hoist.state.mode, Mode::standby);
  for (const auto& c : burst) {
    hoist.drive_command = c;
    hoist.drive_fresh = true;
    hoist.step();
    EXPECT_EQ(hoist.command_m_s(), 0);
    EXPECT_EQ(hoist.state.mode, Mode::standby);
  }
  EXPECT_GE(hoist.out.record.commands_refused, 50U);
}

TEST(Remote, AfterAGapTheStickMustComeBackFirst) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(200, 1.0);
  hoist.step(27);  // the gap
  hoist.drive_for(200, 1.0);
  EXPECT_EQ(hoist.state.mode, Mode::standby) << "no motion resumes by itself";
  EXPECT_EQ(hoist.command_m_s(), 0);
  EXPECT_NE(hoist.out.record.blocked_bits & refusal_bit(Refusal::stick_not_neutral), 0U);
  EXPECT_NE(hoist.ask_mode(Mode::remote), 0U);
  hoist.drive_for(120, 0.0);
  EXPECT_EQ(hoist.ask_mode(Mode::remote), 0U);
  hoist.drive_for(60, 0.5);
  EXPECT_GT(hoist.command_m_s(), 0.05);
}

// The gap ended REMOTE; requesting it again is not a release of the stick.
TEST(Remote, H17AfterAGapTheStickMustComeBackFirstAlsoInTheNextDrive) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(60, 0.6);
  hoist.step(300);
  ASSERT_EQ(hoist.state.mode, Mode::standby);
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(100, 0.6);
  EXPECT_EQ(hoist.command_m_s(), 0.0);
  hoist.hold(0.0);
  hoist.step(4);
  hoist.drive_for(100, 0.6);
  EXPECT_GT(hoist.command_m_s(), 0.05);
}

// A stick pushed in STANDBY and then silent does not count as neutral.
TEST(Remote, H17AStickLastSeenPushedIsPushed) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.drive_for(8, 1.0);
  hoist.step(100);
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(100, 1.0);
  EXPECT_EQ(hoist.command_m_s(), 0.0);
  hoist.hold(0.0, 0.0, false);
  hoist.step(4);
  hoist.drive_for(100, 1.0);
  EXPECT_GT(hoist.command_m_s(), 0.05);
}

TEST(Remote, LettingGoAndSilenceKeepRemote) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(100, 1.0);
  hoist.hold(0, 0, false);
  hoist.step(500);
  EXPECT_EQ(hoist.state.mode, Mode::remote);
  EXPECT_FALSE(hoist.has_fault(Fault::remote_command_lost));
}

// A stop in force never gets gentler, neither by a request for STANDBY, in any order, nor by an alarm with a gentler stop.
TEST(Remote, H17TheEndOfDrivingMakesNoStopGentler) {
  const auto let_go = [](ScriptedHoist& h) { h.hold(0, 0, false); };
  const auto end = [](ScriptedHoist& h) { h.send(CommandKind::request_mode, 7, static_cast<std::uint32_t>(Mode::standby)); };
  const auto alarm = [](ScriptedHoist& h) { h.drive_left.supply_v = h.drive_right.supply_v = h.io.battery_a_v = h.io.battery_b_v = 1.0; };
  const std::function<void(ScriptedHoist&)> seconds[] = {end, alarm, [](ScriptedHoist&) {}};
  for (const bool end_first : {false, true}) {
    for (const auto& second : seconds) {
      ScriptedHoist hoist;
      ASSERT_TRUE(hoist.start(Mode::remote));
      hoist.drive_for(300, 1.0);
      double before_m_s = hoist.command_m_s();
      ASSERT_GT(before_m_s, 0.25);
      if (end_first) {
        end(hoist);
        hoist.step(3);
      }
      let_go(hoist);
      hoist.step(1);
      before_m_s = hoist.command_m_s();
      second(hoist);
      for (int i = 0; i < 10; ++i) {
        hoist.step();
        EXPECT_NEAR((before_m_s - hoist.command_m_s()) / kTick_s, 0.8, 0.02) << end_first << i;
        before_m_s = hoist.command_m_s();
      }
    }
  }
}

TEST(Remote, H21ServerLostFreesTheLeaseAndStopsDriving) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(200, 1.0);
  hoist.server_up = false;
  int until_stop = 0;
  while (!hoist.state.in_mode.leaving && until_stop < 100) {
    hoist.drive_for(1, 1.0);  // even if commands still came
    ++until_stop;
  }
  EXPECT_LE(until_stop, 27);
  EXPECT_EQ(hoist.state.lease.holder, 0U);
  EXPECT_TRUE(hoist.reach(Mode::standby, 100));
  EXPECT_TRUE(hoist.has_fault(Fault::server_lost));
}

TEST(Remote, H21ServerLostLetsThePatientWalkOn) {
  ScriptedHoist with, without;
  for (ScriptedHoist* hoist : {&with, &without}) {
    ASSERT_TRUE(hoist->start(Mode::user));
    hoist->lean_gently(6, 200);
  }
  without.server_up = false;
  for (int i = 0; i < 500; ++i) {
    with.step();
    without.step();
    ASSERT_EQ(with.out.record.wheel_left_command_m_s, without.out.record.wheel_left_command_m_s) << "bit for bit the same walk";
    ASSERT_EQ(with.out.record.x_m, without.out.record.x_m);
  }
  EXPECT_EQ(without.state.mode, Mode::user);
  EXPECT_TRUE(without.has_fault(Fault::server_lost));
  EXPECT_EQ(without.out.record.server_alive, 0);
  EXPECT_EQ(without.state.lease.holder, 0U);
}

TEST(Remote, ANewServerStartsWithANewLeaseAndNewNumbers) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.heartbeat = 1;  // restarted between two steps
  hoist.step();
  EXPECT_EQ(hoist.state.lease.holder, 0U);
  hoist.sequence = 0;
  EXPECT_EQ(hoist.ask(CommandKind::take_lease, 3), 0U);
}

TEST(Remote, LosingTheLeaseStopsDriving) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(200, 1.0);
  EXPECT_EQ(hoist.ask(CommandKind::release_lease), 0U);
  EXPECT_TRUE(hoist.reach(Mode::standby, 100));
}

TEST(Remote, TheDriverTurnsTheHoistLeft) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(150, 0.0, 1.0);
  EXPECT_NEAR(hoist.out.record.yaw_rate_command_rad_s, 0.5236, 1e-3);
  EXPECT_GT(hoist.out.record.psi_rad, 0.3F);
  EXPECT_NEAR(hoist.out.record.x_m, 0, 0.01);
}

}  // namespace
}  // namespace hoist::core::test
