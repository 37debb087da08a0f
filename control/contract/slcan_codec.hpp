// SLCAN (LAWICEL), the line protocol between the computer and the UART-CAN gateway. One strict codec for both ends: the gateway's
// firmware and the host's driver.
//
// Strict, because a UART that loses a byte turns one frame into another: a line must have exactly the length that its type and DLC ask
// for (or four more, a time stamp), hexadecimal digits only, an id that exists. Anything else is dropped whole and counted; the kernel's
// own driver lets such lines through with bytes of the line before (seen on 6.1).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "control/contract/can_frame.hpp"

namespace hoist::contract {

inline constexpr char kSlcanOk = '\r', kSlcanBell = '\a';
inline constexpr std::size_t kSlcanLineMax = 32;            // longest accepted line without its end; a stamped 29-bit frame has 30
inline constexpr std::uint16_t kSlcanStampWrap_ms = 60000;  // stamps run from 0000 to EA5F

namespace slcan_detail {
constexpr int hex_value(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return -1;
}
constexpr char hex_digit(std::uint32_t value) { return "0123456789ABCDEF"[value & 0xFU]; }
// At most eight digits; nothing when one is not hexadecimal or the text is shorter.
constexpr std::optional<std::uint32_t> read_hex(std::string_view text, std::size_t at, std::size_t digits) {
  if (text.size() < at + digits) return std::nullopt;
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < digits; ++i) {
    const int digit = hex_value(text[at + i]);
    if (digit < 0) return std::nullopt;
    value = (value << 4) | static_cast<std::uint32_t>(digit);
  }
  return value;
}
constexpr std::optional<std::uint16_t> read_decimal3(std::string_view text, std::size_t at) {
  std::uint16_t value = 0;
  for (std::size_t i = at; i < at + 3; ++i) {
    if (text[i] < '0' || text[i] > '9') return std::nullopt;
    value = static_cast<std::uint16_t>(value * 10 + (text[i] - '0'));
  }
  return value;
}
}  // namespace slcan_detail

/// Writes one frame as a line with its CR and returns the number of characters; 0 when the frame cannot exist on a bus (id, DLC, error
/// flag), the stamp is not below 60000 or `out` is too small. Nothing useful is then in `out`.
constexpr std::size_t slcan_encode(const CanFrame& frame, std::span<char> out, std::optional<std::uint16_t> stamp_ms = std::nullopt) {
  using slcan_detail::hex_digit;
  const bool extended = (frame.flags & CanFrame::kExtended) != 0;
  const bool remote = (frame.flags & CanFrame::kRemote) != 0;
  if ((frame.flags & CanFrame::kError) != 0 || frame.dlc > 8 || frame.id > (extended ? 0x1FFFFFFFU : 0x7FFU)) return 0;
  if (stamp_ms && *stamp_ms >= kSlcanStampWrap_ms) return 0;
  const std::size_t id_digits = extended ? 8 : 3;
  const std::size_t bytes = remote ? 0 : frame.dlc;
  const std::size_t length = 1 + id_digits + 1 + 2 * bytes + (stamp_ms ? 4U : 0U) + 1;
  if (out.size() < length) return 0;
  std::size_t at = 0;
  out[at++] = remote ? (extended ? 'R' : 'r') : (extended ? 'T' : 't');
  for (std::size_t i = id_digits; i > 0; --i) out[at++] = hex_digit(frame.id >> (4 * (i - 1)));
  out[at++] = hex_digit(frame.dlc);
  for (std::size_t i = 0; i < bytes; ++i) {
    out[at++] = hex_digit(static_cast<std::uint32_t>(frame.data[i]) >> 4);
    out[at++] = hex_digit(frame.data[i]);
  }
  if (stamp_ms)
    for (int shift = 12; shift >= 0; shift -= 4) out[at++] = hex_digit(static_cast<std::uint32_t>(*stamp_ms) >> shift);
  out[at++] = kSlcanOk;
  return at;
}

enum class SlcanKind : std::uint8_t {
  frame,    // t, T, r, R: see frame, stamp_ms
  ack,      // an empty line, z or Z: the last request was accepted
  bel,      // BEL: the last request was refused
  state,    // s + a, w, p or b + two counters: see state, rx_errors, tx_errors
  error,    // e + count + letters: see text
  command,  // any other line of printable characters: a command for the gateway, an answer (V, v, N, F) for the host: see text
  refused,  // dropped and counted
};

struct SlcanLine {
  SlcanKind kind = SlcanKind::refused;
  CanFrame frame{};
  std::optional<std::uint16_t> stamp_ms{};
  char state = 0;  // a active, w warning, p passive, b bus-off
  std::uint16_t rx_errors = 0, tx_errors = 0;
  std::string_view text{};  // the line without its end; valid only during the call
};

