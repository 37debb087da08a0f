// Typed view of signals.def: the record that the core writes each tick, and the description of every column.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string_view>
#include <type_traits>

#include "control/contract/check.hpp"

namespace hoist::contract {

enum class SignalType : std::uint8_t { u64, u32, i32, f32, u16, u8 };
namespace signal_cpp {
using u64 = std::uint64_t;
using u32 = std::uint32_t;
using i32 = std::int32_t;
using f32 = float;
using u16 = std::uint16_t;
using u8 = std::uint8_t;
}  // namespace signal_cpp

// One control step, as it lies in shared memory, goes to the browser (little endian) and into the recording.
struct alignas(8) TickRecord {
#define HOIST_SIGNAL(id, type, name, unit, lsb, ...) signal_cpp::type name = 0;
#include "control/contract/signals.def"
#undef HOIST_SIGNAL
};
static_assert(std::is_trivially_copyable_v<TickRecord>);
// Measured (publishing and reading a slot, against a memcpy each way): 1.0 times at 512 B, 1.2 at 768 B, 1.5 at 1 KiB; the goal is 1.6.
static_assert(sizeof(TickRecord) <= 768, "a larger record makes the ring slower than it may be");

struct SignalInfo {
  std::uint16_t id;
  SignalType type;
  std::string_view name;
  std::string_view unit;
  double lsb;
  std::size_t offset;
  std::size_t size;
  std::string_view title_en, title_de, doc;
};

inline constexpr std::array kSignals{
#define HOIST_SIGNAL(id, type, name, unit, lsb, title_en, title_de, doc)                                                              \
  SignalInfo{id,       SignalType::type, #name, unit, static_cast<double>(lsb), offsetof(TickRecord, name), sizeof(signal_cpp::type), \
             title_en, title_de,         doc},
#include "control/contract/signals.def"
#undef HOIST_SIGNAL
};
inline constexpr std::size_t kSignalCount = kSignals.size();

constexpr std::optional<std::size_t> find_signal(std::string_view name) {
  for (std::size_t i = 0; i < kSignalCount; ++i)
    if (kSignals[i].name == name) return i;
  return std::nullopt;
}

// Any column as a double. u64 values above 2^53 lose their last digits; tick and time stay below that for 100 days.
inline double signal_value(const TickRecord& record, std::size_t index) {
  const SignalInfo& s = kSignals[index];
  const auto* at = reinterpret_cast<const unsigned char*>(&record) + s.offset;
  const auto read = [at]<typename T>(T) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return static_cast<double>(value);
  };
  switch (s.type) {
    case SignalType::u64:
      return read(std::uint64_t{});
    case SignalType::u32:
      return read(std::uint32_t{});
    case SignalType::i32:
      return read(std::int32_t{});
    case SignalType::f32:
      return read(float{});
    case SignalType::u16:
      return read(std::uint16_t{});
    case SignalType::u8:
      return read(std::uint8_t{});
  }
  return 0.0;
}

static_assert(unique_by(kSignals, [](const SignalInfo& s) { return s.id; }), "signals.def: an id is used twice");
static_assert(unique_by(kSignals, [](const SignalInfo& s) { return s.name; }), "signals.def: a name is used twice");
static_assert(all_rows(kSignals,
                       [](const SignalInfo& s) { return s.lsb > 0 && !s.title_en.empty() && !s.title_de.empty() && !s.doc.empty(); }),
              "signals.def: a row lacks its step or its words");
namespace detail {
consteval bool no_hidden_padding() {
  std::size_t end = 0;
  for (const SignalInfo& s : kSignals) {
    if (s.offset != end) return false;
    end = s.offset + s.size;
  }
  return sizeof(TickRecord) - end < 8;
}
}  // namespace detail
static_assert(detail::no_hidden_padding(), "signals.def: order the rows so that no padding hides between them");

constexpr std::uint64_t signals_hash() {
  std::uint64_t hash = hash_number(kHashStart, sizeof(TickRecord));
  for (const SignalInfo& s : kSignals)
    hash = hash_number(hash_number(hash_bytes(hash_bytes(hash, s.name), s.unit), s.offset), static_cast<std::uint64_t>(s.type));
  return hash;
}

}  // namespace hoist::contract
