// What a session of chaos reports.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "control/contract/faults.hpp"
#include "tests/chaos/faults.hpp"

namespace hoist::chaos {

inline constexpr std::size_t kModeCount = contract::kModes.size();

struct SessionReport {
  std::uint64_t seed = 0;
  std::uint64_t digest = 0;
  std::vector<std::uint64_t> hashes;  // of everything so far, at the end of each second
  std::uint64_t motion = 0;           // digest of the drive commands alone
  std::vector<Fault> faults;          // as they were planned
  std::string patient;                // patient_of()
  double length_s = 0;
  double walked_s = 0;                       // time in which the wheels might move
  std::array<double, kModeCount> moved_s{};  // of that, by mode
  std::array<int, kModeCount> unasked{};     // ends of motion that no person asked for while nothing was broken, by the mode that ended
  double distance_m = 0;                     // that the platform truly went
  int starts = 0;                            // motions begun
  int stops = 0;                             // protective stops
  int false_stops = 0;                       // unasked ends of motion that the true state of patient and plant does not explain
  std::uint64_t samples = 0;                 // that were acknowledged as stored and found again
  std::uint64_t samples_again = 0;           // that are stored, and whose step was run again and gave the same bits
  std::uint64_t samples_not_run = 0;         // that are stored, and whose step could not be run again
  std::vector<std::string> story;            // log with times; only on request
  std::vector<std::string> broken;           // violated invariants with times; expected empty
  double broken_s = 0;                       // when the first of them was found
};

}  // namespace hoist::chaos
