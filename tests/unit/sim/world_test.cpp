// The world through its bus and its serial line, with a computer without control laws.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <string>

#include "control/contract/can_dictionary.hpp"
#include "firmware/sim/motor_relay.hpp"
#include "firmware/sim/stop_witness.hpp"
#include "firmware/sim/world.hpp"
#include "tests/unit/sim/scripted_host.hpp"

namespace hoist::sim {
namespace {

using contract::Node;
using contract::canopen::drive::State;

WorldOptions in_process(std::string_view scenario = "stand", std::uint64_t seed = 1) {
  WorldOptions options;
  options.host_in_process = true;
  options.scenario = find_scenario(scenario);
  options.seed = seed;
  return options;
}
State left_state(const ScriptedHost& host) { return contract::canopen::drive::state(host.status_word[0]); }

TEST(World, AllSixNodesBootAndTalkOnceStarted) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(1.0);
  for (const contract::NodeInfo& node : contract::kNodes) {
    if (node.kind == contract::NodeKind::host) continue;
    EXPECT_GE(host.count_by_id[contract::canopen::kHeartbeatBase + node.id], 8U) << node.name;
  }
  for (const Node node : {Node::tilt_left, Node::tilt_right, Node::tilt_base})
    EXPECT_NEAR(host.count_by_id[contract::pdo_cob_id(contract::Pdo::tilt_tx1, node)], 98, 3);
  for (const Node node : {Node::drive_left, Node::drive_right})
    EXPECT_NEAR(host.count_by_id[contract::pdo_cob_id(contract::Pdo::drive_tx1, node)], 98, 3);
  EXPECT_NEAR(host.count_by_id[contract::pdo_cob_id(contract::Pdo::io_tx1, Node::io)], 98, 3);
  EXPECT_EQ(world.bus_counters().rx_lost, 0U);
  EXPECT_EQ(world.bus_counters().tx_refused, 0U);
}

// A word of a node's identity, 1018h; nothing without an answer.
std::optional<std::uint32_t> identity(World& world, ScriptedHost& host, Node node, std::uint8_t sub) {
  const std::uint32_t id = contract::node_id(node);
  host.keep = true;
  host.seen.clear();
  EXPECT_TRUE(world.host_send(contract::canopen::sdo(0x600U + id, contract::canopen::kSdoUploadRequest, 0x1018, sub, 0)));
  host.run(0.05);
  for (const contract::CanFrame& frame : host.seen)
    if (frame.id == 0x580U + id && frame.data[0] == contract::canopen::sdo_upload_reply_command(4))
      return contract::read_le(&frame.data[4], 4);
  return std::nullopt;
}

TEST(World, EveryNodeSaysThatItIsSimulated) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(0.2);
  for (std::size_t i = 0; i < contract::kRemoteNodeCount; ++i)
    EXPECT_NE(identity(world, host, static_cast<Node>(i), 2).value_or(0) & contract::canopen::kSimulatedProduct, 0U) << i;
}

TEST(World, ANumberedHoistIsOneOfRealPartsAndAnExchangedOneHasAnotherNumber) {
  WorldOptions options = in_process();
  options.numbered = true;
  World world(options);
  ScriptedHost host(world);
  host.run(0.2);
  for (std::size_t i = 0; i < contract::kRemoteNodeCount; ++i) {
    const auto node = static_cast<Node>(i);
    EXPECT_EQ(identity(world, host, node, 2).value_or(contract::canopen::kSimulatedProduct) & contract::canopen::kSimulatedProduct, 0U)
        << i;
    EXPECT_EQ(identity(world, host, node, 4), World::first_serial(node));
    world.exchange(node, 77, World::Assembly::right);
    host.run(0.2);
    EXPECT_EQ(identity(world, host, node, 4), 77U);
  }
}

TEST(World, WronglyFittedDrivesTurnTheWrongWheelOrTheWrongWayAndDoNotKnow) {
  for (const World::Assembly how : {World::Assembly::reversed, World::Assembly::swapped}) {
    World world(in_process());
    ScriptedHost host(world);
    world.exchange(Node::drive_left, 0, how);
    host.run(3.0);
    host.enable();
    host.left_rad_s = 0.10 / 0.10 * 30.0;
    host.right_rad_s = 0.20 / 0.10 * 30.0;
    host.run(2.0);
    EXPECT_EQ(left_state(host), State::operation_enabled);
    const bool swapped = how == World::Assembly::swapped;
    EXPECT_NEAR(world.plant().wheel_speed_m_s(Side::left), swapped ? 0.20 : -0.10, 0.02);
    EXPECT_NEAR(world.plant().wheel_speed_m_s(Side::right), swapped ? 0.10 : 0.20, 0.02);
  }
}

