// One page of a list, for every reader that gives rows newest first.
#pragma once
#include <cstdint>
#include <limits>

#include "db/store/sqlite.hpp"
#include "db/store/visits.hpp"

namespace hoist::db {

/// ?1 = only smaller numbers, ?2 = the limit. Reads one row more than asked, which tells whether a next page exists. `read(row)` makes an
/// item, `id(item)` is its number.
template <typename Item, typename Read, typename Id>
VisitPage<Item> page_of(Statement& rows, const VisitQuery& query, Read read, Id id) {
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
