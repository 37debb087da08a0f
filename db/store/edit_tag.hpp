// The content of an editable row as a tag. A change names the tag of the row it was made for and is refused when the
// row differs by then. A hash and no counter: equal writes do not conflict, and no column is needed.
#pragma once
#include <array>
#include <cstdio>
#include <initializer_list>
#include <string>
#include <string_view>

#include "control/contract/check.hpp"
#include "db/store/result.hpp"

namespace hoist::db {

/// 16 hexadecimal digits over these texts; their lengths count too.
inline std::string edit_tag(std::initializer_list<std::string_view> content) {
  std::uint64_t hash = contract::kHashStart;
  for (const std::string_view text : content) hash = contract::hash_number(contract::hash_bytes(hash, text), text.size());
  std::array<char, 17> hex{};
  std::snprintf(hex.data(), hex.size(), "%016llx", static_cast<unsigned long long>(hash));
  return hex.data();
}

/// Error `changed` unless `expected` is empty or names the row's tag; several tags have commas between.
inline Status check_tag(std::string_view expected, std::string_view now) {
  if (expected.empty()) return {};
  for (bool more = true; more;) {
    const std::size_t comma = expected.find(',');
    if (expected.substr(0, comma) == now) return {};
    more = comma != std::string_view::npos;
    expected.remove_prefix(more ? comma + 1 : 0);
  }
  return Error{ErrorKind::changed, "it was changed meanwhile: read it again, then change it", {}};
}

}  // namespace hoist::db
