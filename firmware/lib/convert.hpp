// From floats to the integers of the object dictionary: rounded to the nearest, halves away from zero, held at the ends, NaN becomes zero.
//
// By shifting the float's own bits: exact for every float, and on a processor without floating point an eighth of the work that comparing,
// adding a half and converting would be. A tilt sensor does this a dozen times with every sample.
#pragma once
#include <bit>
#include <cstdint>
#include <limits>

namespace hoist::firmware {

template <class Integer>
constexpr Integer to_integer(float value) {
  static_assert(sizeof(Integer) <= 4);
  constexpr auto kLow = std::numeric_limits<Integer>::min();
  constexpr auto kHigh = std::numeric_limits<Integer>::max();
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
  const bool negative = (bits >> 31) != 0;
  const std::uint32_t exponent = (bits >> 23) & 0xFFU;
  if (exponent == 0xFF && (bits & 0x7FFFFFU) != 0) return 0;  // not a number
  if (exponent < 126) return 0;                               // below a half
  if (exponent >= 127 + 32) return negative ? kLow : kHigh;   // 2^32 and more, infinities too
  const std::uint32_t mantissa = (bits & 0x7FFFFFU) | 0x800000U;
  const std::uint32_t magnitude =
      exponent >= 150 ? mantissa << (exponent - 150) : (mantissa + (1U << (149 - exponent))) >> (150 - exponent);  // at most 2^24 before
  constexpr std::uint32_t kHighBits = static_cast<std::uint32_t>(kHigh);
  constexpr std::uint32_t kLowBits = 0U - static_cast<std::uint32_t>(kLow);  // size of the lowest value: 0 for unsigned types
  if (negative) return magnitude >= kLowBits ? kLow : static_cast<Integer>(0U - magnitude);
  return magnitude >= kHighBits ? kHigh : static_cast<Integer>(magnitude);
}

}  // namespace hoist::firmware
