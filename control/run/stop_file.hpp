// Earlier stops (H22), kept over restarts of program and computer: one JSON file with a checksum beside the parameters, written as a whole
// and durably, validated when read.
#pragma once
#include <cstdint>
#include <string>

#include "control/core/output/repeat_watch.hpp"

namespace hoist::run {

struct LoadedStops {
  core::StopHistory history;
  std::string problem;  // the file is invalid: the hoist starts out of service, because the number of earlier stops is unknown
};
/// `boot_id`: of this start of the computer. Times of the same start hold as they are; of an earlier boot only their order is known, and
/// every stop counts as new. The wall clock is not used: it may not be set yet. No file = no stops.
LoadedStops load_stop_file(const std::string& path, const std::string& boot_id, std::uint64_t now_ns);
/// Empty on success, otherwise the reason. The old file stays intact until the new one and its name are on the disk.
std::string save_stop_file(const std::string& path, const std::string& boot_id, const core::StopHistory& history);

/// Of this start of the computer; empty when unknown.
std::string boot_id();

}  // namespace hoist::run