TEST(StopWitness, AWheelThatRocksBackIsAtRestAndOneThatRollsOnIsNot) {
  StopWitness seen;
  seen.command(0);
  const auto look = [&seen](std::uint64_t ms, double wheel_m_s) { seen.look(ms * 1'000'000, false, wheel_m_s); };
  look(1, 0.3);
  look(400, 0.02);
  EXPECT_FALSE(seen.at_rest_ns().has_value()) << "still on its way";
  look(440, 0.009);
  look(490, -0.028);
  look(540, 0.0);
  EXPECT_EQ(seen.at_rest_ns(), 440'000'000U);
  look(600, -0.06);
  EXPECT_FALSE(seen.at_rest_ns().has_value());
  look(700, 0.0);
  EXPECT_EQ(seen.at_rest_ns(), 700'000'000U);
}

TEST(World, DrivesFollowTheirCommand) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(3.0);
  host.enable();
  EXPECT_EQ(left_state(host), State::operation_enabled);
  EXPECT_TRUE(world.drives_enabled());
  host.drive(0.30);
  host.run(3.0);
  EXPECT_NEAR(world.plant().platform().speed_m_s, 0.30, 0.01);
  EXPECT_EQ(world.patient().state(), PatientState::following);  // it moved first, so the patient lets it lead
  host.drive(0.0);
  host.run(2.0);
  EXPECT_NEAR(world.plant().platform().speed_m_s, 0.0, 0.01);
}

TEST(World, ASilentComputerStopsTheWheelsByThemselves) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(3.0);
  host.enable();
  host.drive(0.30);
  host.run(3.0);
  world.unplug(Node::core, true);
  const double speed_m_s = world.plant().platform().speed_m_s;
  const double x_m = world.plant().platform().x_m;
  // Braking begins within 50 ms of the last command (SOURCES 3), with 1 m/s2 at the wheel (quick-stop ramp 300 rad/s2 at the motor).
  for (int i = 0; i < 65; ++i) world.advance_1ms();
  EXPECT_LT(world.plant().platform().speed_m_s, speed_m_s - 0.005);
  for (int i = 0; i < 1000; ++i) world.advance_1ms();
  EXPECT_NEAR(world.plant().platform().speed_m_s, 0.0, 1e-3);
  EXPECT_FALSE(world.drives_enabled());
  EXPECT_LT(world.plant().platform().x_m - x_m, speed_m_s * 0.05 + speed_m_s * speed_m_s / 2.0 + 0.03);
}

TEST(World, AnUnpluggedSensorIsSilentAndStartsAnewWhenPluggedIn) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(3.0);
  const std::uint32_t id = contract::pdo_cob_id(contract::Pdo::tilt_tx1, Node::tilt_left);
  world.unplug(Node::tilt_left, true);
  EXPECT_TRUE(world.unplugged(Node::tilt_left));
  host.run(0.02);
  const std::uint32_t before = host.count_by_id[id];
  host.run(1.0);
  EXPECT_EQ(host.count_by_id[id], before);
  host.keep = true;
  world.unplug(Node::tilt_left, false);
  host.run(1.0);
  bool booted = false;
  for (const contract::CanFrame& frame : host.seen) booted = booted || (frame.id == 0x711 && frame.data[0] == 0);
  EXPECT_TRUE(booted);
  EXPECT_GT(host.count_by_id[id], before + 20);
}

TEST(World, AnUnpluggedDriveStopsOnItsOwnPower) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(3.0);
  host.enable();
  host.drive(0.30);
  host.run(3.0);
  world.unplug(Node::drive_left, true);
  host.run(0.5);
  EXPECT_FALSE(world.plant().bridge_enabled(Side::left));
  EXPECT_NEAR(world.plant().wheel_speed_m_s(Side::left), 0.0, 0.02);
}

TEST(World, AFrozenNodeIsSilentAndAFrozenSensorIsNot) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(3.0);
  const std::uint32_t left = contract::pdo_cob_id(contract::Pdo::tilt_tx1, Node::tilt_left);
  const std::uint32_t right = contract::pdo_cob_id(contract::Pdo::tilt_tx1, Node::tilt_right);
  world.freeze(Node::tilt_left, true);
  world.freeze_sensor(Node::tilt_right, true);
  host.run(0.02);
  const std::uint32_t left_before = host.count_by_id[left], right_before = host.count_by_id[right];
  host.keep = true;
  host.run(2.0);
  EXPECT_EQ(host.count_by_id[left], left_before);
  EXPECT_NEAR(host.count_by_id[right], right_before + 200, 3);
}

