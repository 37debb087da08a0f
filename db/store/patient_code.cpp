#include "db/store/patient_code.hpp"

#include "db/store/fold.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

bool is_digit(unsigned point) { return point >= '0' && point <= '9'; }
// ASCII, Latin-1 and Latin Extended-A: those that fold.hpp knows in both cases.
bool is_letter(unsigned point) {
  const bool ascii = (point >= 'A' && point <= 'Z') || (point >= 'a' && point <= 'z');
  return ascii || (point >= 0xC0 && point <= 0x17F && point != 0xD7 && point != 0xF7);
}

// The code point that begins here, of at most two bytes, and 0 for anything else.
unsigned next_point(std::string_view text, std::size_t& at) {
  const auto lead = static_cast<unsigned char>(text[at++]);
  if (lead < 0x80) return lead;
  if (lead < 0xC2 || lead > 0xDF || at == text.size()) return 0;
  const auto next = static_cast<unsigned char>(text[at++]);
  return (next & 0xC0U) == 0x80U ? (lead & 0x1FU) << 6U | (next & 0x3FU) : 0;
}

bool follows_rule(std::string_view code) {
  std::size_t count = 0;
  for (std::size_t at = 0; at < code.size(); ++count) {
    const unsigned point = next_point(code, at);
    const bool sign = point == '.' || point == '_' || point == '-';
    if (!is_letter(point) && !is_digit(point) && (!sign || count == 0)) return false;
  }
  return count >= 1 && count <= kMaxCode_chars;
}

}  // namespace

std::string trimmed_code(std::string_view typed) {
  constexpr std::string_view kBlank = " \t";
  const std::size_t first = typed.find_first_not_of(kBlank);
  if (first == std::string_view::npos) return {};
  return std::string(typed.substr(first, typed.find_last_not_of(kBlank) - first + 1));
}

Status check_code(std::string_view code, const char* field) {
  if (follows_rule(code)) return {};
  return Error{ErrorKind::bad_value, std::string(field) + " must be " + std::string(kCodeRule), field};
}

bool same_code(std::string_view one, std::string_view other) { return folded(one) == folded(other); }

std::string stored_code(sqlite3* handle, std::string_view code) {
  // Files from before the rule may have two of them: the very one comes first.
  Statement row(handle, "SELECT code FROM patients WHERE code_same(code, ?1) ORDER BY code = ?1 DESC, id LIMIT 1");
  return row.text(1, code).step() ? row.text_at(0) : std::string();
}

Result<std::string> code_to_record(sqlite3* handle, std::string_view typed, const char* field) {
  return guarded([&]() -> Result<std::string> {
    std::string code = trimmed_code(typed);
    if (std::string stored = stored_code(handle, code); !stored.empty()) return stored;
    if (const Status checked = check_code(code, field); !checked) return checked.error();
    return code;
  });
}

}  // namespace hoist::db
