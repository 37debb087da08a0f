// The deletion of a session in pieces, so that the recorder stores what it has between two of them. SessionEditor::remove does all of it.
#pragma once
#include <string>

#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

struct sqlite3;

namespace hoist::db {

/// Stored blobs that one piece overwrites: some MB at most.
inline constexpr std::size_t kErasedRows = 32;

/// From here on no reader finds the session, also after a power cut. `expected`: the tag of what was looked at, empty = any.
/// Errors: not_found, changed, wrong_state (it is being recorded), busy, disk_full.
Status take_out(Database& database, SessionId session, const std::string& expected = {});
/// Overwrites up to kErasedRows stored blobs of what has been taken out, by whichever run. False once nothing is left and the log is cut.
Result<bool> erase_piece(Database& database);

/// Best effort: the log's content goes into the file, and the log is cut. A reader that is in its way is waited for only briefly, because the
/// recorder cannot commit meanwhile.
void truncate_log(sqlite3* handle) noexcept;

}  // namespace hoist::db
