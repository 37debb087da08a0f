// H21: no server is connected. Patient-led walking goes on.
#pragma once
#include "control/core/monitor/monitor.hpp"

namespace hoist::core {

struct ServerLost {
  static constexpr contract::Fault kFault = contract::Fault::server_lost;
  /// A server that never came is not missed in the first five seconds: the programs start together.
  static constexpr std::uint64_t kStartTicks = 500;

  bool check(const MonitorView& view) noexcept { return !view.server_alive && (view.server_seen || view.ticks > kStartTicks); }
};

}  // namespace hoist::core
