// The object dictionary of one node kind, taken from the contract's table at compile time: small rows for the flash, values as raw 32-bit
// words, no search at run time for objects named in the program.
#pragma once
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "control/contract/can_dictionary.hpp"

namespace hoist::firmware {

using contract::ObjectType;
using contract::raw_word;

// Bounds and default are raw words of the object's type, as in an SDO.
struct ObjectRow {
  std::uint16_t index;
  std::uint8_t sub;
  ObjectType type;
  bool writable;
  bool stored;  // a parameter that 1010h stores
  std::uint32_t low, high, initial;
};

template <contract::NodeKind kKind>
consteval std::size_t object_count() {
  std::size_t count = 0;
  for (const contract::ObjectInfo& o : contract::kObjects) count += contract::object_applies(o, kKind) ? 1U : 0U;
  return count;
}

template <contract::NodeKind kKind>
consteval std::array<ObjectRow, object_count<kKind>()> make_object_rows() {
  std::array<ObjectRow, object_count<kKind>()> rows{};
  std::size_t at = 0;
  for (const contract::ObjectInfo& o : contract::kObjects)
    if (contract::object_applies(o, kKind))
      rows[at++] = ObjectRow{o.index,
                             o.sub,
                             o.type,
                             o.access == contract::Access::rw,
                             contract::is_stored(o),
                             raw_word(o.type, o.min),
                             raw_word(o.type, o.max),
                             raw_word(o.type, o.default_value)};
  return rows;
}

// The rows in flash: 8 bytes each, with bounds and default as indices into a list of distinct words, since most rows share them. Without
// that they took 20 bytes.
struct PackedRow {
  std::uint16_t index;
  std::uint8_t sub;
  std::uint8_t type : 5, writable : 1, stored : 1;
  std::uint8_t low, high, initial;
};
static_assert(sizeof(PackedRow) == 8);

template <std::size_t kRows, std::size_t kWords>
struct ObjectTable {
  std::array<PackedRow, kRows> rows{};
  std::array<std::uint32_t, kWords> words{};

  [[nodiscard]] static constexpr std::size_t size() { return kRows; }
  [[nodiscard]] constexpr ObjectRow operator[](std::size_t at) const {
    const PackedRow& row = rows[at];
    return {row.index,       row.sub,           static_cast<ObjectType>(row.type), row.writable != 0, row.stored != 0, words[row.low],
            words[row.high], words[row.initial]};
  }

  struct Iterator {
    const ObjectTable* table;
    std::size_t at;
    constexpr ObjectRow operator*() const { return (*table)[at]; }
    constexpr Iterator& operator++() {
      ++at;
      return *this;
    }
    constexpr bool operator==(const Iterator&) const = default;
  };
  [[nodiscard]] constexpr Iterator begin() const { return {this, 0}; }
  [[nodiscard]] constexpr Iterator end() const { return {this, kRows}; }
};

// The distinct words of bounds and defaults.
template <std::size_t kRows>
struct WordList {
  std::array<std::uint32_t, 3 * kRows> words{};
  std::size_t count = 0;

