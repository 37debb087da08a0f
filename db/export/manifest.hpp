// What a reader must know to understand an export years later: programs, parameters with units at the start and each change, calibration,
// directions, the words for modes and faults, gaps and the clock. The same facts as JSON (in every format that can hold it) and as the '#'
// lines of a CSV. What is not known is null, and "not read" or "not recorded" in CSV.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "db/export/source.hpp"

namespace hoist::db {

/// "session", "programs", "hoist" (its id; null: recorded before hoists had one), "nodes", "layout_hash", "recordings_file",
/// "directions", "columns", "parameters", "parameter_changes", "calibration",
/// "modes", "faults", "gaps", "clock". Of a change, "in_effect_s" is when its value had arrived; null: another change came before, the session
/// ended before, or the core of that time did not tell.
nlohmann::json manifest_json(const ExportSource& source);
/// The '#' lines without those about columns. Each is an RFC 4180 record `# key,value`, on one line also when its text holds line breaks.
std::string manifest_lines(const ExportSource& source, char separator = ',');
/// {"tick", "time_ns", "kind", "name", "code", "item", "value", "before", "text"}. A marker is of the kind "marker", has its own kind as name, a
/// text, and no time by the steady clock: null.
nlohmann::json moment_json(const Moments::Moment& moment);
/// The number; null when it is not finite.
nlohmann::json finite(double value);
/// As one line; broken UTF-8 of a foreign file is replaced.
std::string dumped(const nlohmann::json& value);

}  // namespace hoist::db
