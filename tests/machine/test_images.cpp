// The firmware's images as they would be flashed, run on the model: each alone, then all together with the control core.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <tuple>

#include "db/metrics/evaluate.hpp"
#include "tests/machine/hoist_bench.hpp"
#include "tests/machine/lpc11c24.hpp"
#include "tests/machine/stm32f072.hpp"

namespace hoist::machine {
namespace {

using contract::CanFrame;
using contract::Fault;
using contract::Mode;

constexpr double kShortLap_s = 100.0;
constexpr int kAnswerMax_ms = 120;         // an answer to "save" may wait for an erase: 100 ms on the LPC11C24, 40 ms on the STM32F072
constexpr std::uint32_t kStackSpare = 64;  // bytes at the end of the stack that must stay untouched

#define NEEDS_IMAGES(images)                                     \
  const ImagesOrReason found_images = load_images();             \
  if (!found_images.images) GTEST_SKIP() << found_images.reason; \
  const Images& images = *found_images.images

BenchOptions eight(bool through_gateway, ImageChip chip = ImageChip::lpc11c24) {
  BenchOptions options;
  options.chips.fill(chip);
  options.scenario = sim::find_scenario("figure-eight");
  options.patient.wish_m_s = 0.30;
  options.through_gateway = through_gateway;
  return options;
}

constexpr std::array<Box, 6> kNodes{Box::drive_left, Box::drive_right, Box::io, Box::tilt_left, Box::tilt_right, Box::tilt_base};
contract::Node node_of(Box box) { return static_cast<contract::Node>(static_cast<std::uint8_t>(box)); }
std::uint32_t id_of(Box box) { return contract::kNodes[static_cast<std::size_t>(node_of(box))].id; }

std::uint32_t stack_low(const Image& image) {
  const auto at = image.symbols.find("hoist_stack_low");
  return at == image.symbols.end() ? 0 : at->second;
}
bool bridge_awake(HoistBench& bench, Box box) {
  const PinPlace at = bench.pins(box).bridge_awake;
  return bench.chip(box).pin_driven_by_chip(at) && bench.chip(box).pin(at);
}

// Every test of one kind of board runs on both microcontrollers.
using EachChip = testing::TestWithParam<ImageChip>;
std::string chip_name(const testing::TestParamInfo<ImageChip>& tested) {
  return std::string(contract::find_image_chip(static_cast<std::uint8_t>(tested.param))->name);
}
class EachImage : public EachChip {};
class Faults : public EachChip {};
class LpcFaults : public EachChip {};  // what does not depend on the chip
INSTANTIATE_TEST_SUITE_P(Chips, EachImage, testing::Values(ImageChip::lpc11c24, ImageChip::stm32f072), chip_name);
INSTANTIATE_TEST_SUITE_P(Chips, LpcFaults, testing::Values(ImageChip::lpc11c24), chip_name);
INSTANTIATE_TEST_SUITE_P(Chips, Faults, testing::Values(ImageChip::lpc11c24, ImageChip::stm32f072), chip_name);

// The bench without a control core: a test that plays the computer.
struct Alone {
  Alone(const Images& images, ImageChip chip, bool through_gateway = false) : Alone(images, eight(through_gateway, chip)) {}
  Alone(const Images& images, const BenchOptions& options) : bench(images, options) {
    bench.wire().on_frame([this](const CanFrame& frame, Time) { wire.push_back(frame); });
  }
  void run(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) bench.advance_1ms();
  }
  [[nodiscard]] std::size_t count(std::uint32_t id) const {
    return static_cast<std::size_t>(std::count_if(wire.begin(), wire.end(), [id](const CanFrame& f) { return f.id == id; }));
  }
  [[nodiscard]] const CanFrame* last(std::uint32_t id) const {
    const auto at = std::find_if(wire.rbegin(), wire.rend(), [id](const CanFrame& f) { return f.id == id; });
    return at == wire.rend() ? nullptr : &*at;
  }
  /// Expedited upload; the four bytes, or the abort code with the top bit of the pair set.
  struct Answer {
    bool good{};
    std::uint32_t value{};
  };
  Answer sdo_read(std::uint32_t id, std::uint16_t index, std::uint8_t sub) {
    return sdo(id, {0x40, static_cast<std::uint8_t>(index), static_cast<std::uint8_t>(index >> 8), sub, 0, 0, 0, 0});
  }
  Answer sdo(std::uint32_t id, std::array<std::uint8_t, 8> data) {
    CanFrame request;
    request.id = 0x600 + id;
    request.dlc = 8;
    request.data = data;
    const std::size_t before = count(0x580 + id);
    bench.host_send(request);
    for (int i = 0; i < kAnswerMax_ms && count(0x580 + id) == before; ++i) bench.advance_1ms();
    const CanFrame* answer = last(0x580 + id);
    if (answer == nullptr || count(0x580 + id) == before) return {};
    std::uint32_t value = 0;
    for (unsigned i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(answer->data[4 + i]) << (8 * i);
    return {answer->data[0] != 0x80, value};
  }
  HoistBench bench;
  std::vector<CanFrame> wire;
};

TEST_P(EachImage, BootsAnswersAndTouchesNothingItMayNot) {
  NEEDS_IMAGES(images);
  Alone alone(images, GetParam());
  alone.run(1500);
  std::set<std::uint32_t> serials;
  for (const Box box : kNodes) {
    const std::uint32_t id = id_of(box);
    const std::string name = alone.bench.chip(box).name();
    ASSERT_GE(alone.count(0x700 + id), 10U) << name;
    const auto first = std::find_if(alone.wire.begin(), alone.wire.end(), [id](const CanFrame& f) { return f.id == 0x700 + id; });
    EXPECT_EQ(first->dlc, 1) << name;
    EXPECT_EQ(first->data[0], 0) << name << ": boot-up";
    EXPECT_EQ(alone.last(0x700 + id)->data[0], 0x7F) << name << ": pre-operational";
    // 1018h:2, product code: not one of a simulator.
    const auto product = alone.sdo_read(id, 0x1018, 2);
    EXPECT_TRUE(product.good) << name;
    EXPECT_EQ(product.value & 0x80000000U, 0U) << name;
    // 1018h:4 out of the chip's own id, another one on each board; 1009h is as long as the chip's name.
    const auto serial = alone.sdo_read(id, 0x1018, 4);
    EXPECT_TRUE(serial.good && serial.value != 0 && serials.insert(serial.value).second) << name << ": " << serial.value;
    EXPECT_EQ(alone.sdo_read(id, 0x1009, 0).value, contract::find_image_chip(static_cast<std::uint8_t>(GetParam()))->name.size()) << name;
    // An object that does not exist is refused with its code.
    const auto nothing = alone.sdo_read(id, 0x5FFF, 0);
    EXPECT_FALSE(nothing.good) << name;
    EXPECT_EQ(nothing.value, 0x06020000U) << name;
    EXPECT_EQ(alone.bench.chip(box).core().hard_faults(), 0U) << name;
    EXPECT_EQ(alone.bench.chip(box).resets(ResetCause::watchdog), 0U) << name;
    EXPECT_EQ(alone.bench.chip(box).clock_hz(), 48'000'000U) << name;
  }
  EXPECT_EQ(alone.bench.violations(), "");
}

TEST_P(EachImage, ABoardWithoutStrapsStaysOffTheBus) {
  NEEDS_IMAGES(images);
  const Image& image = images.of(GetParam(), Box::drive_left);
  const BoardPins& board = board_pins(GetParam());
  std::unique_ptr<Chip> made;
  if (GetParam() == ImageChip::stm32f072)
    made = std::make_unique<Stm32f072>("drive without straps", image.flash);
  else
    made = std::make_unique<Lpc11c24>("drive without straps", image.flash);
  Chip& chip = *made;
  chip.start_at(image.lowest);
  chip.set_analog([](unsigned, Time) { return 1.65; });
  CanWire wire;
  HostStation host;
  (void)wire.connect(host);
  (void)wire.connect(chip.can());
  chip.reset(ResetCause::power_on);
  for (Time now = 0; now < kSecond; now += 20 * kMicrosecond) {
    chip.run_until(now);
    wire.advance(now);
  }
  EXPECT_EQ(wire.frames(), 0U);
  EXPECT_FALSE(chip.pin(board.bridge_awake));
}

TEST_P(EachImage, TheGatewayCarriesBothWays) {
  NEEDS_IMAGES(images);
  Alone alone(images, GetParam(), true);
  alone.run(1200);
  std::array<CanFrame, 256> frames{};
  const std::size_t got = alone.bench.host_receive(frames);
  EXPECT_GT(got, 50U);
  const auto answer = alone.sdo_read(id_of(Box::io), 0x1018, 1);
  EXPECT_TRUE(answer.good);
  alone.run(5);
  const std::size_t more = alone.bench.host_receive(frames);
  EXPECT_TRUE(std::any_of(frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(more),
                          [](const CanFrame& f) { return f.id == 0x580 + id_of(Box::io); }));
  EXPECT_EQ(alone.bench.bad_lines(), 0U);
  EXPECT_EQ(alone.bench.violations(), "");
}

// The serial line at its full rate for 50 ms, far more frames than the bus takes: each line is answered, no character is lost.
TEST_P(EachImage, TheGatewayTakesAFullSerialLine) {
  NEEDS_IMAGES(images);
  BenchOptions options = eight(true, GetParam());
  options.only = Box::gateway;
  Alone alone(images, options);
  HostStation other;  // acknowledges
  (void)alone.bench.wire().connect(other);
  alone.run(300);
  CanFrame frame;
  frame.id = 0x123;
  frame.dlc = 8;
  frame.data.fill(0x55);
  for (int i = 0; i < 200; ++i) alone.bench.host_send(frame);  // 23 characters each
  alone.run(100);
  EXPECT_EQ(alone.bench.chip(Box::gateway).serial_state().overruns(), 0U);
  EXPECT_EQ(alone.bench.chip(Box::gateway).serial_state().line_waiting(), 0U);
  EXPECT_GT(other.received.size(), 30U);
  frame.id = 0x124;
  alone.bench.host_send(frame);
  alone.run(20);
  EXPECT_EQ(other.received.back().id, 0x124U);
  EXPECT_EQ(alone.bench.bad_lines(), 0U);
  EXPECT_EQ(alone.bench.violations(), "");
}

// A sensor that is plugged in later, and one that is pulled while it is read: the bus between the two chips is free again afterwards.
class EachSensor : public testing::TestWithParam<std::tuple<ImageChip, ImuKind>> {};
TEST_P(EachSensor, MayComeAndGo) {
  NEEDS_IMAGES(images);
  BenchOptions options = eight(false, std::get<0>(GetParam()));
  options.imus.fill(std::get<1>(GetParam()));
  options.only = Box::tilt_left;
  Alone alone(images, options);
  ImuChip& imu = alone.bench.imu(Box::tilt_left);
  for (int round = 0; round < 2; ++round) {
    imu.remove(true);
    alone.run(700);
    const std::uint64_t before = imu.samples();
    alone.run(100);
    EXPECT_EQ(imu.samples(), before);
    imu.remove(false);
    alone.run(2500);
    // On SPI a missing chip reads as ones: its configuration has changed, which is a failure until power-off (firmware/lib/imu).
    if (round == 1 && std::get<1>(GetParam()) == ImuKind::icm42688p)
      EXPECT_EQ(imu.samples(), before);
    else
      EXPECT_GT(imu.samples(), before + 100) << "round " << round;
  }
  EXPECT_EQ(alone.bench.chip(Box::tilt_left).resets(ResetCause::watchdog), 0U);
  EXPECT_EQ(alone.bench.violations(), "");
}
INSTANTIATE_TEST_SUITE_P(Chips, EachSensor,
                         testing::Combine(testing::Values(ImageChip::lpc11c24, ImageChip::stm32f072),
                                          testing::Values(ImuKind::mpu6050, ImuKind::icm42688p)));

// Without its crystal a node cannot keep the bus's bit time: it stays off the bus, running, with its outputs off.
TEST(Stm32Images, ADeadCrystalKeepsANodeOffTheBus) {
  NEEDS_IMAGES(images);
  BenchOptions options = eight(false, ImageChip::stm32f072);
  options.only = Box::drive_left;
  Alone alone(images, options);
  auto& chip = static_cast<Stm32f072&>(alone.bench.chip(Box::drive_left));
  chip.break_crystal();
  alone.run(2000);
  EXPECT_TRUE(alone.wire.empty());
  EXPECT_EQ(chip.clock_hz(), 8'000'000U);
  EXPECT_EQ(chip.resets(ResetCause::watchdog), 0U);
  EXPECT_FALSE(bridge_awake(alone.bench, Box::drive_left));
  EXPECT_EQ(alone.bench.violations(), "");
}

// The watchdog's oscillator has 30 to 50 kHz: an erase, in which the processor stands still for 40 ms, is no hang at either end, and a hang
// is found at both.
TEST(Stm32Images, AnEraseOutlivesTheWatchdogAtBothEndsOfItsOscillator) {
  NEEDS_IMAGES(images);
  for (const double slow_hz : {30e3, 50e3}) {
    BenchOptions options = eight(false, ImageChip::stm32f072);
    options.only = Box::io;
    Alone alone(images, options);
    auto& chip = static_cast<Stm32f072&>(alone.bench.chip(Box::io));
    chip.set_slow_oscillator(slow_hz);
    alone.run(400);
    for (int i = 0; i < 3; ++i) ASSERT_TRUE(alone.sdo(id_of(Box::io), {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'}).good) << slow_hz;
    EXPECT_GT(chip.flash_operations(), 6U);
    EXPECT_EQ(chip.resets(ResetCause::watchdog), 0U) << slow_hz;
    chip.hang(true);
    alone.run(70);
    EXPECT_EQ(chip.resets(ResetCause::watchdog), 1U) << slow_hz;
    EXPECT_EQ(alone.bench.violations(), "");
  }
}

// Each contact of the input board separately: a bumper opens when it is pressed, and so does the contact of the emergency stop chain.
TEST_P(EachImage, TheInputBoardReadsEachContactAndKeepsItsOutputsLow) {
  NEEDS_IMAGES(images);
  BenchOptions options = eight(false, GetParam());
  options.only = Box::io;
  Alone alone(images, options);
  alone.run(300);
  Chip& chip = alone.bench.chip(Box::io);
  const BoardPins& board = alone.bench.pins(Box::io);
  const std::uint32_t id = id_of(Box::io);
  const auto bumpers = [&] { return alone.sdo_read(id, 0x6000, 1).value & 0xFU; };
  const auto switches = [&] { return alone.sdo_read(id, 0x6000, 2).value & 0xFU; };
  EXPECT_EQ(bumpers(), 0U);
  EXPECT_EQ(switches(), 0U);
  for (unsigned i = 0; i < 4; ++i) {
    chip.float_pin(board.bumpers[i]);
    alone.run(30);
    EXPECT_EQ(bumpers(), 1U << i);
    chip.drive_pin(board.bumpers[i], false);
    alone.run(30);
  }
  chip.float_pin(board.emergency_stop);
  alone.run(30);
  EXPECT_EQ(switches(), 1U);
  for (unsigned i = 0; i < 8; ++i) {
    EXPECT_TRUE(chip.pin_driven_by_chip(board.outputs[i]));
    EXPECT_FALSE(chip.pin(board.outputs[i]));
  }
  EXPECT_EQ(alone.bench.violations(), "");
}

// Each of the three inertial sensors is found by its board, passes its self-test and measures upright within half a degree.
class EachImu : public testing::TestWithParam<ImuKind> {};
void find_and_measure(const Images& images, ImageChip chip, const std::array<ImuKind, 3>& kinds) {
  BenchOptions options = eight(false, chip);
  options.scenario = sim::find_scenario("stand");
  options.imus = kinds;
  MachineLoop loop(images, options);
  loop.run(4.0);
  EXPECT_EQ(loop.mode(), Mode::standby) << loop.faults();
  for (const Box box : {Box::tilt_left, Box::tilt_right, Box::tilt_base}) EXPECT_GT(loop.bench().imu(box).samples(), 300U);
  EXPECT_LT(std::fabs(static_cast<double>(loop.record().left_alpha_rad)), 0.01);
  EXPECT_LT(std::fabs(static_cast<double>(loop.record().right_beta_rad)), 0.01);
  EXPECT_EQ(loop.bench().violations(), "");
}
TEST_P(EachImu, IsFoundAndMeasures) {
  NEEDS_IMAGES(images);
  find_and_measure(images, ImageChip::lpc11c24, {GetParam(), GetParam(), GetParam()});
}
INSTANTIATE_TEST_SUITE_P(Kinds, EachImu, testing::Values(ImuKind::mpu6050, ImuKind::lsm6dso, ImuKind::icm42688p));
TEST(Stm32Imu, EachOfTheThreeIsFoundAndMeasures) {
  NEEDS_IMAGES(images);
  find_and_measure(images, ImageChip::stm32f072, {ImuKind::mpu6050, ImuKind::lsm6dso, ImuKind::icm42688p});
}

TEST_P(LpcFaults, AFailedSelfTestOrAWrongPartKeepsTheHoistFromStarting) {
  NEEDS_IMAGES(images);
  // A sound hoist is on standby after less than a second (EachImu).
  MachineLoop weak(images, eight(false, GetParam()));
  weak.bench().imu(Box::tilt_left).set_self_test_share(0.5);
  EXPECT_FALSE(weak.run_until([&weak] { return weak.mode() == Mode::standby; }, 4.0));
  MachineLoop wrong(images, eight(false, GetParam()));
  wrong.bench().imu(Box::tilt_base).set_identity(0x70);
  EXPECT_FALSE(wrong.run_until([&wrong] { return wrong.mode() == Mode::standby; }, 4.0));
}

// 1010h:1 keeps the parameters over a power cut; a cut while they are being written leaves the old ones or the new ones.
TEST_P(EachImage, StoredParametersSurviveACutAtAnyFlashOperation) {
  NEEDS_IMAGES(images);
  constexpr std::uint16_t kHeartbeat = 0x1017;
  const auto set = [](Alone& alone, std::uint8_t milliseconds) {
    return alone.sdo(id_of(Box::io), {0x2B, 0x17, 0x10, 0, milliseconds, 0, 0, 0}).good;
  };
  const auto store = [](Alone& alone) { return alone.sdo(id_of(Box::io), {0x23, 0x10, 0x10, 1, 's', 'a', 'v', 'e'}).good; };
  const auto power_cycle = [](Alone& alone) {
    alone.run(300);
    alone.bench.chip(Box::io).power_off();
    alone.run(50);
    alone.bench.chip(Box::io).reset(ResetCause::power_on);
    alone.run(300);
  };
  BenchOptions options = eight(false, GetParam());
  options.only = Box::io;
  for (int cut = 0; cut <= 3; ++cut) {
    Alone alone(images, options);
    alone.run(400);
    ASSERT_TRUE(set(alone, 150));
    ASSERT_TRUE(store(alone)) << "the node refuses to store";
    power_cycle(alone);
    ASSERT_EQ(alone.sdo_read(id_of(Box::io), kHeartbeat, 0).value, 150U);
    ASSERT_TRUE(set(alone, 160));
    if (cut > 0) alone.bench.chip(Box::io).cut_power_in_flash_operation(cut);
    (void)store(alone);
    power_cycle(alone);
    const auto kept = alone.sdo_read(id_of(Box::io), kHeartbeat, 0);
    ASSERT_TRUE(kept.good) << "cut " << cut;
    if (cut == 0)
      EXPECT_EQ(kept.value, 160U);
    else
      EXPECT_TRUE(kept.value == 150U || kept.value == 160U) << "cut " << cut << ": " << kept.value;
    EXPECT_EQ(alone.bench.violations(), "");
  }
}

// A wheel that reverses repeatedly: the old duty is never applied in the new direction (the model checks each change of PH).
TEST_P(EachImage, TheBridgeTurnsOnlyWhileItsOutputIsLow) {
  NEEDS_IMAGES(images);
  Alone alone(images, GetParam());
  alone.run(400);
  const auto id = static_cast<std::uint8_t>(id_of(Box::drive_left));
  alone.bench.host_send(contract::canopen::nmt(contract::canopen::NmtCommand::start, 0));
  alone.run(30);
  std::uint8_t feed = 0;  // of the motors' relay
  // 2200h:1, velocity gain, 5 V s/rad: the largest that is allowed, so that the duty is large where it reverses.
  EXPECT_TRUE(alone.sdo(id, {0x23, 0x00, 0x22, 1, 0x00, 0x00, 0xA0, 0x40}).good);
  const auto command = [&](std::uint16_t word, double speed_rad_s) {
    CanFrame frame{0x200U + id, 6, 0, {}};
    contract::write_le(&frame.data[0], 2, word);
    contract::write_le(&frame.data[2], 4, static_cast<std::uint32_t>(static_cast<std::int32_t>(1000 * speed_rad_s)));
    alone.bench.host_send(frame);
    CanFrame outputs{0x200U + id_of(Box::io), 2, 0, {}};
    outputs.data[0] = static_cast<std::uint8_t>((feed++ / 5U) & contract::canopen::kRelayFeed);
    alone.bench.host_send(outputs);
    alone.run(10);
  };
  for (int i = 0; i < 60; ++i) command(0, 0);  // until the relay has closed
  for (const std::uint16_t word : {0x06, 0x06, 0x07, 0x07, 0x0F}) command(word, 0);
  // The ramp swings between 67 rad/s forward and backward.
  for (int i = 0; i < 300; ++i) command(0x0F, (i + 15) / 30 % 2 == 0 ? 150.0 : -150.0);
  EXPECT_GT(alone.bench.chip(Box::drive_left).interlock_changes(), 9U);
  EXPECT_EQ(alone.bench.violations(), "");
}

// A supply that sags below what the chip can work with resets it, instead of letting it run on.
TEST_P(Faults, ABrownOutResetsTheChip) {
  NEEDS_IMAGES(images);
  Alone alone(images, GetParam());
  alone.run(300);
  Chip& chip = alone.bench.chip(Box::drive_left);
  chip.set_supply(1.7);  // below both supervisors' levels, where RAM still holds
  alone.run(20);
  EXPECT_FALSE(bridge_awake(alone.bench, Box::drive_left));
  chip.set_supply(3.3);
  alone.run(300);
  EXPECT_GE(chip.resets(ResetCause::brown_out), 1U);
  EXPECT_EQ(alone.last(0x700 + id_of(Box::drive_left))->data[0], 0x7F);
}

// ---- walking

struct Columns {
  std::vector<double> x_m, y_m, psi_rad, dpsi_rad;
  void add(const contract::TickRecord& record) {
    x_m.push_back(static_cast<double>(record.x_m));
    y_m.push_back(static_cast<double>(record.y_m));
    psi_rad.push_back(static_cast<double>(record.psi_rad));
    dpsi_rad.push_back(static_cast<double>(record.dpsi_rad));
  }
};

// The figure of eight, patient-led, by machine code: two drives, three tilts, inputs and gateway, the core behind the serial line. Both
// microcontrollers on one cable: each kind of box with each of them somewhere, left and right different.
TEST(Walking, ALapOfTheEightWithMixedChips) {
  NEEDS_IMAGES(images);
  BenchOptions options = eight(true, ImageChip::stm32f072);
  for (const Box box : {Box::drive_left, Box::tilt_right}) options.chips[static_cast<std::size_t>(box)] = ImageChip::lpc11c24;
  options.imus = {ImuKind::mpu6050, ImuKind::lsm6dso, ImuKind::icm42688p};
  MachineLoop loop(images, options);
  const contract::ReferencePath& path = loop.bench().patient().path();
  const contract::PathPose start = path.pose(0.0);
  ASSERT_TRUE(loop.run_until([&loop] { return loop.mode() == Mode::standby; }, 10.0)) << loop.faults();
  loop.ask(contract::CommandKind::take_lease);
  loop.step();
  loop.ask(contract::CommandKind::set_pose, 0, start.x_m, start.y_m, start.psi_rad);
  loop.run(0.05);
  ASSERT_TRUE(loop.start(Mode::user)) << loop.faults();
  // What happens once, before the first tick, is not the work of a millisecond.
  for (const Box box : kNodes) loop.bench().chip(box).core().reset_work();
  Columns run;
  while (loop.bench().patient().progress_m() < path.length_m() && loop.bench().time_s() < kShortLap_s) {
    loop.step();
    run.add(loop.record());
    ASSERT_EQ(loop.mode(), Mode::user) << loop.faults() << loop.bench().violations();
  }
  const auto evaluation = db::evaluate(path, {core::kTick_s, run.x_m, run.y_m, run.psi_rad, run.dpsi_rad});
  ASSERT_TRUE(evaluation && evaluation->c && evaluation->ise);
  // The same bounds as for the nodes compiled for this computer (tests/loop).
  EXPECT_GE(*evaluation->c, 0.75);
  EXPECT_LE(evaluation->ise->j, 15.0);
  const sim::PlatformMotion& truth = loop.bench().plant().platform();
  EXPECT_NEAR(static_cast<double>(loop.record().x_m), truth.x_m, 0.02);
  EXPECT_NEAR(static_cast<double>(loop.record().y_m), truth.y_m, 0.02);
  EXPECT_EQ(loop.bench().violations(), "");
  EXPECT_EQ(loop.bench().bad_lines(), 0U);
  for (const Box box : kNodes) {
    const Chip& chip = loop.bench().chip(box);
    EXPECT_EQ(chip.resets(ResetCause::watchdog), 0U) << chip.name();
    EXPECT_EQ(chip.core().hard_faults(), 0U) << chip.name();
    // Without flash waits no tick exceeds its millisecond, and with the slowest flash half of the processor is free on average.
    const CortexM0::Work& work = chip.core().work();
    // A tenth of a millisecond is left even if every fetch from flash waits.
    EXPECT_LT(work.worst_cycles, kMillisecond * 9 / 10) << chip.name();
    EXPECT_LT(work.total_cycles, work.ticks * kMillisecond * 3 / 4) << chip.name();
    EXPECT_GT(chip.core().lowest_sp(), stack_low(images.of(options.chips[static_cast<std::size_t>(box)], box)) + kStackSpare)
        << chip.name();
  }
  testing::Test::RecordProperty("correlation", std::to_string(*evaluation->c));
  std::printf("C %.3f, J %.2f, %.1f s, wire %.1f %%\n", *evaluation->c, evaluation->ise->j, loop.bench().time_s(),
              100.0 * static_cast<double>(loop.bench().wire().busy_time()) / static_cast<double>(loop.bench().now()));
}

TEST(Walking, TheSameOptionsGiveTheSameRun) {
  NEEDS_IMAGES(images);
  std::uint64_t digests[2]{};
  for (std::uint64_t& digest : digests) {
    MachineLoop loop(images, eight(true));
    loop.run(1.5);
    digest = loop.bench().digest();
  }
  EXPECT_EQ(digests[0], digests[1]);
}

// ---- what goes wrong

struct Walking : MachineLoop {
  Walking(const Images& images, ImageChip chip) : MachineLoop(images, eight(false, chip)) {
    walking = start(Mode::user) && run_until([this] { return bench().plant().platform().speed_m_s > 0.2; }, 10.0);
  }
  bool walking{};
};

// Hazard H2: an encoder line that no longer moves.
TEST_P(Faults, AStuckEncoderLineStopsTheHoist) {
  NEEDS_IMAGES(images);
  Walking loop(images, GetParam());
  ASSERT_TRUE(loop.walking) << loop.faults();
  loop.bench().break_encoder_line(Box::drive_left, 1);
  EXPECT_TRUE(loop.run_until([&loop] { return loop.mode() != Mode::user; }, 0.3));
  EXPECT_TRUE(loop.run_until([&loop] { return std::fabs(loop.bench().plant().platform().speed_m_s) < 0.01; }, 3.0));
  EXPECT_FALSE(loop.bench().plant().bridge_enabled(sim::Side::left));
}

// Hazard table 2.3: the contact of the emergency stop chain opens. A floating pin is pulled up, so a cut wire reads the same.
TEST_P(LpcFaults, AnOpenEmergencyStopChainTakesThePowerUntilItIsClosedAndAcknowledged) {
  NEEDS_IMAGES(images);
  Walking loop(images, GetParam());
  ASSERT_TRUE(loop.walking) << loop.faults();
  const PinPlace contact = loop.bench().pins(Box::io).emergency_stop;
  Chip& chip = loop.bench().chip(Box::io);
  chip.float_pin(contact);
  EXPECT_TRUE(loop.run_until([&loop] { return loop.mode() == Mode::emergency_stop; }, 0.05));
  EXPECT_TRUE(loop.fault(contract::Fault::emergency_stop));
  EXPECT_TRUE(loop.run_until([&loop] { return std::fabs(loop.bench().plant().platform().speed_m_s) < 0.01; }, 3.0));
  const auto acknowledge = [&loop] {
    loop.ask(contract::CommandKind::take_lease);
    loop.run(0.05);
    loop.ask(contract::CommandKind::acknowledge);
    loop.run(0.05);
    return loop.mode() != Mode::emergency_stop;
  };
  EXPECT_FALSE(acknowledge()) << "the chain is still open";
  chip.drive_pin(contact, false);
  loop.run(0.1);
  EXPECT_EQ(loop.mode(), Mode::emergency_stop) << "never by itself";
  EXPECT_TRUE(acknowledge()) << loop.faults();
}

// A hung program is found by the chip's watchdog, which resets it; the drive then reports it and does not move.
TEST_P(Faults, AHungDriveIsResetByItsWatchdogAndTheHoistStops) {
  NEEDS_IMAGES(images);
  Walking loop(images, GetParam());
  ASSERT_TRUE(loop.walking) << loop.faults();
  Chip& chip = loop.bench().chip(Box::drive_right);
  chip.hang(true);
  EXPECT_TRUE(loop.run_until([&loop] { return loop.mode() != Mode::user; }, 0.3));
  EXPECT_TRUE(loop.run_until([&chip] { return chip.resets(ResetCause::watchdog) == 1; }, 1.0));
  loop.run(0.5);
  EXPECT_FALSE(bridge_awake(loop.bench(), Box::drive_right));
  EXPECT_NE(loop.mode(), Mode::user);
  EXPECT_EQ(chip.resets(ResetCause::watchdog), 1U);  // once, not again and again
}

// A drive whose frames are lost stops by itself, and the core stops the other one.
TEST_P(Faults, ADriveThatIsOffTheBusStopsAndComesBack) {
  NEEDS_IMAGES(images);
  Walking loop(images, GetParam());
  ASSERT_TRUE(loop.walking) << loop.faults();
  HoistBench& bench = loop.bench();
  bench.wire().set_hook([&bench](std::size_t from, const CanFrame&, Time) {
    return from == bench.station(Box::drive_left) ? CanWire::Mischief::corrupt : CanWire::Mischief::none;
  });
  EXPECT_TRUE(loop.run_until([&bench] { return bench.chip(Box::drive_left).can().bus_off(); }, 1.0));
  bench.wire().set_hook({});
  EXPECT_TRUE(loop.run_until([&bench] { return !bench.plant().bridge_enabled(sim::Side::left); }, 1.0));
  EXPECT_NE(loop.mode(), Mode::user);
  // It recovers by itself and reports it.
  EXPECT_TRUE(loop.run_until([&bench] { return !bench.chip(Box::drive_left).can().bus_off(); }, 3.0));
  EXPECT_EQ(bench.violations(), "");
}

// Without acknowledge a drive does not go bus-off, and the command deadline stops the wheel.
TEST_P(LpcFaults, APulledBusPlugStopsTheDriveAlone) {
  NEEDS_IMAGES(images);
  Walking loop(images, GetParam());
  ASSERT_TRUE(loop.walking) << loop.faults();
  HoistBench& bench = loop.bench();
  bench.wire().plug(bench.station(Box::drive_left), false);
  const double speed_m_s = bench.plant().wheel_speed_m_s(sim::Side::left);
  loop.run(0.06);
  EXPECT_LT(bench.plant().wheel_speed_m_s(sim::Side::left), speed_m_s);
  EXPECT_TRUE(loop.run_until([&bench] { return !bench.plant().bridge_enabled(sim::Side::left); }, 2.0));
  EXPECT_NE(loop.mode(), Mode::user);
}

}  // namespace
}  // namespace hoist::machine
