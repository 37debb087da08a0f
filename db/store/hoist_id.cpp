#include "db/store/hoist_id.hpp"

#include <sqlite3.h>

#include <exception>
#include <memory>
#include <string_view>

#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// RFC 9562, version 4: 122 random bits of the operating system.
constexpr const char* kNewId =
    "SELECT lower(hex(randomblob(4)) || '-' || hex(randomblob(2)) || '-4' || substr(hex(randomblob(2)), 2) || '-' || "
    "substr('89ab', 1 + (random() & 3), 1) || substr(hex(randomblob(2)), 2) || '-' || hex(randomblob(6)))";

// An address by which SQLite reads the file alone: no log is replayed or deleted and nothing is made beside it, which may be needed for a repair.
std::string address_of(const std::filesystem::path& file) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string out = "file:";
  for (const char c : file.string()) {
    if (c != '%' && c != '?' && c != '#') {
      out += c;
      continue;
    }
    const auto byte = static_cast<unsigned char>(c);
    ((out += '%') += kDigits[byte >> 4U]) += kDigits[byte & 15U];
  }
  return out + "?immutable=1";
}

}  // namespace

std::string hoist_id(sqlite3* handle) {
  Statement row(handle, "SELECT id FROM hoist");
  return row.step() ? row.text_at(0) : std::string();
}

std::string hoist_id_of(const std::filesystem::path& file) noexcept {
  try {
    sqlite3* opened = nullptr;
    const int code =
        sqlite3_open_v2(address_of(file).c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_URI, nullptr);
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
  // hoist_id_of reads without the log.
  try_execute(handle, "PRAGMA wal_checkpoint(PASSIVE)");
}

}  // namespace hoist::db
