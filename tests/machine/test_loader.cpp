// The loader as machine code: starts a valid program, keeps the node with an invalid one, and accepts a new program over the bus, also with
// power cuts in flash operations.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "control/bus/firmware_update.hpp"
#include "control/contract/firmware_image.hpp"
#include "firmware/lib/mailbox.hpp"
#include "tests/machine/hoist_bench.hpp"

namespace hoist::machine {
namespace {

using contract::CanFrame;

constexpr std::uint32_t kOld = contract::image_version(1, 0, 0), kNew = contract::image_version(1, 2, 3);

void put(std::vector<std::uint8_t>& bytes, std::size_t at, std::uint32_t word) {
  for (unsigned i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(word >> (8 * i));
}

// The application as a packed file: what `hoist firmware pack` makes of the linked program, with another version.
std::vector<std::uint8_t> packed(const Image& application, ImageChip chip, std::uint32_t version) {
  const std::size_t start = board_pins(chip).application_start - board_pins(chip).flash_base;
  std::size_t end = application.flash.size();
  while (end > start && application.flash[end - 1] == 0xFF) --end;
  end = (end + 3) & ~std::size_t{3};
  std::vector<std::uint8_t> bytes(application.flash.begin() + static_cast<std::ptrdiff_t>(start),
                                  application.flash.begin() + static_cast<std::ptrdiff_t>(end));
  put(bytes, contract::kImageHeaderAt + 4, static_cast<std::uint32_t>(bytes.size()));
  put(bytes, contract::kImageHeaderAt + 12, version);
  put(bytes, contract::kImageCrcAt, contract::image_crc(bytes));
  return bytes;
}

struct Parts {
  Images images;
  Image io_loader;
  std::size_t application_at{};  // within the flash
  std::vector<std::uint8_t> old_program, new_program;
  /// Loader with a program behind it.
  [[nodiscard]] std::vector<std::uint8_t> flash_with(const std::vector<std::uint8_t>& program) const {
    std::vector<std::uint8_t> flash = io_loader.flash;
    std::copy(program.begin(), program.end(), flash.begin() + static_cast<std::ptrdiff_t>(application_at));
    return flash;
  }
};

class LoaderBench : public testing::Test {
 protected:
  void prepare(ImageChip which) {
    chip = which;
    ImagesOrReason found = load_images();
    if (!found.images) GTEST_SKIP() << found.reason;
    auto loader = load_image("hoist-boot-io", chip);
    if (!loader) GTEST_SKIP() << "no image of the loader";
    parts.images = std::move(*found.images);
    parts.io_loader = std::move(*loader);
    parts.application_at = board_pins(chip).application_start - board_pins(chip).flash_base;
    parts.old_program = packed(parts.images.of(chip, Box::io), chip, kOld);
    parts.new_program = packed(parts.images.of(chip, Box::io), chip, kNew);
    ASSERT_EQ(contract::check_image_file(parts.old_program), contract::ImageError::none);
  }
  [[nodiscard]] BenchOptions options(std::vector<std::uint8_t> flash) const {
    BenchOptions out;
    out.through_gateway = false;
    out.chips.fill(chip);
    out.only = Box::io;
    out.scenario = sim::find_scenario("stand");
    out.flash[static_cast<std::size_t>(Box::io)] = std::move(flash);
    return out;
  }

  // Exchanges frames with the bench, a millisecond at a time; frames returned by `each_ms` are sent.
  template <class Other>
  void talk(HoistBench& bench, Other& other, const std::function<bool()>& over, int at_most_ms) {
    std::array<CanFrame, 64> frames{};
    for (int ms = 0; ms < at_most_ms && !over(); ++ms) {
      const std::size_t got = bench.host_receive(frames);
      for (std::size_t i = 0; i < got; ++i) other.on_frame(frames[i]);
      if (const auto frame = other.step(static_cast<std::uint64_t>(bench.now()) * 125 / 6)) bench.host_send(*frame);
      bench.advance_1ms();
    }
  }
  [[nodiscard]] bus::NodeProgram ask(HoistBench& bench) {
    bus::ProgramQuery query;
    query.begin(contract::node_id(contract::Node::io));
    talk(
        bench, query, [&query] { return !query.busy(); }, 3000);
    return query.result();
  }
  static void run(HoistBench& bench, int ms) {
    for (int i = 0; i < ms; ++i) bench.advance_1ms();
  }
  ImageChip chip{};
  Parts parts;
};

constexpr auto kChips = {ImageChip::lpc11c24, ImageChip::stm32f072};
class Loader : public LoaderBench, public testing::WithParamInterface<ImageChip> {
 protected:
  void SetUp() override { prepare(GetParam()); }
  // A program whose handler at place `vector` of its table is an undefined instruction: HardFault.
  void ends_by(ResetCause cause, std::size_t vector) {
    std::vector<std::uint8_t> faulting = parts.old_program;
    const std::size_t at = (contract::image_word(faulting, vector) & ~1U) - board_pins(chip).application_start;
    faulting[at] = 0x00;  // UDF #0
    faulting[at + 1] = 0xDE;
    put(faulting, contract::kImageCrcAt, contract::image_crc(faulting));
    HoistBench bench(parts.images, options(parts.flash_with(faulting)));
    run(bench, 4000);
    const bus::NodeProgram program = ask(bench);
    EXPECT_TRUE(program.in_loader);
    EXPECT_EQ(program.flash_status, static_cast<std::uint32_t>(contract::FlashStatus::failed_starts));
    EXPECT_EQ(bench.chip(Box::io).resets(cause), firmware::kFailedStartsMax);
    bus::FirmwareUpdate update(parts.new_program, contract::Node::io, {});
    talk(
        bench, update, [&update] { return update.over(); }, 40'000);
    EXPECT_EQ(update.phase(), bus::FirmwareUpdate::Phase::done) << bus::failure_text(update.failure());
    EXPECT_EQ(ask(bench).version, kNew);
    const std::string violations = bench.violations();
    EXPECT_TRUE(violations.starts_with("io: HardFault: undefined instruction") && violations.ends_with("(3)\n")) << violations;
  }
};
INSTANTIATE_TEST_SUITE_P(Chips, Loader, testing::ValuesIn(kChips), [](const testing::TestParamInfo<ImageChip>& tested) {
  return std::string(contract::find_image_chip(static_cast<std::uint8_t>(tested.param))->name);
});

TEST_P(Loader, StartsAWholeProgram) {
  HoistBench bench(parts.images, options(parts.flash_with(parts.old_program)));
  run(bench, 600);
  const bus::NodeProgram program = ask(bench);
  EXPECT_TRUE(program.answered);
  EXPECT_FALSE(program.in_loader);
  EXPECT_EQ(program.version, kOld);
  EXPECT_EQ(bench.violations(), "");
}

// A drive's program on the input board: kind and chip come from the program's header, and the loader checks them.
TEST_P(Loader, DoesNotStartAProgramOfAnotherNode) {
  HoistBench bench(parts.images, options(parts.flash_with(packed(parts.images.of(chip, Box::drive_left), chip, kOld))));
  run(bench, 600);
  const bus::NodeProgram program = ask(bench);
  EXPECT_TRUE(program.in_loader);
  EXPECT_EQ(program.flash_status, static_cast<std::uint32_t>(contract::FlashStatus::unknown_format));
  EXPECT_EQ(bench.violations(), "");
}

TEST_P(Loader, KeepsADamagedProgramAndSaysSo) {
  std::vector<std::uint8_t> damaged = parts.old_program;
  damaged[damaged.size() / 2] ^= 0x10;
  HoistBench bench(parts.images, options(parts.flash_with(damaged)));
  run(bench, 600);
  const bus::NodeProgram program = ask(bench);
  EXPECT_TRUE(program.answered);
  EXPECT_TRUE(program.in_loader);
  EXPECT_NE(program.flash_status, 0U);
  EXPECT_EQ(bench.violations(), "");
}

TEST_P(Loader, TakesANewProgramOverTheBus) {
  HoistBench bench(parts.images, options(parts.flash_with(parts.old_program)));
  run(bench, 600);
  bus::FirmwareUpdate update(parts.new_program, contract::Node::io, {});
  talk(
      bench, update, [&update] { return update.over(); }, 40'000);
  EXPECT_EQ(update.phase(), bus::FirmwareUpdate::Phase::done) << bus::failure_text(update.failure());
  EXPECT_FALSE(update.was_there());
  const bus::NodeProgram program = ask(bench);
  EXPECT_FALSE(program.in_loader);
  EXPECT_EQ(program.version, kNew);
  EXPECT_GT(bench.chip(Box::io).flash_operations(), 10U);
  EXPECT_EQ(bench.violations(), "");
}

// After the third fault of a program the loader keeps the node, and an update still comes in. One that faults at once ends by software; one that
// faults later ends by its watchdog, which a drive does not forget (6010h).
TEST_P(Loader, H30KeepsAProgramThatDoesNotStayAliveAfterThreeStarts) {
  for (const bool at_once : {true, false}) {
    SCOPED_TRACE(at_once);
    ends_by(at_once ? ResetCause::software : ResetCause::watchdog, at_once ? 4 : 4 * 15);
  }
}

// Power cut during erasing or writing: with any flash content the node starts in its loader, and a repeated update succeeds.
class LoaderCut : public LoaderBench, public testing::WithParamInterface<std::tuple<ImageChip, int>> {
 protected:
  void SetUp() override { prepare(std::get<0>(GetParam())); }
};
TEST_P(LoaderCut, LeavesANodeThatStillTakesAProgram) {
  HoistBench bench(parts.images, options(parts.flash_with(parts.old_program)));
  run(bench, 600);
  Chip& cut = bench.chip(Box::io);
  cut.cut_power_in_flash_operation(std::get<1>(GetParam()));
  bus::FirmwareUpdate broken(parts.new_program, contract::Node::io, {});
  talk(
      bench, broken, [&cut] { return !cut.powered(); }, 40'000);
  ASSERT_FALSE(cut.powered());
  run(bench, 200);
  cut.reset(ResetCause::power_on);
  run(bench, 600);
  EXPECT_TRUE(ask(bench).in_loader);
  bus::FirmwareUpdate again(parts.new_program, contract::Node::io, {});
  talk(
      bench, again, [&again] { return again.over(); }, 40'000);
  EXPECT_EQ(again.phase(), bus::FirmwareUpdate::Phase::done) << bus::failure_text(again.failure());
  EXPECT_EQ(ask(bench).version, kNew);
  EXPECT_EQ(bench.violations(), "");
}
INSTANTIATE_TEST_SUITE_P(Operations, LoaderCut, testing::Combine(testing::ValuesIn(kChips), testing::Values(1, 2, 9, 30)));

}  // namespace
}  // namespace hoist::machine
