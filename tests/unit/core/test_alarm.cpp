// What sounds and what is lit at the hoist (IEC 60601-1-8), the pause of the sound, and the console that is missed (H21).
#include <gtest/gtest.h>

#include <optional>
#include <vector>

#include "control/contract/alarms.hpp"
#include "tests/unit/core/scripted_hoist.hpp"

namespace hoist::core::test {
namespace {

using contract::AlarmCommand;
using contract::AlarmLevel;

// What the input node was told last: at most 50 ms old.
AlarmCommand told(ScriptedHoist& hoist) {
  std::optional<AlarmCommand> last;
  for (int i = 0; i < 5; ++i) {
    hoist.step();
    for (const contract::CanFrame& frame : hoist.sent)
      if (frame.id == contract::pdo_cob_id(contract::Pdo::io_rx1, contract::Node::io)) last = contract::alarm_command(frame.data[1]);
  }
  EXPECT_TRUE(last.has_value()) << "one frame each 50 ms";
  const AlarmCommand alarm = last.value_or(AlarmCommand{});
  EXPECT_EQ(hoist.out.record.alarm_sound, static_cast<int>(alarm.sound)) << "the record tells what was sent";
  EXPECT_EQ(hoist.out.record.alarm_light, static_cast<int>(alarm.light));
  return alarm;
}
void expect_alarm(ScriptedHoist& hoist, AlarmLevel sound, AlarmLevel light) {
  const AlarmCommand alarm = told(hoist);
  EXPECT_EQ(alarm.sound, sound);
  EXPECT_EQ(alarm.light, light);
}
std::uint32_t pause(ScriptedHoist& hoist, bool paused = true, std::uint32_t role = kTherapist) {
  return hoist.ask(CommandKind::pause_alarm, 9, paused ? 1 : 0, role);
}
std::vector<std::uint32_t> pauses(const ScriptedHoist& hoist) {
  std::vector<std::uint32_t> codes;
  for (const contract::Event& event : hoist.events)
    if (event.kind == EventKind::alarm_paused) codes.push_back(event.code);
  return codes;
}

TEST(Alarm, TheMostUrgentFaultInForceSoundsAndIsLit) {
  for (const contract::FaultInfo& fault : contract::kFaults)
    EXPECT_EQ(contract::alarm_level(contract::fault_bit(fault)), contract::alarm_level(fault.priority)) << fault.name;
  EXPECT_EQ(contract::alarm_level(contract::FaultBits{0}), AlarmLevel::none);

  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  expect_alarm(hoist, AlarmLevel::none, AlarmLevel::none);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 11.3;  // low
  hoist.step(600);
  expect_alarm(hoist, AlarmLevel::low, AlarmLevel::low);
  hoist.ask(CommandKind::stop);
  expect_alarm(hoist, AlarmLevel::medium, AlarmLevel::medium);
  hoist.io.bumpers = 1;
  hoist.step(2);
  expect_alarm(hoist, AlarmLevel::high, AlarmLevel::high);
  // Latched faults sound until they are released.
  hoist.io.bumpers = 0;
  hoist.step(200);
  expect_alarm(hoist, AlarmLevel::high, AlarmLevel::high);
  EXPECT_EQ(hoist.ask(CommandKind::acknowledge, 7, 0, kTherapist), 0U);
  hoist.step(2);
  expect_alarm(hoist, AlarmLevel::low, AlarmLevel::low);
}

TEST(Alarm, ItIsToldAlsoBeforeTheDrivesAreThere) {
  ScriptedHoist hoist;
  hoist.drive_left.silent = hoist.drive_right.silent = true;
  hoist.server_up = false;  // missed 5 s after the start
  hoist.step(600);
  ASSERT_EQ(hoist.state.mode, Mode::init);
  std::uint8_t levels = 0;
  for (int i = 0; i < 20; ++i) {
    hoist.step();
    for (const contract::CanFrame& frame : hoist.sent)
      if (frame.id == contract::pdo_cob_id(contract::Pdo::io_rx1, contract::Node::io))
        levels |= static_cast<std::uint8_t>(1U << (frame.data[0] & contract::canopen::kRelayFeed));
  }
  EXPECT_TRUE(levels == 1 || levels == 2) << "frames come, and the relay is not fed";
  expect_alarm(hoist, AlarmLevel::medium, AlarmLevel::medium);
}

TEST(Alarm, ThePauseIsForTwoMinutesAndNeverForTheLight) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  EXPECT_EQ(pause(hoist), refusal_bit(Refusal::out_of_order)) << "nothing sounds";
  hoist.ask(CommandKind::stop);
  EXPECT_EQ(pause(hoist, true, 0), refusal_bit(Refusal::not_allowed)) << "a viewer";
  EXPECT_EQ(pause(hoist, true, 3), refusal_bit(Refusal::not_allowed)) << "no role";
  EXPECT_EQ(hoist.ask(CommandKind::pause_alarm, 9, 2, kEngineer), refusal_bit(Refusal::out_of_range));
  expect_alarm(hoist, AlarmLevel::medium, AlarmLevel::medium);
  ASSERT_EQ(pause(hoist), 0U) << "needs no lease";
  EXPECT_NEAR(hoist.out.record.alarm_pause_s, contract::kAudioPause_s, 0.011);
  int silent = 0;  // steps
  for (; hoist.out.record.alarm_sound == 0 && silent < 20'000; ++silent) {
    ASSERT_EQ(pauses(hoist).size(), 1U) << "its end is told with its end";
    hoist.step();
  }
  EXPECT_EQ(hoist.out.record.alarm_light, static_cast<int>(AlarmLevel::medium));
  EXPECT_EQ(silent, 11'999) << "with the step of the command, 120 s";
  EXPECT_EQ(hoist.out.record.alarm_pause_s, 0);
  EXPECT_EQ(pauses(hoist), (std::vector<std::uint32_t>{1, 0}));
  // Ended by hand; a second time there is nothing to end.
  ASSERT_EQ(pause(hoist, true, kEngineer), 0U);
  expect_alarm(hoist, AlarmLevel::none, AlarmLevel::medium);
  EXPECT_EQ(pause(hoist, false), 0U);
  expect_alarm(hoist, AlarmLevel::medium, AlarmLevel::medium);
  EXPECT_EQ(pause(hoist, false), refusal_bit(Refusal::out_of_order));
  EXPECT_EQ(pauses(hoist), (std::vector<std::uint32_t>{1, 0, 1, 0}));
  // Also in its last step.
  ASSERT_EQ(pause(hoist), 0U);
  while (hoist.out.record.alarm_pause_s > 1.5 * kTick_s) hoist.step();
  EXPECT_EQ(pause(hoist, false), 0U);
}

TEST(Alarm, ANewAlarmEndsThePauseAndSoDoesOneThatComesBack) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.io.bumpers = 1;
  hoist.step(2);
  ASSERT_EQ(pause(hoist), 0U);
  expect_alarm(hoist, AlarmLevel::none, AlarmLevel::high);
  // A less urgent one, too.
  hoist.io.battery_a_v = hoist.io.battery_b_v = 11.3;
  hoist.step(600);
  expect_alarm(hoist, AlarmLevel::high, AlarmLevel::high);
  ASSERT_EQ(pause(hoist), 0U);
  hoist.step(600);
  expect_alarm(hoist, AlarmLevel::none, AlarmLevel::high);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 12.8;
  hoist.step(600);
  expect_alarm(hoist, AlarmLevel::none, AlarmLevel::high);
  hoist.io.battery_a_v = hoist.io.battery_b_v = 11.3;
  hoist.step(600);
  expect_alarm(hoist, AlarmLevel::high, AlarmLevel::high);
}

TEST(Alarm, APauseEndsWithItsAlarms) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.ready());
  hoist.ask(CommandKind::stop);
  hoist.step(150);
  ASSERT_EQ(pause(hoist), 0U);
  ASSERT_EQ(hoist.ask(CommandKind::acknowledge, 7, 0, kTherapist), 0U);
  hoist.step(5);
  EXPECT_EQ(hoist.out.record.alarm_pause_s, 0);
  hoist.ask(CommandKind::stop);
  expect_alarm(hoist, AlarmLevel::medium, AlarmLevel::medium);
}

