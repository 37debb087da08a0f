#include "db/codec/column_chunk.hpp"

#include <zstd.h>

#include <algorithm>
#include <utility>

namespace hoist::db {
namespace {

constexpr std::uint8_t kColumnMagic = 0x48;  // 'H'
constexpr std::uint8_t kColumnVersion = 1;
// Measured on walking data: level 9 wins 1.5 % for 2.5 times the time.
constexpr int kLevel = 3;

void write_directory(std::span<const std::vector<std::int64_t>> columns, const ChunkDirectory& directory, Bytes& out) {
  out.clear();
  out.push_back(kColumnMagic);
  out.push_back(kColumnVersion);
  out.push_back(static_cast<std::uint8_t>(directory.layout));
  put_varint(out, directory.columns.size());
  put_varint(out, directory.samples);
  put_varint(out, directory.body_bytes);
  const std::size_t blocks = directory.block_count();
  for (std::size_t c = 0; c < directory.columns.size(); ++c) {
    const ChunkColumn& column = directory.columns[c];
    out.push_back(column.planes);
    put_varint(out, zigzag(column.first));
    if (column.planes == 0) {
      put_varint(out, zigzag(column.step));
      continue;
    }
    const std::span<const std::int64_t> values(columns[c].data(), directory.samples);
    const auto [low, high] = std::ranges::minmax(values);
    put_varint(out, zigzag(wrapping_difference(low, column.first)));
    put_varint(out, static_cast<std::uint64_t>(wrapping_difference(high, low)));
    if (directory.layout == ChunkLayout::frame_per_column) put_varint(out, column.bytes);
    if (blocks < 2) continue;
    for (std::size_t b = 0; b < blocks; ++b) {
      const auto [block_low, block_high] = std::ranges::minmax(values.subspan(b * kBlockSamples, directory.block_samples(b)));
      put_varint(out, static_cast<std::uint64_t>(wrapping_difference(block_low, low)));
      put_varint(out, static_cast<std::uint64_t>(wrapping_difference(block_high, block_low)));
    }
  }
  put_u32(out, crc32(out));
}

// Extremes of `first + i * step` over samples [from, to). Wrapping columns are never linear over a chunk that matters, so ends suffice.
MinMax linear_range(const ChunkColumn& column, std::size_t from, std::size_t to) {
  const auto at = [&](std::size_t i) {
    return static_cast<std::int64_t>(static_cast<std::uint64_t>(column.first) +
                                     static_cast<std::uint64_t>(column.step) * static_cast<std::uint64_t>(i));
  };
  const std::int64_t a = at(from), b = at(to - 1);
  return {std::min(a, b), std::max(a, b)};
}

}  // namespace

std::uint8_t append_planes(std::span<const std::int64_t> values, Bytes& out, std::int64_t& step) {
  step = values.size() > 1 ? wrapping_difference(values[1], values[0]) : 0;
  bool linear = true;
  std::uint64_t all = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const std::int64_t d = wrapping_difference(values[i], values[i - 1]);
    linear &= d == step;
    all |= zigzag(d);
  }
  if (linear) return 0;
  step = 0;
  std::uint8_t planes = 0;
  for (; all != 0; all >>= 8) ++planes;
  const std::size_t count = values.size() - 1, begin = out.size();
  out.resize(begin + count * planes);
  std::uint8_t* to = out.data() + begin;
  for (std::size_t i = 0; i < count; ++i) {
    std::uint64_t z = zigzag(wrapping_difference(values[i + 1], values[i]));
    for (std::size_t p = 0; p < planes; ++p, z >>= 8) to[p * count + i] = static_cast<std::uint8_t>(z);
  }
  return planes;
}

bool read_planes(std::uint8_t planes, std::int64_t first, std::int64_t step, ByteView planes_bytes, std::span<std::int64_t> values) {
  if (values.empty() || planes > 8) return false;
  std::int64_t value = first;
  values[0] = value;
  const std::size_t count = values.size() - 1;
  if (planes == 0) {
    for (std::size_t i = 1; i < values.size(); ++i) values[i] = value = wrapping_sum(value, step);
    return planes_bytes.empty();
  }
  if (planes_bytes.size() != count * planes) return false;
  // The usual widths get their own loops: this is what an export spends its time in.
  const std::uint8_t* p = planes_bytes.data();
  switch (planes) {
    case 1:
      for (std::size_t i = 0; i < count; ++i) values[i + 1] = value = wrapping_sum(value, unzigzag(p[i]));
      break;
    case 2:
      for (std::size_t i = 0; i < count; ++i)
        values[i + 1] = value = wrapping_sum(value, unzigzag(p[i] | static_cast<std::uint64_t>(p[count + i]) << 8));
      break;
    default:
      for (std::size_t i = 0; i < count; ++i) {
        std::uint64_t z = 0;
        for (std::size_t k = 0; k < planes; ++k) z |= static_cast<std::uint64_t>(p[k * count + i]) << (8 * k);
        values[i + 1] = value = wrapping_sum(value, unzigzag(z));
      }
  }
  return true;
}

