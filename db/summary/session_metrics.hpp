// The figures of a session (db/metrics/metric_list.hpp), from the columns as they are exported.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "db/metrics/metric_list.hpp"
#include "db/store/database.hpp"
#include "db/store/result.hpp"
#include "db/store/session_types.hpp"

namespace hoist::db {

/// Of what a figure is computed from, by name: a recorded column with the steps it is of, "gaps", "exercise". FNV-1a, 64 bits.
using InputHashes = std::map<std::string, std::uint64_t, std::less<>>;

struct SessionMetrics {
  SessionId session = 0;
  std::string track;   ///< which track was compared: "fused" (encoders and gyroscope, slip repaired) or "encoders" (older sessions)
  std::string shape;   ///< of the exercise; empty without one
  double start_m = 0;  ///< place on the exercise where the walk began
  Figures figures;     ///< in the order of kMetrics
  /// Why there is no C or no J_N.
  NoFigure why_absent = NoFigure::no_exercise;
  InputHashes inputs;  ///< what the figures are computed from

  /// The figure of this key; a key that no figure has is a mistake of the caller and ends the program.
  [[nodiscard]] const Figure& operator[](std::string_view key) const;
};

/// Reads the session chunk by chunk, up to three times: the memory does not grow with it. Errors: not_found, corrupt, io.
Result<SessionMetrics> session_metrics(Database& database, SessionId session);

}  // namespace hoist::db
