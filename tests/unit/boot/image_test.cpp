// The header of a program: accepted and refused ones, with the messages.
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "tests/unit/boot/boot_support.hpp"

namespace hoist::firmware {
namespace {

using contract::check_image;
using contract::check_image_file;

TEST(Crc32, IsTheOneOfZip) {
  contract::Crc32 crc;
  constexpr std::array<std::uint8_t, 9> kDigits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  crc.add(kDigits);
  EXPECT_EQ(crc.value(), 0xCBF43926U);  // the check value in every catalogue of CRCs
  EXPECT_EQ(contract::Crc32().value(), 0U);
}

TEST(Image, APackedOneIsAccepted) {
  const auto image = make_image(5000, contract::image_version(1, 2, 3));
  EXPECT_EQ(check_image_file(image), ImageError::none);
  EXPECT_EQ(check_image(image, ImageKind::drive, simulated_chip()), ImageError::none);
  const contract::ImageHeader header = contract::read_image_header(image);
  EXPECT_EQ(header.version, 0x00010203U);
  EXPECT_EQ(header.length, 5000U);
}

TEST(Image, WrongNodeOrChipIsRefused) {
  const auto image = make_image(5000, 1);
  EXPECT_EQ(check_image(image, ImageKind::tilt, simulated_chip()), ImageError::kind);
  EXPECT_EQ(check_image(image, ImageKind::drive, *contract::find_image_chip("lpc11c24")), ImageError::chip);
  auto other = image;
  other[contract::kImageHeaderAt + 16] = 9;
  EXPECT_EQ(check_image_file(other), ImageError::kind);
  other = image;
  other[contract::kImageHeaderAt + 17] = 0;
  EXPECT_EQ(check_image_file(other), ImageError::chip);
}

// A shortened or extended file, and any single changed bit, is invalid.
TEST(Image, AnyDamageIsFound) {
  const auto image = make_image(600, 7);
  for (std::size_t length = 0; length < image.size(); ++length)
    ASSERT_NE(check_image_file(std::span(image).first(length)), ImageError::none) << length;
  auto longer = image;
  longer.push_back(0);
  EXPECT_EQ(check_image_file(longer), ImageError::length);
  for (std::size_t bit = 0; bit < image.size() * 8; ++bit) {
    auto damaged = image;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
    ASSERT_NE(check_image_file(damaged), ImageError::none) << bit;
  }
  EXPECT_EQ(check_image_file(std::vector<std::uint8_t>(contract::kImageMax + 1)), ImageError::too_long);
  EXPECT_EQ(check_image_file(std::vector<std::uint8_t>(5000, 0xFF)), ImageError::magic);
}

TEST(Image, LongerThanTheRoomIsRefused) {
  EXPECT_EQ(check_image_file(make_image(simulated_chip().application_max, 1)), ImageError::none);
  EXPECT_EQ(check_image_file(make_image(simulated_chip().application_max + 1, 1)), ImageError::too_long);
}

// The first two words of a program for silicon must point into its memory: finds a file packed from something else.
TEST(Image, VectorsMustFitTheChip) {
  auto image = make_image(4000, 1, 1, ImageKind::tilt, ImageChip::lpc11c24);
  const auto with = [&](std::uint32_t stack, std::uint32_t entry) {
    contract::write_le(&image[0], 4, stack);
    contract::write_le(&image[4], 4, entry);
    seal_image(image, ImageKind::tilt, ImageChip::lpc11c24, 1);
    return check_image_file(image);
  };
  EXPECT_EQ(with(0x10001FD0, 0x10D5), ImageError::none);
  EXPECT_EQ(with(0x10002000, 0x1001 + 3998), ImageError::none);
  EXPECT_EQ(with(0x10002004, 0x10D5), ImageError::vectors);  // above the RAM
  EXPECT_EQ(with(0x10001FD2, 0x10D5), ImageError::vectors);  // not a word
  EXPECT_EQ(with(0x10000000, 0x10D5), ImageError::vectors);
  EXPECT_EQ(with(0x20001000, 0x10D5), ImageError::vectors);         // another chip's RAM
  EXPECT_EQ(with(0x10001FD0, 0x10D4), ImageError::vectors);         // no Thumb code
  EXPECT_EQ(with(0x10001FD0, 0x00D5), ImageError::vectors);         // inside the loader
  EXPECT_EQ(with(0x10001FD0, 0x1041), ImageError::vectors);         // inside the vectors
  EXPECT_EQ(with(0x10001FD0, 0x1001 + 4000), ImageError::vectors);  // behind the end
}

TEST(Image, VersionsAreReadStrictly) {
  EXPECT_EQ(contract::parse_version("1.2.3"), 0x00010203U);
  EXPECT_EQ(contract::parse_version("0.0.0"), 0U);
  EXPECT_EQ(contract::parse_version("65535.255.255"), 0xFFFFFFFFU);
  for (const char* wrong : {"", "1", "1.2", "1.2.", "1.2.3.", "1.2.3.4", "1.2.256", "65536.0.0", "-1.0.0", "1.2.3 ", " 1.2.3", "01.2.3",
                            "1..3", "a.b.c", "1.2.99999999999999999999"})
    EXPECT_FALSE(contract::parse_version(wrong)) << wrong;
}

}  // namespace
}  // namespace hoist::firmware