TEST(World, ABrokenEncoderMakesTheDriveLetGo) {
  for (const World::EncoderFault fault : {World::EncoderFault::lost, World::EncoderFault::reversed}) {
    World world(in_process());
    ScriptedHost host(world);
    host.run(3.0);
    host.enable();
    host.drive(0.20);
    host.run(2.0);
    ASSERT_EQ(left_state(host), State::operation_enabled);
    world.break_encoder(Node::drive_left, fault);
    host.run(1.0);
    EXPECT_EQ(left_state(host), State::fault);
    EXPECT_FALSE(world.plant().bridge_enabled(Side::left));
    EXPECT_LT(std::fabs(world.plant().wheel_speed_m_s(Side::left)), 0.7);
  }
}

TEST(World, AFaultHookSeesAndDropsFrames) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(1.0);
  const std::uint32_t id = contract::pdo_cob_id(contract::Pdo::tilt_tx1, Node::tilt_base);
  world.set_frame_fault([id](std::size_t, const contract::CanFrame& frame, std::uint64_t) {
    return bus::BusFault{frame.id == id ? bus::BusFault::Kind::drop : bus::BusFault::Kind::none, 0, 0};
  });
  host.run(0.02);
  const std::uint32_t before = host.count_by_id[id];
  host.run(0.5);
  EXPECT_EQ(host.count_by_id[id], before);
  world.set_frame_fault({});
  host.run(0.5);
  EXPECT_GT(host.count_by_id[id], before + 40);
}

TEST(World, SameSeedSameRunOtherSeedAnother) {
  const auto digest = [](std::uint64_t seed) {
    World world(in_process("stand", seed));
    ScriptedHost host(world);
    host.run(3.0);
    host.enable();
    host.drive(0.25);
    host.run(2.0);
    return world.digest();
  };
  EXPECT_EQ(digest(1), digest(1));
  // Noise reaches the sensors only; in this script no wheel depends on them, so another patient makes another run.
  const auto walk = [](double mass_kg) {
    WorldOptions options = in_process("straight");
    options.patient.mass_kg = mass_kg;
    World world(options);
    ScriptedHost host(world);
    host.run(3.0);
    host.enable();
    host.run(3.0);
    return world.digest();
  };
  EXPECT_EQ(walk(75.0), walk(75.0));
  EXPECT_NE(walk(75.0), walk(80.0));
}

TEST(World, WhoFallsOutOfBothStrapsLiesOnTheFloorAndIsFastenedWithoutAJerk) {
  for (const double toward_rad : {0.0, 1.5, 3.0}) {
    SCOPED_TRACE(toward_rad);
    World world(in_process());
    ScriptedHost host(world);
    host.run(0.5);
    for (const Side side : {Side::left, Side::right}) world.plant().cut_strap(side, true);
    world.patient().trip(toward_rad);
    host.run(20.0);
    EXPECT_LT(std::hypot(world.patient().harness().dx_m, world.patient().harness().dy_m), 1.0);
    for (const Side side : {Side::left, Side::right}) world.plant().cut_strap(side, false);
    world.patient().stand_in_the_middle();
    host.run(2.0);
    EXPECT_LT(std::hypot(world.plant().platform().x_m, world.plant().platform().y_m), 0.001);
  }
}

TEST(World, GoesBackToTheStartMarkOnlyWithTheDrivesOff) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(3.0);
  host.enable();
  host.drive(0.2);
  host.run(2.0);
  EXPECT_FALSE(world.restart(*find_scenario("square")));
  EXPECT_GT(world.plant().platform().x_m, 0.1);
  host.drive(0.0);
  host.run(1.5);
  host.control_word = 0x06;
  host.run(0.2);
  ASSERT_FALSE(world.drives_enabled());
  EXPECT_TRUE(world.restart(*find_scenario("square")));
  EXPECT_DOUBLE_EQ(world.plant().platform().x_m, -1.6);
  EXPECT_DOUBLE_EQ(world.plant().platform().y_m, -1.6);
  EXPECT_EQ(world.patient().state(), PatientState::standing);
}

// Sends a line of the gateway's protocol, and returns the answer.
std::string talk(World& world, std::string_view text, int milliseconds) {
  std::string back;
  std::array<char, 512> piece{};
  EXPECT_EQ(world.uart_write(text), text.size());
  for (int i = 0; i < milliseconds; ++i) {
    world.advance_1ms();
    const std::size_t got = world.uart_read(piece);
    back.append(piece.data(), got);
  }
  return back;
}

