#include "db/store/integrity.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "db/codec/bytes.hpp"
#include "db/codec/column_chunk.hpp"
#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

// The pages take this share of the progress, the blobs the rest.
constexpr double kPagesShare = 0.5;

// Sees each read of the file by one connection. SQLite 3.40 looks neither at an interrupt nor at its progress handler while it checks the pages
// of a table; a read that fails is the only way to end that, and the bytes read are the only progress.
class ReadWatch {
 public:
  ReadWatch(sqlite3* handle, const CheckStep& step, double file_bytes) : step_(step), file_bytes_(std::max(file_bytes, 1.0)) {
    sqlite3_file_control(handle, "main", SQLITE_FCNTL_FILE_POINTER, &file_);
    original_ = file_->pMethods;
    methods_ = *original_;
    methods_.xRead = &read;
    file_->pMethods = &methods_;
    current_ = this;
  }
  ~ReadWatch() {
    file_->pMethods = original_;
    current_ = nullptr;
  }
  ReadWatch(const ReadWatch&) = delete;
  ReadWatch& operator=(const ReadWatch&) = delete;
  [[nodiscard]] bool stopped() const { return stopped_; }
  [[nodiscard]] bool failed() const { return failed_; }

 private:
  static int read(sqlite3_file* file, void* to, int bytes, sqlite3_int64 at) {
    ReadWatch& watch = *current_;
    watch.bytes_ += bytes;
    watch.stopped_ = watch.stopped_ || !watch.step_(kPagesShare * std::min(1.0, watch.bytes_ / watch.file_bytes_));
    if (watch.stopped_) return SQLITE_IOERR_READ;
    const int code = watch.original_->xRead(file, to, bytes, at);
    watch.failed_ = watch.failed_ || (code != SQLITE_OK && code != SQLITE_IOERR_SHORT_READ);
    return code;
  }

  // A connection belongs to one thread, and so does its check.
  static thread_local ReadWatch* current_;
  const CheckStep& step_;
  double file_bytes_, bytes_ = 0;
  sqlite3_file* file_ = nullptr;
  const sqlite3_io_methods* original_ = nullptr;
  sqlite3_io_methods methods_{};
  bool stopped_ = false, failed_ = false;
};
thread_local ReadWatch* ReadWatch::current_ = nullptr;

// False when it was ended.
bool check_pages(sqlite3* handle, const CheckStep& step, IntegrityReport& report) {
  const auto file_bytes =
      static_cast<double>(number_of(handle, "PRAGMA page_count")) * static_cast<double>(number_of(handle, "PRAGMA page_size"));
  const ReadWatch watch(handle, step, file_bytes);
  try {
    Statement check(handle, "PRAGMA integrity_check(" + std::to_string(kFindingsMost) + ")");
    while (check.step()) {
      std::string finding = check.text_at(0);
      // The first ones come in one row, below a heading.
      if (finding.starts_with("*** in database main ***\n")) finding.erase(0, finding.find('\n') + 1);
      if (finding != "ok") report.structure.push_back(std::move(finding));
    }
  } catch (SqlFailure& failure) {
    if (!watch.stopped() && !watch.failed() && failure.error.kind != ErrorKind::corrupt) throw;
    report.structure.push_back(failure.error.message);
  }
  if (watch.stopped()) return false;
  if (watch.failed()) throw SqlFailure{Error{ErrorKind::io, "the disk could not be read while the database was checked", {}}};
  return true;
}

// Every table with its columns, every index and trigger.
std::vector<std::string> names_of(sqlite3* handle) {
  std::vector<std::string> names;
  Statement row(handle,
                "SELECT object.type, object.name, ifnull(part.name, ''), ifnull(part.type, '') FROM sqlite_schema AS object "
                "LEFT JOIN pragma_table_info(object.name) AS part WHERE object.name NOT LIKE 'sqlite_%' ORDER BY 1, 2, 3");
  while (row.step()) names.push_back(row.text_at(0) + " " + row.text_at(1) + " " + row.text_at(2) + " " + row.text_at(3));
  return names;
}

