// Events of the core, with the step that they belong to.
#pragma once
#include "control/core/state.hpp"

namespace hoist::core {

/// Adds an event with tick and time filled in.
inline void emit(CoreState& state, contract::Event event) noexcept {
  event.tick = state.tick;
  event.time_ns = state.time_ns;
  state.events.push(event);
}

/// Gives the lease to a client, or frees it (0), and records the event.
inline void give_lease(CoreState& state, std::uint32_t client) noexcept {
  if (state.lease.holder == client) return;
  state.lease.holder = client;
  ++state.lease.epoch;
  state.remote.reset();
  if (client != 0) state.console.taken();
  contract::Event event;
  event.kind = contract::EventKind::lease_changed;
  event.client = client;
  event.code = state.lease.epoch;
  emit(state, event);
}

}  // namespace hoist::core