  consteval std::uint8_t place(std::uint32_t word) {
    for (std::size_t i = 0; i < count; ++i)
      if (words[i] == word) return static_cast<std::uint8_t>(i);
    words[count] = word;
    return static_cast<std::uint8_t>(count++);
  }
};
template <contract::NodeKind kKind>
consteval std::size_t object_words() {
  WordList<object_count<kKind>()> list;
  for (const ObjectRow& row : make_object_rows<kKind>())
    for (const std::uint32_t word : {row.low, row.high, row.initial}) (void)list.place(word);
  return list.count;
}
template <contract::NodeKind kKind>
consteval auto make_object_table() {
  constexpr std::size_t kWords = object_words<kKind>();
  static_assert(kWords <= 256, "a place in the list of words must fit into a byte");
  ObjectTable<object_count<kKind>(), kWords> table;
  WordList<object_count<kKind>()> list;
  std::size_t at = 0;
  for (const ObjectRow& row : make_object_rows<kKind>()) {
    static_assert(static_cast<int>(ObjectType::f32) < 32);
    PackedRow& packed = table.rows[at++];
    packed.index = row.index;
    packed.sub = row.sub;
    packed.type = static_cast<std::uint8_t>(row.type) & 31U;
    packed.writable = row.writable ? 1 : 0;
    packed.stored = row.stored ? 1 : 0;
    packed.low = list.place(row.low);
    packed.high = list.place(row.high);
    packed.initial = list.place(row.initial);
  }
  for (std::size_t i = 0; i < kWords; ++i) table.words[i] = list.words[i];
  return table;
}

template <contract::NodeKind kKind>
inline constexpr auto kObjectRows = make_object_table<kKind>();

inline constexpr std::size_t kNoObject = std::numeric_limits<std::size_t>::max();

template <contract::NodeKind kKind>
consteval std::size_t stored_count() {
  std::size_t count = 0;
  for (const ObjectRow& row : kObjectRows<kKind>) count += row.stored ? 1U : 0U;
  return count;
}
// Indices in kObjectRows of the parameters that 1010h stores.
template <contract::NodeKind kKind>
inline constexpr auto kStoredRows = [] {
  std::array<std::uint8_t, stored_count<kKind>()> rows{};
  std::size_t at = 0;
  for (std::size_t i = 0; i < kObjectRows<kKind>.size(); ++i)
    if (kObjectRows<kKind>[i].stored) rows[at++] = static_cast<std::uint8_t>(i);
  return rows;
}();

// Where an object is in kObjectRows; kNoObject when this kind of node does not have it.
template <contract::NodeKind kKind>
constexpr std::size_t find_row(std::uint16_t index, std::uint8_t sub) {
  for (std::size_t i = 0; i < kObjectRows<kKind>.size(); ++i)
    if (kObjectRows<kKind>[i].index == index && kObjectRows<kKind>[i].sub == sub) return i;
  return kNoObject;
}

// Whether the row allows a raw word as value. NaN and infinities are never allowed.
constexpr bool in_range(const ObjectRow& row, std::uint32_t raw) {
  const auto between = [](auto value, auto low, auto high) { return value >= low && value <= high; };
  switch (row.type) {
    case ObjectType::f32: {
      const float value = std::bit_cast<float>(raw);
      return between(value, std::bit_cast<float>(row.low), std::bit_cast<float>(row.high));  // false for NaN, bounds are finite
    }
    case ObjectType::i8:
      return between(static_cast<std::int8_t>(raw), static_cast<std::int8_t>(row.low), static_cast<std::int8_t>(row.high));
    case ObjectType::i16:
      return between(static_cast<std::int16_t>(raw), static_cast<std::int16_t>(row.low), static_cast<std::int16_t>(row.high));
    case ObjectType::i32:
      return between(static_cast<std::int32_t>(raw), static_cast<std::int32_t>(row.low), static_cast<std::int32_t>(row.high));
    default:
      return between(raw, row.low, row.high);
  }
}

template <ObjectType kType>
struct ObjectValue;
template <>
struct ObjectValue<ObjectType::u8> {
  using type = std::uint8_t;
};
template <>
struct ObjectValue<ObjectType::i8> {
  using type = std::int8_t;
};
template <>
struct ObjectValue<ObjectType::u16> {
  using type = std::uint16_t;
};
template <>
struct ObjectValue<ObjectType::i16> {
  using type = std::int16_t;
};
template <>
struct ObjectValue<ObjectType::u32> {
  using type = std::uint32_t;
};
template <>
struct ObjectValue<ObjectType::i32> {
  using type = std::int32_t;
};
template <>
struct ObjectValue<ObjectType::f32> {
  using type = float;
};

// All values of one node. get<0x6041>() and set<0x6041>(x) resolve type and place at compile time.
template <contract::NodeKind kKind>
class ObjectValues {
 public:
  template <std::uint16_t kIndex, std::uint8_t kSub = 0>
  [[nodiscard]] constexpr auto get() const {
    constexpr std::size_t kAt = place<kIndex, kSub>();
    using Value = typename ObjectValue<kObjectRows<kKind>[kAt].type>::type;
    if constexpr (kObjectRows<kKind>[kAt].type == ObjectType::f32)
      return std::bit_cast<float>(raw_[kAt]);
    else
      return static_cast<Value>(raw_[kAt]);
  }
  template <std::uint16_t kIndex, std::uint8_t kSub = 0>
  constexpr void set(typename ObjectValue<kObjectRows<kKind>[find_row<kKind>(kIndex, kSub)].type>::type value) {
    constexpr std::size_t kAt = place<kIndex, kSub>();
    if constexpr (kObjectRows<kKind>[kAt].type == ObjectType::f32)
      raw_[kAt] = std::bit_cast<std::uint32_t>(value);
    else if constexpr (contract::object_bytes(kObjectRows<kKind>[kAt].type) == 4)
      raw_[kAt] = static_cast<std::uint32_t>(value);
    else if constexpr (contract::object_bytes(kObjectRows<kKind>[kAt].type) == 2)
      raw_[kAt] = static_cast<std::uint16_t>(value);
    else
      raw_[kAt] = static_cast<std::uint8_t>(value);
  }
  [[nodiscard]] constexpr std::uint32_t raw(std::size_t at) const { return raw_[at]; }
  constexpr void set_raw(std::size_t at, std::uint32_t value) { raw_[at] = value; }

