// Letters without case, for searching codes: ASCII, Latin-1 and Latin Extended-A (German and Slovenian letters among them). SQLite's own
// lower() knows ASCII only.
#pragma once
#include <string>
#include <string_view>

namespace hoist::db {

/// The small letter of a code point between U+0080 and U+07FF, or the code point itself.
constexpr unsigned small_letter(unsigned point) {
  if (point >= 0xC0 && point <= 0xDE && point != 0xD7) return point + 0x20;
  if (point == 0x178) return 0xFF;
  const bool even_is_capital =
      (point >= 0x100 && point <= 0x12F) || (point >= 0x132 && point <= 0x137) || (point >= 0x14A && point <= 0x177);
  const bool odd_is_capital = (point >= 0x139 && point <= 0x148) || (point >= 0x179 && point <= 0x17E);
  return (even_is_capital && point % 2 == 0) || (odd_is_capital && point % 2 == 1) ? point + 1 : point;
}

/// UTF-8 in small letters; bytes that are no UTF-8 stay as they are.
inline std::string folded(std::string_view text) {
  std::string out(text);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const auto lead = static_cast<unsigned char>(out[i]);
    if (lead >= 'A' && lead <= 'Z') out[i] = static_cast<char>(lead + ('a' - 'A'));
    if (lead < 0xC2 || lead > 0xDF || i + 1 >= out.size()) continue;
    const auto next = static_cast<unsigned char>(out[i + 1]);
    if ((next & 0xC0U) != 0x80U) continue;
    const unsigned point = small_letter((lead & 0x1FU) << 6U | (next & 0x3FU));
    out[i] = static_cast<char>(0xC0U | point >> 6U);
    out[++i] = static_cast<char>(0x80U | (point & 0x3FU));
  }
  return out;
}

}  // namespace hoist::db
