// What a session of chaos is asked for, and what it reports.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "control/contract/can_frame.hpp"
#include "control/core/tick.hpp"
#include "tests/chaos/faults.hpp"

namespace hoist::chaos {

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
  Sabotage sabotage = {};                         // see there
  bool lying_disk = false;                        // the disk says "synced" and has not: sabotage of the recorder
  bool record = false;  // server and disk take part also when none of them breaks, and what they store is run again
  std::optional<contract::CanFrame> spoof = {};  // a foreign device sends this in every step from the first fault on
};

struct SessionReport {
  std::uint64_t seed = 0;
  std::uint64_t digest = 0;
  std::vector<std::uint64_t> hashes;  // of everything so far, at the end of each second
  std::uint64_t motion = 0;           // digest of the drive commands alone
  std::vector<Fault> faults;          // as they were planned
  double length_s = 0;
  double walked_s = 0;                // time in which the wheels might move
  double distance_m = 0;              // that the platform truly went
  int starts = 0;                     // motions begun
  int stops = 0;                      // protective stops
  int false_stops = 0;                // of those (and of soft stops by the core), those without an active fault
  std::uint64_t samples = 0;          // that were acknowledged as stored and found again
  std::uint64_t samples_again = 0;    // that are stored, and whose step was run again and gave the same bits
  std::uint64_t samples_not_run = 0;  // that are stored, and whose step could not be run again
  std::vector<std::string> story;     // log with times; only on request
  std::vector<std::string> broken;    // violated invariants with times; expected empty
  double broken_s = 0;                // when the first of them was found
};

}  // namespace hoist::chaos
