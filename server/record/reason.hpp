// What clients are told about an error of the database.
#pragma once
#include "db/store/result.hpp"
#include "server/contract/reasons.hpp"

namespace hoist::server {

constexpr Reason reason_of(db::ErrorKind kind) {
  switch (kind) {
    case db::ErrorKind::not_found:
      return Reason::unknown;
    case db::ErrorKind::bad_value:
      return Reason::invalid;
    case db::ErrorKind::wrong_state:
      return Reason::not_now;
    case db::ErrorKind::changed:
      return Reason::changed_meanwhile;
    case db::ErrorKind::taken:
      return Reason::taken;
    case db::ErrorKind::busy:
      return Reason::busy;
    case db::ErrorKind::disk_full:
      return Reason::disk_full;
    case db::ErrorKind::read_only:
      return Reason::read_only;
    case db::ErrorKind::internal:
      return Reason::internal;
    default:
      return Reason::storage;
  }
}

}  // namespace hoist::server
