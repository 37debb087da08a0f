// Walks the stored chunks of one session and unpacks columns. The common ground of reader, export, metrics and folding.
// Throws SqlFailure (inside db only); a damaged blob becomes ErrorKind::corrupt with session and tick in its sentence.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "db/codec/column_chunk.hpp"
#include "db/store/session_types.hpp"
#include "db/store/sqlite.hpp"

struct sqlite3_blob;

namespace hoist::db {

struct StoredChunk {
  std::int64_t row = 0;
  std::uint64_t first_tick = 0, last_tick = 0;
  std::uint64_t first_time_ns = 0, last_time_ns = 0;
  ChunkDirectory directory;
};

class ChunkSource {
 public:
  ChunkSource(sqlite3* handle, SessionId session, std::size_t column_count);
  ~ChunkSource();
  ChunkSource(const ChunkSource&) = delete;
  ChunkSource& operator=(const ChunkSource&) = delete;

  /// The chunk that holds `tick`, or the first one after it; absent at the end. Asked by tick and not by row, because folding may replace
  /// rows between two calls.
  std::optional<StoredChunk> at_or_after(std::uint64_t tick);
  /// Columns of that chunk; values[i] belongs to which[i].
  void load(const StoredChunk& chunk, std::span<const std::size_t> which, std::vector<std::vector<std::int64_t>>& values);
  /// Where samples with last_time_ns >= time_ns begin: the first tick of that chunk.
  std::optional<std::uint64_t> first_tick_from_time(std::uint64_t time_ns);

 private:
  StoredChunk row_of(Statement& statement) const;
  [[noreturn]] void damaged(std::uint64_t first_tick, CodecError error) const;
  [[noreturn]] void gone(std::uint64_t first_tick) const;

  sqlite3* handle_;
  SessionId session_;
  std::size_t column_count_;
  Statement before_, after_, body_;
  sqlite3_blob* blob_ = nullptr;
  ChunkDecoder decoder_;
  Bytes payload_;
};

/// Position of a column, or absent.
std::optional<std::size_t> find_column(std::span<const ColumnInfo> layout, std::string_view name);
/// Whether the samples just before this tick are noted as missing: of the session's first sample only the gap's row can tell.
bool gap_ends_before(sqlite3* handle, SessionId session, std::uint64_t tick);
/// 10^decimals; a stored integer divided by it is the value, correctly rounded, as if the printed decimal had been read.
double decimal_scale(int decimals);

}  // namespace hoist::db
