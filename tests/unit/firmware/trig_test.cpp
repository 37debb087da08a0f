#include "firmware/lib/trig.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>

#include "firmware/lib/convert.hpp"

namespace hoist::firmware {
namespace {

TEST(Trig, TheAngleIsTrueAllAroundTheCircle) {
  double worst = 0;
  for (int i = -400000; i <= 400000; ++i) {
    const double angle = i * 3.14159265358979 / 400000;
    const double radius = std::exp2((i % 41) - 20);
    const float x = static_cast<float>(radius * std::cos(angle)), y = static_cast<float>(radius * std::sin(angle));
    const double error = std::fabs(arctan2(y, x) - std::atan2(static_cast<double>(y), static_cast<double>(x)));
    worst = std::max(worst, std::min(error, 6.283185307 - error));
  }
  RecordProperty("worst_nrad", static_cast<int>(worst * 1e9));
  EXPECT_LE(worst, 5e-7);
}

TEST(Trig, SmallTiltsKeepTheirRelativeAccuracy) {
  for (int i = 1; i < 2000; ++i) {
    const float y = static_cast<float>(i) * 1e-4F;
    EXPECT_NEAR(arctan2(y, 9.81F) / std::atan2(static_cast<double>(y), 9.81), 1.0, 3e-7);
  }
}

TEST(Trig, TheCornersAreExact) {
  EXPECT_EQ(arctan2(0, 1), 0.0F);
  EXPECT_EQ(arctan2(1, 0), 1.57079632679F);
  EXPECT_EQ(arctan2(-1, 0), -1.57079632679F);
  EXPECT_EQ(arctan2(0, -1), 3.14159265359F);
  EXPECT_EQ(arctan2(1, 1), 0.785398163397F);
  EXPECT_EQ(arctan2(0, 0), 0.0F);
  static_assert(arctan2(1, 1) > 0.785F);  // usable at compile time
}

TEST(Trig, EveryFiniteVectorHasAnAngleWithinTheCircle) {
  std::mt19937 random(2);
  for (int i = 0; i < 300000; ++i) {
    const float y = std::bit_cast<float>(static_cast<std::uint32_t>(random())),
                x = std::bit_cast<float>(static_cast<std::uint32_t>(random()));
    if (!std::isfinite(x) || !std::isfinite(y) || std::fabs(x) > 1e38F || std::fabs(y) > 1e38F) continue;
    const float angle = arctan2(y, x);
    ASSERT_LE(std::fabs(angle), 3.1415928F) << y << " " << x;
    ASSERT_EQ(arctan2(-y, x), -angle);
  }
}

// Exact bits, so that a change of compiler, option or constant shows: the images on the microcontroller are compared with this computer's angles
// bit for bit.
TEST(Trig, TheBitsAreThoseOfTheReference) {
  std::uint32_t digest = 2166136261U;
  std::uint32_t state = 1;
  for (int i = 0; i < 20000; ++i) {
    state = state * 1664525U + 1013904223U;
    const float y = static_cast<float>(static_cast<std::int32_t>(state)) * 1e-8F;
    state = state * 1664525U + 1013904223U;
    const float x = static_cast<float>(static_cast<std::int32_t>(state)) * 1e-8F;
    digest = (digest ^ std::bit_cast<std::uint32_t>(arctan2(y, x))) * 16777619U;
  }
  EXPECT_EQ(digest, 203874511U);
}

// In double every float and a half are exact.
template <class Integer>
Integer rounded(float value) {
  if (std::isnan(value)) return 0;
  const double nearest = std::round(static_cast<double>(value));  // halves away from zero
  if (nearest <= static_cast<double>(std::numeric_limits<Integer>::min())) return std::numeric_limits<Integer>::min();
  if (nearest >= static_cast<double>(std::numeric_limits<Integer>::max())) return std::numeric_limits<Integer>::max();
  return static_cast<Integer>(nearest);
}

TEST(Convert, RoundsToTheNearestForEveryKindOfFloat) {
  std::mt19937 random(8);
  const auto check = [](float value) {
    ASSERT_EQ(to_integer<std::int16_t>(value), rounded<std::int16_t>(value)) << value;
    ASSERT_EQ(to_integer<std::uint16_t>(value), rounded<std::uint16_t>(value)) << value;
    ASSERT_EQ(to_integer<std::int32_t>(value), rounded<std::int32_t>(value)) << value;
    ASSERT_EQ(to_integer<std::uint32_t>(value), rounded<std::uint32_t>(value)) << value;
    ASSERT_EQ(to_integer<std::int8_t>(value), rounded<std::int8_t>(value)) << value;
  };
  for (const float value : {0.0F,
                            -0.0F,
                            0.5F,
                            -0.5F,
                            0.49999997F,
                            0.50000006F,
                            1.5F,
                            2.5F,
                            -2.5F,
                            127.5F,
                            32767.0F,
                            32767.5F,
                            32766.5F,
                            -32768.0F,
                            -32768.5F,
                            -32769.0F,
                            65535.0F,
                            65535.5F,
                            8388607.5F,
                            16777216.0F,
                            2147483520.0F,
                            2147483648.0F,
                            -2147483648.0F,
                            4294967040.0F,
                            4294967296.0F,
                            1e30F,
                            -1e30F,
                            1e-40F,
                            std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(),
                            std::numeric_limits<float>::quiet_NaN()})
    check(value);
  for (int i = 0; i < 400000; ++i) check(std::bit_cast<float>(static_cast<std::uint32_t>(random())));
  for (int i = -80000; i < 80000; ++i) check(static_cast<float>(i) * 0.25F);
}

}  // namespace
}  // namespace hoist::firmware