// ----- H21: the console in control -----

std::uint32_t connection_ends(ScriptedHoist& hoist) { return hoist.ask(CommandKind::release_lease, 7, contract::kConsoleGone); }

TEST(Alarm, H21_AConsoleThatVanishesDuringAWalkIsHeard) {
  ScriptedHoist hoist, undisturbed;
  for (ScriptedHoist* each : {&hoist, &undisturbed}) {
    ASSERT_TRUE(each->start(Mode::user));
    each->lean_gently(6, 200);
  }
  ASSERT_EQ(connection_ends(hoist), 0U);
  undisturbed.step();
  hoist.step();
  undisturbed.step();
  EXPECT_TRUE(hoist.has_fault(Fault::console_lost));
  for (int i = 0; i < 300; ++i) {
    hoist.step();
    undisturbed.step();
    ASSERT_EQ(hoist.out.record.wheel_left_command_m_s, undisturbed.out.record.wheel_left_command_m_s) << "the patient walks on";
  }
  expect_alarm(hoist, AlarmLevel::medium, AlarmLevel::medium);
  ASSERT_EQ(hoist.ask(CommandKind::take_lease, 8), 0U) << "on another tablet, while the patient walks";
  hoist.step();
  EXPECT_FALSE(hoist.has_fault(Fault::console_lost));
  expect_alarm(hoist, AlarmLevel::none, AlarmLevel::none);
}

