// THE transition table: every change of the mode, who may ask for it and what must hold for it (SOURCES 2.3). Everything else is refused.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "control/contract/faults.hpp"

namespace hoist::core {

enum class Asker : std::uint8_t {
  core,             // the mode itself is finished, or a fault with the reaction soft_stop
  fault,            // a fault with the reaction protective_stop; STOP is one of them and open to anyone
  breakdown,        // a fault with the reaction out_of_service
  hardware,         // the emergency stop chain has opened; needs no request
  driver,           // the lease holder
  engineer,         // the lease holder with this role: service
  acknowledgement,  // the lease holder, who has seen why the hoist stopped
};

/// What must hold before the mode changes. The reasons against it come as refusal bits, all at once.
enum class Guard : std::uint8_t {
  none,                // a stop has no conditions
  finished,            // the mode itself says so: INIT found everything there, CALIBRATE is done
  ramp_first,          // the wheels come to rest before the mode changes
  at_rest,             // nothing moves
  stood,               // at rest, and has been for a second
  ready,               // every reason of start_refusals, bumpers among them
  ready_off_a_bumper,  // the same, but a bumper that was acknowledged while it touches: driving away from it is what is asked for
  ready_with_a_path,   // as ready, and there is a path that was checked
  cause_gone,          // the causes of the stop are gone, and the hoist has stood for a second
  only_silence,        // nothing but nodes that have long been silent is left of the causes, and the hoist has stood for a second
  checked,             // an engineer, or a therapist for what a therapist can mend; the hoist has stood for a second
  chain_closed,        // the emergency stop is released
};

struct Transition {
  contract::Mode from, to;
  Asker asker;
  Guard guard;
};

inline constexpr std::array kTransitions{
    // Upward, step by step.
    Transition{contract::Mode::init, contract::Mode::standby, Asker::core, Guard::finished},
    Transition{contract::Mode::standby, contract::Mode::user, Asker::driver, Guard::ready},
    Transition{contract::Mode::standby, contract::Mode::remote, Asker::driver, Guard::ready_off_a_bumper},
    Transition{contract::Mode::standby, contract::Mode::guided, Asker::driver, Guard::ready_with_a_path},
    Transition{contract::Mode::standby, contract::Mode::calibrate, Asker::driver, Guard::at_rest},
    Transition{contract::Mode::standby, contract::Mode::init, Asker::engineer, Guard::at_rest},
    // Back to STANDBY.
    Transition{contract::Mode::user, contract::Mode::standby, Asker::driver, Guard::ramp_first},
    Transition{contract::Mode::user, contract::Mode::standby, Asker::core, Guard::ramp_first},
    Transition{contract::Mode::remote, contract::Mode::standby, Asker::driver, Guard::ramp_first},
    Transition{contract::Mode::remote, contract::Mode::standby, Asker::core, Guard::ramp_first},
    Transition{contract::Mode::guided, contract::Mode::standby, Asker::driver, Guard::ramp_first},
    Transition{contract::Mode::guided, contract::Mode::standby, Asker::core, Guard::ramp_first},
    Transition{contract::Mode::calibrate, contract::Mode::standby, Asker::driver, Guard::none},
    Transition{contract::Mode::calibrate, contract::Mode::standby, Asker::core, Guard::finished},
    // PROTECTIVE_STOP.
    Transition{contract::Mode::init, contract::Mode::protective_stop, Asker::fault, Guard::none},
    Transition{contract::Mode::standby, contract::Mode::protective_stop, Asker::fault, Guard::none},
    Transition{contract::Mode::user, contract::Mode::protective_stop, Asker::fault, Guard::none},
    Transition{contract::Mode::remote, contract::Mode::protective_stop, Asker::fault, Guard::none},
    Transition{contract::Mode::guided, contract::Mode::protective_stop, Asker::fault, Guard::none},
    Transition{contract::Mode::calibrate, contract::Mode::protective_stop, Asker::fault, Guard::none},
    Transition{contract::Mode::protective_stop, contract::Mode::standby, Asker::acknowledgement, Guard::cause_gone},
    // A node that does not come back must not hold the hoist for ever: INIT has the drives off, waits for the node and allows service.
    Transition{contract::Mode::protective_stop, contract::Mode::init, Asker::acknowledgement, Guard::only_silence},
    // FAULT. Modes in which wheels may turn reach it through PROTECTIVE_STOP: the hoist stands before the drives go
    // off.
    Transition{contract::Mode::init, contract::Mode::fault, Asker::breakdown, Guard::none},
    Transition{contract::Mode::standby, contract::Mode::fault, Asker::breakdown, Guard::at_rest},
    Transition{contract::Mode::calibrate, contract::Mode::fault, Asker::breakdown, Guard::at_rest},
    Transition{contract::Mode::protective_stop, contract::Mode::fault, Asker::breakdown, Guard::stood},
    Transition{contract::Mode::fault, contract::Mode::init, Asker::acknowledgement, Guard::checked},
    // EMERGENCY_STOP.
    Transition{contract::Mode::init, contract::Mode::emergency_stop, Asker::hardware, Guard::none},
    Transition{contract::Mode::standby, contract::Mode::emergency_stop, Asker::hardware, Guard::none},
    Transition{contract::Mode::calibrate, contract::Mode::emergency_stop, Asker::hardware, Guard::none},
    Transition{contract::Mode::user, contract::Mode::emergency_stop, Asker::hardware, Guard::none},
    Transition{contract::Mode::remote, contract::Mode::emergency_stop, Asker::hardware, Guard::none},
    Transition{contract::Mode::guided, contract::Mode::emergency_stop, Asker::hardware, Guard::none},
    Transition{contract::Mode::protective_stop, contract::Mode::emergency_stop, Asker::hardware, Guard::none},
    Transition{contract::Mode::fault, contract::Mode::emergency_stop, Asker::hardware, Guard::none},
    Transition{contract::Mode::emergency_stop, contract::Mode::init, Asker::acknowledgement, Guard::chain_closed},
};

[[nodiscard]] constexpr const Transition* find_transition(contract::Mode from, contract::Mode to, Asker asker) {
  for (const Transition& row : kTransitions)
    if (row.from == from && row.to == to && row.asker == asker) return &row;
  return nullptr;
}

namespace detail {

// As find_transition, without a pointer that may be null: g++ 12 cannot compare those in a constant under its sanitizers.
[[nodiscard]] consteval bool leads(contract::Mode from, contract::Mode to, Asker asker) {
  bool found = false;
  for (const Transition& row : kTransitions) found = found || (row.from == from && row.to == to && row.asker == asker);
  return found;
}

[[nodiscard]] consteval bool may_move(contract::Mode mode) { return contract::kModes[static_cast<std::size_t>(mode)].moving; }

/// Every mode that some chain of rows leads to, as bits.
[[nodiscard]] consteval std::uint32_t reachable_from(contract::Mode start) {
  std::uint32_t seen = 1U << static_cast<unsigned>(start);
  for (std::size_t round = 0; round < contract::kModes.size(); ++round)
    for (const Transition& row : kTransitions)
      if ((seen >> static_cast<unsigned>(row.from) & 1U) != 0) seen |= 1U << static_cast<unsigned>(row.to);
  return seen;
}

/// The invariants of the table.
[[nodiscard]] consteval bool table_is_sound() {
  using contract::Mode;
  for (std::size_t i = 0; i < kTransitions.size(); ++i) {
    const Transition& row = kTransitions[i];
    if (row.from == row.to) return false;
    for (std::size_t k = i + 1; k < kTransitions.size(); ++k)
      if (kTransitions[k].from == row.from && kTransitions[k].to == row.to && kTransitions[k].asker == row.asker) return false;
    // Motion begins on STANDBY, asked by the driver, with every reason looked at; motion to motion does not exist.
    const bool readiness = row.guard == Guard::ready || row.guard == Guard::ready_off_a_bumper || row.guard == Guard::ready_with_a_path;
    if (may_move(row.to) != readiness) return false;
    if (may_move(row.to) && (row.from != Mode::standby || row.asker != Asker::driver)) return false;
    // Motion ends on its ramp, or in a stop that brakes by itself, or because there is no power left.
    if (may_move(row.from) && row.to != Mode::protective_stop && row.to != Mode::emergency_stop && row.guard != Guard::ramp_first)
      return false;
    // The three stops: each has its own trigger, and no other row leads in or out.
    if ((row.to == Mode::protective_stop) != (row.asker == Asker::fault)) return false;
    if ((row.to == Mode::fault) != (row.asker == Asker::breakdown)) return false;
    if ((row.to == Mode::emergency_stop) != (row.asker == Asker::hardware)) return false;
    const bool stopped = row.from == Mode::protective_stop || row.from == Mode::fault || row.from == Mode::emergency_stop;
    const bool worse = row.asker == Asker::breakdown || row.asker == Asker::hardware;
    if (stopped && !worse && row.asker != Asker::acknowledgement) return false;
    if (!stopped && row.asker == Asker::acknowledgement) return false;
  }
  for (const contract::ModeInfo& info : contract::kModes) {
    const auto mode = static_cast<Mode>(info.value);
    if ((reachable_from(Mode::init) >> info.value & 1U) == 0) return false;
    if ((reachable_from(mode) >> static_cast<unsigned>(Mode::standby) & 1U) == 0) return false;
    if (mode != Mode::emergency_stop && !leads(mode, Mode::emergency_stop, Asker::hardware)) return false;
    const bool stopped = mode == Mode::protective_stop || mode == Mode::fault || mode == Mode::emergency_stop;
    if (!stopped && !leads(mode, Mode::protective_stop, Asker::fault)) return false;
  }
  return true;
}

}  // namespace detail
static_assert(detail::table_is_sound(), "kTransitions breaks a rule of the hazard table 2.3");

}  // namespace hoist::core
