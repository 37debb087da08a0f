// Typed view of faults.def: faults, refusals and modes, with their words.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "control/contract/check.hpp"

namespace hoist::contract {

enum class Priority : std::uint8_t { low, medium, high };
enum class Reaction : std::uint8_t { warn, soft_stop, protective_stop, out_of_service, power_off };

// A test takes the table with more rows to see that there is room for them (tests/contract/more_faults.def).
#ifndef HOIST_FAULT_TABLE
#define HOIST_FAULT_TABLE "control/contract/faults.def"
#endif

#define HOIST_FAULT(...)
#define HOIST_REFUSAL(...)
#define HOIST_SPEED_CAUSE(...)
#define HOIST_MODE(...)
#define HOIST_DETAIL(...)
#define HOIST_EXPLAINS(...)
#define HOIST_ENDANGERS(...)

enum class Fault : std::uint8_t {
#undef HOIST_FAULT
#define HOIST_FAULT(bit, name, ...) name = bit,
#include HOIST_FAULT_TABLE
#undef HOIST_FAULT
#define HOIST_FAULT(...)
};
struct FaultInfo {
  std::uint8_t bit;
  std::string_view name;
  Priority priority;
  Reaction reaction;
  std::string_view hazards;  // separated by a space
  std::uint32_t budget_ms;   // from the cause to the beginning of braking
  std::string_view threshold;
  std::string_view text_en, action_en, text_de, action_de;

