// H17: the driver held hold-to-run and then no command came for remote_stop_age_s. The braking itself is begun by the REMOTE mode.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct RemoteCommandLost {
  static constexpr contract::Fault kFault = contract::Fault::remote_command_lost;

  bool check(const MonitorView& view) noexcept { return view.remote_lost; }
};

}  // namespace hoist::core
