// A twin as a file: JSON of one version, checked field by field when it is read (`hoist twin --schema` prints its schema).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "control/contract/params.hpp"
#include "db/store/session_types.hpp"
#include "deploy/tools/hoist/twin/fit.hpp"

namespace hoist::tool::twin {

inline constexpr int kTwinVersion = 1;

/// The twin's own walk held against the recorded one, before anything is tried on it.
struct Check {
  double c_recorded = 0, c_twin = 0;
  double speed_rms_recorded_m_s = 0, speed_rms_twin_m_s = 0;
  int walks = 0;  ///< of the twin that came to their end

  /// C within 0.05 and speed within 10 %: field.md 4, "patient twin".
  [[nodiscard]] bool holds() const;
};
inline constexpr double kCheckC = 0.05, kCheckSpeed_norm = 0.10;

struct Twin {
  db::SessionId session = 0;
  std::int64_t started_utc_ns = 0;
  const sim::Scenario* scenario = nullptr;
  double led_s = 0;
  contract::Params params;  ///< in force in the session
  std::uint64_t seed = 1;
  Fit fit;
  Check check;
};

[[nodiscard]] std::string twin_text(const Twin& twin);
/// Nothing, and `problem` names the field and what is allowed, for a text that is no twin. Of the fit's derived values nothing is read.
[[nodiscard]] std::optional<Twin> read_twin(std::string_view text, std::string& problem);
/// JSON Schema, draft 2020-12.
[[nodiscard]] std::string twin_schema();

/// Fits the session and walks the twin on the session's exercise for the check.
[[nodiscard]] Twin make_twin(const LedSession& session, std::uint64_t seed);

}  // namespace hoist::tool::twin
