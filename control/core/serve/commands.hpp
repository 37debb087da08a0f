// What the server asks for, command by command. Every field is hostile until checked; what is refused changes nothing and is counted.
#pragma once
#include <cstddef>
#include <span>

#include "control/contract/commands.hpp"
#include "control/core/state.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

/// Does or refuses each command, in their order, and answers it with an event (command_done or command_refused with all reasons). Where the step's
/// events leave no room for all answers that may come, a command is refused as busy, except those that only stop.
void take_commands(CoreState& state, std::span<const contract::Command> commands) noexcept;
/// The newest driving command. No event: it comes 25 times a second, and its effect is in every record.
void take_drive_command(CoreState& state, const contract::DriveCommand& command) noexcept;
/// Whether the server is alive; without it there is no driver.
void watch_server(CoreState& state, std::uint64_t heartbeat, std::uint64_t life) noexcept;

}  // namespace hoist::core
