// The one place that changes the mode. Who may lead where stands in kTransitions (research on safety, 2.3); everything else is refused.
#pragma once
#include <array>
#include <cstdint>

#include "control/contract/faults.hpp"
#include "control/core/state.hpp"

namespace hoist::core {

enum class Asker : std::uint8_t {
  core,             // the mode itself is finished, or a fault with the reaction soft_stop
  fault,            // a fault with the reaction protective_stop; STOP is one of them and open to anyone
  driver,           // the lease holder
  engineer,         // the lease holder with this role: service
  acknowledgement,  // the lease holder, when the cause is gone and the hoist has stood for a second
};

struct Transition {
  contract::Mode from, to;
  Asker asker;
  bool ramp_first;  // the wheels come to rest before the mode changes
};

inline constexpr std::array kTransitions{
    Transition{contract::Mode::init, contract::Mode::standby, Asker::core, false},
    Transition{contract::Mode::init, contract::Mode::protective_stop, Asker::fault, false},
    Transition{contract::Mode::standby, contract::Mode::user, Asker::driver, false},
    Transition{contract::Mode::standby, contract::Mode::remote, Asker::driver, false},
    Transition{contract::Mode::standby, contract::Mode::init, Asker::engineer, false},
    Transition{contract::Mode::standby, contract::Mode::protective_stop, Asker::fault, false},
    Transition{contract::Mode::user, contract::Mode::standby, Asker::driver, true},
    Transition{contract::Mode::user, contract::Mode::standby, Asker::core, true},
    Transition{contract::Mode::user, contract::Mode::protective_stop, Asker::fault, false},
    Transition{contract::Mode::remote, contract::Mode::standby, Asker::driver, true},
    Transition{contract::Mode::remote, contract::Mode::standby, Asker::core, true},
    Transition{contract::Mode::remote, contract::Mode::protective_stop, Asker::fault, false},
    Transition{contract::Mode::protective_stop, contract::Mode::standby, Asker::acknowledgement, false},
};

[[nodiscard]] constexpr const Transition* find_transition(contract::Mode from, contract::Mode to, Asker asker) {
  for (const Transition& row : kTransitions)
    if (row.from == from && row.to == to && row.asker == asker) return &row;
  return nullptr;
}

/// How long the hoist must have stood before an acknowledgement counts: one second.
inline constexpr std::uint8_t kStillTicks = 100;
/// A fault of the soft_stop kind that came from a lost driver is shown this long after the hoist has stopped.
inline constexpr std::uint8_t kRemoteLostShownTicks = 100;

/// Bits of every fault with this reaction.
[[nodiscard]] constexpr std::uint32_t faults_with(contract::Reaction reaction) {
  std::uint32_t bits = 0;
  for (const contract::FaultInfo& fault : contract::kFaults)
    if (fault.reaction == reaction) bits |= 1U << fault.bit;
  return bits;
}

/// Every reason, as refusal bits, why motion may not start now; without the ones that depend on who asks. 0 = it may.
[[nodiscard]] std::uint32_t start_refusals(const CoreState& state) noexcept;

/// Takes over what the monitors found: raises, clears, and reacts.
void judge_faults(CoreState& state, std::uint32_t conditions) noexcept;
/// A fault that no monitor watches happened just now (STOP, the gate).
void raise_fault(CoreState& state, contract::Fault fault) noexcept;

/// The lease holder asks for a mode; `to` is a mode of the table. Refusal bits, 0 = done or under way.
[[nodiscard]] std::uint32_t request_mode(CoreState& state, contract::Mode to) noexcept;
/// The lease holder, an engineer, wants nodes to get new programs: INIT, and it stays. Also from INIT, where a node without a program keeps
/// the hoist. Refusal bits, 0 = service is on.
[[nodiscard]] std::uint32_t begin_service(CoreState& state) noexcept;
/// The mode in charge says that it is finished.
void finish_mode(CoreState& state) noexcept;

/// Leaves PROTECTIVE_STOP. Refusal bits; 0 = done, or under way with state.pending filled by the caller when `wait` comes back true.
[[nodiscard]] std::uint32_t acknowledge(CoreState& state, bool& wait) noexcept;
/// Once per step: an acknowledgement that waits for a drive ends here, one way or the other.
void serve_pending(CoreState& state) noexcept;

/// Adds an event with tick and time filled in.
void emit(CoreState& state, contract::Event event) noexcept;
/// Gives the lease to a client, or to nobody (0), and tells so.
void give_lease(CoreState& state, std::uint32_t client) noexcept;

}  // namespace hoist::core
