// Sets of faults by their reaction, as bits.
#pragma once
#include "control/contract/faults.hpp"
#include "control/core/estimate/estimate.hpp"

namespace hoist::core {

/// Bits of every fault with this reaction.
[[nodiscard]] constexpr contract::FaultBits faults_with(contract::Reaction reaction) {
  contract::FaultBits bits = 0;
  for (const contract::FaultInfo& fault : contract::kFaults)
    if (fault.reaction == reaction) bits |= contract::fault_bit(fault);
  return bits;
}

/// Stops that say nothing about the machine: caused by a button, a touch, a fall or a slope.
inline constexpr contract::FaultBits kNotOfTheMachine =
    contract::fault_bit(contract::Fault::stop_pressed) | contract::fault_bit(contract::Fault::bumper_pressed) |
    contract::fault_bit(contract::Fault::fall_detected) | contract::fault_bit(contract::Fault::base_tilted);
/// Too many of these stops put the hoist out of service.
inline constexpr contract::FaultBits kCountedStops = faults_with(contract::Reaction::protective_stop) & ~kNotOfTheMachine;
/// Lost nodes and bus: plugs and cables, which a therapist can put right; repeated, they may be acknowledged without an
/// engineer.
inline constexpr contract::FaultBits kSilence = [] {
  contract::FaultBits bits = contract::fault_bit(contract::Fault::bus_down);
  for (const NodeRow& row : kNodeRows) bits |= contract::fault_bit(row.lost);
  return bits;
}();

inline constexpr contract::FaultBits kProtective = faults_with(contract::Reaction::protective_stop);
inline constexpr contract::FaultBits kBreakdown = faults_with(contract::Reaction::out_of_service);
inline constexpr contract::FaultBits kPowerOff = faults_with(contract::Reaction::power_off);
/// Faults that stay until acknowledged.
inline constexpr contract::FaultBits kLatching = kProtective | kBreakdown | kPowerOff;
inline constexpr contract::FaultBits kSoft = faults_with(contract::Reaction::soft_stop);
inline constexpr contract::FaultBits kWarnings = faults_with(contract::Reaction::warn);
inline constexpr contract::FaultBits kBumper = contract::fault_bit(contract::Fault::bumper_pressed);
inline constexpr contract::FaultBits kDriveFaults =
    contract::fault_bit(contract::Fault::drive_left_fault) | contract::fault_bit(contract::Fault::drive_right_fault);

}  // namespace hoist::core
