// Patients and their visits: one patient on one day, with several sessions. Both come and go with their sessions, but for patients whom people
// manage (patients.hpp).
#pragma once
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/page.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

struct sqlite3;

namespace hoist::db {

struct Visit {
  std::int64_t id = 0, patient_id = 0;
  std::string patient;  ///< the pseudonymous code
  std::string day;      ///< YYYY-MM-DD where the recording computer stands
};
struct VisitInfo {
  Visit visit;
  std::string note;
  std::vector<SessionId> sessions;  ///< walks, in the order of walk_order.hpp
  std::vector<SessionId> standby;   ///< what was recorded between them
  std::string tag;                  ///< of what people may write (edit_tag.hpp)
};
struct PatientInfo {
  std::int64_t id = 0;
  std::string code;
  bool archived = false, has_identity = false;
  std::uint64_t visits = 0, sessions = 0;
  std::optional<std::string> first_day, last_day;  ///< of the visits; a visit counts with its first walk
  std::string tag;
};
/// Reads; every call is its own read transaction. Errors: bad_value (limit), corrupt, busy, io.
class VisitReader {
 public:
  explicit VisitReader(Database& database) : database_(&database) {}
  /// The visits of these sessions. A session without a patient code has none.
  Result<std::map<SessionId, Visit>> of_sessions(std::span<const SessionId> sessions) const;
  Result<VisitPage<VisitInfo>> visits(const VisitQuery& query = {}) const;
  Result<VisitInfo> visit(std::int64_t visit) const;
  Result<VisitPage<PatientInfo>> patients(const VisitQuery& query = {}) const;

 private:
  Database* database_;
};

/// Inside a write transaction of the store: the visit of a session that began then; patient and visit are made when they are new. Capital and
/// small letters do not tell codes apart.
std::int64_t visit_row(sqlite3* handle, const std::string& code, std::int64_t started_utc_ns);
/// Inside a transaction; nothing when there is no such patient.
std::optional<PatientInfo> patient_row(sqlite3* handle, std::int64_t patient);
/// Removes visits without a session, and patients without a visit who are not registered: a code that was only typed
/// goes with its last session.
void drop_empty_visits(sqlite3* handle);

}  // namespace hoist::db