  // Defaults of all objects, or only of those whose index lies in the range (communication objects: 0x1000 to 0x1FFF).
  constexpr void restore(std::uint16_t first_index = 0, std::uint16_t last_index = 0xFFFF) {
    for (std::size_t i = 0; i < raw_.size(); ++i)
      if (kObjectRows<kKind>[i].index >= first_index && kObjectRows<kKind>[i].index <= last_index) raw_[i] = kObjectRows<kKind>[i].initial;
  }

 private:
  template <std::uint16_t kIndex, std::uint8_t kSub>
  static consteval std::size_t place() {
    static_assert(find_row<kKind>(kIndex, kSub) != kNoObject, "this kind of node has no such object");
    return find_row<kKind>(kIndex, kSub);
  }
  std::array<std::uint32_t, kObjectRows<kKind>.size()> raw_{};
};

// One process data frame of a kind: which objects, in which order. `communication` is the place in kObjectRows of its COB-ID (sub-index 1
// of 1400h or 1800h and up), which is followed by its type and, when the node sends it, by its inhibit time and its event timer.
struct PdoRow {
  contract::Pdo pdo{};
  contract::PdoDirection direction{};
  std::uint8_t communication = 0;
  std::uint8_t bytes = 0;
  std::uint8_t entries = 0;
  std::array<std::uint8_t, 8> row{};  // place in kObjectRows
};

template <contract::NodeKind kKind>
consteval std::size_t pdo_count() {
  std::size_t count = 0;
  for (const contract::PdoInfo& p : contract::kPdos) count += p.kind == kKind ? 1U : 0U;
  return count;
}
template <contract::NodeKind kKind>
consteval std::array<PdoRow, pdo_count<kKind>()> make_pdo_rows() {
  std::array<PdoRow, pdo_count<kKind>()> rows{};
  std::size_t at = 0;
  for (const contract::PdoInfo& p : contract::kPdos) {
    if (p.kind != kKind) continue;
    PdoRow row{p.pdo,
               p.direction,
               static_cast<std::uint8_t>(find_row<kKind>(contract::pdo_communication_index(p), 1)),
               static_cast<std::uint8_t>(contract::pdo_bytes(p.pdo)),
               0,
               {}};
    for (const contract::PdoEntry& e : contract::kPdoEntries)
      if (e.pdo == p.pdo) row.row[row.entries++] = static_cast<std::uint8_t>(find_row<kKind>(e.index, e.sub));
    rows[at++] = row;
  }
  return rows;
}
template <contract::NodeKind kKind>
inline constexpr auto kPdoRows = make_pdo_rows<kKind>();

static_assert(kObjectRows<contract::NodeKind::drive>.size() < 256 && kObjectRows<contract::NodeKind::tilt>.size() < 256 &&
                  kObjectRows<contract::NodeKind::io>.size() < 256,
              "a place in the table must fit into a byte");

}  // namespace hoist::firmware
