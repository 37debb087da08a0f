// What is known of earlier stops (H22), kept over a restart of the program and of the computer: one JSON file with a checksum beside the
// parameters, written whole and durably, read with suspicion.
#pragma once
#include <cstdint>
#include <string>

#include "control/core/output/repeat_watch.hpp"

namespace hoist::run {

struct LoadedStops {
  core::StopHistory history;
  std::string problem;  // the file cannot be believed: the hoist starts out of service, because the number of earlier stops is not known
};
/// `boot_id`: of this start of the computer. Times of the same start hold as they are; of another one nothing is known but their order, and
/// every stop counts as one of this moment. The wall clock is not asked: it may not be set yet. No file = no stops.
LoadedStops load_stop_file(const std::string& path, const std::string& boot_id, std::uint64_t now_ns);
/// Empty on success, otherwise the reason. The old file stays whole until the new one, and its name, are on the disk.
std::string save_stop_file(const std::string& path, const std::string& boot_id, const core::StopHistory& history);

/// Of this start of the computer; empty when the system does not tell.
std::string boot_id();

}  // namespace hoist::run
