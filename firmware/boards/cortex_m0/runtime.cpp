// Functions that the compiler calls, under the names of the ARM run-time ABI (IHI 0043): floats, division, copying. Small, in place of the
// library's fast ones; soft_float.hpp is tested against this computer's floats bit by bit.
#include <cstddef>
#include <cstdint>

#include "firmware/boards/cortex_m0/soft_float.hpp"

namespace {
namespace soft = hoist::firmware::cortex_m0::soft_float;
using Word = std::uint32_t;  // a float travels in a core register
using AnyWord [[gnu::may_alias]] = std::uint32_t;

// One bit after the other; a division by zero gives all ones.
std::uint64_t divide(std::uint32_t dividend, std::uint32_t divisor) {
  std::uint32_t quotient = 0, rest = 0;
  for (std::uint32_t i = 0; i < 32; ++i) {
    rest = (rest << 1) | (dividend >> 31);
    dividend <<= 1;
    quotient <<= 1;
    if (rest >= divisor) {
      rest -= divisor;
      quotient |= 1U;
    }
  }
  return (static_cast<std::uint64_t>(rest) << 32) | quotient;
}
}  // namespace

// The floats lie in RAM and are reached through far_calls.cpp.
extern "C" {
Word hoist_fadd(Word a, Word b) { return soft::add(a, b); }
Word hoist_fsub(Word a, Word b) { return hoist_fadd(a, b ^ soft::kSign); }
Word hoist_frsub(Word a, Word b) { return hoist_fadd(b, a ^ soft::kSign); }
Word hoist_fmul(Word a, Word b) { return soft::multiply(a, b); }
Word hoist_fdiv(Word a, Word b) { return soft::divide(a, b); }
int hoist_fcmpun(Word a, Word b) { return soft::unordered(a, b) ? 1 : 0; }
int hoist_fcmpeq(Word a, Word b) { return soft::equal(a, b) ? 1 : 0; }
int hoist_fcmplt(Word a, Word b) { return soft::less(a, b) ? 1 : 0; }
int hoist_fcmple(Word a, Word b) { return hoist_fcmplt(a, b) | hoist_fcmpeq(a, b); }
int hoist_fcmpgt(Word a, Word b) { return hoist_fcmplt(b, a); }
int hoist_fcmpge(Word a, Word b) { return hoist_fcmple(b, a); }
Word hoist_ui2f(std::uint32_t value) { return soft::from_unsigned(value); }
Word hoist_i2f(std::int32_t value) { return soft::from_signed(value); }
std::int32_t hoist_f2iz(Word a) { return soft::to_signed(a); }
std::uint32_t hoist_f2uiz(Word a) { return soft::to_unsigned(a); }

// Quotient in the first register, remainder in the second.
std::uint64_t __aeabi_uidivmod(std::uint32_t a, std::uint32_t b) { return divide(a, b); }
std::uint32_t __aeabi_uidiv(std::uint32_t a, std::uint32_t b) { return static_cast<std::uint32_t>(__aeabi_uidivmod(a, b)); }
std::uint64_t __aeabi_idivmod(std::int32_t a, std::int32_t b) {
  const std::uint32_t size_a = a < 0 ? 0U - static_cast<std::uint32_t>(a) : static_cast<std::uint32_t>(a);
  const std::uint32_t size_b = b < 0 ? 0U - static_cast<std::uint32_t>(b) : static_cast<std::uint32_t>(b);
  const std::uint64_t both = __aeabi_uidivmod(size_a, size_b);
  std::uint32_t quotient = static_cast<std::uint32_t>(both), rest = static_cast<std::uint32_t>(both >> 32);
  if ((a ^ b) < 0) quotient = 0U - quotient;
  if (a < 0) rest = 0U - rest;
  return (static_cast<std::uint64_t>(rest) << 32) | quotient;
}
std::int32_t __aeabi_idiv(std::int32_t a, std::int32_t b) {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(__aeabi_idivmod(a, b)));
}

// The compiler must not replace these loops by calls of themselves (-fno-tree-loop-distribute-patterns for this file).
void* hoist_memcpy(void* to, const void* from, std::size_t count) {
  auto* t = static_cast<unsigned char*>(to);
  const auto* f = static_cast<const unsigned char*>(from);
  if (((reinterpret_cast<std::uintptr_t>(t) | reinterpret_cast<std::uintptr_t>(f)) & 3U) == 0)
    for (; count >= 4; count -= 4, t += 4, f += 4) *reinterpret_cast<AnyWord*>(t) = *reinterpret_cast<const AnyWord*>(f);
  for (; count > 0; --count) *t++ = *f++;
  return to;
}
void* memmove(void* to, const void* from, std::size_t count) {
  auto* t = static_cast<unsigned char*>(to);
  const auto* f = static_cast<const unsigned char*>(from);
  if (t < f) return hoist_memcpy(to, from, count);
  while (count-- > 0) t[count] = f[count];
  return to;
}
void* hoist_memset(void* to, int value, std::size_t count) {
  auto* t = static_cast<unsigned char*>(to);
  const unsigned char byte = static_cast<unsigned char>(value);
  if ((reinterpret_cast<std::uintptr_t>(t) & 3U) == 0)
    for (const AnyWord word = byte * 0x01010101U; count >= 4; count -= 4, t += 4) *reinterpret_cast<AnyWord*>(t) = word;
  for (; count > 0; --count) *t++ = byte;
  return to;
}
void __aeabi_memcpy(void* to, const void* from, std::size_t count) { (void)hoist_memcpy(to, from, count); }
void __aeabi_memcpy4(void* to, const void* from, std::size_t count) { (void)hoist_memcpy(to, from, count); }
void __aeabi_memset(void* to, std::size_t count, int value) { (void)hoist_memset(to, value, count); }
void __aeabi_memclr(void* to, std::size_t count) { (void)hoist_memset(to, 0, count); }
}
