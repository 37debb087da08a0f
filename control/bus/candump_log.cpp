#include "control/bus/candump_log.hpp"

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>

namespace hoist::bus {

using contract::CanFrame;

namespace {

constexpr std::uint64_t kUsPerS = 1'000'000;
constexpr std::uint64_t kLatest_s = 99'999'999'999;  // up to the year 5138; more digits are refused
constexpr std::uint32_t kErrorBit = 0x20000000U;     // as the kernel marks error frames
constexpr std::uint32_t kErrorBits = 0x3FFFFFFFU;

constexpr char kHex[] = "0123456789ABCDEF";

int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}

// Takes the text before `stop`, and `stop` itself; false without one.
bool take_until(std::string_view& rest, char stop, std::string_view& taken) {
  const std::size_t at = rest.find(stop);
  if (at == std::string_view::npos) return false;
  taken = rest.substr(0, at);
  rest.remove_prefix(at + 1);
  return true;
}

bool decimal(std::string_view text, std::uint64_t& value) {
  value = 0;
  if (text.empty() || text.size() > 19) return false;
  for (const char c : text) {
    if (c < '0' || c > '9') return false;
    value = value * 10 + static_cast<std::uint64_t>(c - '0');
  }
  return true;
}

const char* parse_time(std::string_view text, std::uint64_t& time_us) {
  std::string_view seconds;
  std::uint64_t whole = 0, fraction = 0;
  if (!take_until(text, '.', seconds) || !decimal(seconds, whole) || text.size() != 6 || !decimal(text, fraction) || whole > kLatest_s)
    return "the time is not seconds with six decimals";
  time_us = whole * kUsPerS + fraction;
  return nullptr;
}

const char* parse_id(std::string_view text, CanFrame& frame) {
  if (text.size() != 3 && text.size() != 8) return "the id has neither 3 nor 8 digits";
  std::uint32_t id = 0;
  for (const char c : text) {
    const int digit = hex_value(c);
    if (digit < 0) return "the id is not hexadecimal";
    id = (id << 4) | static_cast<std::uint32_t>(digit);
  }
  if (text.size() == 3) {
    if (id > 0x7FF) return "an 11-bit id ends at 7FF";
  } else if ((id & kErrorBit) != 0) {
    if (id > kErrorBits) return "a 29-bit id ends at 1FFFFFFF";
    frame.flags = CanFrame::kError;
    id &= ~kErrorBit;
  } else {
    if (id > 0x1FFFFFFFU) return "a 29-bit id ends at 1FFFFFFF";
    frame.flags = CanFrame::kExtended;
  }
  frame.id = id;
  return nullptr;
}

const char* parse_data(std::string_view text, CanFrame& frame) {
  if (!text.empty() && text[0] == '#') return "a CAN FD frame; this bus has none";
  if (!text.empty() && (text[0] == 'R' || text[0] == 'r')) {
    if ((frame.flags & CanFrame::kError) != 0) return "an error frame cannot be a remote request";
    if (text.size() > 2 || (text.size() == 2 && (text[1] < '0' || text[1] > '8'))) return "a remote request has a length of 0 to 8";
    frame.flags = static_cast<std::uint8_t>(frame.flags | CanFrame::kRemote);
    frame.dlc = text.size() == 2 ? static_cast<std::uint8_t>(text[1] - '0') : std::uint8_t{0};
    return nullptr;
  }
  if (text.size() % 2 != 0 || text.size() > 16) return "the data are not 0 to 8 whole bytes";
  frame.dlc = static_cast<std::uint8_t>(text.size() / 2);
  for (std::size_t i = 0; i < text.size(); i += 2) {
    const int high = hex_value(text[i]), low = hex_value(text[i + 1]);
    if (high < 0 || low < 0) return "the data are not hexadecimal";
    frame.data[i / 2] = static_cast<std::uint8_t>(high * 16 + low);
  }
  return nullptr;
}

}  // namespace