  /// The first of `hazards`: the fault's own.
  [[nodiscard]] constexpr std::string_view hazard() const { return hazards.substr(0, hazards.find(' ')); }
};
inline constexpr std::array kFaults{
#undef HOIST_FAULT
#define HOIST_FAULT(bit, name, priority, reaction, hazards, budget_ms, threshold, text_en, action_en, text_de, action_de) \
  FaultInfo{bit, #name, Priority::priority, Reaction::reaction, hazards, budget_ms, threshold, text_en, action_en, text_de, action_de},
#include HOIST_FAULT_TABLE
#undef HOIST_FAULT
#define HOIST_FAULT(...)
};
/// A set of faults: one bit per fault, at the place that its row says.
using FaultBits = std::uint64_t;
/// Places in a FaultBits. 53, because the console and every export hold numbers as doubles.
inline constexpr std::size_t kFaultPlaces = 53;
constexpr FaultBits fault_bit(Fault fault) { return FaultBits{1} << static_cast<unsigned>(fault); }
constexpr FaultBits fault_bit(const FaultInfo& info) { return FaultBits{1} << info.bit; }

/// The row of a fault. Bits need not be without gaps, so a fault's number is not its place in the table.
constexpr const FaultInfo& fault_info(Fault fault) {
  for (const FaultInfo& info : kFaults)
    if (info.bit == static_cast<std::uint8_t>(fault)) return info;
  return kFaults.front();  // never: every enumerator is a row
}

/// The row of that name, nullptr when there is none.
constexpr const FaultInfo* find_fault(std::string_view name) {
  for (const FaultInfo& info : kFaults)
    if (info.name == name) return &info;
  return nullptr;
}

/// Where a fault comes from: the machine itself, or outside (floor, load or patient).
enum class Origin : std::uint8_t { machine, outside };
struct DetailInfo {
  Fault fault;
  std::uint16_t code;
  std::string_view name;
  Origin origin;
  std::string_view text_en, action_en, text_de, action_de;
};
inline constexpr std::array kDetails{
#undef HOIST_DETAIL
#define HOIST_DETAIL(fault, code, name, origin, text_en, action_en, text_de, action_de) \
  DetailInfo{Fault::fault, code, #name, Origin::origin, text_en, action_en, text_de, action_de},
#include HOIST_FAULT_TABLE
#undef HOIST_DETAIL
#define HOIST_DETAIL(...)
};
/// The row for this fault and code; nullptr when there is none, and the fault's own words apply.
constexpr const DetailInfo* find_detail(Fault fault, std::uint16_t code) {
  for (const DetailInfo& detail : kDetails)
    if (detail.fault == fault && detail.code == code) return &detail;
  return nullptr;
}
/// Faults that have details: each has a live value <name>_code.
constexpr FaultBits faults_with_details() {
  FaultBits bits = 0;
  for (const DetailInfo& detail : kDetails) bits |= fault_bit(detail.fault);
  return bits;
}

struct Explanation {
  Fault cause, effect;
};
inline constexpr std::array kExplanations{
#undef HOIST_EXPLAINS
#define HOIST_EXPLAINS(cause, effect) Explanation{Fault::cause, Fault::effect},
#include HOIST_FAULT_TABLE
#undef HOIST_EXPLAINS
#define HOIST_EXPLAINS(...)
};
constexpr bool explains(Fault cause, Fault effect) {
  for (const Explanation& row : kExplanations)
    if (row.cause == cause && row.effect == effect) return true;
  return false;
}
/// Of these faults those that another one of them explains.
constexpr FaultBits consequences(FaultBits faults) {
  FaultBits bits = 0;
  for (const Explanation& row : kExplanations)
    if ((faults & fault_bit(row.cause)) != 0) bits |= faults & fault_bit(row.effect);
  return bits;
}

/// Faults that endanger the patient, the first one first.
inline constexpr std::array kEndangers{
#undef HOIST_ENDANGERS
#define HOIST_ENDANGERS(fault) Fault::fault,
#include HOIST_FAULT_TABLE
#undef HOIST_ENDANGERS
#define HOIST_ENDANGERS(...)
};

/// The first cause among these faults (at least one) of one step: by priority and bit, never a consequence of another.
constexpr Fault first_cause(FaultBits faults) {
  // No ring of explanations exists (checked below), so one fault always remains.
  const FaultBits roots = faults & ~consequences(faults);
  const FaultInfo* best = nullptr;
  for (const FaultInfo& info : kFaults)
    if ((roots >> info.bit & 1U) != 0 &&
        (best == nullptr || info.priority > best->priority || (info.priority == best->priority && info.bit < best->bit)))
      best = &info;
  return best == nullptr ? static_cast<Fault>(0) : static_cast<Fault>(best->bit);
}

/// The fault to tell first of these (at least one): what endangers the patient, then `first` (the fault that came first, plus one; 0 = not
/// known), then first_cause.
constexpr Fault headline(FaultBits faults, std::uint8_t first = 0) {
  for (const Fault fault : kEndangers)
    if ((faults & fault_bit(fault)) != 0) return fault;
  const FaultBits roots = faults & ~consequences(faults);
  if (first != 0 && first <= kFaultPlaces && (roots >> (first - 1U) & 1U) != 0) return static_cast<Fault>(first - 1U);
  return first_cause(faults);
}

enum class Refusal : std::uint8_t {
#undef HOIST_REFUSAL
#define HOIST_REFUSAL(bit, name, ...) name = bit,
#include HOIST_FAULT_TABLE
#undef HOIST_REFUSAL
#define HOIST_REFUSAL(...)
};
struct RefusalInfo {
  std::uint8_t bit;
  std::string_view name, text_en, text_de;
};
inline constexpr std::array kRefusals{
#undef HOIST_REFUSAL
#define HOIST_REFUSAL(bit, name, text_en, text_de) RefusalInfo{bit, #name, text_en, text_de},
#include HOIST_FAULT_TABLE
#undef HOIST_REFUSAL
#define HOIST_REFUSAL(...)
};
constexpr std::uint32_t refusal_bit(Refusal refusal) { return 1U << static_cast<unsigned>(refusal); }

enum class SpeedCause : std::uint8_t {
  none = 0,
#undef HOIST_SPEED_CAUSE
#define HOIST_SPEED_CAUSE(value, name, ...) name = value,
#include HOIST_FAULT_TABLE
#undef HOIST_SPEED_CAUSE
#define HOIST_SPEED_CAUSE(...)
};
struct SpeedCauseInfo {
  std::uint8_t value;
  std::string_view name, text_en, text_de;
};
inline constexpr std::array kSpeedCauses{
#undef HOIST_SPEED_CAUSE
#define HOIST_SPEED_CAUSE(value, name, text_en, text_de) SpeedCauseInfo{value, #name, text_en, text_de},
#include HOIST_FAULT_TABLE
#undef HOIST_SPEED_CAUSE
#define HOIST_SPEED_CAUSE(...)
};

enum class Mode : std::uint8_t {
#undef HOIST_MODE
#define HOIST_MODE(value, name, ...) name = value,
#include HOIST_FAULT_TABLE
#undef HOIST_MODE
#define HOIST_MODE(...)
};
struct ModeInfo {
  std::uint8_t value;
  std::string_view name;
  bool moving;
  std::string_view title_en, title_de;
};
inline constexpr std::array kModes{
#undef HOIST_MODE
#define HOIST_MODE(value, name, moving, title_en, title_de) ModeInfo{value, #name, moving != 0, title_en, title_de},
#include HOIST_FAULT_TABLE
#undef HOIST_MODE
};
#undef HOIST_FAULT
#undef HOIST_REFUSAL
#undef HOIST_SPEED_CAUSE
#undef HOIST_DETAIL
#undef HOIST_EXPLAINS
#undef HOIST_ENDANGERS

static_assert(kRefusals.size() <= 32, "blocked_bits holds 32 rows");
static_assert(unique_by(kFaults, [](const FaultInfo& f) { return f.bit; }) &&
                  all_rows(kFaults, [](const FaultInfo& f) { return f.bit < kFaultPlaces; }),
              "faults.def: a fault bit is used twice or out of range");
static_assert(unique_by(kFaults, [](const FaultInfo& f) { return f.name; }), "faults.def: a fault name is used twice");
static_assert(all_rows(kFaults,
                       [](const FaultInfo& f) {
                         return !f.hazards.empty() && f.budget_ms > 0 && !f.threshold.empty() && !f.text_en.empty() &&
                                !f.action_en.empty() && !f.text_de.empty() && !f.action_de.empty();
                       }),
              "faults.def: a fault lacks hazard, budget, threshold or words");
static_assert(unique_by(kDetails, [](const DetailInfo& d) { return d.name; }) &&
                  all_rows(kDetails,
                           [](const DetailInfo& d) {
                             return d.code != 0 && find_detail(d.fault, d.code)->name == d.name && !d.text_en.empty() &&
                                    !d.action_en.empty() && !d.text_de.empty() && !d.action_de.empty();
                           }),
              "faults.def: a HOIST_DETAIL row lacks words or is there twice");
// A ring of faults that explain each other would hide all of them.
consteval bool explanations_end() {
  for (const Explanation& row : kExplanations) {
    FaultBits reached = fault_bit(row.effect);
    for (std::size_t round = 0; round < kFaults.size(); ++round)
      for (const Explanation& next : kExplanations)
        if ((reached & fault_bit(next.cause)) != 0) reached |= fault_bit(next.effect);
    if ((reached & fault_bit(row.cause)) != 0) return false;
  }
  return true;
}
static_assert(explanations_end(), "faults.def: HOIST_EXPLAINS rows lead back to their own cause");
static_assert(unique_by(kRefusals, [](const RefusalInfo& r) { return r.bit; }) &&
                  unique_by(kRefusals, [](const RefusalInfo& r) { return r.name; }),
              "faults.def: a refusal is used twice");
static_assert(unique_by(kSpeedCauses, [](const SpeedCauseInfo& c) { return c.value; }) &&
                  all_rows(kSpeedCauses, [](const SpeedCauseInfo& c) { return c.value != 0; }),
              "faults.def: a speed cause is used twice, or is 0");
static_assert(unique_by(kModes, [](const ModeInfo& m) { return m.value; }), "faults.def: a mode value is used twice");
static_assert(all_rows(kModes, [](const ModeInfo& m) { return m.value < kModes.size() && kModes[m.value].value == m.value; }),
              "faults.def: modes must be numbered in order");

/// Hold-to-run modes: without a fresh command and hold-to-run held no speed may rise.
constexpr bool led_by_hand(Mode mode) { return mode == Mode::remote || mode == Mode::guided; }

constexpr std::uint64_t faults_hash() {
  std::uint64_t hash = kHashStart;
  for (const FaultInfo& f : kFaults) hash = hash_number(hash_bytes(hash, f.name), f.bit);
  for (const RefusalInfo& r : kRefusals) hash = hash_number(hash_bytes(hash, r.name), r.bit);
  for (const SpeedCauseInfo& c : kSpeedCauses) hash = hash_number(hash_bytes(hash, c.name), c.value);
  for (const ModeInfo& m : kModes) hash = hash_number(hash_bytes(hash, m.name), m.value);
  return hash;
}

}  // namespace hoist::contract
