#include "db/store/chunk_source.hpp"

#include <sqlite3.h>

#include <array>

namespace hoist::db {
namespace {
constexpr std::size_t kFewColumns = 12;  // up to here single reads beat reading the whole body
constexpr const char* kColumns =
    "SELECT id, first_tick, last_tick, first_time_ns, last_time_ns, directory FROM chunks WHERE session_id = ?1 ";
}  // namespace

ChunkSource::ChunkSource(sqlite3* handle, SessionId session, std::size_t column_count)
    : handle_(handle),
      session_(session),
      column_count_(column_count),
      before_(handle, std::string(kColumns) + "AND first_tick <= ?2 ORDER BY first_tick DESC LIMIT 1"),
      after_(handle, std::string(kColumns) + "AND first_tick > ?2 ORDER BY first_tick LIMIT 1"),
      body_(handle, "SELECT body FROM chunks WHERE id = ?1") {}
ChunkSource::~ChunkSource() { sqlite3_blob_close(blob_); }

void ChunkSource::damaged(std::uint64_t first_tick, CodecError error) const {
  throw SqlFailure{Error{
      ErrorKind::corrupt,
      "session " + std::to_string(session_) + ", chunk of samples from tick " + std::to_string(first_tick) + ": " + codec_error_text(error),
      {}}};
}
void ChunkSource::gone(std::uint64_t first_tick) const {
  throw SqlFailure{
      Error{ErrorKind::not_found,
            "session " + std::to_string(session_) + ", samples from tick " + std::to_string(first_tick) + ": deleted meanwhile",
            {}}};
}

StoredChunk ChunkSource::row_of(Statement& statement) const {
  StoredChunk chunk;
  chunk.row = statement.integer_at(0);
  chunk.first_tick = statement.unsigned_at(1);
  chunk.last_tick = statement.unsigned_at(2);
  chunk.first_time_ns = statement.unsigned_at(3);
  chunk.last_time_ns = statement.unsigned_at(4);
  const CodecError error = parse_directory(statement.blob_at(5), chunk.directory);
  if (error != CodecError::none) damaged(chunk.first_tick, error);
  if (chunk.directory.columns.size() != column_count_) damaged(chunk.first_tick, CodecError::directory_damaged);
  return chunk;
}

std::optional<StoredChunk> ChunkSource::at_or_after(std::uint64_t tick) {
  std::optional<StoredChunk> found;
  before_.reset();
  if (before_.integer(1, session_).unsigned_integer(2, tick).step() && before_.unsigned_at(2) >= tick) found = row_of(before_);
  before_.reset();
  if (found) return found;
  after_.reset();
  if (after_.integer(1, session_).unsigned_integer(2, tick).step()) found = row_of(after_);
  after_.reset();
  return found;
}

std::optional<std::uint64_t> ChunkSource::first_tick_from_time(std::uint64_t time_ns) {
  Statement statement(handle_, "SELECT first_tick FROM chunks WHERE session_id = ?1 AND last_time_ns >= ?2 ORDER BY first_tick LIMIT 1");
  if (!statement.integer(1, session_).unsigned_integer(2, time_ns).step()) return std::nullopt;
  return statement.unsigned_at(0);
}

void ChunkSource::load(const StoredChunk& chunk, std::span<const std::size_t> which, std::vector<std::vector<std::int64_t>>& values) {
  if (chunk.directory.layout == ChunkLayout::frame_per_column && which.size() <= kFewColumns) {
    values.resize(which.size());
    // One body is open at a time; moving the handle to another row is cheaper than opening a new one.
    const int code = blob_ == nullptr ? sqlite3_blob_open(handle_, "main", "chunks", "body", chunk.row, 0, &blob_)
                                      : sqlite3_blob_reopen(blob_, chunk.row);
    if (code != SQLITE_OK) {
      sqlite3_blob_close(blob_);
      blob_ = nullptr;
      if (code == SQLITE_ERROR) gone(chunk.first_tick);
      throw_sql(handle_, code, "reading samples");
    }
    if (static_cast<std::size_t>(sqlite3_blob_bytes(blob_)) != chunk.directory.body_bytes)
      damaged(chunk.first_tick, CodecError::body_damaged);
    for (std::size_t i = 0; i < which.size(); ++i) {
      if (which[i] >= chunk.directory.columns.size()) damaged(chunk.first_tick, CodecError::no_such_column);
      const ChunkColumn& column = chunk.directory.columns[which[i]];
      payload_.resize(column.bytes);
      if (column.bytes > 0) {
        const int read = sqlite3_blob_read(blob_, payload_.data(), static_cast<int>(column.bytes), static_cast<int>(column.offset));
        if (read != SQLITE_OK) throw_sql(handle_, read, "reading samples");
      }
      if (const CodecError error = decoder_.column(chunk.directory, which[i], payload_, values[i]); error != CodecError::none)
        damaged(chunk.first_tick, error);
    }
    return;
  }
  body_.reset();
  if (!body_.integer(1, chunk.row).step()) gone(chunk.first_tick);
  const CodecError error = decoder_.columns(chunk.directory, which, body_.blob_at(0), values);
  body_.reset();
  if (error != CodecError::none) damaged(chunk.first_tick, error);
}

std::optional<std::size_t> find_column(std::span<const ColumnInfo> layout, std::string_view name) {
  for (std::size_t i = 0; i < layout.size(); ++i)
    if (layout[i].name == name) return i;
  return std::nullopt;
}

bool gap_ends_before(sqlite3* handle, SessionId session, std::uint64_t tick) {
  if (tick == 0) return false;
  Statement row(handle, "SELECT 1 FROM gaps WHERE session_id = ?1 AND stream = 'ticks' AND to_tick = ?2");
  return row.integer(1, session).unsigned_integer(2, tick - 1).step();
}

double decimal_scale(int decimals) {
  static constexpr std::array kScale{1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15};
  return kScale[static_cast<std::size_t>(decimals) % kScale.size()];
}

}  // namespace hoist::db