std::size_t format_log_line(const LogEntry& entry, std::span<char> out) noexcept {
  const CanFrame& frame = entry.frame;
  const bool extended = (frame.flags & CanFrame::kExtended) != 0, error = (frame.flags & CanFrame::kError) != 0;
  const bool remote = (frame.flags & CanFrame::kRemote) != 0;
  if (frame.dlc > 8 || frame.id > (extended || error ? 0x1FFFFFFFU : 0x7FFU) || entry.time_us / kUsPerS > kLatest_s) return 0;
  std::array<char, kLogLineMax> line;
  const int head =
      std::snprintf(line.data(), line.size(), error || extended ? "(%010llu.%06llu) %.15s %08X#" : "(%010llu.%06llu) %.15s %03X#",
                    static_cast<unsigned long long>(entry.time_us / kUsPerS), static_cast<unsigned long long>(entry.time_us % kUsPerS),
                    entry.interface.data(), frame.id | (error ? kErrorBit : 0U));
  if (head <= 0) return 0;
  auto at = static_cast<std::size_t>(head);
  if (remote) {
    line[at++] = 'R';
    if (frame.dlc > 0) line[at++] = static_cast<char>('0' + frame.dlc);
  } else {
    for (std::size_t i = 0; i < frame.dlc; ++i) {
      line[at++] = kHex[frame.data[i] >> 4];
      line[at++] = kHex[frame.data[i] & 0x0F];
    }
  }
  if (entry.direction != Direction::unknown) {
    line[at++] = ' ';
    line[at++] = entry.direction == Direction::sent ? 'T' : 'R';
  }
  line[at++] = '\n';
  if (at > out.size()) return 0;
  std::memcpy(out.data(), line.data(), at);
  return at;
}

const char* parse_log_line(std::string_view line, LogEntry& entry) noexcept {
  entry = LogEntry{};
  if (line.size() >= kLogLineMax) return "the line is too long";
  std::string_view rest = line, time, interface, id;
  if (rest.empty() || rest[0] != '(') return "the line does not begin with a time in parentheses";
  rest.remove_prefix(1);
  if (!take_until(rest, ')', time) || rest.empty() || rest[0] != ' ') return "the line does not begin with a time in parentheses";
  rest.remove_prefix(1);
  if (const char* wrong = parse_time(time, entry.time_us)) return wrong;
  if (!take_until(rest, ' ', interface) || interface.empty() || interface.size() >= entry.interface.size())
    return "the interface needs a name of 1 to 15 characters";
  for (const char c : interface)
    if (c <= ' ' || c > '~') return "the interface needs a name of 1 to 15 characters";
  interface.copy(entry.interface.data(), interface.size());
  if (!take_until(rest, '#', id)) return "there is no frame (ID#DATA)";
  if (const char* wrong = parse_id(id, entry.frame)) return wrong;
  if (const std::size_t space = rest.find(' '); space != std::string_view::npos) {
    const std::string_view direction = rest.substr(space + 1);
    if (direction != "R" && direction != "T") return "behind the frame only R or T may stand";
    entry.direction = direction == "T" ? Direction::sent : Direction::received;
    rest = rest.substr(0, space);
  }
  return parse_data(rest, entry.frame);
}

std::string read_log(const std::string& path, std::vector<LogEntry>& entries) {
  entries.clear();
  std::ifstream file(path, std::ios::binary);
  if (!file) return path + ": " + std::strerror(errno);
  std::array<char, kLogLineMax + 1> buffer;
  std::size_t number = 0, bytes = 0;
  const auto refuse = [&](const char* why) {
    entries.clear();
    return path + ":" + std::to_string(number) + ": " + why;
  };
  for (;;) {
    file.getline(buffer.data(), static_cast<std::streamsize>(buffer.size()));
    const auto taken = static_cast<std::size_t>(file.gcount());
    if (taken == 0 && file.eof()) break;
    ++number;
    bytes += taken;
    if (file.bad()) return refuse("the file cannot be read further");
    if (file.fail()) return refuse("the line is too long");
    std::string_view line(buffer.data());
    // A NUL would end the text early and hide what follows.
    if (line.size() + (file.eof() ? 0U : 1U) != taken) return refuse("the line holds a character that is no text");
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty()) continue;
    if (entries.size() == kLogFramesMax || bytes > kLogBytesMax) return refuse("a recording has at most 4000000 frames");
    LogEntry entry;
    if (const char* wrong = parse_log_line(line, entry)) return refuse(wrong);
    entries.push_back(entry);
    if (file.eof()) break;
  }
  if (entries.empty()) return path + ": there is no frame in it";
  return {};
}

}  // namespace hoist::bus
