// Typed view of emergencies.def: what the codes of emergency messages mean, in words.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "control/contract/check.hpp"

namespace hoist::contract {

struct EmergencyInfo {
  std::uint16_t code, mask;
  std::string_view name, text_en, detail_en, text_de, detail_de;
};
inline constexpr std::array kEmergencies{
#define HOIST_EMERGENCY(code, mask, name, text_en, detail_en, text_de, detail_de) \
  EmergencyInfo{code, mask, #name, text_en, detail_en, text_de, detail_de},
#include "control/contract/emergencies.def"
#undef HOIST_EMERGENCY
};

/// The first row that fits; the last one fits everything.
constexpr const EmergencyInfo& emergency_info(std::uint16_t code) {
  for (const EmergencyInfo& row : kEmergencies)
    if ((code & row.mask) == row.code) return row;
  return kEmergencies.back();
}

static_assert(kEmergencies.back().mask == 0, "emergencies.def: the last row is for every code");
static_assert(unique_by(kEmergencies, [](const EmergencyInfo& e) { return e.name; }), "emergencies.def: a name is used twice");
static_assert(all_rows(kEmergencies,
                       [](const EmergencyInfo& e) { return (e.code & e.mask) == e.code && emergency_info(e.code).code == e.code; }),
              "emergencies.def: a row can never be reached");
static_assert(all_rows(kEmergencies,
                       [](const EmergencyInfo& e) {
                         return !e.text_en.empty() && !e.detail_en.empty() && !e.text_de.empty() && !e.detail_de.empty();
                       }),
              "emergencies.def: a row lacks its words");

}  // namespace hoist::contract
