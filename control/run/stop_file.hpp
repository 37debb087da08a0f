// Earlier stops (H22), kept over restarts of program and computer: one JSON file with a checksum beside the parameters, written as a whole
// and durably, validated when read.
#pragma once
#include <cstdint>
#include <string>

#include "control/core/output/repeat_watch.hpp"
#include "control/run/stored_values.hpp"

namespace hoist::run {

struct LoadedStops {
  core::StopHistory history;
  std::string problem;  // the file is invalid: the hoist starts out of service, because the number of earlier stops is unknown
};
/// `boot_id`: of this start of the computer. Times of the same start hold as they are; of an earlier boot only their order is known, and
/// every stop counts as new. The wall clock is not used: it may not be set yet. No file = no stops.
LoadedStops load_stop_file(const std::string& path, const std::string& boot_id, std::uint64_t now_ns);
/// The old file stays intact until the new one and its name are on the disk.
Saved save_stop_file(const std::string& path, const std::string& boot_id, const core::StopHistory& history);

/// Of this start of the computer; empty when unknown. From HOIST_BOOT_ID, which the unit sets, because its sandbox hides the kernel's file.
std::string boot_id();

/// Brings the newest stops to the disk. One thread uses it, which may wait for the disk.
class StopStore {
 public:
  /// `path` empty: nothing is kept.
  explicit StopStore(std::string path);
  [[nodiscard]] LoadedStops load(std::uint64_t now_ns) const;
  /// Whether a restart of the program alone keeps the times of the stops; without it each stop counts as new then.
  [[nodiscard]] bool keeps_times() const { return path_.empty() || !boot_id_.empty(); }
  /// Stores `changed`, if there is a change; what could not be stored is tried again with each call. Returns why the newest is not stored.
  contract::StoreProblem look(const core::StopHistory* changed);
  /// The same for people.
  [[nodiscard]] const std::string& problem() const { return saved_.problem; }

 private:
  std::string path_, boot_id_;
  core::StopHistory newest_;
  bool waiting_ = false;
  Saved saved_;
};

}  // namespace hoist::run