TEST(Alarm, H21_OneWhoGivesControlBackIsNotMissed) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  ASSERT_EQ(hoist.ask(CommandKind::release_lease), 0U);
  hoist.step(100);
  EXPECT_FALSE(hoist.has_fault(Fault::console_lost));
  // Nor is a console that goes while the hoist stands on standby.
  ScriptedHoist standing;
  ASSERT_TRUE(standing.ready());
  ASSERT_EQ(connection_ends(standing), 0U);
  standing.step(100);
  EXPECT_FALSE(standing.has_fault(Fault::console_lost));
}

TEST(Alarm, H21_AConsoleThatDroveIsMissedForAMinuteAfterTheStop) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::remote));
  hoist.drive_for(100, 0.5);
  ASSERT_EQ(connection_ends(hoist), 0U);
  ASSERT_TRUE(hoist.reach(Mode::standby));
  int missed = 0;
  while (hoist.has_fault(Fault::console_lost) && missed < 10'000) hoist.step(), ++missed;
  EXPECT_EQ(missed, 6'000);
  EXPECT_EQ(hoist.out.record.alarm_light, 0);
}

TEST(Alarm, H21_AServerThatReturnsDoesNotHideThatNobodyIsInControl) {
  ScriptedHoist hoist;
  ASSERT_TRUE(hoist.start(Mode::user));
  hoist.server_up = false;
  hoist.step(40);
  EXPECT_TRUE(hoist.has_fault(Fault::server_lost));
  hoist.server_up = true;
  hoist.step(10);
  EXPECT_FALSE(hoist.has_fault(Fault::server_lost));
  EXPECT_TRUE(hoist.has_fault(Fault::console_lost));
  EXPECT_EQ(contract::headline(contract::fault_bit(Fault::server_lost) | contract::fault_bit(Fault::console_lost)), Fault::server_lost);
}

}  // namespace
}  // namespace hoist::core::test
