#include "db/store/session_times.hpp"

#include "control/contract/step_line.hpp"

namespace hoist::db {

std::string time_of_step_sql(std::string_view tick) {
  const std::string step(tick), period = std::to_string(contract::kStepPeriod_ns);
  const std::string time =
      "(SELECT first_time_ns + (" + step + " - first_tick) * " + period + " FROM chunks WHERE session_id = s.id AND first_tick ";
  return "coalesce(" + time + "<= " + step + " ORDER BY first_tick DESC LIMIT 1), " + time + "> " + step +
         " ORDER BY first_tick LIMIT 1), s.start_time_ns)";
}

std::string utc_of_time_sql(std::string_view time_ns) {
  const std::string time(time_ns);
  return "(" + time + " + coalesce((SELECT anchor.utc_ns - anchor.time_ns FROM utc_anchors AS anchor WHERE anchor.session_id = s.id AND " +
         "anchor.time_ns > s.start_time_ns AND anchor.time_ns <= " + time +
         " ORDER BY anchor.time_ns DESC LIMIT 1), s.started_utc_ns - s.start_time_ns))";
}

std::string local_day_sql(std::string_view utc_ns) { return "date(" + std::string(utc_ns) + " / 1000000000, 'unixepoch', 'localtime')"; }

}  // namespace hoist::db
