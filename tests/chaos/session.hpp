// Deterministic chaos: one training session of a random patient with a random therapist and random faults, through the real core, the shipped
// node sources, the real recorder and the simulated machine, in virtual time. What must hold is checked in every step (invariants of the
// hazard analysis). The same seed gives the same session, bit for bit.
#pragma once
#include "tests/chaos/session_types.hpp"

namespace hoist::chaos {

/// Who walks in this session: by options.patient, or the seed.
[[nodiscard]] std::string patient_of(const SessionOptions& options);

SessionReport run_session(const SessionOptions& options);

/// I12: the same walk with and without faults of server, network, disk, clock and other clients. Violated when any drive command differs.
SessionReport run_unmoved(const SessionOptions& options);

}  // namespace hoist::chaos
