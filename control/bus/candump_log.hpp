// The text format of `candump -L`: one frame a line, "(1700000000.123456) can0 181#0011223344556677", with R or T at the end where the
// direction is known. Remote requests are "181#R3", 29-bit ids have eight digits, error frames an id with bit 29 set.
//
// Read strictly: any other line is refused with the reason. A recording with a damaged line must not pass as a complete one.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/can_frame.hpp"

namespace hoist::bus {

enum class Direction : std::uint8_t { unknown, received, sent };

struct LogEntry {
  std::uint64_t time_us = 0;  // since 1970, or since the start of the recorder's clock
  contract::CanFrame frame{};
  std::array<char, 16> interface {};  // a name of at most 15 characters, ended by 0
  Direction direction = Direction::unknown;
  friend bool operator==(const LogEntry&, const LogEntry&) = default;
};

inline constexpr std::size_t kLogLineMax = 96;            // the longest line that can exist has 73 characters
inline constexpr std::size_t kLogFramesMax = 4'000'000;   // an hour of the planned traffic
inline constexpr std::size_t kLogBytesMax = 320'000'000;  // that many frames at their longest

// One line with its line feed; how many characters were written, 0 when `out` is too small or the frame cannot exist.
[[nodiscard]] std::size_t format_log_line(const LogEntry& entry, std::span<char> out) noexcept;

// One line without its line feed. Null when it is good, otherwise half a sentence that says what is wrong.
[[nodiscard]] const char* parse_log_line(std::string_view line, LogEntry& entry) noexcept;

// Reads a whole file. Empty on success, otherwise the refusal with file and line: "walk.log:17: the id has 4 digits instead of 3 or 8".
[[nodiscard]] std::string read_log(const std::string& path, std::vector<LogEntry>& entries);

}  // namespace hoist::bus
