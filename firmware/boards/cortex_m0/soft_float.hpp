// Single precision on integers, IEEE 754, rounded to nearest even, with denormals: the same bits as every host. Written for size: the
// compiler's own library takes 4.5 KB for what is 1.3 KB here, of the 20 KB that an LPC11C24 has for a program.
//
// Values are the words that hold them. The one difference to a host: every NaN result is 7FC00000h.
//
// Inside, a number is 2^(exponent - 127) x significand / 2^29 with the leading bit of the significand in bit 30: seven bits more than a
// float has, the lowest one holding "anything below".
#pragma once
#include <cstdint>

namespace hoist::firmware::cortex_m0::soft_float {

inline constexpr std::uint32_t kSign = 0x80000000, kInfinity = 0x7F800000, kNan = 0x7FC00000, kLeading = 0x00800000;

[[gnu::always_inline]] constexpr bool is_nan(std::uint32_t a) { return (a & ~kSign) > kInfinity; }

// Shifted right; what falls out stays visible in the lowest bit.
constexpr std::uint32_t shift_sticky(std::uint32_t value, std::uint32_t by) {
  if (by >= 32) return value != 0 ? 1U : 0U;
  return (value >> by) | ((value & ((1U << by) - 1U)) != 0 ? 1U : 0U);
}

// `significand` is not zero and below 2^31; its leading bit may be anywhere.
constexpr std::uint32_t pack(std::uint32_t sign, std::int32_t exponent, std::uint32_t significand) {
  // In large steps first: integers and differences may have few bits.
  if (significand < 0x4000U) {
    significand <<= 16;
    exponent -= 16;
  }
  if (significand < 0x400000U) {
    significand <<= 8;
    exponent -= 8;
  }
  while ((significand & 0x40000000U) == 0) {
    significand <<= 1;
    --exponent;
  }
  if (exponent < 0) {
    significand = shift_sticky(significand, static_cast<std::uint32_t>(-exponent));
    exponent = 0;
  }
  std::uint32_t rounded = (significand + 0x40U) >> 7;
  if ((significand & 0x7FU) == 0x40U) rounded &= ~1U;  // just between two: the even one
  if (exponent >= 0xFE) return sign | kInfinity;
  // The leading bit adds one to the exponent, and so does a carry of the rounding: up to infinity, if it must be.
  return sign | ((static_cast<std::uint32_t>(exponent) << 23) + rounded);
}

// 24 bits with the leading one set, and the exponent that belongs to it; for finite numbers other than zero.
struct Parts {
  std::int32_t exponent;
  std::uint32_t significand;
};
constexpr Parts unpack_denormal(std::uint32_t a) {
  Parts parts{1, a & (kLeading - 1U)};
  while ((parts.significand & kLeading) == 0) {
    parts.significand <<= 1;
    --parts.exponent;
  }
  return parts;
}

// The usual case is written out wherever it is needed.
[[gnu::always_inline]] constexpr Parts unpack(std::uint32_t a) {
  const std::uint32_t exponent = (a >> 23) & 0xFFU;
  if (exponent == 0) return unpack_denormal(a);
  return {static_cast<std::int32_t>(exponent), (a & (kLeading - 1U)) | kLeading};
}

constexpr std::uint32_t add(std::uint32_t a, std::uint32_t b) {
  if ((a & ~kSign) < (b & ~kSign)) {
    const std::uint32_t swap = a;
    a = b;
    b = swap;
  }
  const bool opposed = ((a ^ b) & kSign) != 0;
  if ((a & ~kSign) >= kInfinity) return is_nan(a) || (opposed && (b & ~kSign) == kInfinity) ? kNan : a;
  const std::uint32_t sign = a & kSign;
  if ((b & ~kSign) == 0) return (a & ~kSign) == 0 && opposed ? 0U : a;
  const Parts large = unpack(a), other = unpack(b);
  const std::uint32_t first = large.significand << 6;
  const std::uint32_t second = shift_sticky(other.significand << 6, static_cast<std::uint32_t>(large.exponent - other.exponent));
  const std::uint32_t result = opposed ? first - second : first + second;
  return result == 0 ? 0U : pack(sign, large.exponent, result);
}

constexpr std::uint32_t subtract(std::uint32_t a, std::uint32_t b) { return add(a, b ^ kSign); }

constexpr std::uint32_t multiply(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t sign = (a ^ b) & kSign;
  a &= ~kSign;
  b &= ~kSign;
  if (a >= kInfinity || b >= kInfinity) return a > kInfinity || b > kInfinity || a == 0 || b == 0 ? kNan : sign | kInfinity;
  if (a == 0 || b == 0) return sign;
  const Parts x = unpack(a), y = unpack(b);
  // 24 x 24 bits in halves of 12: this processor multiplies to 32 bits only.
  const std::uint32_t xh = x.significand >> 12, xl = x.significand & 0xFFFU, yh = y.significand >> 12, yl = y.significand & 0xFFFU;
  const std::uint32_t middle = xh * yl + xl * yh;
  const std::uint32_t low = xl * yl + ((middle & 0xFFFU) << 12);
  const std::uint32_t high = xh * yh + (middle >> 12) + (low >> 24);
  return pack(sign, x.exponent + y.exponent - 127, (high << 7) | shift_sticky(low & 0xFFFFFFU, 17));
}

constexpr std::uint32_t divide(std::uint32_t a, std::uint32_t b) {
  const std::uint32_t sign = (a ^ b) & kSign;
  a &= ~kSign;
  b &= ~kSign;
  if (a > kInfinity || b > kInfinity || (a == b && (a == 0 || a == kInfinity))) return kNan;
  if (a == kInfinity || b == 0) return sign | kInfinity;
  if (b == kInfinity || a == 0) return sign;
  const Parts x = unpack(a), y = unpack(b);
  std::uint32_t rest = x.significand, quotient = 0;
  for (std::uint32_t i = 0; i < 31; ++i) {
    quotient <<= 1;
    if (rest >= y.significand) {
      rest -= y.significand;
      quotient |= 1U;
    }
    rest <<= 1;
  }
  // One half to two. The bit below the lowest one that rounding looks at says whether there is a rest.
  return pack(sign, x.exponent - y.exponent + 126, quotient | (rest != 0 ? 1U : 0U));
}

constexpr bool unordered(std::uint32_t a, std::uint32_t b) { return is_nan(a) || is_nan(b); }
constexpr bool equal(std::uint32_t a, std::uint32_t b) {
  if (is_nan(a)) return false;
  return a == b || ((a | b) << 1) == 0;  // both zeros are one
}
// Sign and size are compared as the integers they are. Written out, without calls: nothing is called more often.
constexpr bool less(std::uint32_t a, std::uint32_t b) {
  if (((a | b) & kSign) == 0) return a < b && b <= kInfinity;  // the usual case
  if (is_nan(a) || is_nan(b)) return false;
  if (((a | b) << 1) == 0) return false;
  if (((a ^ b) & kSign) != 0) return (a & kSign) != 0;
  return b < a;
}
constexpr bool less_equal(std::uint32_t a, std::uint32_t b) { return less(a, b) || equal(a, b); }

constexpr std::uint32_t from_unsigned(std::uint32_t value, std::uint32_t sign = 0) {
  if (value == 0) return 0;
  return (value & 0x80000000U) != 0 ? pack(sign, 0x9D, shift_sticky(value, 1)) : pack(sign, 0x9C, value);
}
constexpr std::uint32_t from_signed(std::int32_t value) {
  return value < 0 ? from_unsigned(0U - static_cast<std::uint32_t>(value), kSign) : from_unsigned(static_cast<std::uint32_t>(value));
}
// Towards zero. What does not fit is undefined in the language: here it is held at the end, and NaN is zero.
constexpr std::uint32_t magnitude(std::uint32_t a, std::uint32_t most) {
  const std::int32_t exponent = static_cast<std::int32_t>((a >> 23) & 0xFFU) - 127;
  if (exponent < 0 || is_nan(a)) return 0;
  if (exponent > 31) return most;
  const std::uint32_t significand = ((a & (kLeading - 1U)) | kLeading) << 8;
  const std::uint32_t value = significand >> (31 - exponent);
  return value < most ? value : most;
}
constexpr std::int32_t to_signed(std::uint32_t a) {
  return (a & kSign) != 0 ? static_cast<std::int32_t>(0U - magnitude(a, 0x80000000U)) : static_cast<std::int32_t>(magnitude(a, 0x7FFFFFFFU));
}
constexpr std::uint32_t to_unsigned(std::uint32_t a) { return (a & kSign) != 0 ? 0U : magnitude(a, 0xFFFFFFFFU); }

}  // namespace hoist::firmware::cortex_m0::soft_float
