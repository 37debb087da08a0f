#include "server/record/audit_desk.hpp"

#include <string>
#include <utility>

namespace hoist::server {

void AuditDesk::note(db::AuditEntry entry) {
  const std::int64_t utc_ns = entry.utc_ns;
  // Equal but for the time.
  entry.utc_ns = newest_.utc_ns;
  const bool again = entry == newest_ && utc_ns >= newest_.utc_ns && utc_ns - newest_.utc_ns < kSame_ns;
  entry.utc_ns = utc_ns;
  if (again) return;
  newest_ = entry;
  if (waiting_.size() >= kWaitingMost)
    ++dropped_;
  else
    waiting_.push_back(std::move(entry));
  store();
}

void AuditDesk::store() {
  if (storing_ || waiting_.empty()) return;
  const auto work = [entries = waiting_](Records& records) {
    return records.database() != nullptr && db::AuditLog(*records.database()).append(entries).ok();
  };
  storing_ = records_.ask<bool>(work, [this, count = waiting_.size()](bool done) { stored(count, done); });
}

void AuditDesk::stored(std::size_t count, bool done) {
  storing_ = false;
  if (!done) return;
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
  if (dropped_ > 0)
    waiting_.push_back({.utc_ns = newest_.utc_ns,
                        .action = "entries_lost",
                        .result = "done",
                        .detail = R"({"entries":)" + std::to_string(std::exchange(dropped_, 0)) + "}"});
  store();
}

}  // namespace hoist::server
