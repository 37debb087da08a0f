// What crosses the border of the core in one step: all that the judge knows of it.
#pragma once
#include <cstdint>
#include <span>

#include "control/contract/can_frame.hpp"
#include "control/contract/commands.hpp"
#include "control/contract/params.hpp"
#include "control/contract/signals.hpp"
#include "tests/chaos/judge/units.hpp"

namespace hoist::chaos {

/// What a step was given.
struct Given {
  std::uint64_t tick = 0;
  std::uint64_t time_ns = 0;
  std::span<const contract::CanFrame> frames;
  bool bus_up = true;
  std::span<const contract::Command> commands;
  bool drive_fresh = false;
  contract::DriveCommand drive;
  std::uint64_t server_heartbeat = 0, server_life = 0;
  double wake_lateness_s = 0;
};

/// What the hoist says after it.
struct Told {
  const contract::TickRecord& record;
  std::span<const contract::Event> events;  // of the whole session
  const contract::Params& params;           // in force
  std::uint64_t parameter_version = 0;
};

}  // namespace hoist::chaos
