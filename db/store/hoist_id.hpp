// The id of a hoist: a random UUID that tells it from every other one, whatever they are called. It is made once and belongs to the machine:
// a backup does not carry it, a restore keeps the present one, and an empty file that replaces a damaged one takes it over (DECISIONS 170).
#pragma once
#include <filesystem>
#include <string>

struct sqlite3;

namespace hoist::db {

/// Of this file; empty when it has none. Throws SqlFailure.
std::string hoist_id(sqlite3* handle);
/// Of a file that no program uses and that may be damaged or older; empty when it has none that can be read. Changes nothing in or beside it.
std::string hoist_id_of(const std::filesystem::path& file) noexcept;
/// Gives this file an id, unless it has one: `id`, or a new one when that is empty.
void ensure_hoist_id(sqlite3* handle, const std::string& id);
/// The file is of this hoist from now on; empty: of none. Inside or outside of a transaction.
void set_hoist_id(sqlite3* handle, const std::string& id);

}  // namespace hoist::db
