// Whether a whole file of recordings is sound: what SQLite can tell of its pages, and the checksum of every stored blob.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// So many findings are named; more are counted.
inline constexpr std::size_t kFindingsMost = 10;

struct IntegrityReport {
  std::string file_id;                      ///< Database::file_id() of the file that was checked
  std::vector<std::string> structure;       ///< what SQLite says of pages, tables and indexes; empty = sound
  std::uint64_t blobs = 0;                  ///< stored blobs that were looked at; 0 when the structure is damaged
  std::uint64_t damaged_blobs = 0;          ///< of them, those that cannot be read
  std::vector<SessionId> damaged_sessions;  ///< whose they are, rising
  [[nodiscard]] bool sound() const { return structure.empty() && damaged_blobs == 0; }
};

/// Called before each page and blob with the share that is done, 0 to 1. False ends the check there.
using CheckStep = std::function<bool(double)>;

/// Reads every page and every blob, which takes as long as the disk needs for the whole file. It holds a read transaction while SQLite looks at
/// the pages: the log cannot be truncated meanwhile. Nothing when `step` ended it.
/// Errors: io (the disk could not be read: this says nothing of what is stored), busy, internal.
Result<std::optional<IntegrityReport>> check_integrity(Database& database, const CheckStep& step);

}  // namespace hoist::db
