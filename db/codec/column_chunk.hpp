// A run of samples as two blobs: a small directory (per column: where it lies, first value, minimum and maximum of the run and of each block)
// and a body (per column: differences, zig-zag, byte planes, zstd level 3 with its checksum).
//
// While recording, all columns share one zstd frame (kOneFrame): one call per commit instead of one per column. Folded chunks have a frame per
// column (kFramePerColumn), so that one column of an hour is read without the others. A column whose values step by a constant costs no body.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "db/codec/bytes.hpp"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace hoist::db {

enum class CodecError : std::uint8_t { none, directory_damaged, directory_unknown_version, body_damaged, no_such_column, zstd_failed };
constexpr const char* codec_error_text(CodecError error) {
  switch (error) {
    case CodecError::none:
      return "ok";
    case CodecError::directory_damaged:
      return "its directory is damaged";
    case CodecError::directory_unknown_version:
      return "its directory has a version this program does not know";
    case CodecError::body_damaged:
      return "its body is damaged";
    case CodecError::no_such_column:
      return "it has no such column";
    case CodecError::zstd_failed:
      break;
  }
  return "zstd failed";
}

enum class ChunkLayout : std::uint8_t { one_frame = 0, frame_per_column = 1 };

/// Limits that also bound what a damaged directory can make us allocate.
inline constexpr std::size_t kMaxChunkSamples = 8192, kMaxChunkColumns = 512;
/// Samples per block, each with its own minimum and maximum: 5 s, so that an hour's overview has 720 points and the blocks cost 0.5 B per sample.
inline constexpr std::size_t kBlockSamples = 500;

struct MinMax {
  std::int64_t min = 0, max = 0;
};

struct ChunkColumn {
  std::uint8_t planes = 0;  ///< bytes per stored difference; 0 = the value steps by `step` each sample (0 = constant)
  std::int64_t first = 0;
  std::int64_t step = 0;  ///< only with planes == 0
  MinMax range;
  std::size_t offset = 0;  ///< of the column's planes: in the body (frame_per_column) or in the unpacked frame (one_frame)
  std::size_t bytes = 0;   ///< length there
};

struct ChunkDirectory {
  ChunkLayout layout = ChunkLayout::one_frame;
  std::size_t samples = 0;
  std::size_t body_bytes = 0;  ///< whole body
  std::vector<ChunkColumn> columns;
  std::vector<MinMax>
      blocks;  ///< block_count() of the first column, then of the next …: one allocation, because an overview reads hundreds
  [[nodiscard]] const MinMax& block(std::size_t column, std::size_t number) const { return blocks[column * block_count() + number]; }
  [[nodiscard]] std::size_t block_count() const { return (samples + kBlockSamples - 1) / kBlockSamples; }
  /// Samples in block number `block`.
  [[nodiscard]] std::size_t block_samples(std::size_t block) const {
    const std::size_t rest = samples - block * kBlockSamples;
    return rest < kBlockSamples ? rest : kBlockSamples;
  }
};

/// Reads a directory blob; every length and count in it is checked against its checksum, the limits above and each other.
[[nodiscard]] CodecError parse_directory(ByteView blob, ChunkDirectory& directory);

struct EncodedChunk {
  Bytes directory, body;
};

/// Keeps its zstd state between calls.
class ChunkEncoder {
 public:
  ChunkEncoder();
  ~ChunkEncoder();
  ChunkEncoder(ChunkEncoder&&) noexcept;
  ChunkEncoder& operator=(ChunkEncoder&&) noexcept;
  /// columns[c] holds `samples` values each (1 to kMaxChunkSamples).
  [[nodiscard]] CodecError encode(std::span<const std::vector<std::int64_t>> columns, std::size_t samples, ChunkLayout layout,
                                  EncodedChunk& out);

 private:
  ZSTD_CCtx_s* context_;
  Bytes planes_, frame_;
};

class ChunkDecoder {
 public:
  ChunkDecoder();
  ~ChunkDecoder();
  ChunkDecoder(ChunkDecoder&&) noexcept;
  ChunkDecoder& operator=(ChunkDecoder&&) noexcept;
  /// One column out of `payload`: with frame_per_column the column's own bytes (body from offset, `bytes` long), with one_frame the whole body.
  /// Columns without planes need no payload. `values` gets directory.samples numbers.
  [[nodiscard]] CodecError column(const ChunkDirectory& directory, std::size_t column, ByteView payload, std::vector<std::int64_t>& values);
  /// Several columns from the whole body; `values` has one vector per asked column.
  [[nodiscard]] CodecError columns(const ChunkDirectory& directory, std::span<const std::size_t> which, ByteView body,
                                   std::vector<std::vector<std::int64_t>>& values);
  /// Whether the whole body can be unpacked, which includes its checksums; no value is rebuilt.
  [[nodiscard]] CodecError check(const ChunkDirectory& directory, ByteView body);

 private:
  [[nodiscard]] CodecError unpack(ByteView frame, std::size_t expected_bytes);
  [[nodiscard]] CodecError unpack_all(const ChunkDirectory& directory, ByteView body);  // of the layout one_frame
  [[nodiscard]] static CodecError rebuild(const ChunkDirectory& directory, std::size_t column, ByteView planes,
                                          std::vector<std::int64_t>& values);
  ZSTD_DCtx_s* context_;
  Bytes planes_;
};

/// Differences of `values` as byte planes (all first bytes, then all second bytes …), appended to `out`. Returns the planes used, 0 to 8;
/// with 0 nothing was appended because every difference equals `step`.
std::uint8_t append_planes(std::span<const std::int64_t> values, Bytes& out, std::int64_t& step);
/// The way back. `planes_bytes` must hold exactly planes * (values.size() - 1) bytes.
bool read_planes(std::uint8_t planes, std::int64_t first, std::int64_t step, ByteView planes_bytes, std::span<std::int64_t> values);

}  // namespace hoist::db
