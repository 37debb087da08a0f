// The stored parameters: one JSON file with names, SI values and a checksum. Written whole and atomically, read with suspicion.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "control/contract/params.hpp"
#include "control/contract/shared_memory.hpp"

namespace hoist::run {

struct LoadedParams {
  contract::Params params;  // defaults where the file says nothing
  bool usable = false;      // false: the file exists and must not be used; `problem` says why
  std::string problem;
  std::vector<std::string> remarks;  // unknown names, values out of range that were left at their default
};
// A missing file is a first start: defaults, usable.
LoadedParams load_parameter_file(const std::string& path);
// What the file is to hold now; nothing when it stays as it is: nothing was changed since `before`, or what is in force are the defaults after
// damage, and the file is the last place that still knows better. Of `started_with` what differs from `stored` holds for this run only.
std::optional<contract::Params> params_to_store(const contract::ParamsInForce& in_force, const contract::ParamsInForce& before,
                                                const contract::Params& started_with, const contract::Params& stored);
// Empty on success, otherwise the reason. The old file stays whole until the new one is on the disk.
std::string save_parameter_file(const std::string& path, const contract::Params& params);

}  // namespace hoist::run
