// What mutate.py writes into its copies: each place asks whether its mutant is the chosen one, and notes that a test came by.
#pragma once
#include <type_traits>

namespace hoist_mutants {

inline constexpr int kMost = 20000;
inline int chosen = -1;      // set by the test program before the tests
inline bool reached[kMost];  // NOLINT(cppcoreguidelines-avoid-c-arrays,modernize-avoid-c-arrays): needs no constructor

inline bool asked(int number) noexcept {
  reached[number] = true;
  return number == chosen;
}
// What the compiler computes stays as it is.
constexpr bool on(int number) noexcept { return !std::is_constant_evaluated() && asked(number); }

template <typename A, typename B>
constexpr bool less(int n, A a, B b) noexcept {
  return on(n) ? a >= b : on(n + 1) ? a <= b : a < b;
}
template <typename A, typename B>
constexpr bool more(int n, A a, B b) noexcept {
  return on(n) ? a <= b : on(n + 1) ? a >= b : a > b;
}
template <typename A, typename B>
constexpr bool most(int n, A a, B b) noexcept {
  return on(n) ? a > b : on(n + 1) ? a < b : a <= b;
}
template <typename A, typename B>
constexpr bool least(int n, A a, B b) noexcept {
  return on(n) ? a < b : on(n + 1) ? a > b : a >= b;
}
template <typename A, typename B>
constexpr bool same(int n, A a, B b) noexcept {
  return on(n) ? a != b : a == b;
}
template <typename A, typename B>
constexpr bool other(int n, A a, B b) noexcept {
  return on(n) ? a == b : a != b;
}
// Measured numbers are never just equal to a limit, so only the opposite is tried.
template <typename A, typename B>
constexpr bool less_real(int n, A a, B b) noexcept {
  return on(n) ? a >= b : a < b;
}
template <typename A, typename B>
constexpr bool more_real(int n, A a, B b) noexcept {
  return on(n) ? a <= b : a > b;
}
template <typename A, typename B>
constexpr bool most_real(int n, A a, B b) noexcept {
  return on(n) ? a > b : a <= b;
}
template <typename A, typename B>
constexpr bool least_real(int n, A a, B b) noexcept {
  return on(n) ? a < b : a >= b;
}
template <typename A, typename B>
constexpr auto sum(int n, A a, B b) noexcept {
  return on(n) ? a - b : a + b;
}
template <typename A, typename B>
constexpr auto difference(int n, A a, B b) noexcept {
  return on(n) ? a + b : a - b;
}
template <typename A, typename B>
constexpr auto product(int n, A a, B b) noexcept {
  return on(n) ? a + b : a * b;
}
template <typename A, typename B>
constexpr auto quotient(int n, A a, B b) noexcept {
  return on(n) ? a * b : a / b;
}
template <typename A, typename B>
constexpr auto bits_of_both(int n, A a, B b) noexcept {
  return on(n) ? a | b : a & b;
}
template <typename A, typename B>
constexpr auto bits_of_either(int n, A a, B b) noexcept {
  return on(n) ? a & b : a | b;
}

template <typename T>
constexpr T number(int n, T value) noexcept {
  if (!on(n)) return value;
  if constexpr (std::is_same_v<T, bool>)
    return !value;
  else if constexpr (std::is_floating_point_v<T>)
    return value == 0 ? T{1} : 2 * value;
  else
    return static_cast<T>(value + 1);
}
template <typename T>
constexpr T constant(int n, T value) noexcept {
  if (on(n)) return std::is_floating_point_v<T> ? static_cast<T>(2 * value) : static_cast<T>(value + 1);
  if (on(n + 1)) return std::is_floating_point_v<T> ? static_cast<T>(value / 2) : static_cast<T>(value - 1);
  return value;
}

}  // namespace hoist_mutants
