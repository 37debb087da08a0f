// Which sessions of the archive, and the same as SQL.
#pragma once
#include <optional>
#include <string>
#include <string_view>

#include "db/store/result.hpp"

namespace hoist::db {

/// Which sessions; every member that is set must match.
struct ArchiveQuery {
  std::optional<std::string> uuid = {};
  std::optional<std::string> patient = {};                ///< the code
  std::optional<std::string> device = {};                 ///< the name under which it was pushed, or the hoist's id
  std::optional<std::string> from_day = {}, to_day = {};  ///< YYYY-MM-DD of the start in UTC, both inclusive
};

/// FROM and WHERE with $1 uuid, $2 patient, $3 device, $4 and $5 first and last day.
inline constexpr std::string_view kMatching =
    " FROM sessions LEFT JOIN visits ON visits.id = visit_id LEFT JOIN patients ON patients.id = patient_id"
    " WHERE ($1::uuid IS NULL OR uuid = $1::uuid) AND ($2::text IS NULL OR lower(code) = lower($2)) AND ($3::text IS NULL OR device = $3 "
    "OR hoist_id = $3)"
    " AND ($4::date IS NULL OR (to_timestamp(started_utc_ns / 1000000000) AT TIME ZONE 'UTC')::date >= $4::date)"
    " AND ($5::date IS NULL OR (to_timestamp(started_utc_ns / 1000000000) AT TIME ZONE 'UTC')::date <= $5::date)";

/// bad_value with the field's name for values that PostgreSQL would refuse with a message of its own.
Status check_query(const ArchiveQuery& query);

}  // namespace hoist::db
