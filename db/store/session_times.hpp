// Times of a session in SQL. The steady clock counts within a session; the wall clock may be set while it is recorded, so a difference of two
// of its times is no duration. Each text stands in a statement in which `s` is the session's row; the arguments are expressions of it.
#pragma once
#include <string>
#include <string_view>

namespace hoist::db {

/// Steady time of a step, from the stored chunk before it, else the one after it: steps follow the clock also where some were left out. The
/// session's start when nothing is stored.
std::string time_of_step_sql(std::string_view tick);
/// UTC of a steady time, by the wall clock as it was set at that moment.
std::string utc_of_time_sql(std::string_view time_ns);
/// The day of a UTC time where the recording computer stands, YYYY-MM-DD, as in schema/007_visits.sql.
std::string local_day_sql(std::string_view utc_ns);

}  // namespace hoist::db
