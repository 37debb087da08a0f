// What the server asks for, command by command. Every field is hostile until checked; what is refused changes nothing and is counted.
#pragma once
#include <cstddef>

#include "control/contract/commands.hpp"
#include "control/core/state.hpp"
#include "control/core/types.hpp"

namespace hoist::core {

/// More than the ring between the programs can hold; the rest is refused unread, except STOP.
inline constexpr std::size_t kCommandsPerTick = 64;

/// Does or refuses one command and answers it with an event (command_done or command_refused with all reasons).
void take_command(CoreState& state, const contract::Command& command) noexcept;
/// Refuses without looking further than for a STOP.
void take_surplus_command(CoreState& state, const contract::Command& command) noexcept;
/// The newest driving command. No event: it comes 25 times a second, and its effect is in every record.
void take_drive_command(CoreState& state, const contract::DriveCommand& command) noexcept;
/// Whether the server is alive; without it there is no driver.
void watch_server(CoreState& state, std::uint64_t heartbeat, std::uint64_t life) noexcept;

}  // namespace hoist::core