namespace slcan_detail {
constexpr SlcanLine refused_line(std::string_view text) {
  SlcanLine line;
  line.text = text;
  return line;
}

constexpr SlcanLine parse_frame(std::string_view text) {
  const bool extended = text[0] == 'T' || text[0] == 'R';
  const bool remote = text[0] == 'r' || text[0] == 'R';
  const std::size_t id_digits = extended ? 8 : 3;
  const auto id = read_hex(text, 1, id_digits);
  if (!id || *id > (extended ? 0x1FFFFFFFU : 0x7FFU) || text.size() < id_digits + 2) return refused_line(text);
  const char dlc = text[1 + id_digits];
  if (dlc < '0' || dlc > '8') return refused_line(text);
  SlcanLine line;
  line.text = text;
  line.frame.id = *id;
  line.frame.dlc = static_cast<std::uint8_t>(dlc - '0');
  line.frame.flags = static_cast<std::uint8_t>((extended ? CanFrame::kExtended : 0) | (remote ? CanFrame::kRemote : 0));
  const std::size_t bytes = remote ? 0 : line.frame.dlc;
  const std::size_t data_at = id_digits + 2;
  const std::size_t plain = data_at + 2 * bytes;
  if (text.size() != plain && text.size() != plain + 4) return refused_line(text);
  for (std::size_t i = 0; i < bytes; ++i) {
    const auto byte = read_hex(text, data_at + 2 * i, 2);
    if (!byte) return refused_line(text);
    line.frame.data[i] = static_cast<std::uint8_t>(*byte);
  }
  if (text.size() == plain + 4) {
    const auto stamp = read_hex(text, plain, 4);
    if (!stamp || *stamp >= kSlcanStampWrap_ms) return refused_line(text);
    line.stamp_ms = static_cast<std::uint16_t>(*stamp);
  }
  line.kind = SlcanKind::frame;
  return line;
}

constexpr SlcanLine parse_state(std::string_view text) {
  const auto rx = read_decimal3(text, 2);
  const auto tx = read_decimal3(text, 5);
  if (!rx || !tx) return refused_line(text);
  SlcanLine line;
  line.text = text;
  line.kind = SlcanKind::state;
  line.state = text[1];
  line.rx_errors = *rx;
  line.tx_errors = *tx;
  return line;
}
}  // namespace slcan_detail

/// One whole line without its end.
constexpr SlcanLine slcan_parse(std::string_view text) {
  SlcanLine line;
  line.text = text;
  if (text.empty() || text == "z" || text == "Z") {
    line.kind = SlcanKind::ack;
    return line;
  }
  for (const char c : text)
    if (c < ' ' || c > '~') return line;
  switch (text[0]) {
    case 't':
    case 'T':
    case 'r':
    case 'R':
      return slcan_detail::parse_frame(text);
    case 's':
      // "sxxyy" is the command that sets bit timing registers; a state line has eight characters and a letter of its own.
      if (text.size() == 8 && (text[1] == 'a' || text[1] == 'w' || text[1] == 'p' || text[1] == 'b'))
        return slcan_detail::parse_state(text);
      break;
    case 'e':
      line.kind = SlcanKind::error;
      return line;
    default:
      break;
  }
  line.kind = SlcanKind::command;
  return line;
}

struct SlcanCounters {
  std::uint32_t frames = 0;
  std::uint32_t refused_lines = 0;   // malformed, without the over-long ones
  std::uint32_t overlong_lines = 0;  // more than kSlcanLineMax characters before an end
  std::uint32_t bells = 0;
};

/// Lines out of any stream of bytes, however it is cut into pieces: the result depends only on the bytes. CR ends a line; BEL is an
/// answer of its own and ends, as refused, a line that it cuts off.
class SlcanDecoder {
 public:
  /// Calls on_line(const SlcanLine&) for every line; the line's text lives only during that call.
  template <class F>
  constexpr void feed(std::span<const char> bytes, F&& on_line) {
    for (const char c : bytes) {
      if (c == kSlcanOk || c == kSlcanBell) {
        end_line(c == kSlcanBell, on_line);
      } else if (length_ < kSlcanLineMax) {
        text_[length_++] = c;
      } else {
        overlong_ = true;
      }
    }
  }

  /// Forgets a line that has only begun; the counters stay. After the tty was reopened.
  constexpr void restart() {
    length_ = 0;
    overlong_ = false;
  }
  constexpr const SlcanCounters& counters() const { return counters_; }

 private:
  template <class F>
  constexpr void end_line(bool bell, F&& on_line) {
    const std::string_view text(text_.data(), length_);
    const bool overlong = overlong_;
    restart();
    if (overlong) {
      ++counters_.overlong_lines;
      on_line(slcan_detail::refused_line(text));
    } else if (!bell || !text.empty()) {
      const SlcanLine line = bell ? slcan_detail::refused_line(text) : slcan_parse(text);
      if (line.kind == SlcanKind::frame) ++counters_.frames;
      if (line.kind == SlcanKind::refused) ++counters_.refused_lines;
      on_line(line);
    }
    if (bell) {
      ++counters_.bells;
      SlcanLine line;
      line.kind = SlcanKind::bel;
      on_line(line);
    }
  }

  std::array<char, kSlcanLineMax> text_{};
  std::size_t length_ = 0;
  bool overlong_ = false;
  SlcanCounters counters_{};
};

}  // namespace hoist::contract
