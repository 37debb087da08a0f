// What a session of chaos is asked for.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/can_frame.hpp"
#include "control/core/tick.hpp"
#include "tests/chaos/faults.hpp"
#include "tests/chaos/judge/verdict.hpp"

namespace hoist::chaos {

/// The random patient whose steps are all alike.
inline constexpr std::string_view kEvenPatient = "even";

/// Breaks the product on purpose in every step, to show that an invariant notices: may change the core and its outputs.
using Sabotage = std::function<void(double time_s, core::CoreState& core, core::TickOutputs& outputs)>;

struct SessionOptions {
  std::uint64_t seed = 1;
  double length_s = 120.0;
  int faults_max = 5;                             // 0: no fault, and then only the therapist may stop the hoist
  double frame_loss = 0.0;                        // share of all frames that is lost, in addition to the faults
  double link_jitter_s = 0.0;                     // driving commands are delayed by up to this, in addition to the faults
  bool tell = false;                              // keep the log of the session, not only violations
  bool only_walk = false;                         // the therapist starts USER once and then leaves the patient alone
  bool outside_only = false;                      // only server, network, disk, clock and other clients break
  std::optional<std::vector<Fault>> faults = {};  // instead of the seed's own
  // A row of sim::kPatientFamily, or kEvenPatient. Without: by the seed, as its faults are; one with faults of its own has the even patient, too.
  std::optional<std::string> patient = {};
  Sabotage sabotage = {};   // see there
  bool lying_disk = false;  // the disk says "synced" and has not: sabotage of the recorder
  bool storage = true;      // false: without recorder and disk, also where one of them breaks
  bool record = false;      // server and disk take part also when none of them breaks, and what they store is run again
  std::optional<contract::CanFrame> spoof = {};  // a foreign device sends this in every step from the first fault on
};

}  // namespace hoist::chaos
