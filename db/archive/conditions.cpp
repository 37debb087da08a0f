#include "db/archive/conditions.hpp"

#include <charconv>
#include <chrono>

namespace hoist::db {
namespace {

bool is_uuid(std::string_view text) {
  if (text.size() != 36) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool dash = i == 8 || i == 13 || i == 18 || i == 23;
    if (dash ? c != '-' : !((c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'))) return false;
  }
  return true;
}

bool is_day(std::string_view text) {
  if (text.size() != 10 || text[4] != '-' || text[7] != '-') return false;
  const auto number = [&](std::size_t from, std::size_t size, int& out) {
    const char* begin = text.data() + from;
    return std::from_chars(begin, begin + size, out).ptr == begin + size;
  };
  int year = 0;
  int month = 0;
  int day = 0;
  if (!number(0, 4, year) || !number(5, 2, month) || !number(8, 2, day) || year < 1 || month < 1 || day < 1) return false;
  return std::chrono::year_month_day(std::chrono::year(year), std::chrono::month(static_cast<unsigned>(month)),
                                     std::chrono::day(static_cast<unsigned>(day)))
      .ok();
}

}  // namespace

Status check_query(const ArchiveQuery& query) {
  if (query.uuid && !is_uuid(*query.uuid))
    return Error{ErrorKind::bad_value, "uuid must have the form 01234567-89ab-cdef-0123-456789abcdef", "uuid"};
  if (query.from_day && !is_day(*query.from_day)) return Error{ErrorKind::bad_value, "from must be a day, YYYY-MM-DD", "from"};
  if (query.to_day && !is_day(*query.to_day)) return Error{ErrorKind::bad_value, "to must be a day, YYYY-MM-DD", "to"};
  return {};
}

}  // namespace hoist::db
