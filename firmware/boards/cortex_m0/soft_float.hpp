// Single precision on integers, IEEE 754, rounded to nearest even, with denormals: bit for bit as on a host. Written for size: 1.3 KB,
// where the compiler's library takes 4.5 KB.
//
// Values are passed as their 32-bit words. The one difference to a host: every NaN result is 7FC00000h.
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
  if ((significand & 0x7FU) == 0x40U) rounded &= ~1U;  // a tie: to the even one
  if (exponent >= 0xFE) return sign | kInfinity;
  // The leading bit adds one to the exponent. So does a carry of the rounding, which may lead to infinity.
  return sign | ((static_cast<std::uint32_t>(exponent) << 23) + rounded);
}

// The end of pack() for a normal result. Inlined in the common paths of add() and multiply(), the hottest functions of a node.
[[gnu::always_inline]] constexpr bool rounds_to_normal(std::int32_t exponent) { return static_cast<std::uint32_t>(exponent) < 0xFDU; }
[[gnu::always_inline]] constexpr std::uint32_t round_normal(std::uint32_t sign, std::int32_t exponent, std::uint32_t significand) {
  std::uint32_t rounded = (significand + 0x40U) >> 7;
  if ((significand & 0x7FU) == 0x40U) rounded &= ~1U;
  return sign | ((static_cast<std::uint32_t>(exponent) << 23) + rounded);
}
[[gnu::always_inline]] constexpr bool is_normal_exponent(std::uint32_t exponent) { return exponent - 1U < 0xFEU; }

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

// The usual case is inlined at its callers.
[[gnu::always_inline]] constexpr Parts unpack(std::uint32_t a) {
  const std::uint32_t exponent = (a >> 23) & 0xFFU;
  if (exponent == 0) return unpack_denormal(a);
  return {static_cast<std::int32_t>(exponent), (a & (kLeading - 1U)) | kLeading};
}

constexpr std::uint32_t add(std::uint32_t a, std::uint32_t b) {
  if (a << 1 < b << 1) {
    const std::uint32_t swap = a;
    a = b;
    b = swap;
  }
  // Two normal numbers: nearly always.
  const std::uint32_t large_exponent = (a << 1) >> 24, small_exponent = (b << 1) >> 24;
  if (is_normal_exponent(large_exponent) && small_exponent != 0) {
    std::uint32_t sum = ((a << 8) | kSign) >> 2, smaller = ((b << 8) | kSign) >> 2;  // leading bit in bit 29
    const std::uint32_t by = large_exponent - small_exponent;
    if (by != 0) {
      if (by >= 27U) return a;  // less than half of its last bit, and no tie
      const std::uint32_t lost = smaller << (32U - by);
      smaller >>= by;
      if (lost != 0) smaller |= 1U;
    }
    auto exponent = static_cast<std::int32_t>(large_exponent);
    if (static_cast<std::int32_t>(a ^ b) >= 0) {
      sum += smaller;
    } else {
      sum -= smaller;
      if (sum == 0) return 0;
    }
    while ((sum & 0x40000000U) == 0) {
      sum <<= 1;
      --exponent;
    }
    if (rounds_to_normal(exponent)) return round_normal(a & kSign, exponent, sum);
    return pack(a & kSign, exponent, sum);
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
  // Two normal numbers with a normal product: nearly always.
  if (is_normal_exponent(a >> 23) && is_normal_exponent(b >> 23)) {
    std::int32_t exponent = static_cast<std::int32_t>((a >> 23) + (b >> 23)) - 127;
    a = (a << 8) | kSign;  // leading bit in bit 31, eight zeros below
    b = (b << 8) | kSign;
    // Halves of 16 bits, the lower ones with eight zeros: the product's upper word and whether anything is below it.
    const std::uint32_t ah = a >> 16, bh = b >> 16;
    a &= 0xFFFFU;
    b &= 0xFFFFU;
    const std::uint32_t one = ah * b;
    std::uint32_t middle = one + a * bh;  // below 2^33: the carry is worth 2^48
    std::uint32_t high = ah * bh;
    if (middle < one) high += 0x10000U;
    const std::uint32_t low_word = a * b;
    const std::uint32_t low = low_word + (middle << 16);
    if (low < low_word) ++high;
    high += middle >> 16;
    // The product is in bits 63 to 62 of high and low.
    if ((high & kSign) != 0) {
      high = (high >> 1) | (high & 1U);
    } else {
      --exponent;
    }
    if (low != 0) high |= 1U;
    if (rounds_to_normal(exponent)) return round_normal(sign, exponent, high);
    return pack(sign, exponent, high);
  }
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
  const auto bit = [&rest, &quotient, by = y.significand ]() __attribute__((always_inline)) {
    quotient <<= 1;
    if (rest >= by) {
      rest -= by;
      quotient += 1U;
    }
    rest <<= 1;
  };
  // 27 bits: 24 or 25 of the result and two to round by; three to a round, because counting the rounds costs as much as a bit.
  for (std::uint32_t round = 0; round < 9; ++round) {
    bit();
    bit();
    bit();
  }
  // Range 0.5 to 2. The lowest bit is set when there is a remainder.
  std::uint32_t significand = quotient << 4;
  if (rest != 0) significand |= 1U;
  std::int32_t exponent = x.exponent - y.exponent + 126;
  if ((significand & 0x40000000U) == 0) {
    significand <<= 1;
    --exponent;
  }
  if (rounds_to_normal(exponent)) return round_normal(sign, exponent, significand);
  return pack(sign, exponent, significand);
}

constexpr bool unordered(std::uint32_t a, std::uint32_t b) { return is_nan(a) || is_nan(b); }
constexpr bool equal(std::uint32_t a, std::uint32_t b) {
  if (is_nan(a)) return false;
  return a == b || ((a | b) << 1) == 0;  // both zeros are one
}
// Sign and magnitude are compared as integers. Inlined, without calls: this is a hot function.
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
// Rounds towards zero. A value out of range, undefined in the language, is clamped; NaN becomes zero.
constexpr std::uint32_t magnitude(std::uint32_t a, std::uint32_t most) {
  const std::int32_t exponent = static_cast<std::int32_t>((a >> 23) & 0xFFU) - 127;
  if (exponent < 0 || is_nan(a)) return 0;
  if (exponent > 31) return most;
  const std::uint32_t significand = ((a & (kLeading - 1U)) | kLeading) << 8;
  const std::uint32_t value = significand >> (31 - exponent);
  return value < most ? value : most;
}
constexpr std::int32_t to_signed(std::uint32_t a) {
  return (a & kSign) != 0 ? static_cast<std::int32_t>(0U - magnitude(a, 0x80000000U))
                          : static_cast<std::int32_t>(magnitude(a, 0x7FFFFFFFU));
}
constexpr std::uint32_t to_unsigned(std::uint32_t a) { return (a & kSign) != 0 ? 0U : magnitude(a, 0xFFFFFFFFU); }

}  // namespace hoist::firmware::cortex_m0::soft_float
