// The model of the chip: a bare program on it, and the violations that it reports.
#include <gtest/gtest.h>

#include <cstring>
#include <string>

#include "tests/machine/image.hpp"
#include "tests/machine/lpc11c24.hpp"

namespace hoist::machine {
namespace {

using contract::CanFrame;

std::string all(const Lpc11c24& chip) {
  std::string out;
  for (const auto& [what, count] : chip.violations()) out += what + " (" + std::to_string(count) + ")\n";
  return out;
}

// The word checked by the ROM: the first eight vectors add up to 0.
void sign(std::vector<std::uint8_t>& flash) {
  std::uint32_t sum = 0, word = 0;
  for (std::size_t i = 0; i < 7; ++i) {
    std::memcpy(&word, &flash[4 * i], 4);
    sum += word;
  }
  word = ~sum + 1;
  std::memcpy(&flash[28], &word, 4);
}

CanFrame frame(std::uint32_t id, std::initializer_list<std::uint8_t> data) {
  CanFrame out;
  out.id = id;
  out.dlc = static_cast<std::uint8_t>(data.size());
  std::copy(data.begin(), data.end(), out.data.begin());
  return out;
}

struct Echo {
  explicit Echo(Image image) : symbols(std::move(image.symbols)), chip("echo", signed_flash(image.flash)) {
    chip.reset(ResetCause::power_on);
    (void)wire.connect(host);
    port = wire.connect(chip.can());
  }
  static std::vector<std::uint8_t> signed_flash(std::vector<std::uint8_t> flash) {
    sign(flash);
    return flash;
  }
  void run(Time for_time) {
    const Time end = now + for_time;
    while (now < end) {
      now += 4 * kMicrosecond;
      chip.run_until(now);
      wire.advance(now);
    }
  }
  std::uint32_t seen(unsigned field) {
    std::uint32_t value = 0;
    EXPECT_TRUE(chip.core().peek(symbols.at("seen") + 4 * field, 4, value));
    return value;
  }
  std::map<std::string, std::uint32_t> symbols;
  Lpc11c24 chip;
  HostStation host;
  CanWire wire;
  std::size_t port{};
  Time now{};
};

std::optional<Image> program(const std::string& name) {
  return load_elf(std::string(HOIST_PROGRAMS_DIR) + "/" + name + ".elf", kFlashBytes);
}

#define NEEDS_PROGRAM(image, name) \
  auto image = program(name);      \
  if (!image) GTEST_SKIP() << "no ARM compiler when this was built: program " << (name) << " is missing"

TEST(Chip, ABareProgramTicksNestsAndAnswersOnTheBus) {
  NEEDS_PROGRAM(image, "echo");
  Echo echo(*image);
  echo.run(20 * kMillisecond);
  EXPECT_EQ(echo.chip.clock_hz(), 48'000'000U);
  echo.host.send(frame(0x100, {0xFF}));
  echo.run(5 * kMillisecond);
  echo.host.send(frame(0x123, {1, 2, 3}));
  echo.run(5 * kMillisecond);
  EXPECT_TRUE(echo.chip.violations().empty()) << all(echo.chip);
  ASSERT_EQ(echo.host.received.size(), 2U);
  EXPECT_EQ(echo.host.received[0], frame(0x101, {0x00}));
  EXPECT_EQ(echo.host.received[1], frame(0x124, {0xFE, 0xFD, 0xFC}));
  EXPECT_EQ(echo.seen(1), 2U);
  // 30 ms, of which about 2.5 went by before crystal and PLL were up.
  EXPECT_NEAR(echo.seen(0), 27, 1);
  EXPECT_EQ(echo.seen(2), echo.seen(0));  // the more urgent timer came in between each time
  EXPECT_NEAR(echo.seen(3), 275, 10);
  EXPECT_EQ(echo.seen(4), 16U + 18U);
  EXPECT_GT(echo.chip.core().lowest_sp(), CortexM0::kRamBase + 0x1E00);
}

// Two requests so close that the first answer is still waiting when the program writes the second one into the same object: on silicon the frame
// being sent may be a mix of both.
TEST(Chip, AnObjectRewrittenWhileItWaitsIsComplainedAbout) {
  NEEDS_PROGRAM(image, "echo");
  Echo echo(*image);
  echo.run(20 * kMillisecond);
  echo.host.send(frame(0x100, {0xFF}));
  echo.host.send(frame(0x123, {1, 2, 3}));
  echo.run(5 * kMillisecond);
  EXPECT_EQ(echo.chip.violations().count("C_CAN: id of object 2 changed while its transmission is requested"), 1U) << all(echo.chip);
}

TEST(Chip, TheSameRunTwiceIsTheSame) {
  NEEDS_PROGRAM(image, "echo");
  Echo first(*image), second(*image);
  for (Echo* echo : {&first, &second}) {
    echo->host.send(frame(0x55, {1}));
    echo->run(15 * kMillisecond);
  }
  EXPECT_EQ(first.chip.core().instructions(), second.chip.core().instructions());
  EXPECT_EQ(first.chip.core().cycles(), second.chip.core().cycles());
  EXPECT_TRUE(std::equal(first.chip.ram().begin(), first.chip.ram().end(), second.chip.ram().begin()));
}

TEST(Chip, NobodyAcknowledgesAndItGoesOnTryingWithoutLeavingTheBus) {
  NEEDS_PROGRAM(image, "echo");
  Echo echo(*image);
  echo.run(5 * kMillisecond);
  echo.wire.set_hook([&echo](std::size_t from, const CanFrame&, Time) {
    return from == echo.port ? CanWire::Mischief::unacknowledged : CanWire::Mischief::none;
  });
  echo.host.send(frame(0x10, {}));
  echo.run(50 * kMillisecond);
  EXPECT_TRUE(echo.host.received.empty());
  EXPECT_EQ(echo.chip.can().transmit_errors(), 128U);  // error passive, where acknowledge errors count no further
  EXPECT_FALSE(echo.chip.can().bus_off());
  echo.wire.set_hook({});
  echo.run(5 * kMillisecond);
  ASSERT_EQ(echo.host.received.size(), 1U);
  EXPECT_EQ(echo.host.received[0].id, 0x11U);
}

TEST(Chip, DestroyedFramesTakeItOffTheBus) {
  NEEDS_PROGRAM(image, "echo");
  Echo echo(*image);
  echo.run(5 * kMillisecond);
  echo.wire.set_hook([&echo](std::size_t from, const CanFrame&, Time) {
    return from == echo.port ? CanWire::Mischief::corrupt : CanWire::Mischief::none;
  });
  echo.host.send(frame(0x10, {}));
  echo.run(50 * kMillisecond);
  EXPECT_TRUE(echo.chip.can().bus_off());  // after 32 attempts
  EXPECT_FALSE(echo.chip.can().on_bus());
}

TEST(Chip, AnImageWithoutItsSumIsNotStarted) {
  NEEDS_PROGRAM(image, "echo");
  Lpc11c24 chip("unsigned", image->flash);
  chip.reset(ResetCause::power_on);
  ASSERT_EQ(chip.violations().size(), 1U);
  EXPECT_NE(chip.violations().begin()->first.find("ROM would not start"), std::string::npos);
}

// Frames as long as their own bits make them: the two extremes of an eight-byte frame, and the standard's bound.
TEST(Wire, FramesAreAsLongAsTheirStuffBits) {
  const unsigned zeros = wire_bits(frame(0, {0, 0, 0, 0, 0, 0, 0, 0}));
  const unsigned mixed = wire_bits(frame(0x2AA, {0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55}));
  EXPECT_GT(zeros, mixed);
  EXPECT_LE(zeros, 132U);  // 135 with the intermission
  EXPECT_GE(mixed, 108U);  // 111 without one stuff bit
  EXPECT_LE(mixed, 114U);
}

TEST(Wire, TheLowestIdGoesFirst) {
  CanWire wire;
  HostStation a, b, c;
  (void)wire.connect(a);
  (void)wire.connect(b);
  (void)wire.connect(c);
  a.send(frame(0x300, {}));
  b.send(frame(0x100, {}));
  b.send(frame(0x080, {}));
  for (Time now = 0; now < 10 * kMillisecond; now += kMicrosecond) wire.advance(now);
  ASSERT_EQ(c.received.size(), 3U);
  EXPECT_EQ(c.received[0].id, 0x080U);
  EXPECT_EQ(c.received[1].id, 0x100U);
  EXPECT_EQ(c.received[2].id, 0x300U);
}

}  // namespace
}  // namespace hoist::machine
