// Proof of the judge: each monitor of the core switched off in turn. Compiled with HOIST_MUTATION only (control/core/base/mutation.hpp).
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/contract/faults.hpp"
#include "tests/chaos/session_types.hpp"

namespace hoist::chaos {

/// Every fault that has a monitor in the core, but console_lost: the clients of a session have no connection to lose.
[[nodiscard]] std::vector<contract::Fault> masks();

struct MaskResult {
  std::uint64_t sessions = 0;  // that were run until the judge failed one; all of them, if it never did
  std::optional<SessionReport> found;
  std::string replay;  // that session until it failed, as hoist-chaos takes it
};
/// Sessions of the seeds first, first + 1, ... with this monitor off, on so many threads, until one fails.
[[nodiscard]] MaskResult run_masked(contract::Fault fault, std::uint64_t first, std::uint64_t most, unsigned jobs);

/// Whether this session fails with this monitor off.
[[nodiscard]] bool fails_masked(contract::Fault fault, const SessionOptions& session);

/// A row of masks.tsv: the monitor, and a session that finds it off.
struct KnownMask {
  std::string monitor;
  SessionOptions session;
};
[[nodiscard]] std::vector<KnownMask> read_masks(const std::string& path);

}  // namespace hoist::chaos
