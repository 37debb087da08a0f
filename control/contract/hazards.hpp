// Typed view of hazards.def.
#pragma once
#include <array>
#include <string_view>

#include "control/contract/check.hpp"

namespace hoist::contract {

#define HOIST_HAZARD(...)
#define HOIST_HAZARD_GAP(...)
#define HOIST_HAZARD_OPEN(...)
#define HOIST_REQUEST(...)

struct HazardInfo {
  int number;
  std::string_view what, guard, files;
};
inline constexpr std::array kHazards{
#undef HOIST_HAZARD
#define HOIST_HAZARD(number, what, guard, files) HazardInfo{number, what, guard, files},
#include "control/contract/hazards.def"
#undef HOIST_HAZARD
#define HOIST_HAZARD(...)
};

struct HazardGap {
  int number;
  std::string_view missing, comes_with;
};
inline constexpr std::array kHazardGaps{
#undef HOIST_HAZARD_GAP
#define HOIST_HAZARD_GAP(number, missing, comes_with) HazardGap{number, missing, comes_with},
#include "control/contract/hazards.def"
#undef HOIST_HAZARD_GAP
#define HOIST_HAZARD_GAP(...)
};

struct OpenHazard {
  int number;
  std::string_view comes_with;
};
// One row of number 0 keeps the array when there is none.
inline constexpr std::array kOpenHazards{
    OpenHazard{0, ""},
#undef HOIST_HAZARD_OPEN
#define HOIST_HAZARD_OPEN(number, comes_with) OpenHazard{number, comes_with},
#include "control/contract/hazards.def"
#undef HOIST_HAZARD_OPEN
#define HOIST_HAZARD_OPEN(...)
};

struct RequestInfo {
  std::string_view name, why;
};
inline constexpr std::array kRequests{
#undef HOIST_REQUEST
#define HOIST_REQUEST(name, why) RequestInfo{name, why},
#include "control/contract/hazards.def"
};
#undef HOIST_HAZARD
#undef HOIST_HAZARD_GAP
#undef HOIST_HAZARD_OPEN
#undef HOIST_REQUEST

static_assert(all_rows(kHazards, [](const HazardInfo& h) { return &h - kHazards.data() == h.number - 1 && !h.what.empty(); }),
              "hazards.def: hazards must be numbered in order from 1");
static_assert(all_rows(kHazards, [](const HazardInfo& h) { return h.guard.empty() == h.files.empty(); }),
              "hazards.def: a guard says where it stands");

}  // namespace hoist::contract
