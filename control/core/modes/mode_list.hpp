// THE modes the core runs: one row each, in the order of the mode table in faults.def.
#pragma once
#include <array>
#include <cstddef>

#include "control/core/modes/calibrate.hpp"
#include "control/core/modes/emergency_stop.hpp"
#include "control/core/modes/fault.hpp"
#include "control/core/modes/guided.hpp"
#include "control/core/modes/init.hpp"
#include "control/core/modes/mode.hpp"
#include "control/core/modes/protective_stop.hpp"
#include "control/core/modes/remote.hpp"
#include "control/core/modes/standby.hpp"
#include "control/core/modes/user.hpp"

namespace hoist::core {

struct ModeRow {
  contract::Mode mode;
  bool drives;  // the drives are enabled in this mode
  void (*enter)(CoreState&) noexcept;
  Wish (*step)(CoreState&, double) noexcept;
};

template <typename M>
constexpr ModeRow mode_row(bool drives) {
  return {M::kMode, drives, &M::enter, &M::step};
}

inline constexpr std::array kModeList{
    mode_row<InitMode>(false),  mode_row<StandbyMode>(false),       mode_row<UserMode>(true),
    mode_row<RemoteMode>(true), mode_row<ProtectiveStopMode>(true), mode_row<CalibrateMode>(false),
    mode_row<GuidedMode>(true), mode_row<FaultMode>(false),         mode_row<EmergencyStopMode>(false),
};

namespace detail {
consteval bool modes_match() {
  if (kModeList.size() != contract::kModes.size()) return false;
  for (std::size_t i = 0; i < kModeList.size(); ++i) {
    if (static_cast<std::size_t>(kModeList[i].mode) != i) return false;
    // Wheels that may turn need drives that run.
    if (contract::kModes[i].moving && !kModeList[i].drives) return false;
  }
  return true;
}
}  // namespace detail
static_assert(detail::modes_match(), "mode_list.hpp and the mode table of faults.def differ");

[[nodiscard]] inline const ModeRow& mode_row_of(contract::Mode mode) noexcept { return kModeList[static_cast<std::size_t>(mode)]; }
[[nodiscard]] inline bool is_moving(contract::Mode mode) noexcept { return contract::kModes[static_cast<std::size_t>(mode)].moving; }

}  // namespace hoist::core
