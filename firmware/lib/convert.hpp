// From floats to the integers of the object dictionary: rounded to the nearest, held at the ends, NaN becomes zero.
#pragma once
#include <cstdint>
#include <limits>

namespace hoist::firmware {

template <class Integer>
constexpr Integer to_integer(float value) {
  constexpr auto kLow = std::numeric_limits<Integer>::min();
  constexpr auto kHigh = std::numeric_limits<Integer>::max();
  if (value != value) return 0;
  const float rounded = value < 0 ? value - 0.5F : value + 0.5F;
  // Compared as floats first: a conversion of what does not fit is undefined. The float next to kHigh of 32 bit lies above it.
  if (rounded <= static_cast<float>(kLow)) return kLow;
  if (rounded >= static_cast<float>(kHigh)) return kHigh;
  return static_cast<Integer>(rounded);
}

}  // namespace hoist::firmware
