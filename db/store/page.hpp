// One page of a list, for every reader that gives rows newest first.
#pragma once
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace hoist::db {

/// Newest first; `next` is the `before` of the next page, absent at the end.
template <typename Item>
struct VisitPage {
  std::vector<Item> items;
  std::optional<std::int64_t> next;
};
struct VisitQuery {
  std::size_t limit = 50;                       ///< 1 to kMaxPage
  std::optional<std::int64_t> before = {};      ///< only those with a smaller number
  std::optional<std::int64_t> patient_id = {};  ///< visits of this patient only
  std::optional<std::string> day = {};          ///< visits of this day only
  std::optional<std::string> code_part = {};    ///< patients whose code contains this, capital or small
  std::optional<bool> archived = {};            ///< only patients that are, or are not
};

/// ?1 = only smaller numbers, ?2 = the limit. Reads one row more than asked, which tells whether a next page exists. `read(row)` makes an
/// item, `id(item)` is its number.
template <typename Item, typename Rows, typename Read, typename Id>
VisitPage<Item> page_of(Rows& rows, const VisitQuery& query, Read read, Id id) {
  rows.integer(1, query.before.value_or(std::numeric_limits<std::int64_t>::max())).unsigned_integer(2, query.limit + 1);
  VisitPage<Item> page;
  while (rows.step()) {
    if (page.items.size() == query.limit) {
      page.next = id(page.items.back());
      break;
    }
    page.items.push_back(read(rows));
  }
  return page;
}

}  // namespace hoist::db
