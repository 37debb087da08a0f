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

#define HOIST_FAULT(...)
#define HOIST_MONITOR(...)
#define HOIST_REFUSAL(...)
#define HOIST_MODE(...)

enum class Fault : std::uint8_t {
#undef HOIST_FAULT
#define HOIST_FAULT(bit, name, ...) name = bit,
#include "control/contract/faults.def"
#undef HOIST_FAULT
#define HOIST_FAULT(...)
};
struct FaultInfo {
  std::uint8_t bit;
  std::string_view name;
  Priority priority;
  Reaction reaction;
  std::string_view hazard, text_en, action_en, text_de, action_de;
};
inline constexpr std::array kFaults{
#undef HOIST_FAULT
#define HOIST_FAULT(bit, name, priority, reaction, hazard, text_en, action_en, text_de, action_de) \
  FaultInfo{bit, #name, Priority::priority, Reaction::reaction, hazard, text_en, action_en, text_de, action_de},
#include "control/contract/faults.def"
#undef HOIST_FAULT
#define HOIST_FAULT(...)
};
constexpr std::uint32_t fault_bit(Fault fault) { return 1U << static_cast<unsigned>(fault); }

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

/// What answers a fault, in the words of the hazard table: R1 soft stop, R2 protective stop, R3 the drive by itself, R4 power off.
enum class MonitorReaction : std::uint8_t { warn, R1, R2, R3, R4 };
/// How a fault is found, and how soon braking has to begin.
struct MonitorInfo {
  Fault fault;
  std::string_view hazards;  // separated by a space
  MonitorReaction reaction;
  std::uint32_t budget_ms;
  std::string_view threshold;
};
inline constexpr std::array kMonitors{
#undef HOIST_MONITOR
#define HOIST_MONITOR(fault, hazards, reaction, budget_ms, threshold) \
  MonitorInfo{Fault::fault, hazards, MonitorReaction::reaction, budget_ms, threshold},
#include "control/contract/faults.def"
#undef HOIST_MONITOR
#define HOIST_MONITOR(...)
};
/// The row of a fault; null for a fault without one, which does not compile.
constexpr const MonitorInfo* find_monitor(Fault fault) {
  for (const MonitorInfo& monitor : kMonitors)
    if (monitor.fault == fault) return &monitor;
  return nullptr;
}

enum class Refusal : std::uint8_t {
#undef HOIST_REFUSAL
#define HOIST_REFUSAL(bit, name, ...) name = bit,
#include "control/contract/faults.def"
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
#include "control/contract/faults.def"
#undef HOIST_REFUSAL
#define HOIST_REFUSAL(...)
};
constexpr std::uint32_t refusal_bit(Refusal refusal) { return 1U << static_cast<unsigned>(refusal); }

enum class Mode : std::uint8_t {
#undef HOIST_MODE
#define HOIST_MODE(value, name, ...) name = value,
#include "control/contract/faults.def"
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
#include "control/contract/faults.def"
#undef HOIST_MODE
};
#undef HOIST_FAULT
#undef HOIST_MONITOR
#undef HOIST_REFUSAL

static_assert(kFaults.size() <= 32 && kRefusals.size() <= 32, "fault_bits and blocked_bits hold 32 rows");
static_assert(unique_by(kFaults, [](const FaultInfo& f) { return f.bit; }) &&
                  all_rows(kFaults, [](const FaultInfo& f) { return f.bit < 32; }),
              "faults.def: a fault bit is used twice or out of range");
static_assert(unique_by(kFaults, [](const FaultInfo& f) { return f.name; }), "faults.def: a fault name is used twice");
static_assert(all_rows(kFaults,
                       [](const FaultInfo& f) {
                         return !f.hazard.empty() && !f.text_en.empty() && !f.action_en.empty() && !f.text_de.empty() &&
                                !f.action_de.empty();
                       }),
              "faults.def: a fault lacks its words");
static_assert(kMonitors.size() == kFaults.size() && unique_by(kMonitors, [](const MonitorInfo& m) { return m.fault; }),
              "faults.def: every fault needs exactly one HOIST_MONITOR row");
static_assert(all_rows(kMonitors, [](const MonitorInfo& m) { return !m.hazards.empty() && m.budget_ms > 0 && !m.threshold.empty(); }),
              "faults.def: a HOIST_MONITOR row lacks hazard, budget or threshold");
// Both tables say the same: what the supervisor does is the fault's reaction, what the hazard table asks for is the monitor's. R3 and R4 are
// others' doing, with a protective stop beside it.
static_assert(all_rows(kFaults,
                       [](const FaultInfo& f) {
                         // Not by a pointer that may be null: g++ 12 cannot compare those in a constant under its sanitizers.
                         bool agree = false;
                         for (const MonitorInfo& m : kMonitors)
                           agree = agree || (m.fault == static_cast<Fault>(f.bit) && m.hazards.find(f.hazard) != std::string_view::npos &&
                                             (m.reaction == MonitorReaction::warn) == (f.reaction == Reaction::warn) &&
                                             (m.reaction == MonitorReaction::R1) == (f.reaction == Reaction::soft_stop));
                         return agree;
                       }),
              "faults.def: HOIST_FAULT and HOIST_MONITOR of a fault do not agree");
static_assert(unique_by(kRefusals, [](const RefusalInfo& r) { return r.bit; }) &&
                  unique_by(kRefusals, [](const RefusalInfo& r) { return r.name; }),
              "faults.def: a refusal is used twice");
static_assert(unique_by(kModes, [](const ModeInfo& m) { return m.value; }), "faults.def: a mode value is used twice");
static_assert(all_rows(kModes, [](const ModeInfo& m) { return m.value < kModes.size() && kModes[m.value].value == m.value; }),
              "faults.def: modes must be numbered in order");

/// The therapist's hand leads in this mode: without a fresh command and a held dead-man nothing may speed up.
constexpr bool led_by_hand(Mode mode) { return mode == Mode::remote || mode == Mode::guided; }

constexpr std::uint64_t faults_hash() {
  std::uint64_t hash = kHashStart;
  for (const FaultInfo& f : kFaults) hash = hash_number(hash_bytes(hash, f.name), f.bit);
  for (const RefusalInfo& r : kRefusals) hash = hash_number(hash_bytes(hash, r.name), r.bit);
  for (const ModeInfo& m : kModes) hash = hash_number(hash_bytes(hash, m.name), m.value);
  return hash;
}

}  // namespace hoist::contract
