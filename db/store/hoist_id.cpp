#include "db/store/hoist_id.hpp"

#include <sqlite3.h>

#include <exception>
#include <memory>

#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// RFC 9562, version 4: 122 random bits of the operating system.
constexpr const char* kNewId =
    "SELECT lower(hex(randomblob(4)) || '-' || hex(randomblob(2)) || '-4' || substr(hex(randomblob(2)), 2) || '-' || "
    "substr('89ab', 1 + (random() & 3), 1) || substr(hex(randomblob(2)), 2) || '-' || hex(randomblob(6)))";

}  // namespace

std::string hoist_id(sqlite3* handle) {
  Statement row(handle, "SELECT id FROM hoist");
  return row.step() ? row.text_at(0) : std::string();
}

std::string hoist_id_of(const std::filesystem::path& file) noexcept {
  try {
    sqlite3* opened = nullptr;
    const int code = sqlite3_open_v2(file.c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
    const std::unique_ptr<sqlite3, decltype(&sqlite3_close_v2)> handle(opened, &sqlite3_close_v2);
    return code == SQLITE_OK ? hoist_id(opened) : std::string();
  } catch (const SqlFailure&) {
    return {};
  } catch (const std::exception&) {
    return {};
  }
}

void set_hoist_id(sqlite3* handle, const std::string& id) {
  execute(handle, "DELETE FROM hoist");
  if (!id.empty()) Statement(handle, "INSERT INTO hoist (id) VALUES (?1)").text(1, std::string_view(id)).run();
}

void ensure_hoist_id(sqlite3* handle, const std::string& id) {
  if (!hoist_id(handle).empty()) return;
  Transaction transaction(handle, Transaction::Kind::write);
  std::string given = id;
  if (given.empty()) {
    Statement fresh(handle, kNewId);
    fresh.step();
    given = fresh.text_at(0);
  }
  set_hoist_id(handle, given);
  transaction.commit();
}

}  // namespace hoist::db
