// Parameters in flash that survive a power cut at any byte. Two pages alternate: a save erases and writes the page without the newest good
// copy, so that the older copy counts until the last byte is written.
//
// A copy, little endian:
//   0  u32 magic "HPRM"    4  u32 sequence number, one more than the copy before    8  u8 kind of node  9  u8 0  10  u16 number of records
//   12 records of 8 bytes: u16 index, u8 sub-index, u8 bytes, u32 value             then u32 CRC-32 of everything before
// Records name their object, so that a new program reads the objects it knows and skips the others. A copy without records means "defaults".
#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "control/contract/can_dictionary.hpp"
#include "control/contract/crc32.hpp"
#include "firmware/lib/board.hpp"

namespace hoist::firmware {

struct StoredValue {
  std::uint16_t index = 0;
  std::uint8_t sub = 0, bytes = 0;
  std::uint32_t raw = 0;
  friend constexpr bool operator==(const StoredValue&, const StoredValue&) = default;
};

// State of the two pages: erased; a good copy; or damaged, so that saved values are lost.
enum class StoreState : std::uint8_t { empty, good, lost };

inline constexpr std::uint32_t kStoreMagic = 0x4D525048;  // "HPRM" in ASCII
inline constexpr std::size_t kStoreHeadBytes = 12, kStoreRecordBytes = 8, kStoreCrcBytes = 4;
inline constexpr std::size_t kStoreBlockBytes = 256;  // every chip's write unit divides it (board.hpp)
constexpr std::size_t store_bytes(std::size_t records) { return kStoreHeadBytes + records * kStoreRecordBytes + kStoreCrcBytes; }

template <FlashPages Flash>
class ParameterStore {
 public:
  ParameterStore(Flash& flash, std::uint8_t kind) : flash_(flash), kind_(kind) {}

  // Calls take(const StoredValue&) for each record of the newest good copy.
  template <class Take>
  [[nodiscard]] StoreState load(Take&& take) const {
    const int page = newest();
    if (page < 0) return blank(0) && blank(1) ? StoreState::empty : StoreState::lost;
    const auto bytes = flash_.read(page);
    const std::size_t records = word(bytes, 8) >> 16;
    for (std::size_t i = 0; i < records; ++i) {
      const std::uint32_t head = word(bytes, kStoreHeadBytes + i * kStoreRecordBytes);
      take(StoredValue{static_cast<std::uint16_t>(head), static_cast<std::uint8_t>(head >> 16), static_cast<std::uint8_t>(head >> 24),
                       word(bytes, kStoreHeadBytes + i * kStoreRecordBytes + 4)});
    }
    return StoreState::good;
  }

  // Writes `records` records, which give(i) returns as StoredValue. False on a flash error: the earlier copy still counts then. On a
  // microcontroller this takes up to the time of one page erase, in which the processor is stopped.
  template <class Give>
  [[nodiscard]] bool save(std::size_t records, Give&& give) {
    if (records > kRecordsMax) return false;
    const int now = newest();
    const int page = now == 0 ? 1 : 0;
    const std::uint32_t sequence = now < 0 ? 1 : word(flash_.read(now), 4) + 1;
    if (!flash_.erase(page)) return false;
    Writer writer{flash_, page};
    writer.put(kStoreMagic);
    writer.put(sequence);
    writer.put(kind_ | (static_cast<std::uint32_t>(records) << 16));
    for (std::size_t i = 0; i < records; ++i) {
      const StoredValue value = give(i);
      writer.put(value.index | (static_cast<std::uint32_t>(value.sub) << 16) | (static_cast<std::uint32_t>(value.bytes) << 24));
      writer.put(value.raw);
    }
    return writer.finish() && good(page) && newest() == page;
  }

 private:
  static constexpr std::size_t kRecordsMax =
      std::min<std::size_t>((Flash::kPageBytes - kStoreHeadBytes - kStoreCrcBytes) / kStoreRecordBytes, 0xFFFF);

  // Collects words into blocks, because flash is written in blocks; the CRC comes last and makes the copy good.
  struct Writer {
    Flash& flash;
    int page;
    std::array<std::uint8_t, kStoreBlockBytes> block{};
    std::size_t used = 0, offset = 0;
    contract::Crc32 crc{};
    bool ok = true;

    void put(std::uint32_t value) {
      contract::write_le(&block[used], 4, value);
      crc.add(std::span<const std::uint8_t>(block).subspan(used, 4));
      used += 4;
      if (used == kStoreBlockBytes) flush();
    }
    void flush() {
      std::fill(block.begin() + static_cast<std::ptrdiff_t>(used), block.end(), std::uint8_t{0xFF});
      ok = ok && flash.write(page, offset, std::as_bytes(std::span<const std::uint8_t>(block)));
      offset += kStoreBlockBytes;
      used = 0;
    }
    bool finish() {
      put(crc.value());
      if (used != 0) flush();
      return ok;
    }
  };

  static std::uint32_t word(std::span<const std::byte> bytes, std::size_t at) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
    return value;
  }
  [[nodiscard]] bool blank(int page) const {
    const auto bytes = flash_.read(page);
    return std::all_of(bytes.begin(), bytes.end(), [](std::byte b) { return b == std::byte{0xFF}; });
  }
  [[nodiscard]] bool good(int page) const {
    const auto bytes = flash_.read(page);
    if (bytes.size() < store_bytes(0) || word(bytes, 0) != kStoreMagic || (word(bytes, 8) & 0xFFFFU) != kind_) return false;
    const std::size_t end = store_bytes(word(bytes, 8) >> 16) - kStoreCrcBytes;
    if (end > bytes.size() - kStoreCrcBytes) return false;
    contract::Crc32 crc;
    for (const std::byte b : bytes.first(end)) {
      const std::uint8_t byte = std::to_integer<std::uint8_t>(b);
      crc.add(std::span(&byte, 1));
    }
    return crc.value() == word(bytes, end);
  }
  // The page with the newest good copy, -1 without one. Sequence numbers may wrap: their difference counts.
  [[nodiscard]] int newest() const {
    const bool first = good(0), second = good(1);
    if (!first || !second) return first ? 0 : second ? 1 : -1;
    const std::uint32_t ahead = word(flash_.read(1), 4) - word(flash_.read(0), 4);
    return static_cast<std::int32_t>(ahead) > 0 ? 1 : 0;
  }

  Flash& flash_;
  std::uint8_t kind_;
};

}  // namespace hoist::firmware
