// The network thread's way to the audit: entries wait here until the recorder's thread has stored them.
#pragma once
#include <cstdint>
#include <vector>

#include "db/store/audit.hpp"
#include "server/record/recorder_desk.hpp"

namespace hoist::server {

class AuditDesk {
 public:
  // Entries that wait while the disk refuses. Newer ones are dropped, and counted in an entry of their own.
  static constexpr std::size_t kWaitingMost = 1000;
  // The same once more within this time is one entry: a held STOP key must not fill the disk.
  static constexpr std::int64_t kSame_ns = 1'000'000'000;

  explicit AuditDesk(RecorderDesk& records) : records_(records) {}
  void note(db::AuditEntry entry);
  // Asks once more for what could not be stored; each second is often enough.
  void retry() { store(); }

 private:
  void store();
  void stored(std::size_t count, bool done);

  RecorderDesk& records_;
  std::vector<db::AuditEntry> waiting_;
  db::AuditEntry newest_;
  std::uint64_t dropped_ = 0;
  bool storing_ = false;
};

}  // namespace hoist::server
