// The order of a patient's walks in time. Numbers are no such order: a session that an archive brings back gets a later one than all that were
// recorded here before.
#pragma once
#include <compare>
#include <cstdint>
#include <string>

#include "db/store/session_types.hpp"

namespace hoist::db {

/// Earlier walks are smaller.
struct WalkOrder {
  std::string day;  ///< of the visit
  std::int64_t started_utc_ns = 0;
  SessionId session = 0;
  auto operator<=>(const WalkOrder&) const = default;
};

}  // namespace hoist::db
