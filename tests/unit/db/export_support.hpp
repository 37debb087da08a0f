// A recording and its whole export: what the tests of the formats share.
#pragma once
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "db/export/session_export.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db::test {

using contract::TickRecord;

struct Fixture {
  TemporaryFolder dir;
  Database database = std::move(*Database::open(dir / "hoist.db"));
  SessionWriter writer = std::move(*SessionWriter::create(database));
  SessionId id = 0;

  void record(const SessionStart& start, const std::vector<TickRecord>& records) {
    id = *writer.begin(start);
    EXPECT_TRUE(writer.append_ticks(records).ok());
  }
  void end() { EXPECT_TRUE(writer.end(CloseReason::finished, kStartUtc_ns).ok()); }
};

inline std::string whole(Database& database, SessionId id, const ExportOptions& options, std::size_t* largest = nullptr) {
  Result<SessionExport> session_export = SessionExport::open(database, id, options);
  EXPECT_TRUE(session_export.ok());
  std::string all, piece;
  for (;;) {
    const Result<bool> more = session_export->next_chunk(piece);
    EXPECT_TRUE(more.ok()) << (more.ok() ? "" : more.error().message);
    if (!more.ok() || !*more) break;
    if (largest != nullptr) *largest = std::max(*largest, piece.size());
    all += piece;
  }
  EXPECT_FALSE(*session_export->next_chunk(piece)) << "the end stays the end";
  return all;
}

}  // namespace hoist::db::test
