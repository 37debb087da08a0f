// Reduces a failing session: fewest faults, then the shortest time.
#pragma once
#include <optional>
#include <string>

#include "tests/chaos/session.hpp"

namespace hoist::chaos {

/// Runs at most this many sessions to find a smaller one.
inline constexpr int kShrinkRuns = 80;

/// `options` led to `report`, which is broken. Returns the smallest options that were found; they carry their faults with them.
[[nodiscard]] SessionOptions shrink(const SessionOptions& options, const SessionReport& report);

/// The arguments of hoist-chaos for this session.
[[nodiscard]] std::string replay_words(const SessionOptions& options);
/// And back. Null for an unknown argument, or without faults.
[[nodiscard]] std::optional<SessionOptions> read_replay(const std::string& words);

}  // namespace hoist::chaos
