// The firmware's images as they would be flashed, run on the model: each alone, then all together with the control core.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>

#include "db/metrics/evaluate.hpp"
#include "firmware/boards/lpc11c24/memory.hpp"
#include "firmware/boards/lpc11c24/pins.hpp"
#include "tests/machine/hoist_bench.hpp"

namespace hoist::machine {
namespace {

using contract::CanFrame;
using contract::Fault;
using contract::Mode;

constexpr double kShortLap_s = 100.0;
constexpr std::uint32_t kStackSpare = 64;  // bytes that nothing may have touched at the stack's far end

#define NEEDS_IMAGES(images)                                     \
  const ImagesOrReason found_images = load_images();             \
  if (!found_images.images) GTEST_SKIP() << found_images.reason; \
  const Images& images = *found_images.images

BenchOptions eight(bool through_gateway) {
  BenchOptions options;
  options.scenario = sim::find_scenario("figure-eight");
  options.patient.wish_m_s = 0.30;
  options.through_gateway = through_gateway;
  return options;
}

constexpr std::array<Box, 6> kNodes{Box::drive_left, Box::drive_right, Box::io, Box::tilt_left, Box::tilt_right, Box::tilt_base};
contract::Node node_of(Box box) { return static_cast<contract::Node>(static_cast<std::uint8_t>(box)); }
std::uint32_t id_of(Box box) { return contract::kNodes[static_cast<std::size_t>(node_of(box))].id; }

std::uint32_t stack_low(const Images& images, Box box) {
  const Image& image =
      box == Box::io ? images.io : (box <= Box::drive_right ? images.drive : (box == Box::gateway ? images.gateway : images.tilt));
  const auto at = image.symbols.find("hoist_stack_low");
  return at == image.symbols.end() ? 0 : at->second;
}

// The bench without a control core: a test that plays the computer.
struct Alone {
  Alone(const Images& images, bool through_gateway = false) : bench(images, eight(through_gateway)) {
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
    for (int i = 0; i < 50 && count(0x580 + id) == before; ++i) bench.advance_1ms();
    const CanFrame* answer = last(0x580 + id);
    if (answer == nullptr || count(0x580 + id) == before) return {};
    std::uint32_t value = 0;
    for (unsigned i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(answer->data[4 + i]) << (8 * i);
    return {answer->data[0] != 0x80, value};
  }
  HoistBench bench;
  std::vector<CanFrame> wire;
};

TEST(Images, EachBootsAnswersAndTouchesNothingItMayNot) {
  NEEDS_IMAGES(images);
  Alone alone(images);
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
    // 1018h:4 out of the chip's own id, another one on each board; 1009h, eight letters: LPC11C24.
    const auto serial = alone.sdo_read(id, 0x1018, 4);
    EXPECT_TRUE(serial.good && serial.value != 0 && serials.insert(serial.value).second) << name << ": " << serial.value;
    EXPECT_EQ(alone.sdo_read(id, 0x1009, 0).value, 8U) << name;
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

TEST(Images, ABoardWithoutStrapsStaysOffTheBus) {
  NEEDS_IMAGES(images);
  Lpc11c24 chip("drive without straps", images.drive.flash);
  chip.start_at(images.drive.lowest);
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
  EXPECT_FALSE(chip.pin(2, 8));  // nSLEEP: the bridge stays off
}

TEST(Images, TheGatewayCarriesBothWays) {
  NEEDS_IMAGES(images);
  Alone alone(images, true);
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

// Each of the three inertial sensors is found by its board, passes its self-test and measures upright within half a degree.
class EachImu : public testing::TestWithParam<ImuKind> {};
TEST_P(EachImu, IsFoundAndMeasures) {
  NEEDS_IMAGES(images);
  BenchOptions options = eight(false);
  options.scenario = sim::find_scenario("stand");
  options.imus.fill(GetParam());
  MachineLoop loop(images, options);
  loop.run(4.0);
  EXPECT_EQ(loop.mode(), Mode::standby) << loop.faults();
  EXPECT_GT(loop.bench().imu(Box::tilt_left).samples(), 300U);
  EXPECT_LT(std::fabs(static_cast<double>(loop.record().left_alpha_rad)), 0.01);
  EXPECT_LT(std::fabs(static_cast<double>(loop.record().right_beta_rad)), 0.01);
  EXPECT_EQ(loop.bench().violations(), "");
}
INSTANTIATE_TEST_SUITE_P(Kinds, EachImu, testing::Values(ImuKind::mpu6050, ImuKind::lsm6dso, ImuKind::icm42688p));

TEST(Images, AFailedSelfTestOrAWrongPartKeepsTheHoistFromStarting) {
  NEEDS_IMAGES(images);
  // A sound hoist is on standby after less than a second (EachImu).
  MachineLoop weak(images, eight(false));
  weak.bench().imu(Box::tilt_left).set_self_test_share(0.5);
  EXPECT_FALSE(weak.run_until([&weak] { return weak.mode() == Mode::standby; }, 4.0));
  MachineLoop wrong(images, eight(false));
  wrong.bench().imu(Box::tilt_base).set_identity(0x70);
  EXPECT_FALSE(wrong.run_until([&wrong] { return wrong.mode() == Mode::standby; }, 4.0));
}

// 1010h:1 keeps the parameters over a power cut; a cut while they are being written leaves the old ones or the new ones.
TEST(Images, StoredParametersSurviveACutAtAnyFlashOperation) {
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
  for (int cut = 0; cut <= 3; ++cut) {
    Alone alone(images);
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

// A wheel thrown to and fro: the old duty is never applied in the new direction (the model looks at each change of PH).
TEST(Images, TheBridgeTurnsOnlyWhileItsOutputIsLow) {
  NEEDS_IMAGES(images);
  Alone alone(images);
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
    CanFrame outputs{0x200U + id_of(Box::io), 1, 0, {}};
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
TEST(Faults, ABrownOutResetsTheChip) {
  NEEDS_IMAGES(images);
  Alone alone(images);
  alone.run(300);
  Lpc11c24& chip = alone.bench.chip(Box::drive_left);
  chip.set_supply(2.0);
  alone.run(20);
  EXPECT_GE(chip.resets(ResetCause::brown_out), 1U);
  EXPECT_FALSE(chip.pin_driven_by_chip(2, 8) && chip.pin(2, 8));
  chip.set_supply(3.3);
  alone.run(300);
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

// The figure of eight, patient-led, by machine code: two drives, three tilts, inputs and gateway, the core behind the serial line.
TEST(Walking, ALapOfTheEightByMachineCode) {
  NEEDS_IMAGES(images);
  MachineLoop loop(images, eight(true));
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
    const Lpc11c24& chip = loop.bench().chip(box);
    EXPECT_EQ(chip.resets(ResetCause::watchdog), 0U) << chip.name();
    EXPECT_EQ(chip.core().hard_faults(), 0U) << chip.name();
    // No millisecond was longer than one with a flash that keeps up, and with the slowest flash half of the processor is still free on average.
    const CortexM0::Work& work = chip.core().work();
    // A tenth of a millisecond is left even if every fetch from flash waits.
    EXPECT_LT(work.worst_cycles, kMillisecond * 9 / 10) << chip.name();
    EXPECT_LT(work.total_cycles, work.ticks * kMillisecond * 3 / 4) << chip.name();
    EXPECT_GT(chip.core().lowest_sp(), stack_low(images, box) + kStackSpare) << chip.name();
  }
  RecordProperty("correlation", std::to_string(*evaluation->c));
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
  explicit Walking(const Images& images) : MachineLoop(images, eight(false)) {
    walking = start(Mode::user) && run_until([this] { return bench().plant().platform().speed_m_s > 0.2; }, 10.0);
  }
  bool walking{};
};

// Hazard H2: an encoder line that no longer moves.
TEST(Faults, AStuckEncoderLineStopsTheHoist) {
  NEEDS_IMAGES(images);
  Walking loop(images);
  ASSERT_TRUE(loop.walking) << loop.faults();
  loop.bench().break_encoder_line(Box::drive_left, 1);
  EXPECT_TRUE(loop.run_until([&loop] { return loop.mode() != Mode::user; }, 0.3));
  EXPECT_TRUE(loop.run_until([&loop] { return std::fabs(loop.bench().plant().platform().speed_m_s) < 0.01; }, 3.0));
  EXPECT_FALSE(loop.bench().plant().bridge_enabled(sim::Side::left));
}

// Hazard table 2.3: the contact of the emergency stop chain opens. A pin that floats is pulled up, so a torn wire reads alike.
TEST(Faults, AnOpenEmergencyStopChainTakesThePowerUntilItIsClosedAndAcknowledged) {
  NEEDS_IMAGES(images);
  Walking loop(images);
  ASSERT_TRUE(loop.walking) << loop.faults();
  namespace board = firmware::lpc11c24;
  Lpc11c24& chip = loop.bench().chip(Box::io);
  chip.float_pin(board::kSwitch0.port, board::kSwitch0.bit);
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
  chip.drive_pin(board::kSwitch0.port, board::kSwitch0.bit, false);
  loop.run(0.1);
  EXPECT_EQ(loop.mode(), Mode::emergency_stop) << "never by itself";
  EXPECT_TRUE(acknowledge()) << loop.faults();
}

// A hung program is found by the chip's watchdog, which really resets it; the drive then says so and does not move by itself.
TEST(Faults, AHungDriveIsResetByItsWatchdogAndTheHoistStops) {
  NEEDS_IMAGES(images);
  Walking loop(images);
  ASSERT_TRUE(loop.walking) << loop.faults();
  Lpc11c24& chip = loop.bench().chip(Box::drive_right);
  chip.hang(true);
  EXPECT_TRUE(loop.run_until([&loop] { return loop.mode() != Mode::user; }, 0.3));
  EXPECT_TRUE(loop.run_until([&chip] { return chip.resets(ResetCause::watchdog) == 1; }, 1.0));
  loop.run(0.5);
  EXPECT_FALSE(chip.pin_driven_by_chip(2, 8) && chip.pin(2, 8));  // bridge asleep
  EXPECT_NE(loop.mode(), Mode::user);
  EXPECT_EQ(chip.resets(ResetCause::watchdog), 1U);  // once, not again and again
}

// A drive that nobody hears any more stops by itself, and the core stops the other one.
TEST(Faults, ADriveThatIsOffTheBusStopsAndComesBack) {
  NEEDS_IMAGES(images);
  Walking loop(images);
  ASSERT_TRUE(loop.walking) << loop.faults();
  HoistBench& bench = loop.bench();
  bench.wire().set_hook([&bench](std::size_t from, const CanFrame&, Time) {
    return from == bench.station(Box::drive_left) ? CanWire::Mischief::corrupt : CanWire::Mischief::none;
  });
  EXPECT_TRUE(loop.run_until([&bench] { return bench.chip(Box::drive_left).can().bus_off(); }, 1.0));
  bench.wire().set_hook({});
  EXPECT_TRUE(loop.run_until([&bench] { return !bench.plant().bridge_enabled(sim::Side::left); }, 1.0));
  EXPECT_NE(loop.mode(), Mode::user);
  // It comes back by itself and says so.
  EXPECT_TRUE(loop.run_until([&bench] { return !bench.chip(Box::drive_left).can().bus_off(); }, 3.0));
  EXPECT_EQ(bench.violations(), "");
}

// With nobody to acknowledge its frames a drive does not leave the bus, and the wheel is stopped by the missing commands.
TEST(Faults, APulledBusPlugStopsTheDriveAlone) {
  NEEDS_IMAGES(images);
  Walking loop(images);
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
