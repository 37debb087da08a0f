#include "db/store/identity.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// SQLite's file format: 100 bytes of header, the application id as a big-endian number at 68; the log's own header has 32 bytes.
constexpr std::size_t kHeader_bytes = 100, kApplicationIdAt = 68;
constexpr std::uintmax_t kLogHeader_bytes = 32;
constexpr std::string_view kSqliteMagic{"SQLite format 3\0", 16};

std::uintmax_t size_of(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  return error ? 0 : size;
}

/// The first bytes, read through SQLite: a descriptor of our own would, when it is closed, drop every lock that this process holds on the file
/// (POSIX), and the next program that closes the file would take the log away from under our recorder. SQLite closes it when the locks are gone.
/// Opened for reading and without a statement, it changes nothing. Nothing: the file cannot be opened.
std::optional<std::string> first_bytes(const std::filesystem::path& file) {
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(file.c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
  const std::unique_ptr<sqlite3, decltype(&sqlite3_close_v2)> handle(opened, &sqlite3_close_v2);
  sqlite3_file* inside = nullptr;
  if (code != SQLITE_OK || sqlite3_file_control(opened, "main", SQLITE_FCNTL_FILE_POINTER, static_cast<void*>(&inside)) != SQLITE_OK ||
      inside == nullptr || inside->pMethods == nullptr)
    return std::nullopt;
  std::string bytes(static_cast<std::size_t>(std::min<std::uintmax_t>(size_of(file), kHeader_bytes)), '\0');
  if (inside->pMethods->xRead(inside, bytes.data(), static_cast<int>(bytes.size()), 0) != SQLITE_OK) return std::nullopt;
  return bytes;
}

std::int64_t id_in(std::string_view header) {
  std::int64_t id = 0;
  for (const char byte : header.substr(kApplicationIdAt, 4)) id = id << 8 | static_cast<unsigned char>(byte);
  return id;
}

// A database without an application id: an older one of ours, an empty one, or one of another program.
Identified by_tables(const std::filesystem::path& file) {
  sqlite3* opened = nullptr;
  const int code = sqlite3_open_v2(file.c_str(), &opened, SQLITE_OPEN_READONLY | SQLITE_OPEN_NOMUTEX, nullptr);
  const std::unique_ptr<sqlite3, decltype(&sqlite3_close_v2)> handle(opened, &sqlite3_close_v2);
  const Identified foreign{FileIdentity::foreign, "is a database of another program"};
  if (code != SQLITE_OK) return foreign;
  try {
    Statement statement(opened, "SELECT count(*), sum(name IN ('sessions', 'column_layout', 'chunks')) FROM sqlite_master");
    if (!statement.step()) return foreign;
    if (statement.integer_at(0) == 0) return {FileIdentity::fresh, {}};
    return statement.integer_at(1) == 3 ? Identified{} : foreign;
  } catch (const SqlFailure&) {
    return foreign;
  }
}

}  // namespace

std::optional<std::int64_t> application_id(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored)) return std::nullopt;
  const std::optional<std::string> bytes = first_bytes(file);
  if (!bytes || bytes->size() < kHeader_bytes || !bytes->starts_with(kSqliteMagic)) return std::nullopt;
  return id_in(*bytes);
}

Identified identify(const std::filesystem::path& file) {
  if (size_of(file) == 0) {
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored)) return {};
    if (size_of(file.string() + "-wal") > kLogHeader_bytes) return {FileIdentity::damaged, "the file is empty or gone, its log is not"};
    return {FileIdentity::fresh, {}};
  }
  const std::optional<std::string> bytes_read = first_bytes(file);
  if (!bytes_read) return {};  // opening it says what the system has against it
  const std::string_view bytes = *bytes_read;
  if (std::ranges::all_of(bytes, [](char byte) { return byte == 0; })) return {FileIdentity::damaged, "the file begins with zeros"};
  const std::size_t magic = std::min(bytes.size(), kSqliteMagic.size());
  if (bytes.substr(0, magic) != kSqliteMagic.substr(0, magic)) return {FileIdentity::foreign, "is no database"};
  if (bytes.size() < kHeader_bytes) return {FileIdentity::damaged, "the file is cut in its first bytes"};
  const std::int64_t id = id_in(bytes);
  if (id == kApplicationId) return {};
  return id == 0 ? by_tables(file) : Identified{FileIdentity::foreign, "is a database of another program"};
}

}  // namespace hoist::db
