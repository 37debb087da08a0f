#include "db/export/zip_file.hpp"

#include <zlib.h>

#include <array>
#include <bit>
#include <cstring>
#include <ctime>

#include "db/store/sqlite.hpp"

namespace hoist::db {
namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::uint64_t kAll32 = 0xFFFFFFFFU, kAll16 = 0xFFFFU;
constexpr std::uint16_t kZipVersion = 20, kZip64Version = 45;
// Sizes follow the data; names are UTF-8.
constexpr std::uint16_t kFlags = 0x0808, kDeflate = 8, kZip64 = 1;
constexpr std::uint16_t kMadeByUnix = 3 << 8;
constexpr std::uint32_t kPlainFile = 0100644U << 16;

template <typename Value>
void number(std::string& out, Value value) {
  std::array<char, sizeof value> bytes;
  std::memcpy(bytes.data(), &value, sizeof value);
  out.append(bytes.data(), bytes.size());
}
template <typename... Values>
void numbers(std::string& out, Values... values) {
  (number(out, values), ...);
}

// Two seconds at best, from 1980 on.
std::uint32_t dos_time(std::int64_t utc_ns) {
  const std::time_t time = utc_ns / 1'000'000'000;
  std::tm parts{};
  gmtime_r(&time, &parts);
  if (parts.tm_year < 80) return 1U << 21 | 1U << 16;
  const auto part = [](int value) { return static_cast<std::uint32_t>(value); };
  return part(parts.tm_year - 80) << 25 | part(parts.tm_mon + 1) << 21 | part(parts.tm_mday) << 16 | part(parts.tm_hour) << 11 |
         part(parts.tm_min) << 5 | part(parts.tm_sec) / 2;
}
std::uint32_t low(std::uint64_t value) { return static_cast<std::uint32_t>(value < kAll32 ? value : kAll32); }

}  // namespace

ZipFile::ZipFile() : stream_(std::make_unique<z_stream>()) {
  // No zlib head: the archive has its own.
  if (deflateInit2(stream_.get(), Z_DEFAULT_COMPRESSION, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw SqlFailure{Error{ErrorKind::internal, "zlib failed", {}}};
}
ZipFile::~ZipFile() { deflateEnd(stream_.get()); }

void ZipFile::put(std::string& out, std::string_view bytes) {
  out += bytes;
  position_ += bytes.size();
}

void ZipFile::begin_file(std::string& out, std::string_view name, std::int64_t utc_ns, bool large) {
  Entry entry;
  entry.name = name;
  entry.offset = position_;
  entry.large = large;
  entry.dos_time = dos_time(utc_ns);
  std::string head = "PK\3\4";
  numbers(head, large ? kZip64Version : kZipVersion, kFlags, kDeflate, entry.dos_time, std::uint32_t{0});
  const std::uint32_t unknown = large ? static_cast<std::uint32_t>(kAll32) : 0;
  numbers(head, unknown, unknown, static_cast<std::uint16_t>(name.size()), static_cast<std::uint16_t>(large ? 20 : 0));
  head += name;
  if (large) numbers(head, kZip64, std::uint16_t{16}, std::uint64_t{0}, std::uint64_t{0});
  put(out, head);
  entries_.push_back(std::move(entry));
  deflateReset(stream_.get());
}

void ZipFile::deflate_into(std::string& out, std::string_view bytes, int flush) {
  Entry& entry = entries_.back();
  std::array<char, 16384> packed;
  stream_->next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream_->avail_in = static_cast<uInt>(bytes.size());
  do {
    stream_->next_out = reinterpret_cast<Bytef*>(packed.data());
    stream_->avail_out = packed.size();
    if (deflate(stream_.get(), flush) == Z_STREAM_ERROR) throw SqlFailure{Error{ErrorKind::internal, "zlib failed", {}}};
    const std::size_t made = packed.size() - stream_->avail_out;
    put(out, {packed.data(), made});
    entry.packed += made;
  } while (stream_->avail_out == 0);
}

void ZipFile::write(std::string& out, std::string_view bytes) {
  Entry& entry = entries_.back();
  entry.crc = static_cast<std::uint32_t>(crc32_z(entry.crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
  entry.size += bytes.size();
  deflate_into(out, bytes, Z_NO_FLUSH);
}

void ZipFile::end_file(std::string& out) {
  deflate_into(out, {}, Z_FINISH);
  const Entry& entry = entries_.back();
  if (!entry.large && (entry.size >= kAll32 || entry.packed >= kAll32))
    throw SqlFailure{Error{ErrorKind::internal, entry.name + " has passed 4 GB", {}}};
  std::string tail = "PK\7\x08";
  number(tail, entry.crc);
  if (entry.large)
    numbers(tail, entry.packed, entry.size);
  else
    numbers(tail, low(entry.packed), low(entry.size));
  put(out, tail);
}

void ZipFile::end(std::string& out) {
  const std::uint64_t begin = position_;
  for (const Entry& entry : entries_) {
    const bool wide = entry.large || entry.offset >= kAll32;
    std::string extra;
    if (wide) numbers(extra, kZip64, std::uint16_t{24}, entry.size, entry.packed, entry.offset);
    const auto shown = [wide](std::uint64_t value) { return wide ? static_cast<std::uint32_t>(kAll32) : low(value); };
    std::string row = "PK\1\2";
    const std::uint16_t version = wide ? kZip64Version : kZipVersion;
    numbers(row, static_cast<std::uint16_t>(kMadeByUnix | version), version, kFlags, kDeflate, entry.dos_time, entry.crc);
    numbers(row, shown(entry.packed), shown(entry.size), static_cast<std::uint16_t>(entry.name.size()));
    numbers(row, static_cast<std::uint16_t>(extra.size()), std::uint16_t{0}, std::uint16_t{0}, std::uint16_t{0}, kPlainFile);
    number(row, shown(entry.offset));
    put(out, row + entry.name + extra);
  }
  const std::uint64_t size = position_ - begin, count = entries_.size();
  std::string tail;
  if (begin + size >= kAll32 || count >= kAll16) {
    tail = "PK\6\6";
    numbers(tail, std::uint64_t{44}, static_cast<std::uint16_t>(kMadeByUnix | kZip64Version), kZip64Version, std::uint32_t{0},
            std::uint32_t{0});
    numbers(tail, count, count, size, begin);
    tail += "PK\6\7";
    numbers(tail, std::uint32_t{0}, begin + size, std::uint32_t{1});
  }
  tail += "PK\5\6";
  const auto short_count = static_cast<std::uint16_t>(count < kAll16 ? count : kAll16);
  numbers(tail, std::uint16_t{0}, std::uint16_t{0}, short_count, short_count, low(size), low(begin), std::uint16_t{0});
  put(out, tail);
}

}  // namespace hoist::db
