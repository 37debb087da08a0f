// Deterministic chaos: one training session of a random patient with a random therapist and random faults, through the real core, the shipped
// node sources and the simulated machine, in virtual time. What must hold is checked in every step (invariants of the hazard analysis).
// The same seed gives the same session, bit for bit.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace hoist::chaos {

struct SessionOptions {
  std::uint64_t seed = 1;
  double length_s = 120.0;
  int faults_max = 5;       // 0: nothing breaks, and then nothing may stop the hoist but the therapist
  double frame_loss = 0.0;  // share of all frames that is lost, besides the faults
  bool tell = false;        // keep the story of the session, not only what was wrong
};

struct SessionReport {
  std::uint64_t seed = 0;
  std::uint64_t digest = 0;
  double walked_s = 0;              // time in which the wheels might move
  double distance_m = 0;            // that the platform truly went
  int starts = 0;                   // motions begun
  int stops = 0;                    // protective stops
  int false_stops = 0;              // of those (and of soft stops by the core), the ones without any fault under way
  std::vector<std::string> story;   // what happened, with the time; only when asked for
  std::vector<std::string> broken;  // invariants that did not hold, with the time; empty is what we want
};

SessionReport run_session(const SessionOptions& options);

}  // namespace hoist::chaos
