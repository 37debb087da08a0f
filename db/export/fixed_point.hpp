// Integers with a decimal point, and times as people write them: no floating point, so what is printed is what was stored.
#pragma once
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <string>

namespace hoist::db {

/// Longest text the functions below write.
inline constexpr std::size_t kMaxNumber_chars = 40;

/// value / 10^decimals with exactly `decimals` digits after the point (none and no point for 0); returns the end.
/// `at` has room for kMaxNumber_chars; decimals is 0 to 15.
inline char* print_fixed(char* at, std::int64_t value, int decimals) {
  std::uint64_t magnitude = static_cast<std::uint64_t>(value);
  if (value < 0) {
    *at++ = '-';
    magnitude = ~magnitude + 1;
  }
  if (decimals == 0) return std::to_chars(at, at + 20, magnitude).ptr;
  std::array<char, 20> digits;
  const auto count = static_cast<std::size_t>(std::to_chars(digits.data(), digits.data() + digits.size(), magnitude).ptr - digits.data());
  const auto after = static_cast<std::size_t>(decimals);
  if (count <= after) {
    *at++ = '0';
    *at++ = '.';
    for (std::size_t zeros = after - count; zeros > 0; --zeros) *at++ = '0';
    std::memcpy(at, digits.data(), count);
    return at + count;
  }
  const std::size_t whole = count - after;
  std::memcpy(at, digits.data(), whole);
  at += whole;
  *at++ = '.';
  std::memcpy(at, digits.data() + whole, after);
  return at + after;
}

/// "2026-11-21T12:46:57.010000Z": microseconds, rounded down. Years 1678 to 2262 fit in the nanoseconds.
class UtcPrinter {
 public:
  char* print(char* at, std::int64_t utc_ns) {
    std::int64_t seconds = utc_ns / 1'000'000'000, rest_ns = utc_ns % 1'000'000'000;
    if (rest_ns < 0) {
      rest_ns += 1'000'000'000;
      --seconds;
    }
    // The calendar is asked once a second, not a hundred times.
    if (!known_ || seconds != seconds_) {
      const std::time_t time = seconds;
      std::tm parts{};
      gmtime_r(&time, &parts);
      length_ = std::strftime(text_.data(), text_.size(), "%Y-%m-%dT%H:%M:%S.", &parts);
      seconds_ = seconds;
      known_ = true;
    }
    std::memcpy(at, text_.data(), length_);
    at += length_;
    std::int64_t micros = rest_ns / 1000;
    for (int digit = 5; digit >= 0; --digit, micros /= 10) at[digit] = static_cast<char>('0' + micros % 10);
    at[6] = 'Z';
    return at + 7;
  }

 private:
  std::array<char, 32> text_{};
  std::size_t length_ = 0;
  std::int64_t seconds_ = 0;
  bool known_ = false;
};

}  // namespace hoist::db
