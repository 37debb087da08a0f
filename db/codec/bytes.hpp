// Little-endian integers of variable length, and a checksum: the alphabet of the stored blobs.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace hoist::db {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

/// Small numbers of either sign become small unsigned numbers: 0, -1, 1, -2 … to 0, 1, 2, 3 …
constexpr std::uint64_t zigzag(std::int64_t value) {
  return (static_cast<std::uint64_t>(value) << 1) ^ (value < 0 ? ~std::uint64_t{0} : 0);
}
constexpr std::int64_t unzigzag(std::uint64_t value) { return static_cast<std::int64_t>((value >> 1) ^ (~(value & 1) + 1)); }
/// Difference and sum that wrap instead of overflowing, so that any two 64-bit integers round trip.
constexpr std::int64_t wrapping_difference(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) - static_cast<std::uint64_t>(b));
}
constexpr std::int64_t wrapping_sum(std::int64_t a, std::int64_t b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(a) + static_cast<std::uint64_t>(b));
}

inline void put_varint(Bytes& out, std::uint64_t value) {
  while (value >= 0x80) {
    out.push_back(static_cast<std::uint8_t>(value | 0x80));
    value >>= 7;
  }
  out.push_back(static_cast<std::uint8_t>(value));
}
inline void put_u32(Bytes& out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

/// Reads what the functions above wrote. After reading past the end or an overlong number `ok()` is false and every value is 0.
class ByteReader {
 public:
  explicit ByteReader(ByteView bytes) : bytes_(bytes) {}
  [[nodiscard]] bool ok() const { return ok_; }
  [[nodiscard]] std::size_t left() const { return bytes_.size() - at_; }

  std::uint8_t u8() {
    if (!ok_ || at_ >= bytes_.size()) return fail();
    return bytes_[at_++];
  }
  std::uint32_t u32() {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(u8()) << (8 * i);
    return ok_ ? value : 0;
  }
  std::uint64_t varint() {
    // Most numbers of a directory have one byte.
    if (at_ < bytes_.size() && bytes_[at_] < 0x80U) return bytes_[at_++];
    std::uint64_t value = 0;
    for (int shift = 0; shift < 64; shift += 7) {
      const std::uint8_t byte = u8();
      if (!ok_) return 0;
      if (shift == 63 && byte > 1) return fail();
      value |= static_cast<std::uint64_t>(byte & 0x7FU) << shift;
      if ((byte & 0x80U) == 0) return value;
    }
    return fail();
  }
  std::int64_t signed_varint() { return unzigzag(varint()); }
  /// The next `size` bytes as they are.
  ByteView take(std::uint64_t size) {
    if (!ok_ || size > left()) {
      fail();
      return {};
    }
    const ByteView taken = bytes_.subspan(at_, size);
    at_ += size;
    return taken;
  }

 private:
  std::uint8_t fail() {
    ok_ = false;
    at_ = bytes_.size();
    return 0;
  }
  ByteView bytes_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

namespace detail {
// Table n: the checksum's part of a byte that has n more bytes of its word behind it ("slicing by eight").
consteval std::array<std::array<std::uint32_t, 256>, 8> crc_tables() {
  std::array<std::array<std::uint32_t, 256>, 8> tables{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t c = i;
    for (int bit = 0; bit < 8; ++bit) c = (c & 1U) != 0 ? (c >> 1) ^ 0xEDB88320U : c >> 1;
    tables[0][i] = c;
  }
  for (std::size_t n = 1; n < tables.size(); ++n)
    for (std::size_t i = 0; i < 256; ++i) tables[n][i] = (tables[n - 1][i] >> 8) ^ tables[0][tables[n - 1][i] & 0xFFU];
  return tables;
}
inline constexpr auto kCrcTables = crc_tables();
}  // namespace detail
/// CRC-32 as in IEEE 802.3: finds every single burst of up to 32 bits.
constexpr std::uint32_t crc32(ByteView bytes) {
  const auto& tables = detail::kCrcTables;
  std::uint32_t c = 0xFFFFFFFFU;
  for (; bytes.size() >= 8; bytes = bytes.subspan(8)) {
    std::uint32_t next = 0;
    for (std::size_t i = 0; i < 4; ++i) next ^= tables[7 - i][((c >> (8 * i)) ^ bytes[i]) & 0xFFU] ^ tables[3 - i][bytes[4 + i]];
    c = next;
  }
  for (std::uint8_t b : bytes) c = tables[0][(c ^ b) & 0xFFU] ^ (c >> 8);
  return c ^ 0xFFFFFFFFU;
}

/// A stored blob without the checksum at its end; nothing when the checksum does not fit.
[[nodiscard]] inline std::optional<ByteView> without_checksum(ByteView blob) {
  if (blob.size() < 4) return std::nullopt;
  const ByteView content = blob.first(blob.size() - 4);
  return ByteReader(blob.last(4)).u32() == crc32(content) ? std::optional(content) : std::nullopt;
}

}  // namespace hoist::db
