// Files that must survive a power cut: one JSON object of values with a checksum, written as a whole and durably, validated when read.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "control/contract/shared_memory.hpp"

namespace hoist::run {

struct Saved {
  std::string problem;  // empty: file and folder are synced
  int error = 0;        // errno
};
/// The same for the server.
contract::StoreProblem store_problem(const Saved& saved);
/// The old file stays intact until the new one is on the disk.
Saved save_values(const std::string& path, const nlohmann::json& values);

struct StoredValues {
  nlohmann::json values;
  bool missing = false;
  std::string problem;  // the file exists but is invalid
};
/// `kind` names the file in the problem, such as "parameter file".
StoredValues load_values(const std::string& path, const std::string& kind);

}  // namespace hoist::run