CodecError parse_directory(ByteView blob, ChunkDirectory& directory) {
  directory = {};
  const auto content = without_checksum(blob);
  if (!content) return CodecError::directory_damaged;
  ByteReader in(*content);
  if (in.u8() != kColumnMagic) return CodecError::directory_damaged;
  if (in.u8() != kColumnVersion) return CodecError::directory_unknown_version;
  const std::uint8_t layout = in.u8();
  const std::uint64_t columns = in.varint(), samples = in.varint(), body_bytes = in.varint();
  if (!in.ok() || layout > 1 || columns == 0 || columns > kMaxChunkColumns || samples == 0 || samples > kMaxChunkSamples)
    return CodecError::directory_damaged;
  directory.layout = static_cast<ChunkLayout>(layout);
  directory.samples = samples;
  directory.body_bytes = body_bytes;
  directory.columns.resize(columns);
  const std::size_t blocks = directory.block_count();
  directory.blocks.resize(columns * blocks);
  MinMax* block = directory.blocks.data();
  std::size_t offset = 0;
  for (ChunkColumn& column : directory.columns) {
    column.planes = in.u8();
    column.first = in.signed_varint();
    column.offset = offset;
    if (column.planes > 8) return CodecError::directory_damaged;
    if (column.planes == 0) {
      column.step = in.signed_varint();
      column.range = linear_range(column, 0, samples);
      for (std::size_t b = 0; b < blocks; ++b)
        *block++ =
            column.step == 0 ? column.range : linear_range(column, b * kBlockSamples, b * kBlockSamples + directory.block_samples(b));
      continue;
    }
    column.range.min = wrapping_sum(column.first, in.signed_varint());
    column.range.max = wrapping_sum(column.range.min, static_cast<std::int64_t>(in.varint()));
    column.bytes = directory.layout == ChunkLayout::frame_per_column ? in.varint() : column.planes * (samples - 1);
    if (blocks < 2) {
      *block++ = column.range;
    } else {
      for (std::size_t b = 0; b < blocks; ++b) {
        const std::int64_t low = wrapping_sum(column.range.min, static_cast<std::int64_t>(in.varint()));
        *block++ = {low, wrapping_sum(low, static_cast<std::int64_t>(in.varint()))};
      }
    }
    if (!in.ok()) return CodecError::directory_damaged;
    if (directory.layout == ChunkLayout::frame_per_column && (column.bytes > body_bytes || offset > body_bytes - column.bytes))
      return CodecError::directory_damaged;
    offset += column.bytes;
  }
  if (!in.ok() || in.left() != 0) return CodecError::directory_damaged;
  if (directory.layout == ChunkLayout::frame_per_column && offset != body_bytes) return CodecError::directory_damaged;
  return CodecError::none;
}

ChunkEncoder::ChunkEncoder() : context_(ZSTD_createCCtx()) {
  if (context_ == nullptr) return;
  ZSTD_CCtx_setParameter(context_, ZSTD_c_compressionLevel, kLevel);
  ZSTD_CCtx_setParameter(context_, ZSTD_c_checksumFlag, 1);
}
ChunkEncoder::~ChunkEncoder() { ZSTD_freeCCtx(context_); }
ChunkEncoder::ChunkEncoder(ChunkEncoder&& other) noexcept
    : context_(std::exchange(other.context_, nullptr)), planes_(std::move(other.planes_)), frame_(std::move(other.frame_)) {}
ChunkEncoder& ChunkEncoder::operator=(ChunkEncoder&& other) noexcept {
  std::swap(context_, other.context_);
  planes_.swap(other.planes_);
  frame_.swap(other.frame_);
  return *this;
}

CodecError ChunkEncoder::encode(std::span<const std::vector<std::int64_t>> columns, std::size_t samples, ChunkLayout layout,
                                EncodedChunk& out) {
  if (context_ == nullptr) return CodecError::zstd_failed;
  if (columns.empty() || columns.size() > kMaxChunkColumns || samples == 0 || samples > kMaxChunkSamples) return CodecError::no_such_column;
  ChunkDirectory directory;
  directory.layout = layout;
  directory.samples = samples;
  directory.columns.resize(columns.size());
  out.body.clear();
  planes_.clear();
  const auto pack = [&]() -> std::size_t {
    frame_.resize(ZSTD_compressBound(planes_.size()));
    const std::size_t n = ZSTD_compress2(context_, frame_.data(), frame_.size(), planes_.data(), planes_.size());
    if (ZSTD_isError(n) != 0) return 0;
    out.body.insert(out.body.end(), frame_.begin(), frame_.begin() + static_cast<std::ptrdiff_t>(n));
    return n;
  };
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (columns[c].size() < samples) return CodecError::no_such_column;
    ChunkColumn& column = directory.columns[c];
    const std::span<const std::int64_t> values(columns[c].data(), samples);
    column.first = values[0];
    if (layout == ChunkLayout::frame_per_column) planes_.clear();
    column.planes = append_planes(values, planes_, column.step);
    if (column.planes == 0 || layout == ChunkLayout::one_frame) continue;
    column.bytes = pack();
    if (column.bytes == 0) return CodecError::zstd_failed;
  }
  if (layout == ChunkLayout::one_frame && !planes_.empty() && pack() == 0) return CodecError::zstd_failed;
  directory.body_bytes = out.body.size();
  write_directory(columns, directory, out.directory);
  return CodecError::none;
}

