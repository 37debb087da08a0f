// What people asked of the hoist: rows that are only added.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

struct AuditEntry {
  std::int64_t utc_ns = 0;  ///< when it was asked
  std::optional<Actor> actor = {};
  std::string action;
  std::string result;  ///< done, or why not
  std::optional<SessionId> session = {};
  std::string detail = "{}";  ///< JSON; never a patient code
  bool operator==(const AuditEntry&) const = default;
};
struct StoredAuditEntry {
  std::int64_t id = 0;
  AuditEntry entry;
};
struct AuditPage {
  std::vector<StoredAuditEntry> items;  ///< newest first
  std::optional<std::int64_t> next;     ///< `before` of the next page; absent at the end
};
struct AuditQuery {
  std::size_t limit = 50;  ///< 1 to kMaxPage
  std::optional<std::int64_t> before = {};
};

class AuditLog {
 public:
  explicit AuditLog(Database& database) : database_(&database) {}
  /// All or none, durable when it returns without an error. Errors: busy, disk_full, io.
  Status append(std::span<const AuditEntry> entries);
  Result<AuditPage> list(const AuditQuery& query = {}) const;

 private:
  Database* database_;
};

}  // namespace hoist::db
