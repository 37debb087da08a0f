// What the finished images must look like to the chip that starts them, read from the files that are flashed.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "control/contract/firmware_image.hpp"
#include "firmware/boards/lpc11c24/memory.hpp"
#include "firmware/lib/version.hpp"
#include "tests/support/shell.hpp"

namespace hoist::firmware {
namespace {

std::filesystem::path directory() {
  const char* given = std::getenv("HOIST_FIRMWARE_DIR");
  return given != nullptr ? std::filesystem::path(given) : std::filesystem::path(HOIST_BINARY_DIR) / "firmware";
}

std::vector<std::uint8_t> read_file(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Image {
  std::string name;
  std::vector<std::uint8_t> bytes;
  const contract::ImageChipInfo* chip = nullptr;
  bool loader = false;
};
std::vector<Image> images() {
  std::vector<Image> found;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(directory(), error)) {
    if (entry.path().extension() != ".bin") continue;
    Image image;
    image.name = entry.path().stem().string();
    image.bytes = read_file(entry.path());
    image.chip = contract::find_image_chip(image.name.substr(image.name.rfind('-') + 1));
    image.loader = image.name.starts_with("hoist-boot-");
    found.push_back(std::move(image));
  }
  std::sort(found.begin(), found.end(), [](const Image& a, const Image& b) { return a.name < b.name; });
  return found;
}
#define SKIP_WITHOUT_IMAGES(list) \
  if ((list).empty()) GTEST_SKIP() << "no images in " << directory() << " (deploy/dev firmware builds them)"

TEST(Images, EachKindOfNodeHasOneForEachChip) {
  const auto all = images();
  SKIP_WITHOUT_IMAGES(all);
  for (const char* kind : {"tilt", "drive", "io", "gateway"})
    for (const char* chip : {"lpc11c24", "stm32f072"}) {
      const std::string name = std::string("hoist-") + kind + "-" + chip;
      EXPECT_TRUE(std::any_of(all.begin(), all.end(), [&](const Image& image) { return image.name == name; })) << name;
    }
}

TEST(Images, BeginWithVectorsThatTheirChipAccepts) {
  const auto all = images();
  SKIP_WITHOUT_IMAGES(all);
  for (const Image& image : all) {
    SCOPED_TRACE(image.name);
    ASSERT_NE(image.chip, nullptr);
    ASSERT_GE(image.bytes.size(), contract::kImageMin);
    const auto word = [&image](std::size_t at) { return contract::image_word(image.bytes, at); };
    // The ROM of the LPC11C24 starts only a program whose first eight words add up to zero.
    std::uint32_t sum = 0;
    for (std::size_t at = 0; at < 32; at += 4) sum += word(at);
    EXPECT_EQ(sum, 0U);
    EXPECT_EQ(word(0) % 8, 0U);
    EXPECT_GT(word(0), image.chip->ram_at);
    EXPECT_LE(word(0), image.chip->ram_at + image.chip->ram_bytes - 16);  // below the mailbox or the flash routines
    const std::uint32_t flash_at = image.loader ? image.chip->application_at & 0xFF000000U : image.chip->application_at;
    // A loader polls: it has the handlers for reset and the two faults only.
    for (std::size_t at = 4; at < (image.loader ? 16U : 0xC0U); at += 4) {
      const bool reserved = (at >= 16 && at < 44) || at == 48 || at == 52;  // word 7 among them: the checksum
      if (reserved) continue;
      SCOPED_TRACE(at);
      EXPECT_EQ(word(at) & 1U, 1U);  // Thumb code
      // A handler may be in RAM, as that of the encoder's edges.
      const bool in_ram = word(at) >= image.chip->ram_at && word(at) < image.chip->ram_at + image.chip->ram_bytes;
      EXPECT_TRUE(in_ram || (word(at) > flash_at && word(at) < flash_at + image.bytes.size()));
    }
    if (!image.loader) {
      EXPECT_LE(image.bytes.size(), image.chip->application_max);
      EXPECT_EQ(word(contract::kImageHeaderAt), contract::kImageMagic);
      EXPECT_EQ(word(contract::kImageHeaderAt + 4), 0U) << "filled in by packing only";
      EXPECT_EQ(word(contract::kImageCrcAt), 0U) << "filled in by packing only";
    }
  }
}

// Node kind, chip and version come from the program, and its update file has the same.
TEST(Images, SayForWhichNodeAndChipTheyAre) {
  const auto all = images();
  SKIP_WITHOUT_IMAGES(all);
  for (const Image& image : all) {
    if (image.loader) continue;
    SCOPED_TRACE(image.name);
    const contract::ImageHeader header = contract::read_image_header(image.bytes);
    const contract::ImageKindInfo* kind = contract::find_image_kind(header.kind);
    ASSERT_NE(kind, nullptr);
    EXPECT_EQ("hoist-" + std::string(kind->name) + "-" + std::string(image.chip->name), image.name);
    EXPECT_EQ(header.chip, static_cast<std::uint8_t>(image.chip->chip));
    EXPECT_EQ(header.version, contract::parse_version(kSoftwareVersion));
    const auto packed = read_file(directory() / (image.name + ".hoistfw"));
    ASSERT_EQ(contract::check_image_file(packed), contract::ImageError::none);
    EXPECT_EQ(contract::check_image(packed, kind->kind, *image.chip), contract::ImageError::none);
    EXPECT_EQ(contract::read_image_header(packed).version, header.version);
  }
}

// At 2FCh the LPC11C24 keeps its code protection: four values lock the chip, one of them for ever. The code at this address must have
// another value.
TEST(Images, NeverLockTheChip) {
  const auto all = images();
  SKIP_WITHOUT_IMAGES(all);
  bool looked = false;
  for (const Image& image : all) {
    if (!image.loader || image.name.find("lpc11c24") == std::string::npos) continue;
    ASSERT_GT(image.bytes.size(), 0x300U);
    const std::uint32_t word = contract::image_word(image.bytes, 0x2FC);
    for (const std::uint32_t lock : {0x12345678U, 0x87654321U, 0x43218765U, 0x4E697370U}) EXPECT_NE(word, lock) << image.name;
    looked = true;
  }
  if (!looked) GTEST_SKIP() << "no loader of the LPC11C24 among the images";
}

// ---- firmware/cmake/stack_depth.awk, which bounds the stack of an image from its machine code

// A program of a few functions as objdump shows it: vectors at 1000h with reset at 1100h and one interrupt at 1200h.
std::string listing(const std::string& code, const std::string& words = {}) {
  return " 1000 d01f0010 01110000 00000000 00000000  ................\n"
         " 1010 00000000 00000000 00000000 00000000  ................\n"
         " 1020 00000000 00000000 00000000 00000000  ................\n"
         " 1030 00000000 00000000 00000000 01120000  ................\n" +
         words + "00001200 <tick>:\n    1200:\tpush\t{r4, lr}\n    1202:\tpop\t{r4, pc}\n00001100 <start>:\n" + code;
}
test::ShellResult stack_depth(const std::string& input) {
  std::string pattern = (std::filesystem::temp_directory_path() / "hoist-stack-test-XXXXXX").string();
  const int file = ::mkstemp(pattern.data());
  EXPECT_GE(file, 0);
  ::close(file);
  std::ofstream(pattern) << input;
  test::ShellResult depth = test::run_shell("awk -f " HOIST_SOURCE_DIR "/firmware/cmake/stack_depth.awk " + pattern + " 2>&1");
  std::filesystem::remove(pattern);
  return depth;
}

TEST(StackDepth, AddsFramesCallsAndInterrupts) {
  // 8 in start, 24 in work, 20 in more by a jump; the interrupt takes 36 and its 8.
  const test::ShellResult depth =
      stack_depth(listing("    1100:\tpush\t{r4, lr}\n    1102:\tbl\t1120 <work>\n00001120 <work>:\n    1120:\tsub\tsp, #24\n"
                          "    1122:\tb.n\t1140 <more>\n00001140 <more>:\n    1140:\tpush\t{r4, r5, r6, r7, lr}\n"));
  EXPECT_EQ(depth.exit_code, 0) << depth.output;
  EXPECT_EQ(depth.output, "96 start(8) work(24) more(20); interrupt(36) tick(8)\n");
}

TEST(StackDepth, FollowsLargeFramesPointersAndRom) {
  // A frame from a literal (-512) that is given back by a number made in two steps.
  test::ShellResult depth = stack_depth(
      listing("    1100:\tldr\tr4, [pc, #12]\t@ (1110 <start+0x10>)\n    1102:\tadd\tsp, r4\n    1104:\tmovs\tr3, #128\t@ 0x80\n"
              "    1106:\tlsls\tr3, r3, #2\n    1108:\tadd\tsp, r3\n    1110:\t.word\t0xfffffe00\n"));
  EXPECT_EQ(depth.output.substr(0, 4), "556 ") << depth.output;
  // Through a pointer: any function whose address is in the image, here 1140h. ROM by its address.
  depth = stack_depth(
      listing("    1100:\tblx\tr3\n00001140 <taken>:\n    1140:\tsub\tsp, #100\n    1142:\tldr\tr3, [pc, #4]\t@ (1148 <taken+0x8>)\n"
              "    1144:\tblx\tr3\n    1148:\t.word\t0x1fff1ff1\n",
              " 1400 41110000                              A...\n"));
  EXPECT_EQ(depth.output, "272 start(0) taken(100) ROM; interrupt(36) tick(8)\n");
}

TEST(StackDepth, RefusesWhatHasNoBound) {
  const auto refused = [](const std::string& code, const std::string& why) {
    const test::ShellResult depth = stack_depth(listing(code));
    EXPECT_EQ(depth.exit_code, 1) << depth.output;
    EXPECT_NE(depth.output.find(why), std::string::npos) << depth.output;
  };
  refused("    1100:\tbl\t1120 <work>\n00001120 <work>:\n    1120:\tpush\t{lr}\n    1122:\tbl\t1120 <work>\n", "recursion through work");
  refused("    1100:\tsubs\tr3, r3, r2\n    1102:\tadd\tsp, r3\n", "frame of start is not constant");
  refused("    1100:\tmov\tsp, r3\n", "start sets the stack pointer");
}

}  // namespace
}  // namespace hoist::firmware
