#include "firmware/lib/trig.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <random>

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

// The very bits, so that a change of compiler, option or constant is seen: the images on the microcontroller are compared with this
// computer's angles bit for bit.
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

}  // namespace
}  // namespace hoist::firmware
