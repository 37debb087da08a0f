// The table of actions (actions.def) as values.
#pragma once
#include <array>
#include <cstdint>
#include <string_view>

#include "control/contract/params.hpp"
#include "server/contract/audit.hpp"

namespace hoist::server {

enum class Action : std::uint8_t {
#define HOIST_ACTION(name, role, ends) name,
#include "server/actions/actions.def"
#undef HOIST_ACTION
};

struct ActionInfo {
  std::string_view name;
  contract::Role role;
  bool ends;
};
inline constexpr std::array kActions{
#define HOIST_ACTION(name, role, ends) ActionInfo{#name, contract::Role::role, (ends) != 0},
#include "server/actions/actions.def"
#undef HOIST_ACTION
};

static_assert(contract::all_rows(kActions, [](const ActionInfo& action) { return is_audit_kind(action.name); }),
              "audit.def: an action has no words");

}  // namespace hoist::server