ChunkDecoder::ChunkDecoder() : context_(ZSTD_createDCtx()) {}
ChunkDecoder::~ChunkDecoder() { ZSTD_freeDCtx(context_); }
ChunkDecoder::ChunkDecoder(ChunkDecoder&& other) noexcept
    : context_(std::exchange(other.context_, nullptr)), planes_(std::move(other.planes_)) {}
ChunkDecoder& ChunkDecoder::operator=(ChunkDecoder&& other) noexcept {
  std::swap(context_, other.context_);
  planes_.swap(other.planes_);
  return *this;
}

CodecError ChunkDecoder::unpack(ByteView frame, std::size_t expected_bytes) {
  if (context_ == nullptr) return CodecError::zstd_failed;
  planes_.resize(expected_bytes);
  const std::size_t n = ZSTD_decompressDCtx(context_, planes_.data(), planes_.size(), frame.data(), frame.size());
  return ZSTD_isError(n) == 0 && n == expected_bytes ? CodecError::none : CodecError::body_damaged;
}

CodecError ChunkDecoder::unpack_all(const ChunkDirectory& directory, ByteView body) {
  std::size_t total = 0;
  for (const ChunkColumn& column : directory.columns) total += column.bytes;
  return total == 0 && body.empty() ? CodecError::none : unpack(body, total);
}

CodecError ChunkDecoder::check(const ChunkDirectory& directory, ByteView body) {
  if (body.size() != directory.body_bytes) return CodecError::body_damaged;
  if (directory.layout == ChunkLayout::one_frame) return unpack_all(directory, body);
  for (const ChunkColumn& column : directory.columns) {
    if (column.planes == 0) continue;
    const CodecError error = unpack(body.subspan(column.offset, column.bytes), column.planes * (directory.samples - 1));
    if (error != CodecError::none) return error;
  }
  return CodecError::none;
}

CodecError ChunkDecoder::rebuild(const ChunkDirectory& directory, std::size_t column, ByteView planes, std::vector<std::int64_t>& values) {
  const ChunkColumn& entry = directory.columns[column];
  values.resize(directory.samples);
  return read_planes(entry.planes, entry.first, entry.step, planes, values) ? CodecError::none : CodecError::body_damaged;
}

CodecError ChunkDecoder::column(const ChunkDirectory& directory, std::size_t column, ByteView payload, std::vector<std::int64_t>& values) {
  if (column >= directory.columns.size()) return CodecError::no_such_column;
  const ChunkColumn& entry = directory.columns[column];
  if (entry.planes == 0) return rebuild(directory, column, {}, values);
  if (directory.layout == ChunkLayout::one_frame) {
    const std::size_t which[] = {column};
    std::vector<std::vector<std::int64_t>> one(1);
    one[0].swap(values);
    const CodecError error = columns(directory, which, payload, one);
    values.swap(one[0]);
    return error;
  }
  if (payload.size() != entry.bytes) return CodecError::body_damaged;
  if (const CodecError error = unpack(payload, entry.planes * (directory.samples - 1)); error != CodecError::none) return error;
  return rebuild(directory, column, planes_, values);
}

CodecError ChunkDecoder::columns(const ChunkDirectory& directory, std::span<const std::size_t> which, ByteView body,
                                 std::vector<std::vector<std::int64_t>>& values) {
  values.resize(which.size());
  if (body.size() != directory.body_bytes) return CodecError::body_damaged;
  if (directory.layout == ChunkLayout::one_frame)
    if (const CodecError error = unpack_all(directory, body); error != CodecError::none) return error;
  for (std::size_t i = 0; i < which.size(); ++i) {
    if (which[i] >= directory.columns.size()) return CodecError::no_such_column;
    const ChunkColumn& entry = directory.columns[which[i]];
    CodecError error = CodecError::none;
    if (entry.planes == 0) {
      error = rebuild(directory, which[i], {}, values[i]);
    } else if (directory.layout == ChunkLayout::one_frame) {
      error = rebuild(directory, which[i], ByteView(planes_).subspan(entry.offset, entry.bytes), values[i]);
    } else {
      error = column(directory, which[i], body.subspan(entry.offset, entry.bytes), values[i]);
    }
    if (error != CodecError::none) return error;
  }
  return CodecError::none;
}

}  // namespace hoist::db
