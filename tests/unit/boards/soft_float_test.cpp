// The images' floats against this computer's: every bit, because a law that runs on both must give the same numbers.
#include "firmware/boards/cortex_m0/soft_float.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <random>
#include <vector>

namespace hoist::firmware::cortex_m0 {
namespace {

namespace soft = soft_float;

float value(std::uint32_t word) { return std::bit_cast<float>(word); }
// All NaN count as equal.
std::uint32_t word(float number) { return std::isnan(number) ? soft::kNan : std::bit_cast<std::uint32_t>(number); }

void expect_same(std::uint32_t a, std::uint32_t b) {
  // volatile: the host's processor must do it, not its compiler.
  volatile float x = value(a), y = value(b);
  ASSERT_EQ(soft::add(a, b), word(x + y)) << std::hex << a << " + " << b;
  ASSERT_EQ(soft::subtract(a, b), word(x - y)) << std::hex << a << " - " << b;
  ASSERT_EQ(soft::multiply(a, b), word(x * y)) << std::hex << a << " * " << b;
  ASSERT_EQ(soft::divide(a, b), word(x / y)) << std::hex << a << " / " << b;
  ASSERT_EQ(soft::less(a, b), x < y) << std::hex << a << " < " << b;
  ASSERT_EQ(soft::less_equal(a, b), x <= y) << std::hex << a << " <= " << b;
  ASSERT_EQ(soft::equal(a, b), x == y) << std::hex << a << " == " << b;
  ASSERT_EQ(soft::unordered(a, b), std::isunordered(x, y)) << std::hex << a << " ? " << b;
}

TEST(SoftFloat, AgreesOnEveryPairOfSpecialValues) {
  std::vector<std::uint32_t> words{0x00000000, 0x00000001, 0x00000002, 0x003FFFFF, 0x00400000, 0x007FFFFF, 0x00800000,
                                   0x00800001, 0x00FFFFFF, 0x01000000, 0x0C000000, 0x33800000, 0x34000000, 0x3F000000,
                                   0x3F7FFFFF, 0x3F800000, 0x3F800001, 0x3FFFFFFF, 0x40000000, 0x40490FDB, 0x4B000000,
                                   0x4B7FFFFF, 0x4B800000, 0x4EFFFFFF, 0x4F000000, 0x4F800000, 0x5F000000, 0x7E800000,
                                   0x7F000000, 0x7F7FFFFE, 0x7F7FFFFF, 0x7F800000, 0x7F800001, 0x7FC00000};
  const std::size_t positive = words.size();
  for (std::size_t i = 0; i < positive; ++i) words.push_back(words[i] | soft::kSign);
  for (const std::uint32_t a : words)
    for (const std::uint32_t b : words) ASSERT_NO_FATAL_FAILURE(expect_same(a, b));
}

TEST(SoftFloat, AgreesOnRandomPairs) {
  std::mt19937 random(20261121);
  // Any bits; denormals; close to the largest; one of the two near the other, where a difference cancels.
  const auto draw = [&random] {
    const auto bits = static_cast<std::uint32_t>(random());
    switch (random() % 5) {
      case 0:
        return bits & 0x807FFFFFU;
      case 1:
        return (bits & 0x80FFFFFFU) | 0x7E000000U;
      case 2:
        return (bits & 0x807FFFFFU) | ((100U + static_cast<std::uint32_t>(random()) % 56U) << 23);
      default:
        return bits;
    }
  };
  for (int i = 0; i < 1'000'000; ++i) {
    const std::uint32_t a = draw();
    const std::uint32_t b = i % 8 == 0 ? a ^ (static_cast<std::uint32_t>(random()) & 0x80000003U) : draw();
    ASSERT_NO_FATAL_FAILURE(expect_same(a, b));
  }
}

TEST(SoftFloat, AgreesOnConversions) {
  std::mt19937 random(4711);
  for (int i = 0; i < 1'000'000; ++i) {
    const std::uint32_t bits = static_cast<std::uint32_t>(random()) >> (random() % 32);
    volatile auto integer = static_cast<std::int32_t>(bits);
    volatile std::uint32_t natural = bits;
    ASSERT_EQ(soft::from_signed(integer), word(static_cast<float>(integer))) << integer;
    ASSERT_EQ(soft::from_unsigned(natural), word(static_cast<float>(natural))) << natural;
    const auto any = static_cast<std::uint32_t>(random());
    volatile float number = value(any);
    if (std::fabs(number) < 2147483648.0F) {
      ASSERT_EQ(soft::to_signed(any), static_cast<std::int32_t>(number)) << number;
    }
    if (number > -1.0F && number < 4294967296.0F) {
      ASSERT_EQ(soft::to_unsigned(any), static_cast<std::uint32_t>(number)) << number;
    }
  }
}

// Undefined conversions saturate, so that a large number never becomes a small one.
TEST(SoftFloat, HoldsWhatDoesNotFitAnInteger) {
  EXPECT_EQ(soft::to_signed(word(3e9F)), 2147483647);
  EXPECT_EQ(soft::to_signed(word(-3e9F)), -2147483647 - 1);
  EXPECT_EQ(soft::to_signed(word(-2147483648.0F)), -2147483647 - 1);
  EXPECT_EQ(soft::to_signed(soft::kInfinity), 2147483647);
  EXPECT_EQ(soft::to_signed(soft::kNan), 0);
  EXPECT_EQ(soft::to_unsigned(word(1e10F)), 0xFFFFFFFFU);
  EXPECT_EQ(soft::to_unsigned(word(-5.0F)), 0U);
}

}  // namespace
}  // namespace hoist::firmware::cortex_m0
