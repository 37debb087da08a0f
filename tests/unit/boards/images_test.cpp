// What the finished images must look like to the chip that starts them, read from the files that are flashed.
#include <gtest/gtest.h>

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

namespace hoist::firmware {
namespace {

std::filesystem::path directory() {
  const char* given = std::getenv("HOIST_FIRMWARE_DIR");
  return given != nullptr ? std::filesystem::path(given) : std::filesystem::path(HOIST_BINARY_DIR) / "firmware";
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
    std::ifstream file(entry.path(), std::ios::binary);
    image.bytes.assign(std::istreambuf_iterator<char>(file), {});
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
    // The ROM of the LPC11C24 starts nothing whose first eight words do not add up to zero.
    std::uint32_t sum = 0;
    for (std::size_t at = 0; at < 32; at += 4) sum += word(at);
    EXPECT_EQ(sum, 0U);
    EXPECT_EQ(word(0) % 8, 0U);
    EXPECT_GT(word(0), image.chip->ram_at);
    EXPECT_LE(word(0), image.chip->ram_at + image.chip->ram_bytes - 16);  // below the mailbox
    const std::uint32_t flash_at = image.loader ? image.chip->application_at & 0xFF000000U : image.chip->application_at;
    // A loader polls: it has the handlers for reset and the two faults only.
    for (std::size_t at = 4; at < (image.loader ? 16U : 0xC0U); at += 4) {
      const bool reserved = (at >= 16 && at < 44) || at == 48 || at == 52;  // word 7 among them: the sum
      if (reserved) continue;
      SCOPED_TRACE(at);
      EXPECT_EQ(word(at) & 1U, 1U);  // Thumb code
      // A handler may lie in RAM: the edges of the encoder are counted there.
      const bool in_ram = word(at) >= image.chip->ram_at && word(at) < image.chip->ram_at + image.chip->ram_bytes;
      EXPECT_TRUE(in_ram || (word(at) > flash_at && word(at) < flash_at + image.bytes.size()));
    }
    if (!image.loader) {
      EXPECT_LE(image.bytes.size(), image.chip->application_max);
      EXPECT_EQ(word(contract::kImageHeaderAt), contract::kImageMagic);
      EXPECT_EQ(word(contract::kImageHeaderAt + 4), 0U) << "filled in by packing only";
    }
  }
}

// At 2FCh the LPC11C24 keeps its code protection: four values lock the chip, one of them for ever. Code lies there; it must be none of them.
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

}  // namespace
}  // namespace hoist::firmware