TEST(World, TheGatewaySpeaksSlcanAndCarriesFramesBothWays) {
  WorldOptions options;
  options.scenario = find_scenario("stand");
  World world(options);
  EXPECT_EQ(talk(world, "", 300), "");  // closed: silent
  EXPECT_EQ(talk(world, "S5\rO\r", 3).substr(0, 2), "\r\r");
  EXPECT_NE(talk(world, "", 200).find("t71117F\r"), std::string::npos);  // heartbeat of the left strut, pre-operational
  (void)talk(world, "t00020100\r", 150);
  EXPECT_NE(talk(world, "", 200).find("t711105\r"), std::string::npos);  // and operational
  EXPECT_NE(talk(world, "t0800\r", 20).find("t1816"), 0U);
  EXPECT_NE(talk(world, "t0800\r", 20).find("t1918"), 0U);
  (void)talk(world, "C\r", 5);
  EXPECT_EQ(talk(world, "", 200), "");
}

TEST(MotorRelay, H23IsHeldByChangesAndByNothingElse) {
  MotorRelay relay;
  for (int ms = 0; ms < 5000; ++ms) ASSERT_TRUE(relay.step_1ms(false)) << "not fitted";
  bool level = false;
  for (int ms = 0; ms < 5000; ++ms) {
    if (ms % 50 == 0) level = !level;
    ASSERT_TRUE(relay.step_1ms(level));
  }
  for (const bool stuck : {true, false}) {
    int held_ms = 0;
    static_cast<void>(relay.step_1ms(!stuck));
    while (relay.step_1ms(stuck) && held_ms < 3000) ++held_ms;
    EXPECT_NEAR(held_ms, 1000, 2) << "stuck " << (stuck ? "on" : "off");
    // One or two changes, as of a restarting node, do not close it.
    EXPECT_FALSE(relay.step_1ms(!stuck));
    EXPECT_FALSE(relay.step_1ms(stuck));
    for (int ms = 0; ms < 2000; ++ms) ASSERT_FALSE(relay.step_1ms(stuck));
    for (int change = 0; change < 4; ++change) static_cast<void>(relay.step_1ms(change % 2 == 0 ? !stuck : stuck));
    EXPECT_TRUE(relay.closed());
  }
}

TEST(MotorRelay, H1IsReleasedAtOnceAndClosesOnlyByNewChanges) {
  MotorRelay relay;
  bool level = false;
  const auto feed = [&](int ms, bool release) {
    for (int i = 0; i < ms; ++i) {
      if (i % 50 == 0) level = !level;
      static_cast<void>(relay.step_1ms(level, release));
    }
  };
  feed(1000, false);
  ASSERT_TRUE(relay.closed());
  feed(19, true);
  EXPECT_TRUE(relay.closed());
  feed(2, true);
  EXPECT_FALSE(relay.closed());
  feed(1000, true);
  EXPECT_FALSE(relay.closed()) << "changes do not hold what is released";
  for (int ms = 0; ms < 2000; ++ms) ASSERT_FALSE(relay.step_1ms(level, false));
  feed(120, false);
  EXPECT_FALSE(relay.closed());
  feed(100, false);
  EXPECT_TRUE(relay.closed());
}

TEST(World, H1AShortedBridgeObeysTheRelayAlone) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(3.0);
  sim::Plant& plant = world.plant();
  plant.short_bridge(Side::left, 1.0);
  host.run(1.0);
  EXPECT_FALSE(world.drives_enabled());
  EXPECT_EQ(left_state(host), State::fault) << "its drive sees the current";
  EXPECT_NEAR(plant.wheel_speed_m_s(Side::left), 0.64, 0.05) << "against its closed brake";
  EXPECT_GT(plant.motor_current_a(Side::left), 2.0);
  plant.cut_power(true);
  host.run(1.0);
  EXPECT_NEAR(plant.wheel_speed_m_s(Side::left), 0.0, 1e-6);
  plant.cut_power(false);
  plant.short_bridge(Side::left, std::nullopt);
  host.run(1.0);
  EXPECT_NEAR(plant.wheel_speed_m_s(Side::left), 0.0, 1e-6);
}

TEST(World, ACutPowerLineLeavesTheNodesTalking) {
  World world(in_process());
  ScriptedHost host(world);
  host.run(3.0);
  host.enable();
  host.drive(0.2);
  host.run(1.0);
  world.plant().cut_power(true);
  host.run(0.5);
  EXPECT_EQ(left_state(host), State::fault);
  EXPECT_FALSE(world.drives_enabled());
  const std::uint32_t before = host.count_by_id[contract::pdo_cob_id(contract::Pdo::drive_tx1, Node::drive_left)];
  host.run(0.5);
  EXPECT_GT(host.count_by_id[contract::pdo_cob_id(contract::Pdo::drive_tx1, Node::drive_left)], before + 40);
}

}  // namespace
}  // namespace hoist::sim