// Made once: applying the whole schema takes longer than the rest of the check of a small file.
const std::vector<std::string>& names_of_new_file() {
  static const std::vector<std::string> names = [] {
    Result<Database> fresh = Database::create_copy(":memory:");
    if (!fresh) throw SqlFailure{fresh.error()};
    if (const Status made = fresh->migrate(); !made) throw SqlFailure{made.error()};
    return names_of(fresh->handle());
  }();
  return names;
}

// A damaged letter in a name leaves every page well formed, and our statements without their table or column. A backup may have an older schema;
// that one is compared when it has been brought up to date.
void check_names(sqlite3* handle, IntegrityReport& report) {
  if (number_of(handle, "PRAGMA user_version") != schema_version()) return;
  const std::vector<std::string> found = names_of(handle);
  std::vector<std::string> missing;
  std::ranges::set_difference(names_of_new_file(), found, std::back_inserter(missing));
  for (const std::string& name : missing) report.structure.push_back("the schema has no " + name);
}

bool samples_readable(Statement& row, ChunkDecoder& decoder) {
  ChunkDirectory directory;
  return parse_directory(row.blob_at(2), directory) == CodecError::none && decoder.check(directory, row.blob_at(3)) == CodecError::none;
}

struct BlobTable {
  std::string_view name, columns;
};
constexpr std::array kBlobTables{BlobTable{"chunks", "directory, body"}, BlobTable{"bus_chunks", "body"},
                                 BlobTable{"journal_chunks", "body"}, BlobTable{"core_images", "body"}};

// One row at a time, so that no transaction stays open. Rows that are added meanwhile belong to the next check.
bool check_blobs(sqlite3* handle, const BlobTable& table, double from, const CheckStep& step, IntegrityReport& report) {
  const std::string name(table.name);
  // A backup may be older than the table.
  if (number_of(handle, "SELECT count(*) FROM sqlite_schema WHERE name = '" + name + "'") == 0) return true;
  const std::int64_t last = number_of(handle, "SELECT max(id) FROM " + name);
  Statement row(
      handle, "SELECT id, session_id, " + std::string(table.columns) + " FROM " + name + " WHERE id > ?1 AND id <= ?2 ORDER BY id LIMIT 1");
  const bool samples = table.name == "chunks";
  ChunkDecoder decoder;
  for (std::int64_t id = 0;;) {
    const double share = last > 0 ? static_cast<double>(id) / static_cast<double>(last) : 1.0;
    row.reset();
    if (!step(from + (1.0 - kPagesShare) / static_cast<double>(kBlobTables.size()) * share)) return false;
    if (!row.integer(1, id).integer(2, last).step()) return true;
    id = row.integer_at(0);
    ++report.blobs;
    if (samples ? samples_readable(row, decoder) : without_checksum(row.blob_at(2)).has_value()) continue;
    ++report.damaged_blobs;
    const SessionId session = row.integer_at(1);
    auto& known = report.damaged_sessions;
    const auto at = std::ranges::lower_bound(known, session);
    if (at == known.end() || *at != session) known.insert(at, session);
  }
}

}  // namespace

Result<std::optional<IntegrityReport>> check_integrity(Database& database, const CheckStep& step) {
  return guarded([&]() -> Result<std::optional<IntegrityReport>> {
    IntegrityReport report;
    report.file_id = database.file_id();
    sqlite3* handle = database.handle();
    if (!check_pages(handle, step, report)) return std::optional<IntegrityReport>{};
    if (report.structure.empty()) check_names(handle, report);
    if (!report.structure.empty()) return std::optional(std::move(report));
    double from = kPagesShare;
    for (const BlobTable& table : kBlobTables) {
      if (!check_blobs(handle, table, from, step, report)) return std::optional<IntegrityReport>{};
      from += (1.0 - kPagesShare) / static_cast<double>(kBlobTables.size());
    }
    return std::optional(std::move(report));
  });
}

}  // namespace hoist::db
