// The stored parameters: one JSON file with names, SI values and a checksum. Written as a whole, atomically, and validated when read.
#pragma once
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "control/contract/params.hpp"
#include "control/contract/shared_memory.hpp"
#include "control/run/stored_values.hpp"

namespace hoist::run {

struct LoadedParams {
  contract::Params params;  // defaults for missing values
  bool usable = false;      // false: the file exists and must not be used; `problem` says why
  std::string problem;
  std::vector<std::string> remarks;  // unknown names; values out of range, whose default holds and calibration does not
};
// A missing file is a first start: defaults, usable.
LoadedParams load_parameter_file(const std::string& path);
Saved save_parameter_file(const std::string& path, const contract::Params& params);

// Brings what is in force to the disk. One thread uses it, which may wait for the disk.
class ParameterStore {
 public:
  static constexpr std::uint64_t kRetry_ns = 1'000'000'000;  // after a refusal by the disk

  // `path` empty: nothing is stored, as the report says. Values of `started_with` that differ from `stored` hold for this run only (--set).
  ParameterStore(std::string path, const contract::Params& started_with, const contract::Params& stored);
  // Stores the parameters in force with this sequence unless already stored. Defaults that replace damaged values are never stored: the
  // file still holds the right values.
  const contract::StoreReport& look(const contract::ParamsInForce& in_force, std::uint64_t sequence, std::uint64_t now_ns);
  // Why the newest attempt failed; empty when it did not.
  [[nodiscard]] const std::string& problem() const { return problem_; }

 private:
  using Values = std::array<double, contract::kParamCount>;
  [[nodiscard]] contract::Params file_content(const Values& kept) const;
  void store(const Values& kept, std::uint64_t sequence);

  std::string path_;
  contract::Params started_with_, stored_;
  std::optional<Values> synced_;  // the `kept` of the file; none after a failed attempt, when the file may be the old or the new one
  contract::StoreReport report_;
  std::uint64_t retry_ns_ = 0;
  std::string problem_;
};

}  // namespace hoist::run
