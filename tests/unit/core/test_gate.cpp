// The gate checks every kind of frame, and refuses unknown ones.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "control/core/output/safety_gate.hpp"
#include "control/core/types.hpp"

namespace hoist::core {
namespace {

namespace canopen = contract::canopen;
using contract::CanFrame;
using contract::Mode;
using contract::Node;
using contract::Pdo;

class Gate : public ::testing::Test {
 protected:
  static constexpr std::uint16_t kEnable = canopen::drive::kEnable;
  contract::Params params;
  Derived derived = derive(params);
  SafetyGate gate;
  GateView view{Mode::user, false, false, false, false, 0};

  [[nodiscard]] bool judge(const CanFrame& frame) const { return SafetyGate::judge(frame, view); }
  static CanFrame drive(Node node, std::uint16_t control, double wheel_m_s) {
    CanFrame f{contract::pdo_cob_id(Pdo::drive_rx1, node), 6, 0, {}};
    contract::write_slot(f, contract::pdo_slot(Pdo::drive_rx1, 0x6040), control);
    contract::write_slot(f, contract::pdo_slot(Pdo::drive_rx1, 0x60FF), std::lround(wheel_m_s / 0.1 * 30 * 1000));
    return f;
  }
  static double wheel(const CanFrame& f) {
    return static_cast<double>(contract::read_slot(f, contract::pdo_slot(Pdo::drive_rx1, 0x60FF))) * 0.1 / 30 / 1000;
  }
  static std::uint16_t control(const CanFrame& f) {
    return static_cast<std::uint16_t>(contract::read_slot(f, contract::pdo_slot(Pdo::drive_rx1, 0x6040)));
  }
  bool pair(const CanFrame& left, const CanFrame& right) { return gate.judge_drives(left, right, view, params, derived, kTick_s); }
  bool wheels(double left_m_s, double right_m_s, std::uint16_t left = kEnable, std::uint16_t right = kEnable) {
    return pair(drive(Node::drive_left, left, left_m_s), drive(Node::drive_right, right, right_m_s));
  }
  bool both(double speed_m_s, std::uint16_t word = kEnable) { return wheels(speed_m_s, speed_m_s, word, word); }
  bool moving(double speed_m_s, double yaw_rate_rad_s) {
    const double half_m_s = yaw_rate_rad_s * params.track_width_m / 2;
    return wheels(speed_m_s - half_m_s, speed_m_s + half_m_s);
  }
  // A legal ramp up to the motion; then it stays.
  void bring_to(double speed_m_s, double yaw_rate_rad_s = 0) {
    const GateView asked = view;
    gate = SafetyGate{};
    view = {Mode::user, false, false, false, false, 0};
    const int steps = 200;
    for (int i = 0; i <= steps; ++i) ASSERT_TRUE(moving(speed_m_s * i / steps, yaw_rate_rad_s * i / steps)) << i;
    view = asked;
  }
  double rounding_m_s = 5e-5;
};

TEST_F(Gate, EnablesDrivesOnlyWhereTheModeLetsThemRun) {
  for (const auto& mode : contract::kModes) {
    view.mode = static_cast<Mode>(mode.value);
    view.driver_fresh = true;
    const bool may = mode.moving != 0 || view.mode == Mode::protective_stop;
    gate = SafetyGate{};
    EXPECT_EQ(both(0), may) << mode.name;
    EXPECT_EQ(both(0, canopen::drive::kSwitchOn), may) << mode.name;
    EXPECT_EQ(wheels(0, 0, kEnable, canopen::drive::kShutdown), may) << mode.name;
    EXPECT_EQ(wheels(0, 0, canopen::drive::kShutdown, kEnable), may) << mode.name;
    EXPECT_TRUE(both(0, canopen::drive::kShutdown));
    EXPECT_TRUE(both(0, canopen::drive::kDisableVoltage));
    EXPECT_TRUE(both(0, canopen::drive::kQuickStop));
    EXPECT_TRUE(both(0, canopen::drive::kFaultReset));
    for (const std::uint16_t word : {canopen::drive::kShutdown, canopen::drive::kSwitchOn}) {
      EXPECT_FALSE(wheels(0.001, 0, word, word)) << "a target for a drive that does not run";
      EXPECT_FALSE(wheels(0, 0.001, word, word));
    }
    EXPECT_FALSE(wheels(0, 0, 0x1F, kEnable)) << "an unknown control word";
    EXPECT_FALSE(wheels(0, 0, kEnable, 0x1F));
  }
  for (const Mode mode : {Mode::init, Mode::standby}) EXPECT_EQ(contract::kModes[static_cast<std::size_t>(mode)].moving, 0);
}

TEST_F(Gate, BoundsTheSteps) {
  bring_to(0.3);
  EXPECT_FALSE(both(0.35)) << "a jump";
  EXPECT_FALSE(both(0.2)) << "harder than any stop";
  EXPECT_FALSE(both(-0.3));
  EXPECT_FALSE(both(0.3 - 0.015 - 2 * rounding_m_s));
  EXPECT_TRUE(both(0.3 - 0.015)) << "the bumper's stop";
  EXPECT_FALSE(both(0.285 + 0.005 + 2 * rounding_m_s)) << "faster than the acceleration allows";
  EXPECT_TRUE(both(0.285 + 0.005));
  bring_to(-0.3);
  EXPECT_FALSE(both(-0.3 + 0.015 + 2 * rounding_m_s));
  EXPECT_FALSE(both(-0.3 - 0.005 - 2 * rounding_m_s));
  EXPECT_TRUE(both(-0.3 + 0.015));
  gate = SafetyGate{};
  EXPECT_FALSE(both(0.1)) << "motion begins at rest";
  EXPECT_TRUE(both(0.005));
}

// H3: one wheel that continues while the other stops spins the patient; each wheel alone would look like a legal stop.
TEST_F(Gate, H1_H3TheTurnOfThePairIsJudgedAndNotEachWheel) {
  bring_to(0.3);
  const double step_rad_s = params.yaw_acceleration_rad_s2_max * kTick_s;
  EXPECT_FALSE(wheels(0.3 - 0.015, 0.3)) << "one wheel brakes alone: 2.1 degrees per second in a step";
  EXPECT_FALSE(wheels(0.3, 0.3 - 0.015));
  EXPECT_FALSE(moving(0.3, step_rad_s + 4 * rounding_m_s / params.track_width_m));
  EXPECT_FALSE(moving(0.3, -step_rad_s - 4 * rounding_m_s / params.track_width_m));
  EXPECT_TRUE(moving(0.3, step_rad_s));
  EXPECT_TRUE(moving(0.3, 0));
  EXPECT_TRUE(moving(0.3, -step_rad_s));
  bring_to(0, 0.8);
  double turn_rad_s = 0.8;
  while (moving(0, turn_rad_s + 0.01) && turn_rad_s < 2) turn_rad_s += 0.01;
  EXPECT_LE(turn_rad_s, params.yaw_rate_rad_s_max + 1e-3);
  EXPECT_GE(turn_rad_s, params.yaw_rate_rad_s_max - 0.011);
  bring_to(0, -0.8);
  turn_rad_s = -0.8;
  while (moving(0, turn_rad_s - 0.01) && turn_rad_s > -2) turn_rad_s -= 0.01;
  EXPECT_GE(turn_rad_s, -params.yaw_rate_rad_s_max - 1e-3);
}

TEST_F(Gate, TopSpeedHoldsWhateverTheSteps) {
  for (const double way : {1.0, -1.0}) {
    gate = SafetyGate{};
    double v = 0;
    while (both(way * (v + 0.004)) && v < 1.5) v += 0.004;
    EXPECT_LE(v, 0.65 + 1e-4);
    EXPECT_GE(v, 0.65 - 0.0041);
  }
}

TEST_F(Gate, NothingSpeedsUpOrTurnsFasterBlindlyOrWithoutADriver) {
  for (int blind = 0; blind < 6; ++blind) {
    SCOPED_TRACE(blind);
    for (const double way : {1.0, -1.0}) {
      bring_to(way * 0.2, way * 0.2);
      view = {Mode::user, false, false, true, false, 0};
      if (blind == 0) view.tilts_lost = true;
      if (blind == 1) view.drives_unfit = true;
      if (blind == 2) view = {Mode::remote, false, false, false, false, 0};
      if (blind == 3) view.mode = Mode::protective_stop;
      if (blind == 4) view = {Mode::remote, false, true, true, false, 0};
      const bool sees = blind == 5;
      EXPECT_EQ(moving(way * 0.201, way * 0.2), sees);
      bring_to(way * 0.2, way * 0.2);
      if (blind == 3) view.mode = Mode::protective_stop;
      EXPECT_EQ(moving(way * 0.2, way * 0.205), sees);
      EXPECT_TRUE(moving(way * 0.19, way * 0.19)) << "slowing is always allowed";
      EXPECT_TRUE(moving(way * 0.18, way * 0.18));
    }
  }
  // REMOTE needs no tilt, and USER no driver.
  bring_to(0.2);
  view = {Mode::remote, true, false, true, false, 0};
  EXPECT_TRUE(both(0.201));
  view = {Mode::user, false, false, false, false, 0};
  EXPECT_TRUE(both(0.202));
}

TEST_F(Gate, H13APressedBumperLetsNothingFasterThanAwayFromIt) {
  struct Case {
    std::uint8_t bumpers;
    double from_m_s, to_m_s;
    bool may;
  };
  for (const Case& c : {Case{0, 0.02, 0.021, true}, Case{0, 0.2, 0.201, true}, Case{1, 0.02, 0.021, false}, Case{1, -0.02, -0.021, true},
                        Case{2, 0.02, 0.021, true}, Case{2, -0.02, -0.021, false}, Case{3, 0.02, 0.021, false},
                        Case{3, -0.02, -0.021, false}, Case{4, 0.02, 0.021, true}, Case{8, -0.02, -0.021, true}, Case{2, 0.099, 0.1, true},
                        Case{2, 0.1, 0.1005, false}, Case{1, -0.1, -0.1005, false}, Case{1, -0.099, -0.1, true},
                        Case{8, 0.1, 0.1005, false}, Case{1, 0.02, 0.019, true}, Case{15, 0.3, 0.29, true}}) {
    bring_to(c.from_m_s);
    view.bumpers = c.bumpers;
    EXPECT_EQ(both(c.to_m_s), c.may) << int{c.bumpers} << " " << c.from_m_s;
  }
}

TEST_F(Gate, H13APressedBumperLetsNothingTurnFaster) {
  for (const std::uint8_t bumper : {0, 1, 2, 4, 8})
    for (const double turn_rad_s : {0.1, -0.1})
      for (const double speed_m_s : {0.05, 0.0, -0.05}) {
        SCOPED_TRACE(int{bumper});
        bring_to(speed_m_s, turn_rad_s);
        view.bumpers = bumper;
        EXPECT_EQ(moving(speed_m_s, turn_rad_s * 1.01), bumper == 0) << "a turn sweeps every corner";
        EXPECT_TRUE(moving(speed_m_s, turn_rad_s));
        EXPECT_TRUE(moving(speed_m_s, turn_rad_s * 0.99)) << "and may always end";
      }
}

TEST_F(Gate, AStopMayTakeOverAHoistThatRollsButNoOtherModeMay) {
  view.mode = Mode::protective_stop;
  EXPECT_TRUE(both(0.4));
  EXPECT_FALSE(both(0.45)) << "and then only slows";
  gate = SafetyGate{};
  EXPECT_FALSE(both(0.66)) << "not faster than anything may be";
  EXPECT_TRUE(wheels(0.4, 0, kEnable, canopen::drive::kShutdown)) << "with one drive, when the other is dead";
  gate = SafetyGate{};
  EXPECT_TRUE(wheels(0, -0.4, canopen::drive::kDisableVoltage, kEnable));
  gate = SafetyGate{};
  EXPECT_FALSE(wheels(0, 1.2, canopen::drive::kDisableVoltage, kEnable));
  EXPECT_FALSE(wheels(0, -1.2, canopen::drive::kDisableVoltage, kEnable));
  EXPECT_TRUE(wheels(0, 0.65 + params.yaw_rate_rad_s_max * 0.35, canopen::drive::kDisableVoltage, kEnable));
  // The second drive joins a stop that one began.
  EXPECT_TRUE(wheels(0.1, 0.2));
  gate = SafetyGate{};
  ASSERT_TRUE(wheels(0.2, 0, kEnable, canopen::drive::kShutdown));
  EXPECT_TRUE(wheels(0.2, 0.1));
  view.mode = Mode::remote;
  view.driver_fresh = true;
  gate = SafetyGate{};
  EXPECT_FALSE(both(0.4));
  EXPECT_FALSE(wheels(0.4, 0, kEnable, canopen::drive::kShutdown));
  EXPECT_FALSE(wheels(0, 0.4, canopen::drive::kShutdown, kEnable));
}

// H2, H3: one drive has dropped out. The other may continue until that is detected; then it may only slow down.
TEST_F(Gate, H2_H3AWheelLeftAloneComesToRest) {
  const double turn_step_m_s = params.yaw_acceleration_rad_s2_max * params.track_width_m / 2 * kTick_s;
  const double driving_m_s = params.acceleration_m_s2_max * kTick_s + turn_step_m_s;
  for (const bool is_left : {true, false}) {
    const auto alone = [&](double m_s) {
      return is_left ? wheels(m_s, 0, kEnable, canopen::drive::kDisableVoltage) : wheels(0, m_s, canopen::drive::kDisableVoltage, kEnable);
    };
    bring_to(0.2);
    EXPECT_FALSE(alone(0.2 + driving_m_s + 2 * rounding_m_s));
    EXPECT_TRUE(alone(0.2 + driving_m_s));
    bring_to(0.2);
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(alone(0.2 + 0.001 * i)) << i;
    EXPECT_FALSE(alone(0.21)) << "for 100 ms, not longer";
    EXPECT_TRUE(alone(0.209));
    EXPECT_TRUE(alone(0.2));
    EXPECT_FALSE(alone(0.2 - 0.015 - turn_step_m_s - 2 * rounding_m_s)) << "harder than any stop";
    EXPECT_TRUE(alone(0.2 - 0.015 - turn_step_m_s));
    bring_to(-0.2);
    EXPECT_FALSE(alone(-0.2 + 0.015 + turn_step_m_s + 2 * rounding_m_s));
    bring_to(0.2);
    view.tilts_lost = true;
    EXPECT_FALSE(alone(0.201)) << "blind";
    EXPECT_TRUE(alone(0.2));
    view.tilts_lost = false;
    bring_to(0.2);
    view.bumpers = 1;
    EXPECT_FALSE(alone(0.201)) << "towards or away: one wheel swings the hoist round";
    EXPECT_TRUE(alone(0.2));
    view.bumpers = 0;
    // Both run again: the count restarts.
    bring_to(0.0);
    for (int i = 0; i < 8; ++i) ASSERT_TRUE(alone(0));
    ASSERT_TRUE(both(0));
    for (int i = 0; i < 10; ++i) EXPECT_TRUE(alone(0.001 * i)) << i;
    // Or none does.
    ASSERT_TRUE(both(0, canopen::drive::kShutdown));
    for (int i = 0; i < 12; ++i) EXPECT_TRUE(alone(0));
    EXPECT_FALSE(alone(0.001));
  }
}

TEST_F(Gate, AStopMayEndTheShareOfATurnOfAWheelAlone) {
  const double turn_step_m_s = params.yaw_acceleration_rad_s2_max * params.track_width_m / 2 * kTick_s;
  for (const double bumper_m_s2 : {params.bumper_deceleration_m_s2, 8.0}) {
    params.bumper_deceleration_m_s2 = bumper_m_s2;
    const double inner_m_s = bumper_m_s2 * kTick_s - turn_step_m_s;
    const double gain_m_s = inner_m_s > turn_step_m_s ? inner_m_s : turn_step_m_s;
    bring_to(-0.1);
    view.mode = Mode::protective_stop;
    EXPECT_FALSE(wheels(-0.1 - gain_m_s - 2 * rounding_m_s, 0, kEnable, canopen::drive::kDisableVoltage));
    EXPECT_TRUE(wheels(-0.1 - gain_m_s, 0, kEnable, canopen::drive::kDisableVoltage));
    view.mode = Mode::user;
  }
}

TEST_F(Gate, TheHardestStopIsTheBumpersOrWhateverIsHarder) {
  struct Case {
    double protective, bumper, hardest;
  };
  for (const Case& c : {Case{1.0, 1.5, 1.5}, Case{1.0, 0.9, 1.0}, Case{0.5, 0.6, 0.8}, Case{0.6, 0.5, 0.8}}) {
    params.protective_deceleration_m_s2 = c.protective;
    params.bumper_deceleration_m_s2 = c.bumper;
    bring_to(0.3);
    EXPECT_FALSE(both(0.3 - c.hardest * kTick_s - 2 * rounding_m_s)) << c.hardest;
    EXPECT_TRUE(both(0.3 - c.hardest * kTick_s)) << c.hardest;
  }
}

TEST_F(Gate, WrongShapesAreRefused) {
  const CanFrame left = drive(Node::drive_left, kEnable, 0), right = drive(Node::drive_right, kEnable, 0);
  EXPECT_TRUE(pair(left, right));
  EXPECT_FALSE(pair(right, left)) << "each drive gets its own";
  EXPECT_FALSE(pair(left, left));
  EXPECT_FALSE(pair(right, right));
  CanFrame f = left;
  f.dlc = 5;
  EXPECT_FALSE(pair(f, right));
  f = right;
  f.flags = CanFrame::kExtended;
  EXPECT_FALSE(pair(left, f));
  EXPECT_FALSE(judge(left)) << "never one alone";
  CanFrame sync = canopen::sync();
  sync.flags = CanFrame::kExtended;
  EXPECT_FALSE(judge(sync));
  EXPECT_FALSE(judge(CanFrame{0x205, 6, 0, {}})) << "no such drive";
  EXPECT_FALSE(judge(CanFrame{0x181, 8, 0, {}})) << "a node's own frame";
  EXPECT_FALSE(judge(CanFrame{0x123, 0, 0, {}}));
  EXPECT_FALSE(judge(CanFrame{canopen::kSdoRequestBase, 8, 0, {}}));
}

TEST_F(Gate, SdoOnlyInItsShapeAndToANodeOfOurs) {
  const auto ask = [](std::uint8_t node) {
    return canopen::sdo(canopen::kSdoRequestBase + node, canopen::kSdoUploadRequest, 0x1018, 1, 0);
  };
  EXPECT_TRUE(judge(ask(0x11)));
  EXPECT_FALSE(judge(ask(0x33))) << "nobody";
  EXPECT_FALSE(judge(ask(0x7F))) << "the core itself";
  CanFrame shorter = ask(0x11);
  shorter.dlc = 7;
  EXPECT_FALSE(judge(shorter));
  CanFrame strange = ask(0x11);
  strange.flags = CanFrame::kExtended;
  EXPECT_FALSE(SafetyGate::is_service_frame(strange));
  EXPECT_TRUE(SafetyGate::is_service_frame(ask(0x11)));
}

// As a 32-bit float the edge of a range may lie beyond it by a rounding, and not by more. H27
TEST_F(Gate, H27ParametersOfNodesOnTheEdgeOfTheirRange) {
  view.mode = Mode::standby;
  for (const contract::ParamObject& object : contract::kParamObjects) {
    const contract::ParamInfo& info = contract::kParams[contract::param_index(object.param)];
    for (const contract::NodeInfo& node : contract::kNodes) {
      if (node.kind != object.kind) continue;
      const auto write = [&](double value) {
        const std::uint32_t bits = contract::param_word(object, value);
        return judge(canopen::sdo(canopen::kSdoRequestBase + node.id, canopen::sdo_download_command(4), object.index, object.sub, bits));
      };
      const double range = info.max - info.min;
      EXPECT_TRUE(write(info.min)) << info.name;
      EXPECT_TRUE(write(info.max)) << info.name;
      EXPECT_FALSE(write(info.min - 0.001 * range)) << info.name;
      EXPECT_FALSE(write(info.max + 0.001 * range)) << info.name;
      if (contract::find_object(object.kind, object.index, object.sub)->type == contract::ObjectType::f32) {
        EXPECT_FALSE(write(NAN)) << info.name;
      }
      // One rounding beyond the edge, where a float can say that.
      for (const auto& [edge, outward] : {std::pair{info.min, -INFINITY}, std::pair{info.max, INFINITY}}) {
        const auto beyond = static_cast<double>(std::nextafterf(static_cast<float>(edge), static_cast<float>(outward)));
        EXPECT_EQ(write(beyond), std::fabs(beyond - edge) <= 1e-6 * range || (beyond >= info.min && beyond <= info.max)) << info.name;
      }
    }
  }
}

// Objects that hold their default: this value alone, in its own size, to nodes of its kind, in each mode. H27
TEST_F(Gate, H27ObjectsThatHoldTheirDefaultAreWrittenNothingElse) {
  struct Kept {
    std::uint32_t id;
    std::size_t bytes;
    std::uint16_t index;
    std::uint8_t sub;
    std::uint32_t word;
  };
  for (const Mode mode : {Mode::init, Mode::standby, Mode::user, Mode::protective_stop}) {
    view.mode = mode;
    for (const Kept& kept : {Kept{0x601, 4, 0x6085, 0, 300}, Kept{0x602, 4, 0x6085, 0, 300}, Kept{0x602, 2, 0x605A, 0, 2},
                             Kept{0x601, 4, 0x2231, 1, std::bit_cast<std::uint32_t>(32.0F)}, Kept{0x608, 1, 0x6206, 1, 255},
                             Kept{0x608, 4, 0x1016, 1, 0x007F00FA}}) {
      const auto may = [&](std::uint32_t id, std::size_t bytes, unsigned index, unsigned sub, std::uint32_t word) {
        return judge(canopen::sdo(id, canopen::sdo_download_command(bytes), static_cast<std::uint16_t>(index),
                                  static_cast<std::uint8_t>(sub), word));
      };
      EXPECT_TRUE(may(kept.id, kept.bytes, kept.index, kept.sub, kept.word)) << kept.index;
      EXPECT_FALSE(may(kept.id, kept.bytes, kept.index, kept.sub, kept.word ^ 1U)) << kept.index;
      EXPECT_FALSE(may(kept.id, kept.bytes == 4 ? 3 : kept.bytes + 1, kept.index, kept.sub, kept.word)) << kept.index;
      EXPECT_FALSE(may(0x611, kept.bytes, kept.index, kept.sub, kept.word)) << kept.index << ": no tilt sensor has it";
      EXPECT_FALSE(may(kept.id, kept.bytes, kept.index, kept.sub + 2U, kept.word)) << kept.index;
      EXPECT_FALSE(may(kept.id, kept.bytes, kept.index + 0x100U, kept.sub, kept.word)) << kept.index;
    }
  }
}

// What leaves instead of a refused pair brakes both wheels alike and is itself a pair that the gate would let pass.
TEST_F(Gate, H1_H3WhatReplacesARefusedPairBrakesBothWheelsTogether) {
  bring_to(0.4, 0.4);
  double speed = 0.4, turn = 0.4;
  int steps = 0;
  for (; steps < 100 && speed > 0; ++steps) {
    CanFrame left = drive(Node::drive_left, kEnable, 2), right = drive(Node::drive_right, kEnable, 2);
    const SafetyGate same = gate;
    const SafetyGate::Motion motion = gate.brake(left, right, view, params, derived, kTick_s);
    EXPECT_EQ(control(left), kEnable);
    EXPECT_EQ(control(right), kEnable);
    EXPECT_NEAR(motion.speed_m_s, (wheel(left) + wheel(right)) / 2, 1e-9);
    EXPECT_NEAR(motion.yaw_rate_rad_s, (wheel(right) - wheel(left)) / params.track_width_m, 1e-9);
    EXPECT_LE(speed - motion.speed_m_s, 0.01 + rounding_m_s);
    EXPECT_LT(motion.speed_m_s, speed);
    EXPECT_LE(motion.yaw_rate_rad_s, turn);
    if (motion.speed_m_s > 0.02) {
      EXPECT_NEAR(motion.yaw_rate_rad_s / motion.speed_m_s, 1.0, 0.02) << "on its curve";
    }
    SafetyGate judge = same;
    EXPECT_TRUE(judge.judge_drives(left, right, view, params, derived, kTick_s));
    speed = motion.speed_m_s;
    turn = motion.yaw_rate_rad_s;
  }
  EXPECT_NEAR(steps, 54, 2) << "the outer wheel from 0.54 m/s at 1 m/s2";
  EXPECT_EQ(turn, 0);
}

TEST_F(Gate, WhateverShapeARefusedFrameHadItsReplacementIsADrivesCommand) {
  bring_to(0.3);
  CanFrame left{0x7FF, 8, CanFrame::kExtended, {}}, right = drive(Node::drive_right, kEnable, 0.3);
  left.data.fill(0xFF);
  right.dlc = 3;
  right.data[7] = 1;
  EXPECT_FALSE(pair(left, right));
  EXPECT_NEAR(gate.brake(left, right, view, params, derived, kTick_s).speed_m_s, 0.29, 1e-5) << "both go on braking";
  for (const CanFrame& f : {left, right}) {
    EXPECT_EQ(f.dlc, 6);
    EXPECT_EQ(f.flags, 0);
    EXPECT_EQ(f.data[6] | f.data[7], 0);
  }
  EXPECT_EQ(left.id, 0x201U);
  EXPECT_EQ(right.id, 0x202U);
}

TEST_F(Gate, ADriveThatWasToBeOffStaysOffWhenThePairIsReplaced) {
  bring_to(0.3);
  CanFrame left = drive(Node::drive_left, canopen::drive::kDisableVoltage, 0), right = drive(Node::drive_right, kEnable, 0.9);
  const auto alone = gate.brake(left, right, view, params, derived, kTick_s);
  EXPECT_EQ(control(left), canopen::drive::kDisableVoltage);
  EXPECT_EQ(wheel(left), 0);
  EXPECT_EQ(control(right), kEnable);
  EXPECT_NEAR(wheel(right), 0.29, 1e-5);
  EXPECT_NEAR(alone.speed_m_s, 0.29, 1e-5);
  EXPECT_EQ(alone.yaw_rate_rad_s, 0) << "one wheel alone is no turn to go on with";
  bring_to(0.3);
  left = drive(Node::drive_left, kEnable, 0.9);
  right = drive(Node::drive_right, canopen::drive::kShutdown, 0);
  EXPECT_NEAR(gate.brake(left, right, view, params, derived, kTick_s).speed_m_s, 0.29, 1e-5);
  EXPECT_EQ(control(right), canopen::drive::kShutdown);
}

TEST_F(Gate, WhereNoDriveMayRunBothAreSwitchedOff) {
  bring_to(0.3);
  view.mode = Mode::standby;
  CanFrame left = drive(Node::drive_left, kEnable, 0.3), right = drive(Node::drive_right, canopen::drive::kQuickStop, 0.3);
  const auto rest = gate.brake(left, right, view, params, derived, kTick_s);
  EXPECT_EQ(rest.speed_m_s, 0);
  for (const CanFrame& f : {left, right}) {
    EXPECT_EQ(control(f), canopen::drive::kShutdown);
    EXPECT_EQ(wheel(f), 0);
    EXPECT_EQ(f.dlc, 6);
  }
  EXPECT_EQ(left.id, 0x201U);
  EXPECT_EQ(right.id, 0x202U);
  // Nothing was running: zero, and the drives hold it.
  gate = SafetyGate{};
  view.mode = Mode::user;
  left = drive(Node::drive_left, kEnable, 0.3);
  right = drive(Node::drive_right, kEnable, 0.3);
  EXPECT_EQ(gate.brake(left, right, view, params, derived, kTick_s).speed_m_s, 0);
  EXPECT_EQ(wheel(left), 0);
  EXPECT_EQ(control(left), kEnable);
  EXPECT_TRUE(both(0));
}

TEST_F(Gate, H1_H23OfTheOutputsOnlyTheRelaysTwoAndTheSynchronisationLeave) {
  const std::uint32_t id = contract::pdo_cob_id(Pdo::io_rx1, Node::io);
  EXPECT_TRUE(judge({id, 2, 0, {0}}));
  EXPECT_TRUE(judge({id, 2, 0, {canopen::kRelayFeed}}));
  EXPECT_TRUE(judge({id, 2, 0, {canopen::kRelayRelease}}));
  EXPECT_TRUE(judge({id, 2, 0, {canopen::kRelayFeed | canopen::kRelayRelease}}));
  EXPECT_TRUE(judge({id, 2, 0, {canopen::kSyncOutput | canopen::kRelayFeed}}));
  for (unsigned bit = 3; bit < 8; ++bit) EXPECT_FALSE(judge({id, 2, 0, {static_cast<std::uint8_t>(1U << bit)}})) << bit;
  EXPECT_FALSE(judge({id, 0, 0, {}}));
  EXPECT_FALSE(judge({id, 1, 0, {1}}));
  EXPECT_FALSE(judge({id, 3, 0, {1}}));
  EXPECT_FALSE(judge({contract::pdo_cob_id(Pdo::drive_rx1, Node::drive_left), 2, 0, {1}}));
}

// What sounds is lit at least as urgently: sound may be paused, the light never is.
TEST_F(Gate, AnAlarmThatSoundsIsLit) {
  using contract::AlarmLevel;
  const std::uint32_t id = contract::pdo_cob_id(Pdo::io_rx1, Node::io);
  for (unsigned byte = 0; byte < 256; ++byte) {
    const unsigned sound = byte & 3U, light = byte >> 2U & 3U;
    EXPECT_EQ(judge({id, 2, 0, {0, static_cast<std::uint8_t>(byte)}}), byte < 16 && sound <= light) << byte;
  }
  EXPECT_EQ(contract::alarm_byte({AlarmLevel::none, AlarmLevel::high}), 12);
  EXPECT_EQ(contract::alarm_byte({AlarmLevel::medium, AlarmLevel::medium}), 10);
}

// A pair or nothing: alone, a quick stop of one wheel would turn the hoist about it.
TEST_F(Gate, H1NoDriveIsCommandedAlone) {
  for (const Node node : {Node::drive_left, Node::drive_right})
    for (const std::uint16_t control : {0x00, 0x02, 0x06, 0x07, 0x0F, 0x80}) EXPECT_FALSE(judge(drive(node, control, 0))) << control;
  // Nor in service, for any request of a tool.
  EXPECT_FALSE(SafetyGate::is_service_frame(drive(Node::drive_left, 0, 0)));
  EXPECT_FALSE(SafetyGate::is_service_frame(canopen::sync()));
}

TEST_F(Gate, SyncAndHeartbeatOnlyAsTheyAre) {
  EXPECT_TRUE(judge(canopen::sync()));
  CanFrame longer = canopen::sync();
  longer.dlc = 1;
  EXPECT_FALSE(judge(longer));
  EXPECT_TRUE(judge(canopen::heartbeat(0x7F, canopen::NmtState::operational)));
  EXPECT_FALSE(judge(canopen::heartbeat(0x7F, canopen::NmtState::stopped)));
  EXPECT_FALSE(judge(canopen::heartbeat(0x01, canopen::NmtState::operational))) << "speaking for a node";
  CanFrame beat = canopen::heartbeat(0x7F, canopen::NmtState::operational);
  beat.dlc = 2;
  EXPECT_FALSE(judge(beat));
}

TEST_F(Gate, NmtStartsNodesAndNeverResetsThem) {
  EXPECT_TRUE(judge(canopen::nmt(canopen::NmtCommand::start, 0x11)));
  EXPECT_TRUE(judge(canopen::nmt(canopen::NmtCommand::pre_operational, 0x11)));
  for (const auto command : {canopen::NmtCommand::stop, canopen::NmtCommand::reset_node, canopen::NmtCommand::reset_communication})
    EXPECT_FALSE(judge(canopen::nmt(command, 0x01)));
  EXPECT_FALSE(judge(canopen::nmt(canopen::NmtCommand::start, 0))) << "all at once";
  EXPECT_FALSE(judge(canopen::nmt(canopen::NmtCommand::start, 0x20)));
  EXPECT_FALSE(judge(canopen::nmt(canopen::NmtCommand::start, 0x7F)));
}

TEST_F(Gate, SdoWritesOnlyNodeParametersInTheirRange) {
  const auto write = [](std::uint8_t node, std::uint16_t index, std::uint8_t sub, float value) {
    return canopen::sdo(canopen::kSdoRequestBase + node, canopen::sdo_download_command(4), index, sub, std::bit_cast<std::uint32_t>(value));
  };
  view.mode = Mode::standby;
  EXPECT_TRUE(judge(canopen::sdo(0x601, canopen::kSdoUploadRequest, 0x1018, 2, 0)));
  EXPECT_FALSE(judge(canopen::sdo(0x601, canopen::kSdoUploadRequest, 0x7777, 2, 0)));
  EXPECT_TRUE(judge(write(0x01, 0x2200, 1, 0.12F)));
  EXPECT_TRUE(judge(write(0x02, 0x2200, 5, 12.0F))) << "the edge of the range";
  EXPECT_FALSE(judge(write(0x01, 0x2200, 5, 13.0F)));
  EXPECT_FALSE(judge(write(0x01, 0x2200, 1, NAN)));
  EXPECT_FALSE(judge(write(0x01, 0x2200, 3, 1.0F))) << "no parameter of the table";
  const auto ramp = [](std::uint32_t rad_s2) { return canopen::sdo(0x601, canopen::sdo_download_command(4), 0x6083, 0, rad_s2); };
  EXPECT_TRUE(judge(ramp(450)) && judge(ramp(2000)));
  EXPECT_FALSE(judge(ramp(2010)) || judge(ramp(0)) || judge(write(0x01, 0x6083, 0, 450.0F))) << "an integer, no float";
  EXPECT_FALSE(judge(write(0x01, 0x60FF, 0, 1.0F))) << "no driving by SDO";
  EXPECT_FALSE(judge(write(0x11, 0x2200, 1, 0.12F))) << "not an object of a tilt sensor";
  EXPECT_TRUE(judge(write(0x11, 0x2102, 1, 0.0102F)));
  EXPECT_FALSE(judge(canopen::sdo(0x601, canopen::sdo_download_command(2), 0x2200, 1, 0))) << "two bytes of a float";
  EXPECT_FALSE(judge(canopen::sdo(0x630, canopen::kSdoUploadRequest, 0x1018, 2, 0)));
  view.mode = Mode::user;
  EXPECT_TRUE(judge(write(0x01, 0x2200, 1, 0.2F))) << "a live gain";
  EXPECT_FALSE(judge(write(0x01, 0x2200, 5, 6.0F))) << "the current limit needs standstill";
}

// What a tool may send while nodes get new programs (CiA 302-3): reading, segments, aborts, and writing sub 1 of 1F50h to 1F57h.
TEST_F(Gate, H30OfServiceOnlyTheProgramsObjectsAreWritten) {
  constexpr std::uint32_t kNode = contract::canopen::kSdoRequestBase + contract::node_id(Node::tilt_left);
  const auto sdo = [](std::uint32_t id, unsigned first, unsigned index, unsigned sub) {
    return CanFrame{id,
                    8,
                    0,
                    {static_cast<std::uint8_t>(first), static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8U),
                     static_cast<std::uint8_t>(sub), 0, 0, 0, 0}};
  };
  for (unsigned first = 0; first < 256; ++first)
    for (const unsigned index : {0x0000U, 0x1010U, 0x1F4FU, 0x1F50U, 0x1F51U, 0x1F57U, 0x1F58U, 0x501FU, 0x6060U})
      for (const unsigned sub : {0U, 1U, 2U}) {
        const bool program = index >= 0x1F50 && index <= 0x1F57 && sub == 1;
        const unsigned kind = first >> 5U;
        const bool may = kind == 0 || kind == 2 || kind == 3 || (kind == 1 && program) || first == 0x80;
        EXPECT_EQ(SafetyGate::is_service_frame(sdo(kNode, first, index, sub)), may) << first << " " << index << " " << sub;
      }
  const CanFrame good = sdo(kNode, 0x21, 0x1F50, 1);
  // Wrong length, a flag, the computer itself, no node, and ids that equal a node's only in their low byte.
  CanFrame bad = good;
  bad.dlc = 7;
  EXPECT_FALSE(SafetyGate::is_service_frame(bad));
  bad = good;
  bad.flags = CanFrame::kRemote;
  EXPECT_FALSE(SafetyGate::is_service_frame(bad));
  for (const std::uint32_t id : {contract::canopen::kSdoRequestBase + contract::node_id(Node::core),
                                 contract::canopen::kSdoRequestBase + 0x7FU, kNode - 0x100U, kNode + 0x100U, kNode - 0x300U})
    EXPECT_FALSE(SafetyGate::is_service_frame(sdo(id, 0x21, 0x1F50, 1))) << id;
  // Only during service, which exists in INIT only.
  for (const bool service : {false, true})
    for (const auto& mode : contract::kModes) {
      view.service = service;
      view.mode = static_cast<Mode>(mode.value);
      EXPECT_EQ(judge(good), service && view.mode == Mode::init) << service << " " << mode.name;
      EXPECT_FALSE(judge(sdo(kNode - 0x300U, 0x40, 0x1000, 0))) << "no request of ours, whatever its last bits say";
      EXPECT_FALSE(judge(sdo(kNode + 0x100U, 0x40, 0x1000, 0)));
    }
}

TEST_F(Gate, H30AnNmtCommandHasTwoBytes) {
  for (const int dlc : {0, 1, 3, 8}) {
    CanFrame frame{contract::canopen::kNmt,
                   static_cast<std::uint8_t>(dlc),
                   0,
                   {static_cast<std::uint8_t>(contract::canopen::NmtCommand::start), contract::node_id(Node::tilt_left)}};
    EXPECT_FALSE(judge(frame)) << dlc;
    frame.dlc = 2;
    EXPECT_TRUE(judge(frame));
  }
}

}  // namespace
}  // namespace hoist::core
